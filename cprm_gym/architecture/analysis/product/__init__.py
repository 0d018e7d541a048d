"""Agent and world as one chain (dissertation §3.2): environment x belief x net with clocks, reachable states only.

A `World` has finitely many states, percepts in each, and chances of the next one given what the net commands: a two-slice relational model
used generatively (`PRMWorld`), or cells with counts (`LearnedWorld`). `product` runs the net itself, in batches, from every state that can
be reached; what comes out is a `MarkovChain` (and an `IntervalChain` where the world's chances are intervals) with readable states.
`ProductRuns` plays the same. `groups` finds what is independent, to be analysed apart.
"""
