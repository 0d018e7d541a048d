"""Appendix A: as printed it is contradictory, corrected it is proved in exact fractions, and no simulated approach beats its bounds."""

import math
import time
from fractions import Fraction

import numpy as np
import pytest

from cprm_gym.architecture.analysis.certificates.attractor import Attractor, must_reach, recheck
from cprm_gym.architecture.analysis.certificates.grid import Grid, branches, threshold_attractor
from cprm_gym.architecture.analysis.certificates.lemmas import LEMMAS, prove_lemmas
from cprm_gym.architecture.analysis.certificates.rationals import cosine, root, sine
from cprm_gym.architecture.analysis.certificates.slow_approach import Certificate, Observer, SlowParams, printed_conditions, propose
from cprm_gym.errors import ModelError

CODE = SlowParams()
CASES = {  # parameters, threshold, ratio, amount, steps from any direction
    "code": (CODE, 0.35, 0.647, 0.462, 50),
    "inertia": (SlowParams(delta_omega=0.1276), 0.4364, 0.676, 0.425, 54),
    "manual": (SlowParams(delta_s=0.1414, delta_a=0.1), 0.40, 0.748, 0.378, 60),
    "manual, inertia": (SlowParams(delta_s=0.1414, delta_a=0.1, delta_omega=0.1276), 0.48, 0.769, 0.345, 66),
    "printed observer": (SlowParams(observer=Observer(rho_d=0.916 / 1.084, rho_s=1.1 / 0.9, e_s=0.0)), 0.35, 0.738, 0.462, 50),
}


@pytest.mark.parametrize("case", CASES)
def test_the_corrected_theorem_holds_with_the_known_rates(case):
    params, tau, ratio, amount, steps = CASES[case]
    certificate = propose(params, tau=tau)
    start = time.process_time()
    proof = certificate.check(params)
    seconds = time.process_time() - start
    assert proof.proved
    assert float(proof.ratio) == pytest.approx(ratio, abs=6e-4)
    assert float(proof.amount) == pytest.approx(amount, abs=6e-4)
    assert (proof.steps, proof.any_direction) == (steps, True)
    assert seconds < 0.15  # 7 ms where nothing else runs


def test_strict_alternation_is_proved_too():
    proof = propose(CODE).check(CODE)
    assert proof.proved
    assert proof.steps == 47


@pytest.mark.parametrize(
    ("change", "fails"),
    [
        ({"e_w": 0.5}, "C1"),
        ({"e_a": 0.1}, "C2"),
        ({"e_a": 0.345}, "T"),
        ({"tau": 1.5}, "P1"),
    ],
)
def test_a_wrong_certificate_names_the_condition_that_fails(change, fails):
    good = propose(CODE, tau=0.35)
    proof = Certificate(**{"e_w": good.e_w, "e_a": good.e_a, "tau": good.tau, **change}).check(CODE)
    assert not proof.proved
    assert proof.steps is None
    assert fails in [c.name.split(":")[0] for c in proof.conditions if not c.holds]


def test_smaller_errors_never_lose_a_certificate():
    certificate = propose(SlowParams(delta_s=0.1, delta_omega=0.12), tau=0.42)
    for ds in (0.1, 0.05, 0.0):
        for dw in (0.12, 0.05, 0.0):
            assert certificate.check(SlowParams(delta_s=ds, delta_omega=dw)).proved


def test_the_printed_conditions_contradict_each_other_at_the_defaults():
    printed = printed_conditions(CODE, h_s=0.05)
    assert not printed.feasible
    assert {"c2", "c3"} <= set(printed.contradictory)
    assert printed.gain == pytest.approx(1.542, abs=1e-3)
    assert printed_conditions(SlowParams(gamma=0.8, delta_s=0.1)).feasible
    assert not printed_conditions(SlowParams(gamma=0.7, delta_s=0.1)).feasible
    assert printed_conditions(SlowParams(gamma=0.4, delta_s=0.02, delta_omega=0.02)).feasible


def test_the_printed_lemma_on_speed_is_false():
    """CE1: all seven printed conditions, and the agent backs up."""
    g, ds, da, hs, hd = 0.9, 0.02, 0.25, 0.25, 0.25
    c, kappa = (1 - g) / ((1 + ds) * (1 + da)), g * (1 + ds) / (1 - g)
    d, s = 1.0, 1.0 / kappa
    seen_d, seen_s = 0.75, s * (1 + hs)
    a = c * (seen_d / (1 + hd) - kappa * seen_s / (1 - hs))
    assert g * s + a * (1 + da) == pytest.approx(-0.0065, abs=1e-4)
    assert d >= kappa * s


def test_enclosures_of_sines_and_roots():
    for x in np.linspace(-3.2, 3.2, 41):
        exact = Fraction(float(x))
        for low, high, value in ((*sine(exact), math.sin(x)), (*cosine(exact), math.cos(x))):
            assert low <= high
            assert high - low < Fraction(1, 10**12)
            assert float(low) - 1e-15 <= value <= float(high) + 1e-15
    low, high = root(Fraction(2))
    assert low * low <= 2 <= high * high


def test_parameters_without_sense_are_refused():
    with pytest.raises(ModelError, match="0 < gamma < 1"):
        SlowParams(gamma=1.0)


