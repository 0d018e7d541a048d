"""Rare failures of the simulator by splitting, against plain runs and against the noise as the manual has it."""

import numpy as np
import pytest

from cprm_gym.benchmark.behaviours.straying import Pass, StrayingBall, StrayingPass, counted, plain, split, split_passes
from cprm_gym.simulator.parameters import ServerParameters


def by_formula(runs, seed, kick):
    """Share of failures where ball and noise are computed here: velocity, a disc of noise, position, decay."""
    p, rng = ServerParameters(), np.random.default_rng(seed)
    x, y, vx, vy = np.zeros(runs), np.zeros(runs), np.full(runs, kick.speed), np.zeros(runs)
    aside, done = np.zeros(runs), np.zeros(runs, bool)
    while not done.all():
        size, angle = np.hypot(vx, vy) * p.ball_rand * rng.random(runs), rng.uniform(-np.pi, np.pi, runs)
        vx, vy = vx + size * np.cos(angle), vy + size * np.sin(angle)
        x, y = x + vx, y + vy
        vx, vy = vx * p.ball_decay, vy * p.ball_decay
        hit = ~done & ((x >= kick.target) | (np.hypot(vx, vy) < 0.01))
        aside[hit] = np.abs(y[hit])
        done |= hit
    return float((aside > kick.reach).mean())


def test_the_ball_strays_as_often_as_the_noise_says():
    kick = Pass(reach=1.2)
    found = plain(4000, kick=kick)
    rate = by_formula(200_000, 1, kick)
    assert found.failures / found.runs == pytest.approx(rate, abs=3 * (rate / found.runs) ** 0.5)


def test_splitting_comes_within_three_errors_of_it():
    kick = Pass(reach=1.6)
    found = split(150, 8, seed=2, kick=kick)
    rate = by_formula(400_000, 2, kick)
    assert abs(found.value - rate) <= 3 * found.deviation
    assert found.zeros == 0.0


def test_a_copy_goes_on_with_luck_of_its_own():
    worlds = StrayingBall(3)
    worlds.begin(1)
    worlds.advance(np.ones(3, bool))
    kept = worlds.keep(0)
    worlds.put(1, kept, 11)
    worlds.put(2, kept, 12)
    assert (worlds.sim.world["pos"][1] == worlds.sim.world["pos"][2]).all()
    worlds.advance(np.ones(3, bool))
    assert (worlds.sim.world["pos"][1] != worlds.sim.world["pos"][2]).any()


def test_a_copy_of_a_pass_knows_where_the_kick_sent_it():
    worlds, everywhere = StrayingPass(3), np.ones(3, bool)
    worlds.begin(4)
    while np.isnan(worlds.sent[0]):
        worlds.advance(everywhere)
    worlds.advance(everywhere)
    strayed, kept = worlds.strayed()[0], worlds.keep(0)
    assert strayed != 0.0
    worlds.put(1, kept, 11)
    worlds.put(2, kept, 12)
    assert (worlds.strayed()[1:] == strayed).all()
    for _ in range(4):
        worlds.advance(everywhere)
    assert worlds.strayed()[1] != worlds.strayed()[2]


def test_passes_of_a_net_are_split_without_bias():
    """Strayed by more than 0.9 m: some four in a hundred."""
    seen = counted(StrayingPass(500, 0.9), 1500, 8, 500)
    rate = seen.failures / seen.runs
    assert 0.02 < rate < 0.08
    found = split_passes(80, 4, seed=3, reach=0.9)
    assert abs(found.value - rate) <= 4 * (found.deviation**2 + rate / seen.runs) ** 0.5


@pytest.mark.slow
def test_one_in_a_hundred_thousand_to_20_percent_in_a_twentieth_of_the_cycles():
    """`pytest -m slow tests/benchmark/test_straying.py`."""
    kick = Pass(reach=2.45)
    found = split(2000, 10, seed=9, kick=kick)
    rate = float(np.mean([by_formula(1_000_000, 100 + k, kick) for k in range(8)]))
    assert 4e-6 < rate < 3e-5
    assert abs(found.value - rate) <= 3 * (found.deviation**2 + rate / 8e6) ** 0.5
    assert found.relative < 0.2
    cycles = found.steps_for(0.2)
    per_run = plain(4000, kick=kick).cycles / 4000
    assert per_run / rate / 0.2**2 > 20 * cycles


def kicks(runs, seed):
    """(k, 6) Place and velocity of the ball and place of the team-mate, seen from where passes of the net begin to roll."""
    worlds, found = StrayingPass(500), []
    for block in range(runs // 500):
        worlds.begin(seed + block)
        going = np.ones(500, bool)
        while going.any():
            before = np.isnan(worlds.sent)
            worlds.advance(going)
            world = worlds.stage.core.sim.world
            sends = before & ~np.isnan(worlds.sent)
            found.append(np.hstack((world["pos"][sends, 0], world["vel"][sends, 0], world["pos"][sends, 2])))
            going &= ~worlds.ended()
    return np.concatenate(found)


def side(at, v, mate):
    """Metres to the right of the team-mate at which a ball comes by that nothing disturbs."""
    gap = mate - at
    return (gap[:, 0] * v[:, 1] - gap[:, 1] * v[:, 0]) / np.hypot(*v.T)


def by_noise_alone(begun, copies, reach, seed):
    """How often the noise of the manual carries passes that are sent so too far from their line, copies of each."""
    p, rng = ServerParameters(), np.random.default_rng(seed)
    failed = 0
    for _ in range(copies):
        at, v, mate = begun[:, :2], begun[:, 2:4], begun[:, 4:]
        sent, done = side(at, v, mate), np.zeros(len(at), bool)
        for _ in range(60):
            size, angle = np.hypot(*v.T) * p.ball_rand * rng.random(len(at)), rng.uniform(-np.pi, np.pi, len(at))
            v = v + size[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)
            at, v = at + v, v * p.ball_decay
            by, rests = ((mate - at) * v).sum(axis=1) <= 0.0, np.hypot(*v.T) <= 0.1
            failed += int((~done & by & ~rests & (np.abs(side(at, v, mate) - sent) > reach)).sum())
            done |= (np.hypot(*(mate - at).T) < 1.2) | by | rests
    return failed / copies / len(begun)


@pytest.mark.slow
def test_a_pass_of_a_net_that_strays_once_in_a_hundred_thousand_takes_a_twentieth_of_the_cycles():
    """`pytest -m slow tests/benchmark/test_straying.py`."""
    found = split_passes(800, 5, seed=0, reach=2.3)
    rate = by_noise_alone(kicks(2000, 50), 2000, 2.3, 1)
    assert 3e-6 < rate < 3e-5
    assert abs(found.value - rate) <= 3 * (found.deviation**2 + rate / 4e6) ** 0.5
    each = counted(StrayingPass(500), 1000, 3, 500)
    assert each.cycles / each.runs / rate / 0.2**2 > 20 * found.steps_for(0.2)
