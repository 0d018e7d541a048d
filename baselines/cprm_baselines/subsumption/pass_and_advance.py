"""One of the passing pair in layers: find, run free, fetch what nobody takes, receive, and what to do with the ball."""

from __future__ import annotations

from cprm_gym.agents.passer import AFTER_SHOT, FORGOTTEN, IN_RANGE, ONSIDE, UNCLAIMED

from ..behaviour.layers import Layer

LIES = "ball_speed < 0.3 and ball_age < 4"
HAS = "at_ball and ball_age < 3 and his < 0.3"
LAYERS = (
    Layer("stand", "1", order="stand"),
    Layer("face", f"off_axis >= 60 and ball_age < {2 * FORGOTTEN}", order="face"),
    Layer("run free", "off_place >= 1.8", skill="advance", stays="1"),
    Layer("look round", f"ball_age >= {2 * FORGOTTEN} and off_place < 1.8", order="sweep", stays=f"ball_age >= {FORGOTTEN}"),
    Layer("fetch", f"mine >= 0 and {LIES} and not passed", skill="go", stays="his < 3 and not passed"),
    Layer("receive", "coming and not at_ball", skill="receive", stays="1", sets={"received": ("got", 1)}),
    Layer("hold", f"{HAS} and not passed", order="stand", stays="not out_of_reach and his < 0.3 and not passed"),
    Layer("pass", f"{HAS} and not passed and onside >= {ONSIDE}", skill="passing", stays="1", raises=("passing.ongoing",),
          sets={"passed": ("passed", UNCLAIMED)}),
    Layer("shoot", f"{HAS} and not passed and goal_distance < {IN_RANGE}", skill="shoot", stays="1", sets={"shot": ("passed", AFTER_SHOT)}),
)  # fmt: skip
EYES = "look"
