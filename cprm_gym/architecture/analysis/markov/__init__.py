"""What a chain of states ends in, when, and how sure that is (dissertation §3.2).

A `MarkovChain` is a frozen value: compressed rows (row-stochastic: ``pi' = pi P``), named *outcomes* (sets of states that are never left),
a distribution at the start, names of states where they have some. `absorption` gives for every state the probability of each outcome, of
never ending in one, and the expected time, with a bound on the error of each number; `outcomes_over_time` the same cycle by cycle.
"""
