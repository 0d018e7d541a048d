"""Noise learned with the engine of Gaussian mixtures: closed forms, one update by brute force, and parameters that come out again."""

import numpy as np
import pytest
from scipy import stats

from cprm_gym.architecture.prm import (
    BOOL,
    Add,
    Attribute,
    Given,
    Grounding,
    Mixture,
    Model,
    Noise,
    Prior,
    PRMClass,
    Real,
    Relation,
    Switch,
    Table,
    Uniform,
    em,
)
from cprm_gym.architecture.prm.inference.engines.mixture import MixtureEngine
from cprm_gym.architecture.prm.inference.engines.noise_learning import moved, scaled, unscented
from cprm_gym.architecture.prm.inference.engines.unfolding import unfold
from cprm_gym.architecture.prm.inference.learning import Episode


def world(*attributes, given=()):
    return Grounding(Model("test", (PRMClass("A", attributes, given=given),)), {"a": "A"})


def noise(model, name, part="cpd"):
    found = next(a for a in model.classes[0].attributes if a.name == name)
    return getattr(found, part)


def level(sd=0.5, read=1.0, start=2.0, drift=""):
    """A number that wanders, and a reading of it."""
    return world(
        Attribute("x", Real("m"), Noise(f"prev.x{drift}", sd=sd), ("prev.x",), initial=Noise("0", sd=start)),
        Attribute("z", Real("m"), Noise("x", sd=read), ("x",)),
    )


def wander(rng, runs, steps, sd, read, drift=0.0, start=1.0):
    x = start * rng.normal(size=runs)
    out = []
    for t in range(steps):
        x = x + drift + sd * rng.normal(size=runs) if t else x
        out.append({"a.z": x + read * rng.normal(size=runs)})
    return Episode(tuple(out), batch=runs)


def test_of_numbers_that_are_read_the_fit_is_the_sample_mean_and_deviation():
    rng = np.random.default_rng(1)
    x = np.cumsum(0.3 + rng.normal(size=(20, 12)), axis=0)
    fit = em(level(), [Episode(tuple({"a.x": row} for row in x), batch=12)], iterations=1, engine="mixture")
    steps = np.diff(x, axis=0)
    cpd, initial = noise(fit.model, "x"), noise(fit.model, "x", "initial")
    assert cpd.mean == f"(prev.x) + {steps.mean():.3}"[:10] + cpd.mean[10:]
    assert float(cpd.mean.split("+")[1]) == pytest.approx(steps.mean(), abs=1e-9)
    assert cpd.sd == pytest.approx(steps.std(), abs=1e-9)
    assert [float(initial.mean), initial.sd] == pytest.approx([x[0].mean(), x[0].std()], abs=1e-9)
    assert noise(fit.model, "z") == Noise("x", sd=1.0)  # nobody read it
    assert ("class", "A", "z", "cpd") in fit.kept


def test_one_update_of_a_linear_model_is_the_closed_form():
    """Expectations under the normal of the whole path, conditioned on all readings at once, by numpy."""
    rng = np.random.default_rng(2)
    steps, q, r, start = 7, 0.5, 1.0, 2.0
    z = np.cumsum(rng.normal(size=steps)) + rng.normal(size=steps)
    z[3] = np.nan
    fit = em(level(q, r, start), [[{"a.z": v} for v in z]], iterations=1, engine="mixture")
    covariance = start**2 + q**2 * np.minimum.outer(np.arange(steps), np.arange(steps))
    there = ~np.isnan(z)
    gain = covariance[:, there] @ np.linalg.inv(covariance[np.ix_(there, there)] + r**2 * np.eye(there.sum()))
    mean, rest = gain @ z[there], covariance - gain @ covariance[there]
    residual = mean[1:] - mean[:-1]
    spread = np.diag(rest)[1:] + np.diag(rest)[:-1] - 2.0 * np.diag(rest, 1)
    offset = residual.mean()
    cpd, sensor = noise(fit.model, "x"), noise(fit.model, "z")
    assert float(cpd.mean.partition(") ")[2].replace(" ", "")) == pytest.approx(offset, abs=1e-9)
    assert cpd.sd == pytest.approx(np.sqrt((residual**2 + spread).mean() - offset**2), abs=1e-9)
    off = (z - mean)[there]
    assert sensor.sd == pytest.approx(np.sqrt((off**2 + np.diag(rest)[there]).mean() - off.mean() ** 2), abs=1e-9)
    total = np.linalg.slogdet(2 * np.pi * (covariance[np.ix_(there, there)] + r**2 * np.eye(there.sum())))[1]
    total += z[there] @ np.linalg.solve(covariance[np.ix_(there, there)] + r**2 * np.eye(there.sum()), z[there])
    assert fit.log_likelihoods[0] == pytest.approx(-0.5 * total, abs=1e-9)


