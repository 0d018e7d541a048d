"""The striker in layers. That the ball has been passed on, and is not to be fetched, is a register that runs out."""

from __future__ import annotations

from cprm_gym.agents.striker import COMING, FORGOTTEN, WAIT

from ..behaviour.layers import Layer

COMES = f"approach >= {COMING} and ball_age < {FORGOTTEN}"
AT_BALL = f"at_ball and ball_age < {FORGOTTEN}"
FOREVER = 10_000
"""Cycles, more than an episode has."""
PATIENCE = 120
"""Cycles for which he counts on the return pass."""
LAYERS = (
    Layer("face", "off_axis >= 60", order="face"),
    Layer("look round", f"ball_age >= {FORGOTTEN}", order="sweep"),
    Layer("fetch", f"ball_age < {FORGOTTEN} and off_axis < 60", skill="go", stays="1"),
    Layer("dribble", AT_BALL, skill="dribble", stays="1"),
    Layer("shoot", f"{AT_BALL} and goal_near", skill="shoot", stays="1"),
    Layer("watch", "(passed and not done)", order="stand"),
    Layer("turn to it", "(passed and not done) and off_axis >= 60", order="face"),
    Layer("run forward", "(passed and not done) and not arrived", skill="advance", stays="(passed and not done)", sets={"arrived": ("arrived", WAIT)}),
    Layer("receive", f"(passed and not done) and {COMES}", skill="receive", stays="1", sets={"received": ("done", FOREVER), "missed": ("done", FOREVER)}),
    Layer("kick off", f"{AT_BALL} and not (passed or done)", skill="passing", stays="1", raises=("passing.ongoing",),
          sets={"passed": ("passed", PATIENCE), "failed": ("done", FOREVER)}),
    Layer("set up", "not_begun", skill="setup"),
)  # fmt: skip
EYES = "look"
