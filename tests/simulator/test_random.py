"""Random draws: right distributions, and nobody's draw depends on anybody else's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from cprm_gym.simulator.kernels import kernel
from cprm_gym.simulator.kernels.random import (
    PHYSICS,
    SENSORS,
    bernoulli,
    decide,
    normal,
    polar_noise,
    shuffle,
    uniform,
    uniform_between,
)
from cprm_gym.simulator.state import WORLD

N = 20000


@kernel
def fill_uniform(worlds, stream, objects, purpose, out):
    """Draws of objects 0..objects-1 over many steps, ``out`` (steps, objects)."""
    w = worlds[0]
    for step in range(out.shape[0]):
        w.steps = step
        for a in range(objects):
            out[step, a] = uniform(w, stream, a, purpose, 0)


@kernel
def fill_others(worlds, out):
    """Columns: U(-2, 5), U(5, -2), Bernoulli(0.3), Normal(1, 2), polar noise of radius 3 (x, y), decide with 0.3."""
    w = worlds[0]
    for k in range(out.shape[0]):
        w.steps = k
        out[k, 0] = uniform_between(w, 0, 1, 1, 0, -2.0, 5.0)
        out[k, 1] = uniform_between(w, 0, 1, 1, 0, 5.0, -2.0)
        out[k, 2] = bernoulli(w, 0, 1, 2, 0, 0.3)
        out[k, 3] = normal(w, 0, 1, 3, 0, 1.0, 2.0)
        out[k, 4], out[k, 5] = polar_noise(w, 0, 1, 4, 0, 3.0)
        out[k, 6] = decide(w, 0, 0, 1, 2, 0, 0.3)


@kernel
def fill_orders(worlds, out):
    """A permutation per row."""
    w = worlds[0]
    for k in range(out.shape[0]):
        w.steps = k
        shuffle(w, 0, -1, 1, out[k], out.shape[1])


@kernel
def corners(worlds, out):
    """Values at the edges."""
    w = worlds[0]
    out[0] = uniform_between(w, 0, 1, 1, 0, 3.0, 3.0 + 1e-11)
    out[1], out[2] = polar_noise(w, 0, 1, 1, 0, 0.0)
    out[3] = bernoulli(w, 0, 1, 1, 0, 0.0)
    out[4] = bernoulli(w, 0, 1, 1, 0, 1.0)
    out[5] = decide(w, 1, 0, 1, 1, 0, 0.0)
    out[6] = decide(w, -1, 0, 1, 1, 0, 1.0)


def world(key=7):
    worlds = np.zeros(1, WORLD)
    worlds["key"] = np.random.SeedSequence(key).generate_state(4, np.uint64)
    return worlds


def draws(stream=PHYSICS, purpose=2, key=7, steps=N // 10, objects=10):
    out = np.zeros((steps, objects))
    fill_uniform(world(key), stream, objects, purpose, out)
    return out


def test_uniform_draws_are_uniform_over_steps_and_objects():
    out = draws()
    assert stats.kstest(out.ravel(), "uniform").pvalue > 0.001
    assert all(stats.kstest(column, "uniform").pvalue > 1e-4 for column in out.T)
    assert out.min() >= 0
    assert out.max() < 1
    assert len(np.unique(out)) == out.size


def test_draws_of_neighbours_in_step_object_purpose_and_stream_are_independent():
    base = draws()
    for other in (np.roll(base, 1, axis=0), np.roll(base, 1, axis=1), draws(purpose=3), draws(stream=SENSORS), draws(key=8)):
        assert abs(np.corrcoef(base.ravel(), other.ravel())[0, 1]) < 4 / np.sqrt(base.size)
        table = np.histogram2d(base.ravel(), other.ravel(), bins=8)[0]
        assert stats.chisquare(table.ravel()).pvalue > 1e-4


def test_a_draw_depends_only_on_its_own_address():
    few, many = draws(objects=3), draws(objects=10)
    assert (few == many[:, :3]).all()
    assert (draws(steps=50) == many[:50]).all()


def test_distributions():
    out = np.zeros((N, 7))
    fill_others(world(), out)
    assert stats.kstest((out[:, 0] + 2) / 7, "uniform").pvalue > 0.001
    assert (out[:, 0] == out[:, 1]).all()
    assert stats.binomtest(int(out[:, 2].sum()), N, 0.3).pvalue > 0.001
    assert (out[:, 2] == out[:, 6]).all()
    assert stats.kstest((out[:, 3] - 1) / 2, "norm").pvalue > 0.001
    radius, angle = np.hypot(out[:, 4], out[:, 5]), np.arctan2(out[:, 5], out[:, 4])
    assert stats.kstest(radius / 3, "uniform").pvalue > 0.001
    assert stats.kstest(angle / (2 * np.pi) + 0.5, "uniform").pvalue > 0.001
    assert abs(stats.spearmanr(radius, angle).statistic) < 4 / np.sqrt(N)


def test_orders_are_uniform_permutations():
    out = np.zeros((N, 4), np.uint8)
    fill_orders(world(), out)
    counts = np.unique(out @ np.array([64, 16, 4, 1]), return_counts=True)[1]
    assert len(counts) == 24
    assert stats.chisquare(counts).pvalue > 0.001


def test_edges():
    out = np.zeros(7)
    corners(world(), out)
    assert out[0] == pytest.approx(3.0)
    assert out[1:].tolist() == [0, 0, 0, 1, 1, 0]
