"""What a net of modules will do, from what its modules do (dissertation §3.1, Algorithms 3.1 and 3.2).

A module is summarised by conditions before and after, and by the least and the most that the probability of each outcome can be over all
states in which it may begin (a single number is unsound: which state it begins in depends on what came before). The net says which outcome
leads to which module; conditions are checked along these ways, and the summaries are chained to an interval chain. Modules that may work at
once must not interfere, or be analysed together.
"""