# ------------------------------------------------------------------------------------------------------ the grid


def one_cycle(params, tau, state, rng, extreme):
    """The world itself, with any noise within its bounds; state (W, 3) of d, s, theta."""
    d, s, theta = state.T
    w = len(d)

    def noise(size):
        x = rng.uniform(-1, 1, w)
        return size * np.where(extreme & (rng.random(w) < 0.7), np.sign(x), x)

    o = params.observer
    seen = (theta + noise(o.h) + np.pi) % (2 * np.pi) - np.pi
    turns = np.abs(seen) > tau
    dc = o.rho_d * d - o.e_d + (0.5 + noise(0.5)) * (d - o.rho_d * d + o.e_d)
    sc = s + (0.5 + noise(0.5)) * ((o.rho_s - 1) * s + o.e_s)
    c = (1 - params.gamma) / ((1 + params.delta_s) * (1 + params.delta_a))
    a = np.clip(c * (dc - float(params.kappa) * sc), 0.0, params.a_max)
    alpha = np.where(turns, theta - seen * (1 + noise(params.delta_omega)), theta)
    v = np.where(turns, params.gamma * s, params.gamma * s + a * (1 + noise(params.delta_a)))
    radius, angle = np.abs(noise(params.delta_s)), rng.uniform(-np.pi, np.pi, w)
    moved = d * np.exp(1j * alpha) - v * (1 + radius * np.exp(1j * angle))
    return np.stack((np.abs(moved), v, np.angle(moved)), axis=1)


def approaches(params, tau, count, seed, attractor):
    """Steps of simulated approaches; checks in every cycle that the layer falls."""
    rng = np.random.default_rng(seed)
    state = np.stack((rng.uniform(params.epsilon_d, 11.9, count), rng.uniform(0, 1.05, count), rng.uniform(-np.pi, np.pi, count)), axis=1)
    edge = rng.random(count) < 0.2  # where cells meet
    state[edge, 0] = rng.choice(attractor.edges[0][:-2], edge.sum())
    state[edge, 1] = rng.choice(attractor.edges[1], edge.sum())
    state[edge, 2] = rng.choice([-1, 1], edge.sum()) * rng.choice(attractor.edges[2], edge.sum())
    extreme = rng.random(count) < 0.5
    steps = np.zeros(count, int)
    going = np.arange(count)
    bound = attractor.at(np.abs(state))
    assert (bound > 0).all()
    layer = bound.copy()
    while going.size:
        state = one_cycle(params, tau, state, rng, extreme)
        steps[going] += 1
        left = state[:, 0] >= params.epsilon_d
        now = attractor.at(np.abs(state[left]))
        assert (now >= 0).all()
        assert (now < layer[left]).all()
        state, going, extreme, layer = state[left], going[left], extreme[left], now
    return steps, bound


TAU = math.radians(25)


@pytest.fixture(scope="module")
def attractor():
    return threshold_attractor(CODE, TAU)


def test_from_nearly_everywhere_the_goal_is_reached_within_21_steps(attractor):
    assert attractor.steps_from((1.085, 0.0, 0.0), (11.9, 1.05, math.pi)) == 21
    assert attractor.steps_from((1.085, 0.0, 0.0), (1.5, 1.05, math.pi)) < 12
    assert recheck(attractor, branches(CODE, TAU, attractor.edges), CODE.epsilon_d)


def test_no_simulated_approach_takes_longer_and_every_step_comes_nearer(attractor):
    steps, bound = approaches(CODE, TAU, 20_000, 1, attractor)
    assert (steps <= bound).all()
    assert steps.max() > 10


@pytest.mark.slow
def test_no_approach_of_a_million_takes_longer(attractor):
    """`pytest -m slow tests/architecture/analysis/certificates`."""
    worst = 0
    for seed in range(10):
        steps, bound = approaches(CODE, TAU, 100_000, seed, attractor)
        assert (steps <= bound).all()
        worst = max(worst, int(steps.max()))
    assert worst <= 21


def test_a_tampered_layer_is_found(attractor):
    layer = attractor.layer.copy()
    layer[layer == layer.max()] = 1
    assert not recheck(Attractor(attractor.edges, layer), branches(CODE, TAU, attractor.edges), CODE.epsilon_d)


def test_an_agent_that_turns_the_wrong_way_is_not_shown_to_arrive():
    """The sign as printed: what is off axis doubles."""
    edges = Grid(theta_cells=12, d_step=0.4, s_step=0.15).edges(CODE)
    turn, dash = branches(CODE, TAU, edges)
    wrong = turn._replace(low=np.concatenate((turn.low[:, :2], np.zeros((len(turn.low), 1))), axis=1),
                          high=np.concatenate((turn.high[:, :2], np.full((len(turn.low), 1), np.pi)), axis=1))  # fmt: skip
    far = must_reach(edges, (wrong, dash), CODE.epsilon_d)
    assert (far.layer >= 0).mean() < 0.5


@pytest.mark.slow
def test_every_lemma_is_proved_for_all_parameters():
    """`pytest -m slow tests/architecture/analysis/certificates`."""
    pytest.importorskip("z3")
    found = prove_lemmas()
    assert len(found) == len(LEMMAS) >= 9
    assert [name for name, verdict in found.items() if not verdict.holds] == []
