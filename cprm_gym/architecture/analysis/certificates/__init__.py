"""Proofs that a behaviour closes with its goal (dissertation §3.4, Appendix A).

`error_metric`: a behaviour as updates of a few numbers, with its invariant and its rank; every obligation of the proof over boxes.
`slow_approach`: Appendix A in closed form: as printed (contradictory at the defaults), corrected, checked in exact fractions.
`attractor`: the same by a grid of cells from which every run must reach the goal, with a bound on its steps; `grid` is Appendix A's.
"""
