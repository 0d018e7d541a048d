"""Worlds without rules are played by a step that is compiled without the referee."""

import numba
import numpy as np
import pytest

from cprm_gym.simulator.kernels.referee.events import on_kick, on_step
from cprm_gym.simulator.packing import NO_REFEREE, PARAMETERS
from cprm_gym.simulator.parameters import Rules, ServerParameters
from cprm_gym.simulator.simulator import Simulator

JIT = not numba.config.DISABLE_JIT


def play(sim, cycles=80):
    sim.world["mode"] = 3
    rng = np.random.default_rng(3)
    sim.trainer.place_player(1, 0.3, 0.0, 0.0)
    for _ in range(cycles):
        sim.commands["kind"] = rng.integers(0, 6, sim.commands.shape)
        sim.commands["a"], sim.commands["b"] = rng.uniform(-100, 100, (2, *sim.commands.shape))
        sim.step()
    return sim.snapshot()


def test_both_steps_give_the_same_worlds():
    silent, whistled = (Simulator(3, rules=Rules.NONE, seed=1) for _ in range(2))
    whistled.played = whistled.packed  # the type with which everything of the referee is compiled
    whistled.trainer._packed = whistled.packed
    one, other = play(silent), play(whistled)
    assert one.tobytes() == other.tobytes()
    assert (one["counts"][:, :, 0] > 0).any(), "somebody kicked"


@pytest.mark.skipif(not JIT, reason="there are no compiled versions")
def test_only_parameters_without_rules_leave_the_referee_out():
    for event in (on_kick, on_step):
        assert event._version((None, numba.from_dtype(NO_REFEREE))) is event.silence
        assert event._version((None, numba.from_dtype(PARAMETERS))) is event.callee


def test_rules_and_the_automatic_mode_keep_the_referee():
    assert Simulator(1, rules=Rules.NONE).played.dtype == NO_REFEREE
    assert Simulator(1, rules=Rules.TIME).played.dtype == PARAMETERS
    assert Simulator(1, ServerParameters(auto_mode=True), rules=Rules.NONE).played.dtype == PARAMETERS


def test_the_record_without_a_referee_is_the_same_memory():
    for name in PARAMETERS.names:
        assert NO_REFEREE.fields[name][:2] == PARAMETERS.fields[name][:2]
    assert NO_REFEREE.itemsize == PARAMETERS.itemsize
