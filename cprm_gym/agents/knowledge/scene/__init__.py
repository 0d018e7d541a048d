"""The scene from raw senses: the own pose, mates and opponents in one relational model of real numbers, with identities that are uncertain.

`pose` and `others` state the classes of the model; what runs in every cycle are kernels that do with them what the engine ``"mixture"``
does, and are tested against it.
"""