def test_transition_and_sensor_come_out_again():
    data = wander(np.random.default_rng(3), runs=60, steps=15, sd=0.4, read=0.8, drift=0.2)
    fit = em(level(0.6, 0.6, 1.0), [data], iterations=40, engine="mixture", only=[("class", "A", "x", "cpd"), ("class", "A", "z")])
    assert all(b > a - 1e-6 for a, b in zip(fit.log_likelihoods, fit.log_likelihoods[1:]))
    cpd, sensor = noise(fit.model, "x"), noise(fit.model, "z")
    assert cpd.sd == pytest.approx(0.4, rel=0.12)
    assert sensor.sd == pytest.approx(0.8, rel=0.06)
    assert float(cpd.mean.partition(") ")[2].replace(" ", "")) == pytest.approx(0.2, abs=0.05)
    assert noise(fit.model, "x", "initial") == Noise("0", sd=1.0)


def test_modes_that_nobody_told_have_noise_of_their_own():
    """A hidden mode turns the noise of a step; its table and both deviations are learned together."""
    rng = np.random.default_rng(4)
    runs, steps = 30, 12
    wild = rng.random((steps, runs)) < 0.25
    x = np.cumsum(np.where(wild, 2.0, 0.2) * rng.normal(size=(steps, runs)), axis=0)
    modes = world(
        Attribute("wild", BOOL, Table({(): (0.5, 0.5)})),
        Attribute("x", Real("m"), Switch("wild", {"no": Noise("prev.x", sd=0.5), "yes": Noise("prev.x", sd=1.0)}), ("prev.x", "wild"),
                  initial=Noise("0", sd=1.0), initial_parents=()),
    )  # fmt: skip
    fit = em(modes, [Episode(tuple({"a.x": row} for row in x), batch=runs)], iterations=12, engine="mixture",
             only=[("class", "A", "wild"), ("class", "A", "x", "cpd")])  # fmt: skip
    assert fit.log_likelihoods[-1] > fit.log_likelihoods[0] + 50.0
    cases = dict(noise(fit.model, "x").cases)
    step = np.diff(x, axis=0)  # what is found is near what would be, had the modes been told
    assert cases["no"].sd == pytest.approx(step[~wild[1:]].std(), rel=0.15)
    assert cases["yes"].sd == pytest.approx(step[wild[1:]].std(), rel=0.15)
    assert noise(fit.model, "wild").values[1] == pytest.approx(wild[1:].mean(), abs=0.05)


def test_a_deviation_that_depends_on_numbers_keeps_its_form_and_gets_a_scale():
    rng = np.random.default_rng(5)
    far = rng.uniform(5.0, 40.0, 400)
    told = far + (0.1 + 0.05 * far) * rng.normal(size=400) + 0.5
    eye = world(
        Attribute("far", Real("m"), Noise("20", sd=15.0)),
        Attribute("seen", Real("m"), Noise("far + bias", sd="0.02 + 0.01 * far"), ("far", "bias")),
        given=(Given("bias", Real("m"), 0.0),),
    )
    fit = em(eye, [Episode(({"a.far": far, "a.seen": told},), batch=400)], iterations=2, engine="mixture", only=[("class", "A", "seen")])
    cpd = noise(fit.model, "seen")
    scale, _, text = cpd.sd.partition(" * ")
    assert text == "(0.02 + 0.01 * far)"
    assert float(scale) == pytest.approx(5.0, rel=0.1)
    assert cpd.mean.startswith("(far + bias) + ")
    assert float(cpd.mean.rpartition(" ")[2]) == pytest.approx(0.5, abs=0.25)


