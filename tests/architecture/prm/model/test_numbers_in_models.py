"""Real numbers and angles as domains, what CPDs mean with them, and who asks for bins."""

import numpy as np
import pytest

from cprm_gym.architecture import CPRM, CPRMRunner, Observe
from cprm_gym.architecture.petri import Belief, PetriNet
from cprm_gym.architecture.prm import (
    BOOL,
    Angle,
    Attribute,
    BayesNet,
    Bins,
    Chance,
    Filter,
    FilterBank,
    Given,
    Grounding,
    Interval,
    Labels,
    Link,
    Mixture,
    Model,
    Noise,
    PRMClass,
    Real,
    Relation,
    Replace,
    Role,
    Switch,
    Uniform,
    class_diagram_dot,
    em,
    ground_net_svg,
    model_from_json,
    model_to_json,
    to_bif,
    unroll,
)  # fmt: skip
from cprm_gym.architecture.prm.model.densities import FLAT, NORMAL, density
from cprm_gym.errors import EvidenceError, ModelError

FINE = Bins.linear(-10.0, 10.0, 100, "m", clip=True)
ROUND = Bins.circle(36, "deg")
THING = PRMClass(
    "Thing",
    given=(Given("push", Real("m", bins=Bins.linear(-1.0, 1.0, 20, clip=True)), default=0.0),),
    attributes=(
        Attribute("x", Real("m", bins=FINE), Noise("prev.x + push", sd=0.3), ("prev.x", "push"), initial=Noise("0", sd=2.0)),
        Attribute("dir", Angle("deg", bins=ROUND), Noise("prev.dir", sd=5.0), ("prev.dir",), initial=Uniform()),
        Attribute("near", BOOL, Chance("0.9 if abs(x) < 3 else 0.1"), ("x",)),
        Attribute("z", Real("m", bins=FINE), Noise("x", sd=0.4), ("x",)),
    ),
)
MODEL = Model(
    "things", (THING,), (Relation("still", {"t": "Thing"}, changes=(Replace("t.x", ("prev.t.x",), Noise("prev.t.x", sd=0.01)),)),)
)


def test_models_with_numbers_are_read_back_equal():
    assert model_from_json(model_to_json(MODEL)) == MODEL
    assert MODEL.continuous
    assert not MODEL.binned().continuous
    assert MODEL.binned().binned() == MODEL.binned()


def test_drawings_show_units():
    assert "x [real m]" in class_diagram_dot(MODEL)
    assert "dir [angle deg]" in class_diagram_dot(MODEL)
    assert "<svg" in ground_net_svg(Grounding(MODEL, {"a": "Thing"}).ground())


def test_every_engine_for_states_runs_on_the_bins():
    world = Grounding(MODEL, {"a": "Thing"})
    for engine in ("exact", "projection", "particles", "anytime"):
        answer = Filter(world, engine=engine, seed=1).step({"a.z": 1.1, "a.near": "yes"})
        assert answer["a.x"].shape == (1, 100)
        assert abs(answer.read("a.x")[0] - 1.06) < 0.15


def test_learning_takes_the_bins():
    steps = [[{"a.z": 1.0 + 0.1 * t, "a.near": "yes"} for t in range(4)]]
    fit = em(Grounding(MODEL, {"a": "Thing"}), steps, iterations=2, only=[("class", "Thing", "near")])
    assert not fit.model.continuous
    assert fit.log_likelihoods[0] < fit.log_likelihoods[1]


def test_what_knows_states_only_says_so():
    first = Grounding(MODEL, {"a": "Thing"}).ground(first=True)
    with pytest.raises(ModelError, match=r"take `Model\.binned`"):
        to_bif(unroll([first]))
    with pytest.raises(ModelError, match=r"take `Model\.binned`"):
        BayesNet(unroll([first]))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Real("m", low=1.0), "both limits or none"),
        (lambda: Real("m", low=2.0, high=1.0), "finite and increase"),
        (lambda: Real("m", bins=ROUND), "straight Bins"),
        (lambda: Angle("turns"), "'rad' or 'deg'"),
        (lambda: Angle("rad", bins=ROUND), "bins of 6.28319 all round"),
        (lambda: Angle("deg", bins=FINE), "circular Bins"),
        (lambda: Given("g", Real("m"), default=float("nan")), "finite number"),
        (lambda: Interval("a", 2.0), "has numbers"),
    ],
)
def test_domains_without_meaning_are_refused(make, message):
    with pytest.raises((ModelError, EvidenceError), match=message):
        make()


