"""What holds although chances are known only within bounds (dissertation §3.2.2).

An `IntervalChain` has a lower and an upper chance on each edge; nature picks a row between them in every state and cycle. Two answers
stand side by side: the text's, which sends what the lower chances leave to an unknown state (`unknown_state_bounds`), and the optimal one,
the fixed point of interval value iteration (`interval_bounds`). A third is for chains that are learned from few runs: what most runs keep
to is bounded so, and how often it is left is counted (`regular`). Intervals come from parameter ranges (`ParametricChain`), from counts
(`intervals_from_counts`) or from a margin around a chain.
"""
