"""The observation's layout."""

import numpy as np

from cprm_gym.envs.observations import observation_space


def test_observation_space_has_finite_bounds_and_named_task_part():
    space = observation_space((("distance_to_goal", 0.0, 120.0),))
    assert space["task"].shape == (1,)
    assert all(np.isfinite(part.low).all() and np.isfinite(part.high).all() for part in space.values())
    assert "task" not in observation_space()
