"""Chances learned with the engines of real numbers: one update by brute force over all modes, the optimum, and two levels again."""

from itertools import pairwise, product

import numpy as np
import pytest
from scipy import optimize, stats

from cprm_gym.architecture.prm import BOOL, Attribute, Chance, Grounding, Model, Noise, Prior, PRMClass, Real, Switch, Table, em
from cprm_gym.architecture.prm.inference.engines.chance_learning import tilted
from cprm_gym.architecture.prm.inference.engines.mixture import MixtureEngine
from cprm_gym.architecture.prm.inference.engines.rao_blackwell import RaoBlackwellEngine
from cprm_gym.architecture.prm.inference.learning import Episode
from cprm_gym.architecture.prm.model.formulas import Formula

STAY = np.array([[0.8, 0.2], [0.3, 0.7]])
FORMULAS = {"no": "0.9 if x < 1 else 0.2", "yes": "1 / (1 + exp(-x))"}


def world(*attributes):
    return Grounding(Model("test", (PRMClass("A", attributes),)), {"a": "A"})


def cpd_of(model, name):
    return next(a for a in model.classes[0].attributes if a.name == name).cpd


def two_modes():
    """A hidden mode that lasts, a number that is read, and a hit whose chance depends on both."""
    return world(
        Attribute("mode", BOOL, Table({("no",): (0.8, 0.2), ("yes",): (0.3, 0.7)}), ("prev.mode",), Prior((0.6, 0.4))),
        Attribute("x", Real("m"), Noise("0", sd=2.0)),
        Attribute("hit", BOOL, Switch("mode", {state: Chance(text) for state, text in FORMULAS.items()}), ("mode", "x")),
    )


def values(text, x):
    return Formula(text)({"x": np.asarray(x, float)}, len(x))


def data(seed=1, runs=4, steps=5):
    rng = np.random.default_rng(seed)
    x, hit = 2.0 * rng.normal(size=(steps, runs)), rng.random((steps, runs)) < 0.5
    return x, hit, Episode(tuple({"a.x": row, "a.hit": made.astype(int)} for row, made in zip(x, hit)), batch=runs)


def enumerated(x, hit, texts):
    """Log-likelihood of the hits, and the probability of each mode, by a sum over all paths."""
    steps, runs = x.shape
    chance = np.array([values(texts[state], x.ravel()).reshape(x.shape) for state in ("no", "yes")])
    said = np.where(hit, chance, 1.0 - chance)
    total, modes = np.zeros(runs), np.zeros((steps, 2, runs))
    for path in product((0, 1), repeat=steps):
        weight = np.full(runs, (0.6, 0.4)[path[0]]) * np.prod([STAY[a, b] for a, b in pairwise(path)])
        for t, mode in enumerate(path):
            weight = weight * said[mode, t]
        total += weight
        for t, mode in enumerate(path):
            modes[t, mode] += weight
    return float(np.log(total).sum()), modes / total


def log_odds(p):
    return np.log(p / (1.0 - p))


@pytest.mark.parametrize("engine", [MixtureEngine(256), RaoBlackwellEngine(256)])
def test_one_update_is_that_of_all_paths_of_modes(engine):
    """Expected counts by enumeration, and the square in offset and scale that bounds the expected log-likelihood, solved by numpy."""
    x, hit, episode = data()
    fit = em(two_modes(), [episode], iterations=1, engine=engine, only=[("class", "A", "hit")])
    likelihood, modes = enumerated(x, hit, FORMULAS)
    assert fit.log_likelihoods[0] == pytest.approx(likelihood + stats.norm(0, 2).logpdf(x).sum(), abs=1e-9)
    for k, state in enumerate(("no", "yes")):
        odds = log_odds(values(FORMULAS[state], x.ravel()))
        design, weight = np.stack([np.ones_like(odds), odds], axis=1), modes[:, k].ravel()
        curve = (np.tanh(odds / 2) / (2 * odds))[:, None]
        wanted = np.linalg.solve(design.T @ (weight[:, None] * curve * design), design.T @ (weight * (hit.ravel() - 0.5)))
        found = dict(cpd_of(fit.model, "hit").cases)[state]
        at = np.linspace(-3.0, 3.0, 7)
        np.testing.assert_allclose(log_odds(values(found.p, at)), wanted[0] + wanted[1] * log_odds(values(FORMULAS[state], at)), atol=1e-9)


def test_it_ends_where_the_likelihood_of_all_paths_is_greatest():
    x, hit, episode = data(seed=3, runs=60)
    fit = em(two_modes(), [episode], iterations=300, engine=MixtureEngine(256), only=[("class", "A", "hit")])
    assert all(b > a - 1e-9 for a, b in pairwise(fit.log_likelihoods))

    def loss(numbers):
        texts = {s: tilted(Chance(FORMULAS[s]), *numbers[2 * k : 2 * k + 2]).p for k, s in enumerate(("no", "yes"))}
        return -enumerated(x, hit, texts)[0]

    best = optimize.minimize(loss, [0.0, 1.0, 0.0, 1.0], bounds=[(-4, 4), (1e-3, 8)] * 2, method="L-BFGS-B")
    reached = fit.log_likelihoods[-1] - stats.norm(0, 2).logpdf(x).sum()
    assert reached == pytest.approx(-best.fun, abs=2e-3)
    assert reached > fit.log_likelihoods[0] - stats.norm(0, 2).logpdf(x).sum() + 1.0


