"""Soccer's worlds for analysis: behaviours put on a stage of the simulator, and models of what surrounds them there.

==========  ============================================================================================
`trials`    every skill alone: where it starts, what it promises
`learned`   cells of what a net tests, with counts of how they follow each other in the simulator
`pair`      one passes and the other receives: two nets, one world
`stage`     what both are played on, in batch
`runs`      episodes on it as runs to be sampled, and films of them
`observer`  the world of Appendix A with the simulator's motion, noise and roundings
`splitting` worlds that are copied with the agents in them
==========  ============================================================================================
"""
