"""Outcomes that hardly ever come, and what led to them (dissertation §3.3.1).

Of a chain that is known the probability is solved exactly (`markov`) and the runs that end badly are drawn directly (`conditional`):
this is what the text's backward sampling wants. Of a world that is too large for that, `importance` draws runs under chances that lean
to the outcome, with the likelihood ratio of each; `splitting` copies those that came far, of anything that can be copied.
"""
