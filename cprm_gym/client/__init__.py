"""The other end of the protocol: programs of ours as clients of any server that speaks it.

`Connection` is a socket; `Percepts` turn a player's messages into the arrays of `cprm_gym.simulator.senses`, exactly as the
simulator would fill them; `PerceivedSimulator` answers ``see``, ``sense_body``, ``hear`` and ``landmarks`` from them, so that everything
built on a `Simulator` works on what a server tells. `RemoteSimulator` plays on a server with a trainer's powers.
"""
