"""Appendix A with the simulator's own roundings: they are bounded from the formula, and the proof holds with them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.agents.body import Body
from cprm_gym.agents.worlds import observer
from cprm_gym.agents.worlds.observer import TAU, simulated_approaches, simulator_approach, simulator_observer, told_shares
from cprm_gym.architecture.analysis.certificates.slow_approach import Observer, propose
from cprm_gym.errors import ParameterError
from cprm_gym.simulator.kernels.rounding import banded_distance
from cprm_gym.simulator.parameters import ServerParameters

SERVER = ServerParameters()


def told(distances, step):
    return np.array([banded_distance(d, step) for d in distances])


@pytest.mark.parametrize("step", [0.1, 0.05])
def test_no_distance_that_the_simulator_tells_leaves_the_bounds_and_they_are_tight(step):
    server = replace(SERVER, quantize_step=step)
    near, far = Body(server=server).reach, 40.0
    least, most = told_shares(server, near, far)
    rng = np.random.default_rng(3)
    true = np.exp(rng.uniform(math.log(near), math.log(far), 40_000))
    shares = told(true, step) / true
    assert least <= shares.min()
    assert shares.max() <= most
    assert shares.min() - least < 2e-3
    assert most - shares.max() < 2e-3


def test_the_observer_is_the_one_that_the_appendix_names():
    found = simulator_observer()
    assert found.rho_d == pytest.approx(Observer().rho_d, abs=1e-3)
    assert found.rho_d <= 0.9161 / 1.0685
    assert found.e_s == pytest.approx(0.025)
    assert found.h == pytest.approx(math.radians(0.5))


def test_the_approach_is_proved_with_the_simulators_motion_noise_and_roundings():
    world = simulator_approach()
    assert (world.gamma, world.delta_s, world.a_max) == (SERVER.player_decay, SERVER.player_rand, 0.6)
    assert world.epsilon_d == pytest.approx(1.085)
    assert world.delta_omega == pytest.approx(1.1 * 1.025 - 1, abs=1e-6)
    proof = propose(world, tau=TAU).check(world)
    assert proof.proved
    assert proof.steps <= 60


def longest(worlds, seed):
    """The most cycles that an approach in the simulator takes."""
    played = simulated_approaches(worlds, seed)
    assert (played >= 0).all()
    return int(played.max())


def test_no_approach_in_the_simulator_takes_longer_than_is_proved():
    world = simulator_approach()
    steps = propose(world, tau=TAU).check(world).steps
    assert 10 < longest(3000, 1) <= steps


@pytest.mark.slow
def test_no_approach_of_two_hundred_thousand_in_the_simulator_takes_longer():
    """`pytest -m slow tests/agents/test_observer.py`."""
    world = simulator_approach()
    steps = propose(world, tau=TAU).check(world).steps
    assert max(longest(20_000, seed) for seed in range(10)) <= steps


def test_an_agent_that_is_told_the_other_side_does_not_arrive_in_time(monkeypatch):
    monkeypatch.setattr(observer, "_between", lambda angle: -((np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi))
    world = simulator_approach()
    steps = propose(world, tau=TAU).check(world).steps
    played = simulated_approaches(200, 2)
    assert ((played < 0) | (played > steps)).mean() > 0.1


def test_coarser_eyes_cost_cycles_and_wilder_motion_the_proof():
    """Told distances may be off by factors: they only make him slow. Three times the noise of motion leaves nothing to be shown."""

    def proved(**changes):
        world = simulator_approach(replace(SERVER, **changes))
        found = propose(world, tau=TAU)
        proof = None if found is None else found.check(world)
        return proof.steps if proof is not None and proof.proved else None

    sharp, dim, blind = (proved(quantize_step=step) for step in (0.1, 0.9, 3.0))
    assert sharp < dim < blind
    assert proved(player_rand=0.3) is None


def test_what_cannot_be_bounded_is_refused():
    with pytest.raises(ParameterError, match="told as 0"):
        told_shares(SERVER, 0.01, 1.0)
    with pytest.raises(ParameterError, match="a step"):
        simulator_observer(replace(SERVER, quantize_step=0.0))
