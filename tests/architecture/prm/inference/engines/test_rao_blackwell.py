"""Rao-Blackwellised particles against all sequences of modes, fine bins and the mixture engine."""

import numpy as np
import pytest

from cprm_gym.architecture.prm import (
    Attribute,
    Bins,
    Filter,
    Given,
    Grounding,
    Labels,
    Model,
    Noise,
    PRMClass,
    Real,
    Switch,
    Table,
)  # fmt: skip
from cprm_gym.errors import ParameterError


def switching():
    return PRMClass(
        "S",
        attributes=(
            Attribute("mode", Labels(("a", "b")), Table({("a",): (0.8, 0.2), ("b",): (0.3, 0.7)}), ("prev.mode",), initial=(0.6, 0.4)),
            Attribute(
                "x", Real(), parents=("prev.x", "mode"), initial=Noise("0", sd=1.0),
                cpd=Switch("mode", {"a": Noise("0.9 * prev.x + 0.3", sd=0.4), "b": Noise("0.5 * prev.x - 1", sd=0.7)}),
            ),
            Attribute("z", Real(), Noise("x", sd=0.5), ("x",)),
        ),
    )  # fmt: skip


MOTION = "0.5 * prev.x + 25 * prev.x / (1 + prev.x * prev.x) + push"


def growth(bins=None):
    """The standard strongly nonlinear model: a bending motion, and a reading that does not tell the sign."""
    return PRMClass(
        "G",
        given=(Given("push", Real(bins=Bins.linear(-8.5, 8.5, 17, clip=True)), default=0.0),),
        attributes=(
            Attribute("x", Real(bins=bins), Noise(MOTION, sd=3.0, points=4), ("prev.x", "push"),
                      initial=Noise("2", sd=2.0)),
            Attribute("z", Real(bins=Bins.linear(-8.0, 60.0, 272, clip=True)), Noise("x * x / 20", sd=1.0), ("x",)),
        ),
    )  # fmt: skip


def world(of):
    return Grounding(Model("test", (of,)), {"a": of.name})


def test_all_modes_are_kept_while_there_is_room():
    readings = np.random.default_rng(1).normal(size=6) * 1.5
    mixture = Filter(world(switching()), engine="mixture", components=256, merge=0.0)
    particles = Filter(world(switching()), engine="rao-blackwell", particles=256, seed=2)
    for z in readings:
        a, b = mixture.step({"a.z": z}), particles.step({"a.z": z})
        np.testing.assert_allclose(b.log_likelihood, a.log_likelihood, rtol=1e-9)
        np.testing.assert_allclose(b.read("a.x"), a.read("a.x"), rtol=1e-9)


def test_few_particles_are_near_all_sequences_of_modes():
    readings = np.random.default_rng(3).normal(size=30) * 1.5
    mixture = Filter(world(switching()), engine="mixture", components=128)
    particles = Filter(world(switching()), batch=20, engine="rao-blackwell", particles=64, seed=4)
    for z in readings:
        a, b = mixture.step({"a.z": z}), particles.step({"a.z": z})
        assert abs(b.read("a.x") - a.read("a.x")).max() < 0.15
        assert abs(b["a.mode"] - a["a.mode"]).mean() < 0.1
    assert abs(b.log_likelihood - a.log_likelihood).max() < 0.6
    assert abs(b.log_likelihood.mean() - a.log_likelihood[0]) < 0.1  # unbiased but for the logarithm


def test_numbers_that_bend_too_far_are_drawn():
    """Particles are near fine bins where a normal is far off."""
    rng = np.random.default_rng(5)
    exact = Filter(world(growth(Bins.linear(-30.0, 30.0, 150, clip=True))))
    drawn = Filter(world(growth()), batch=4, engine="rao-blackwell", particles=2000, drawn=("a.x",), seed=6)
    normal = Filter(world(growth()), engine="mixture")
    x, far, near = 2.0, [], []
    for t in range(12):
        push = np.rint(8.0 * np.cos(1.2 * t))
        x = (0.5 * x + 25 * x / (1 + x * x) + push if t else x) + rng.normal() * 3.0
        told = {"a.z": x * x / 20 + rng.normal(), "a.push": push}
        a, b, c = exact.step(told), drawn.step(told), normal.step(told)
        near.append(abs(b.read("a.x") - a.read("a.x")).max())
        far.append(abs(c.read("a.x") - a.read("a.x"))[0])
    assert np.mean(near) < 0.6
    assert np.mean(far) > 2.0 * np.mean(near)
    assert abs(b.log_likelihood - a.log_likelihood[0] + 12 * np.log(0.25)).max() < 1.0  # a bin is 0.25 wide


def test_one_seed_decides_everything():
    def run(seed):
        filter = Filter(world(switching()), batch=3, engine="rao-blackwell", particles=4, seed=seed)
        for z in (0.3, -1.0, 2.0, 0.1, 0.7):
            answer = filter.step({"a.z": z})
        return answer.read("a.x")

    np.testing.assert_array_equal(run(1), run(1))
    assert (run(1) != run(2)).any()


def test_state_that_was_kept_goes_on_as_before():
    filter = Filter(world(switching()), engine="rao-blackwell", particles=4, seed=1)
    for z in (0.3, -1.0, 2.0):
        filter.step({"a.z": z})
    kept = filter.state
    first = filter.step({"a.z": 0.5}).read("a.x")
    filter.state = kept
    np.testing.assert_array_equal(filter.step({"a.z": 0.5}).read("a.x"), first)


def test_what_cannot_be_drawn_is_refused_by_name():
    with pytest.raises(ParameterError, match="at least 2"):
        Filter(world(switching()), engine="rao-blackwell", particles=1)
    with pytest.raises(ParameterError, match=r"'a\.mode' has states"):
        Filter(world(switching()), engine="rao-blackwell", drawn="a.mode").step({})
