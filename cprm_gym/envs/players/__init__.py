"""Players that the environments bring along: what they remember, how they move, and the teams that they form.

Everything here sees only what the server would tell the player (`memory`), in the frame of the own team: x towards the opponent's
goal, whichever side that is.
"""