def test_a_prior_holds_the_parameters_where_there_is_little_to_learn_from():
    one = [[{"a.x": 5.0}]]
    free, held = (em(level(), one, iterations=1, engine="mixture", prior=p).model for p in (0.0, 1e6))
    assert float(noise(free, "x", "initial").mean) == pytest.approx(5.0)
    assert float(noise(held, "x", "initial").mean) == pytest.approx(0.0, abs=1e-4)
    assert noise(held, "x", "initial").sd == pytest.approx(2.0, rel=1e-4)


@pytest.mark.parametrize(
    ("given", "offset", "text"),
    [("x", 0.5, "(x) + 0.5"), ("(x) + 0.5", -1.0, "(x) - 0.5"), ("(a) + (b) - 3", 1.0, "((a) + (b) - 3) + 1.0"), ("2", 0.5, "2.5")],
)
def test_offsets_are_added_up(given, offset, text):
    assert moved(given, offset) == text


@pytest.mark.parametrize(
    ("given", "scale", "text"), [("0.1 * x", 2.0, "2.0 * (0.1 * x)"), ("2.0 * (0.1 * x)", 0.5, "1.0 * (0.1 * x)"), (0.3, 2.0, 0.6)]
)
def test_scales_are_multiplied(given, scale, text):
    assert scaled(given, scale) == text


def test_points_have_the_moments_they_stand_for():
    rng = np.random.default_rng(6)
    root = rng.normal(size=(3, 4, 4))
    means, covs = rng.normal(size=(3, 4)), root @ root.transpose(0, 2, 1)
    points, shares = unscented(means, covs)
    np.testing.assert_allclose(np.einsum("p,npd->nd", shares, points), means, atol=1e-12)
    off = points - means[:, None]
    np.testing.assert_allclose(np.einsum("p,npi,npj->nij", shares, off, off), covs, atol=1e-12)


def test_weights_and_parts_of_a_mixture_are_those_of_mixture_em_by_hand():
    """A number that is read, of two normals and a uniform: responsibilities and one update by numpy."""
    rng = np.random.default_rng(11)
    x = np.where(rng.random(200) < 0.3, rng.normal(4.0, 0.5, 200), rng.normal(0.0, 1.0, 200))
    x[::20] = rng.uniform(-10.0, 10.0, 10)
    weights, normals = (0.5, 0.3, 0.2), ((0.5, 1.5), (3.0, 1.0))
    parts = [Noise(str(m), sd=s) for m, s in normals]
    made = world(Attribute("x", Real("m", -10.0, 10.0), Mixture(*zip(weights, (*parts, Uniform())))))
    fit = em(made, [Episode(({"a.x": x},), batch=200)], iterations=1, engine="mixture")
    density = np.stack([w * stats.norm.pdf(x, m, s) for w, (m, s) in zip(weights, normals)] + [np.full(200, weights[2] / 20.0)])
    share = density / density.sum(axis=0)
    learned = noise(fit.model, "x")
    assert [w for w, _ in learned.parts] == pytest.approx(share.sum(axis=1) / 200, abs=1e-9)
    for k in range(2):
        mean = (share[k] * x).sum() / share[k].sum()
        assert float(learned.parts[k][1].mean) == pytest.approx(mean, abs=1e-9)
        assert learned.parts[k][1].sd == pytest.approx(np.sqrt((share[k] * (x - mean) ** 2).sum() / share[k].sum()), abs=1e-9)
    assert learned.parts[2][1] == Uniform()
    assert fit.counts["class", "A", "x", "cpd", "parts"] == pytest.approx(share.sum(axis=1), abs=1e-9)
    assert fit.log_likelihoods[0] == pytest.approx(np.log(density.sum(axis=0)).sum(), abs=1e-8)
    assert [a.name for a in fit.model.classes[0].attributes] == ["x"]


