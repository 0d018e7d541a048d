"""Hike: out to the view and home again, spun round in the middle both times."""

import math

import numpy as np
import pytest

from cprm_gym import make_task
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks.base import Status
from cprm_gym.errors import ParameterError


def idle(core):
    return {key: value[:, None] for key, value in no_action(core.worlds).items()}


def put(core, x, y=0.0):
    core.place_player(1, np.full(core.worlds, x), np.full(core.worlds, y), np.zeros(core.worlds))


def test_he_starts_at_home_and_faces_anywhere():
    core = SoccerCore(make_task("Hike", way=20.0), 50, seed=1)
    core.reset(1)
    np.testing.assert_allclose(core.sim.world["pos"][:, 1], np.tile([-10.0, 0.0], (50, 1)), atol=1e-9)
    assert np.ptp(core.sim.world["body"][:, 0]) > math.pi


def test_home_counts_only_after_the_view_and_pays_once():
    core = SoccerCore(make_task("Hike"), 3, seed=2)
    core.reset(2)
    assert not core.step(idle(core)).terminated.any()  # he is at home, but has seen nothing
    put(core, 2.0)
    core.step(idle(core))  # spun round in the middle
    put(core, 15.0)
    first = core.step(idle(core))
    np.testing.assert_array_equal(first.reward[:, 0], 1.0)
    put(core, 15.0)
    np.testing.assert_array_equal(core.step(idle(core)).reward[:, 0], 0.0)
    put(core, -2.0)
    core.step(idle(core))  # and again
    put(core, -15.0)
    last = core.step(idle(core))
    assert last.terminated.all()
    assert last.success.all()
    assert (last.status == Status.SUCCESS).all()
    np.testing.assert_array_equal(last.reward[:, 0], 1.0)


def test_the_middle_looks_the_same_out_and_home():
    """Once each way he stands still in the middle and faces anywhere; what an agent is told does not say which way it is."""
    core = SoccerCore(make_task("Hike"), 400, seed=3, include=("memory",))
    observation = core.reset(3)
    put(core, 2.0)
    core.step(idle(core))
    out = core.sim.world["body"][:, 0].copy(), core.sim.world["pos"][:, 1].copy()
    put(core, 4.0)
    core.step(idle(core))
    assert (core.sim.world["pos"][:, 1, 0] > 3.0).all()  # the second time nothing happens
    put(core, 15.0)
    core.step(idle(core))
    put(core, -2.0)
    core.step(idle(core))
    home = core.sim.world["body"][:, 0].copy(), core.sim.world["pos"][:, 1].copy()
    for facing, place in (out, home):
        np.testing.assert_allclose(place, 0.0, atol=1e-9)
        assert abs(np.mean(np.exp(1j * facing))) < 0.15
    assert np.abs(np.mean(np.exp(1j * (out[0] - home[0])))) < 0.15
    assert {key: value.shape for key, value in observation.items()} == {k: v.shape for k, v in core.reset(3).items()}


def test_worlds_do_not_depend_on_the_batch():
    def faces(worlds, first):
        core = SoccerCore(make_task("Hike"), worlds, seed=5, first_world=first)
        core.reset(5)
        put(core, 2.0)
        core.step(idle(core))
        return core.sim.world["body"][:, 0].copy()

    np.testing.assert_array_equal(faces(4, 0)[2:], faces(2, 2))


def test_ways_that_are_none_are_refused():
    with pytest.raises(ParameterError, match=r"way: 200\.0 given; allowed are finite numbers from 8 to 90"):
        make_task("Hike", way=200.0)
