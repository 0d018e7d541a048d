"""Runs that can be stopped, asked and taken back: one world, its players, and what is remembered of both.

A cycle has two halves. First the players decide about the world as it is; that is a frame, and there the run stands when it is paused.
Then the commands are carried out, and with them what was changed by hand in between: the ball dragged, a player blinded, a reading forced.
"""
