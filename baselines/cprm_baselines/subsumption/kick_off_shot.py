"""The striker in layers. That the ball has been passed on, and is not to be fetched, is a register that runs out."""

from __future__ import annotations

from cprm_gym.agents.striker import COMING, FORGOTTEN, WAIT

from ..behaviour.layers import Layer

COMES = f"approach >= {COMING} and ball_age < {FORGOTTEN}"
AT_BALL = f"at_ball and ball_age < {FORGOTTEN}"
AWAITED = "(passed and not done)"
FOREVER = 10_000
"""Cycles, more than an episode has."""
PATIENCE = 120
"""Cycles for which he counts on the return pass."""
_DONE = "done", FOREVER
LAYERS = (
    Layer("face", "off_axis >= 60", order="face"),
    Layer("look round", f"ball_age >= {FORGOTTEN}", order="sweep"),
    Layer("fetch", f"ball_age < {FORGOTTEN} and off_axis < 60", skill="go", stays="1"),
    Layer("dribble", AT_BALL, skill="dribble", stays="1"),
    Layer("shoot", f"{AT_BALL} and goal_near", skill="shoot", stays="1"),
    Layer("watch", AWAITED, order="stand"),
    Layer("turn to it", f"{AWAITED} and off_axis >= 60", order="face"),
    Layer("run forward", f"{AWAITED} and not arrived", skill="advance", stays=AWAITED, sets={"arrived": ("arrived", WAIT)}),
    Layer("receive", f"{AWAITED} and {COMES}", skill="receive", stays="1", sets={"received": _DONE, "missed": _DONE}),
    Layer("kick off", f"{AT_BALL} and not (passed or done)", skill="passing", stays="1", raises=("passing.ongoing",),
          sets={"passed": ("passed", PATIENCE), "failed": _DONE}),
    Layer("set up", "not_begun", skill="setup"),
)  # fmt: skip
EYES = "look"
