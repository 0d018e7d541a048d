"""Our controllers on any server: every one that plays an environment joins a match as the programs of a team do.

`JoinedPlayer` is one player: a connection, his percepts as observations, his controller, his commands as text. `JoinedTeam` keeps several
of them, with nothing shared between them, and a coach; ``cprm-gym join`` runs one.
"""