def test_switches_and_mixtures_are_rows_of_weighted_leaves():
    cpd = Switch("mode", {"a": Mixture((0.7, Noise("x", sd=1.0)), (0.3, Uniform())), "*": Noise("2 * x", sd=0.5)})
    made = density(cpd, Real("m", low=0.0, high=9.0), (("mode", Labels(("a", "b", "c"))), ("x", Real())))
    assert made.switches == (0,)
    assert [[(w, leaf.kind) for w, leaf in row] for row in made.rows] == [[(0.7, NORMAL), (0.3, FLAT)], [(1.0, NORMAL)], [(1.0, NORMAL)]]
    assert made.rows[0][1][1].values == (0.0, 9.0)
    assert made.rows[1][0][1].inputs == {"x": 1}


def test_interval_of_bins_is_the_share_of_each():
    filter = Filter(Grounding(Model("b", (PRMClass("B", (Attribute("x", Bins((0, 1, 2, 4))),)),)), {"a": "B"}))
    answer = filter.step({"a.x": Interval(0.5, 3.0)})
    np.testing.assert_allclose(answer["a.x"][0], np.array([0.5, 1.0, 0.5]) / 2.0)
    with pytest.raises(EvidenceError, match="outside its bins"):
        filter.step({"a.x": Interval(7.0, 9.0)})


def test_number_with_noise_into_bins_is_a_threshold():
    """A variable with bins whose parent is a number: told, it cuts; hidden, it has the normal's shares."""
    zone = PRMClass(
        "Z",
        attributes=(
            Attribute("x", Real("m"), Noise("0", sd=2.0)),
            Attribute("zone", Bins((-5, -1, 1, 5)), Noise("x", sd=0.0, floor=0.0), ("x",)),
        ),
    )
    answer = Filter(Grounding(Model("z", (zone,)), {"a": "Z"}), engine="mixture").step({})
    np.testing.assert_allclose(answer["a.zone"][0], [0.30853754, 0.38292492, 0.30853754], atol=1e-8)
    told = Filter(Grounding(Model("z", (zone,)), {"a": "Z"}), engine="mixture").step({"a.zone": 3.0})
    np.testing.assert_allclose(told.read("a.x"), 2.0 * 0.35206533 / 0.30853754, rtol=1e-6)  # phi(1/2) / (1 - Phi(1/2))


@pytest.mark.parametrize("engine", ["mixture", "exact"])
def test_bank_of_agents_with_other_relations(engine):
    bank = FilterBank(Grounding(MODEL, {"a": "Thing", "b": "Thing"}), batch=3, engine=engine)
    alone = [Filter(Grounding(MODEL, {"a": "Thing", "b": "Thing"}), engine=engine) for _ in range(3)]
    whom = np.array([0, 1, -1])
    from cprm_gym.architecture.prm import View

    for t in range(4):
        told = np.array([1.0, 0.5, -1.0]) * t
        whom = np.roll(whom, 1)
        bank.step({"a.z": told, "b.z": told + 1.0, "a.push": np.array([0.1, 0.0, 0.2])}, [Link("still", (Role("Thing", whom),))])
        for k, filter in enumerate(alone):
            relations = () if whom[k] < 0 else (f"still({'ab'[whom[k]]})",)
            own = filter.step({"a.z": told[k], "b.z": told[k] + 1.0, "a.push": [0.1, 0.0, 0.2][k]}, relations)
            for name in ("a.x", "b.x"):
                np.testing.assert_allclose(bank.view(View.parse("expectation"), name)[k], own.read(name)[0], atol=1e-9)


@pytest.mark.parametrize("engine", ["mixture", "exact"])
def test_net_reads_numbers_of_the_belief(engine):
    net = PetriNet("net", places=(Belief("place", variable="a.x"), Belief("close", variable="a.x", view="probability(-3..3)")))
    cprm = CPRM("reader", net, MODEL, {"a": "Thing"}, observations=(Observe("a.z", "seen_x", when="seen"),))
    runner = CPRMRunner(cprm, batch=2, engine=engine)
    for _ in range(3):
        runner.step({"seen_x": np.array([2.05, 4.05]), "seen": np.array([1.0, 0.0])})
    place, close = runner.executor.read("place"), runner.executor.read("close")
    assert abs(place[0] - 2.0) < 0.15
    assert abs(place[1]) < 0.1
    assert close[0] > 0.98
    assert 0.8 < close[1] < 0.95
