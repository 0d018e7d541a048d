"""The scripted team plays KickOffShot: who kicks off leaves the ball to the other one."""

import numpy as np

from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import Status, make_task


def test_a_scripted_pair_scores_from_the_kick_off():
    core = SoccerCore(make_task("KickOffShot"), 40, controlled=(), others="medium", seed=1)
    core.reset(1)
    ends = np.zeros(40, int)
    for _ in range(600):
        step = core.step(None)
        ends = np.where((ends == 0) & (step.terminated | step.truncated), step.status, ends)
    assert (ends == Status.GOAL).mean() >= 0.5
    assert (ends == Status.OUT_OF_BOUNDS).mean() <= 0.25, "the kick-off is not touched twice"