def test_outliers_of_a_sensor_come_out_again_and_other_cpds_stay_where_they_are():
    """A wandering number read by a sensor of which one reading of five is far off: the weight and both deviations, from readings alone."""
    rng = np.random.default_rng(12)
    runs, steps = 40, 10
    x = np.cumsum(0.3 * rng.normal(size=(steps, runs)), axis=0)
    off = rng.random((steps, runs)) < 0.2
    z = x + np.where(off, 4.0, 0.4) * rng.normal(size=(steps, runs))
    sensor = Mixture((0.5, Noise("x", sd=0.6)), (0.5, Noise("x", sd=2.5)))
    made = world(
        Attribute("x", Real("m"), Noise("prev.x", sd=0.3), ("prev.x",), initial=Noise("0", sd=0.3)),
        Attribute("z", Real("m"), sensor, ("x",)),
    )
    data = Episode(tuple({"a.z": row} for row in z), batch=runs)
    fit = em(made, [data], iterations=8, engine=MixtureEngine(24), only=[("class", "A", "z")])
    (weight, near), (_, far) = noise(fit.model, "z").parts
    assert weight == pytest.approx(1.0 - off.mean(), abs=0.06)
    assert near.sd == pytest.approx(0.4, rel=0.15)
    assert far.sd == pytest.approx(4.0, rel=0.25)
    assert noise(fit.model, "x") == Noise("prev.x", sd=0.3)
    assert fit.log_likelihoods[-1] > fit.log_likelihoods[0]
    fixed = em(made, [data], iterations=1, engine=MixtureEngine(24), only=[("class", "A", "x")])
    assert noise(fixed.model, "z") == sensor
    assert ("class", "A", "z", "cpd", "parts") in fixed.kept


def test_a_beginning_that_is_a_mixture_learns_from_first_slices_alone_and_names_do_not_clash():
    rng = np.random.default_rng(13)
    x = np.where(rng.random(300) < 0.7, rng.normal(5.0, 1.0, 300), rng.normal(-5.0, 1.0, 300))
    start = Mixture((0.5, Noise("5", sd=1.0)), (0.5, Noise("-5", sd=1.0)))
    made = world(
        Attribute("x_initial_is", BOOL, Table({(): (0.4, 0.6)})),
        Attribute("x", Real("m"), Noise("prev.x", sd=1.0), ("prev.x",), initial=start),
    )
    steps = ({"a.x": x}, {"a.x": x + rng.normal(size=300)}, {"a.x": x})
    fit = em(made, [Episode(steps, batch=300)], iterations=1, engine="mixture", only=[("class", "A", "x", "initial")])
    high, low = noise(fit.model, "x", "initial").parts
    assert high[0] == pytest.approx((x > 0).mean(), abs=1e-6)
    assert [float(high[1].mean), float(low[1].mean)] == pytest.approx([x[x > 0].mean(), x[x < 0].mean()], abs=1e-6)
    assert noise(fit.model, "x_initial_is") == made.model.classes[0].attributes[0].cpd
    assert noise(fit.model, "x") == Noise("prev.x", sd=1.0)
    assert fit.counts["class", "A", "x", "initial", "parts"].sum() == pytest.approx(300)


