"""What nets can do, what they will do in a modelled world, and what is proved.

One net, four forms of arrays
=============================

======================================  ============================================================================================
`petri.CompiledNet`                     places and arcs of every kind, as the executor runs them: where every analysis begins
`net_arrays.System`                     tokens only: one row per transition, one column per place; time and environment left out.
                                        Needed by all that is structural (invariants, siphons, conservation), by coverability, and
                                        by the untimed state space as its definition
`behaviour.packing` (`PackedNet`)       the same as operations on words of bits, for one layout of the fields. Needed by the untimed
                                        state space alone, for its millions of markings
`timed.system` (`TimedNet`)             tokens, cells of what is observed, clocks, one phase. Needed by the timed state space, and so
                                        by contracts, composition and co-activity
======================================  ============================================================================================

Rooms
=====

==============  ====================================================================================================================
`report`        one report on a net: ``cprm-gym analyze``
`verdicts`      every answer: yes, no or unknown, why, and a run that shows it
`structure`     true for every initial marking: P- and T-invariants, siphons and traps, conservation
`behaviour`     reached from one marking, time left out: reachability, boundedness, deadlocks, liveness, coverability, bisimulation
`timed`         the same with clocks, priorities and any environment, cycle by cycle; which modules may be active together
`modules`       whether a behaviour module keeps the promises of its interface, and whether a net uses its modules well
==============  ====================================================================================================================
"""
