"""What nets can do (structure, module contracts), what they will do in a modelled world, and what is proved.

Structural analysis, for all environments:

=================  ======================================================================================================
`report`           one report on a net: ``cprm-gym analyze``
`structure`        reachability, boundedness, deadlocks, liveness, home markings, soundness of the untimed view
`timed`            the same with clocks, priorities and the environment, cycle by cycle; which modules may be active together
`contracts`        whether a behaviour module keeps the promises of its interface; `composition`: whether a net uses them well
`coverability`     unbounded nets (Karp and Miller)
`invariants`       P- and T-invariants; `siphons`: siphons and traps
`state_space`      the markings themselves, bit-packed; `cycles`: the steps of a timed net; `system`: a net as arrays
=================  ======================================================================================================

Every answer is yes, no or unknown, with the reason; a "no" comes with a run that shows it.
"""