def test_mixtures_in_a_switch_are_those_of_mixture_em_in_each_state():
    """The mode is read; of two states with mixtures, of three and two parts, each by numpy from its own readings; the third is a normal."""
    rng = np.random.default_rng(14)
    mode = rng.integers(0, 3, 300)
    x = np.select(
        [mode == 0, mode == 1], [rng.normal(rng.choice([-3.0, 0.0, 4.0], 300), 1.0), rng.normal(rng.choice([1.0, 6.0], 300), 0.7)], 2.0
    )
    x = x + np.where(mode == 2, rng.normal(0.0, 0.5, 300), 0.0)
    start = {"a": ((0.2, -2.0), (0.5, 0.0), (0.3, 3.0)), "b": ((0.6, 2.0), (0.4, 5.0))}
    cases = {s: Mixture(*((w, Noise(str(m), sd=1.0)) for w, m in parts)) for s, parts in start.items()}
    made = world(
        Attribute("mode", ("a", "b", "c"), Prior((0.3, 0.3, 0.4))),
        Attribute("x", Real("m"), Switch("mode", {**cases, "*": Noise("1", sd=1.0)}), ("mode",)),
    )
    fit = em(made, [Episode(({"a.mode": mode, "a.x": x},), batch=300)], iterations=1, engine="mixture")
    learned = dict(noise(fit.model, "x").cases)
    for k, (state, parts) in enumerate(start.items()):
        own = x[mode == k]
        density = np.stack([w * stats.norm.pdf(own, m, 1.0) for w, m in parts])
        share = density / density.sum(axis=0)
        assert [w for w, _ in learned[state].parts] == pytest.approx(share.sum(axis=1) / len(own), abs=1e-9)
        for (_, part), found in zip(learned[state].parts, share):
            assert float(part.mean) == pytest.approx((found * own).sum() / found.sum(), abs=1e-9)
        assert fit.counts["class", "A", "x", "cpd", "parts"][k, : len(parts)] == pytest.approx(share.sum(axis=1), abs=1e-9)
    assert float(learned["*"].mean) == pytest.approx(x[mode == 2].mean(), abs=1e-9)
    assert [a.name for a in fit.model.classes[0].attributes] == ["mode", "x"]
    assert fit.model.classes[0].attributes[1].parents == ("mode",)


def test_outliers_that_come_in_one_hidden_mode_alone_are_learned_with_it():
    """A sensor that is good by day and now and then far off by night; of neither day nor part was anything told."""
    rng = np.random.default_rng(15)
    runs, steps = 60, 8
    night = np.zeros((steps, runs), int)
    night[0] = rng.random(runs) < 0.5
    for t in range(1, steps):
        night[t] = np.where(rng.random(runs) < 0.1, 1 - night[t - 1], night[t - 1])
    off = (rng.random((steps, runs)) < 0.4) & (night == 1)
    z = np.where(off, rng.normal(0.0, 5.0, (steps, runs)), rng.normal(0.0, 0.3, (steps, runs)))
    reading = {"yes": Mixture((0.7, Noise("0", sd=0.3)), (0.3, Noise("0", sd=3.0))), "no": Noise("0", sd=0.3)}
    made = world(
        Attribute("night", BOOL, Table({("no",): (0.9, 0.1), ("yes",): (0.1, 0.9)}), ("prev.night",), initial=Prior((0.5, 0.5))),
        Attribute("z", Real("m"), Switch("night", reading), ("night",)),
    )
    fit = em(made, [Episode(tuple({"a.z": row} for row in z), batch=runs)], iterations=8, engine="mixture")
    assert (np.diff(fit.log_likelihoods) > -1e-6).all()
    good, bad = dict(noise(fit.model, "z").cases)["yes"].parts
    assert bad[0] == pytest.approx(0.4, abs=0.1)
    assert bad[1].sd == pytest.approx(5.0, rel=0.2)
    assert good[1].sd == pytest.approx(0.3, rel=0.25)
    again = fit.model
    assert [u.cases for u in unfold(again)[1]] == [(("yes", 2),)]


def test_a_mixture_to_which_a_relation_adds_parents_stays_as_it_is():
    """What is added counts on the parents that there are, in their order."""
    item = PRMClass("A", (Attribute("x", Real("m"), Mixture((0.5, Noise("0", sd=1.0)), (0.5, Noise("1", sd=1.0)))),))
    near = Relation("near", {"b": "A", "c": "A"}, (Add("b.x", ("prev.c.x",), Noise("prev.c.x", sd=1.0)),))
    assert [u.key for u in unfold(Model("test", (item,)))[1]] == [("class", "A", "x", "cpd")]
    assert unfold(Model("test", (item,), (near,)))[1] == ()