def test_two_levels_over_a_number_that_nobody_reads_come_out_as_on_fine_bins():
    """Near enough to see: how likely a look shows it, inside and outside of a cone, where a reading with noise tells the place."""
    rng = np.random.default_rng(5)
    x = 2.0 * rng.normal(size=4000)
    seen, read = rng.random(4000) < np.where(np.abs(x) < 1.5, 0.9, 0.15), x + 0.4 * rng.normal(size=4000)
    eye = world(
        Attribute("x", Real("m"), Noise("0", sd=2.0)),
        Attribute("z", Real("m"), Noise("x", sd=0.4), ("x",)),
        Attribute("seen", BOOL, Chance("0.7 if abs(x) < 1.5 else 0.4"), ("x",)),
    )
    fit = em(
        eye,
        [Episode(({"a.z": read, "a.seen": seen.astype(int)},), batch=4000)],
        iterations=40,
        engine="mixture",
        only=[("class", "A", "seen")],
    )
    inside, outside = values(cpd_of(fit.model, "seen").p, [0.0, 3.0])

    fine = np.linspace(-9.0, 9.0, 1801)
    share = stats.norm(0, 2).pdf(fine)[:, None] * stats.norm(0, 0.4).pdf(read - fine[:, None])
    near = (share * (np.abs(fine) < 1.5)[:, None]).sum(axis=0) / share.sum(axis=0)

    def loss(levels):
        p = near * levels[0] + (1.0 - near) * levels[1]
        return -np.log(np.where(seen, p, 1.0 - p)).sum()

    best = optimize.minimize(loss, [0.7, 0.4], bounds=[(0.01, 0.99)] * 2)
    assert [inside, outside] == pytest.approx(best.x, abs=0.02)
    assert [inside, outside] == pytest.approx([0.9, 0.15], abs=0.04)


def test_a_certainty_stays_one_and_a_prior_in_a_switch_is_counted():
    rng = np.random.default_rng(6)
    mode, x = rng.random(500) < 0.4, rng.normal(size=500)
    hit = np.where(mode, rng.random(500) < np.where(x < 0, 0.0, 0.7), rng.random(500) < 0.25)
    worlds = world(
        Attribute("mode", BOOL, Prior((0.5, 0.5))),
        Attribute("x", Real("m"), Noise("0", sd=1.0)),
        Attribute("hit", BOOL, Switch("mode", {"no": Prior((0.5, 0.5)), "yes": Chance("0 if x < 0 else 0.4")}), ("mode", "x")),
    )
    episode = Episode(({"a.mode": mode.astype(int), "a.x": x, "a.hit": hit.astype(int)},), batch=500)
    fit = em(worlds, [episode], iterations=60, engine="mixture", only=[("class", "A", "hit")])
    cases = dict(cpd_of(fit.model, "hit").cases)
    assert cases["no"].p[1] == pytest.approx(hit[~mode].mean(), abs=1e-9)
    assert values(cases["yes"].p, [-1.0])[0] == 0.0
    assert values(cases["yes"].p, [1.0])[0] == pytest.approx(hit[mode & (x >= 0)].mean(), abs=1e-6)
    assert len(cases["yes"].p) < 60


@pytest.mark.parametrize(("text", "floor"), [("clip(0.5 + 0.1 * x, 0, 1)", 0.0), ("0.5 if x < 0 else exp(-x)", 0.1), ("0.25", 0.0)])
def test_tilting_twice_is_tilting_once(text, floor):
    x = np.linspace(-4.0, 4.0, 9)
    twice = tilted(tilted(Chance(text, floor=floor), 0.3, 0.8), -0.5, 1.5)
    once = tilted(Chance(text, floor=floor), 1.5 * 0.3 - 0.5, 0.8 * 1.5)
    np.testing.assert_allclose(values(twice.p, x), values(once.p, x), atol=1e-12)
    assert len(twice.p) <= len(once.p) + 40


def test_a_prior_holds_the_chance_where_there_is_little_to_learn_from():
    def learned(prior):
        eye = world(Attribute("x", Real("m"), Noise("0", sd=1.0)), Attribute("seen", BOOL, Chance("0.5 if x < 9 else 0.4"), ("x",)))
        fit = em(eye, [[{"a.x": 0.0, "a.seen": "yes"}]], iterations=1, prior=prior, engine="mixture", only=[("class", "A", "seen")])
        return values(cpd_of(fit.model, "seen").p, [0.0])[0]

    assert 0.5 < learned(20.0) < learned(2.0) < learned(0.0)
