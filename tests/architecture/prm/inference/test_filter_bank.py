"""A bank of filters answers as if every agent had a filter of its own, in the objects' own names."""

import numpy as np
import pytest

from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.architecture.prm.inference.engines.projection import ProjectionEngine
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.architecture.prm.inference.filter_bank import FilterBank
from cprm_gym.architecture.prm.inference.links import Link, Role
from cprm_gym.architecture.prm.inference.views import View
from cprm_gym.architecture.prm.model.cpds import Noise, Prior, Switch, Table
from cprm_gym.architecture.prm.model.domains import Bins, Index
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, Given, PRMClass, Reference, Relation, Replace, prev
from cprm_gym.errors import EvidenceError, ImpossibleEvidence, ModelError, ParameterError

PLACE = Bins((0.0, 1.0, 2.0, 3.0, 4.0), clip=True)
BALL = PRMClass(
    "Ball",
    given=(Given("push", ("no", "yes"), default="no"),),
    attributes=(
        Attribute("at", PLACE, parents=(prev("at"), "push"),
                  cpd=Switch("push", {"no": Noise("prev.at", sd=0.5), "yes": Noise("prev.at + 1", sd=0.7)}), initial=Noise("2", sd=2.0)),
        Attribute("seen_at", PLACE, parents=("at",), cpd=Noise("at", sd=0.4, floor=1e-3)),
    ),
)  # fmt: skip
PLAYER = PRMClass(
    "Player",
    attributes=(
        Attribute("at", PLACE, cpd=Prior((0.4, 0.3, 0.2, 0.1))),
        Attribute("calm", ("no", "yes"), cpd=Prior((0.3, 0.7))),
        Attribute("seen_at", PLACE, parents=("at",), cpd=Noise("at", sd=0.6, floor=1e-3)),
    ),
)
WATCHED = Relation("watched", (("p", "Player"),), changes=(Replace("p.at", parents=(prev("p.at"),), cpd=Noise("prev.p.at", sd=0.6)),))
HOLDS = Relation(
    "holds",
    (("p", "Player"), ("b", "Ball")),
    attributes=(Attribute("shoots", ("no", "yes"), parents=("p.calm",), cpd=Table({("no",): (0.5, 0.5), ("yes",): (0.8, 0.2)})),),
    changes=(
        Replace("b.at", parents=("p.at", "shoots"), cpd=Switch("shoots", {"no": Noise("p.at", sd=0.3), "yes": Noise("p.at + 1", sd=1.0)})),
    ),
)
MODEL = Model("pitch", classes=(BALL, PLAYER), relations=(WATCHED, HOLDS))
NAMES = [f"p{k}" for k in range(4)]
OBJECTS = {"ball": "Ball", **dict.fromkeys(NAMES, "Player")}
HIDDEN = ["ball.at", *(f"{p}.{a}" for p in NAMES for a in ("at", "calm"))]
SEEN = ["ball.seen_at", *(f"{p}.seen_at" for p in NAMES)]


def links(first, second, holder):
    """Watched are two, and one holds the ball."""
    return (
        Link("watched", (Role("Player", first),)),
        Link("watched", (Role("Player", second),)),
        Link("holds", (Role("Player", holder), "ball")),
    )


def named(first, second, holder, k):
    """The relations of one agent by name."""
    watched = [f"watched({NAMES[i]})" for i in dict.fromkeys((first[k], second[k])) if i >= 0]
    return (*watched, *((f"holds({NAMES[holder[k]]},ball)",) if holder[k] >= 0 else ()))


def wander(rng, width, steps):
    """Whom the agents mean, what they see and which of them are due, step by step."""
    first, second, holder = (rng.integers(-1, 4, width) for _ in range(3))
    for _ in range(steps):
        first = np.where(rng.random(width) < 0.2, rng.integers(-1, 4, width), first)
        second = np.where(rng.random(width) < 0.2, rng.integers(-1, 4, width), second)
        holder = np.where(rng.random(width) < 0.3, rng.integers(-1, 4, width), holder)
        seen = {name: np.where(rng.random(width) < 0.5, rng.integers(0, 4, width), -1) for name in SEEN if rng.random() < 0.8}
        yield first, second, holder, {**seen, "ball.push": rng.integers(0, 2, width)}, rng.random(width) < 0.9


@pytest.mark.parametrize("engine", ["exact", "projection"])
def test_a_bank_answers_as_one_filter_for_each_agent_does(engine):
    rng, width = np.random.default_rng(3), 9
    make = (lambda: "exact") if engine == "exact" else (lambda: ProjectionEngine((("ball.at",),)))
    grounding = Grounding(MODEL, OBJECTS)
    bank = FilterBank(grounding, width, make())
    own = [Filter(grounding, 1, make()) for _ in range(width)]
    for t, (first, second, holder, evidence, due) in enumerate(wander(rng, width, 40)):
        if t in (12, 25):
            again = rng.random(width) < 0.4
            bank.reset(again)
            for k in np.flatnonzero(again):
                own[k].reset()
        bank.step(evidence, links(first, second, holder), due)
        for k in np.flatnonzero(due):
            expected = own[k].step({name: int(values[k]) for name, values in evidence.items()}, relations=named(first, second, holder, k))
            for name in HIDDEN:
                np.testing.assert_allclose(bank.marginal(name, k), expected[name][0], atol=1e-12)
            assert bank.log_likelihood[k] == pytest.approx(own[k].log_likelihood[0], abs=1e-9)
        ahead = bank.alone(3).predict(2)
        np.testing.assert_allclose(ahead["p1.at"], own[3].predict(2)["p1.at"], atol=1e-12)
    assert len(bank.answers) < width, "agents who ask for the same make one step"


def test_views_follow_whom_each_agent_means():
    rng, width = np.random.default_rng(5), 7
    bank = FilterBank(Grounding(MODEL, OBJECTS), width)
    mean = View.parse("expectation")
    for first, second, holder, evidence, _ in wander(rng, width, 20):
        bank.step(evidence, links(first, second, holder))
        read, ball, p2 = bank.view_of(mean, Role("Player", second), "at"), bank.view(mean, "ball.at"), bank.view(mean, "p2.at")
        for k in range(width):
            assert np.isnan(read[k]) if second[k] < 0 else read[k] == pytest.approx(mean(bank.marginal(f"{NAMES[second[k]]}.at", k), PLACE))
            assert ball[k] == pytest.approx(mean(bank.marginal("ball.at", k), PLACE))
            assert p2[k] == pytest.approx(mean(bank.marginal("p2.at", k), PLACE))


def test_an_object_that_all_agents_mean_is_given_by_name():
    bank, width = FilterBank(Grounding(MODEL, OBJECTS), 3), 3
    one = Filter(Grounding(MODEL, OBJECTS), width)
    for t in range(4):
        whom = np.array([0, 2, 3])
        bank.step({"p2.seen_at": np.array([t % 4, 1, 2])}, (Link("watched", ("p2",)), Link("watched", (Role("Player", whom),))))
        expected = one.step({"p2.seen_at": np.array([t % 4, 1, 2])}, relations=("watched(p2)",))
        for k in range(width):
            np.testing.assert_allclose(bank.marginal("p2.at", k), expected["p2.at"][k], atol=1e-12)
    with pytest.raises(ModelError, match=r"unknown object 'p9'"):
        bank.step({}, (Link("watched", ("p9",)),))


def test_attention_to_any_object_is_one_cohort():
    width = 100
    rng = np.random.default_rng(0)
    bank = FilterBank(Grounding(MODEL, OBJECTS), width)
    nobody = np.full(width, -1)
    for _ in range(4):
        bank.step({}, links(rng.integers(0, 4, width), nobody, nobody))
    whom = rng.integers(0, 4, width)
    for _ in range(3):
        bank.step({}, links(whom, nobody, nobody))
    assert len(bank.answers) == 1


def test_objects_that_others_refer_to_keep_their_names():
    sure = Attribute("sure", ("no", "yes"), cpd=Prior((0.5, 0.5)))
    keeper = PRMClass("Keeper", references=(Reference("foe", "Player"),), attributes=(sure,))
    model = Model("pitch", classes=(BALL, PLAYER, keeper), relations=(WATCHED, HOLDS))
    grounding = Grounding(model, {**OBJECTS, "keeper": "Keeper"}, {"keeper": {"foe": "p1"}})
    bank = FilterBank(grounding, 3)
    own = [Filter(grounding) for _ in range(3)]
    whom, nobody = np.array([0, 1, 3]), np.full(3, -1)
    for _ in range(3):
        bank.step({"p3.seen_at": np.full(3, 2)}, links(whom, nobody, nobody))
        for k, one in enumerate(own):
            np.testing.assert_allclose(
                bank.marginal("p3.at", k), one.step({"p3.seen_at": 2}, relations=named(whom, nobody, nobody, k))["p3.at"][0], atol=1e-12
            )
    assert not bank.object_in


def test_agents_who_sample_have_particles_of_their_own():
    bank = FilterBank(Grounding(MODEL, OBJECTS), 2, "particles", seed=1)
    nobody = np.full(2, -1)
    for _ in range(5):
        bank.step({"p1.seen_at": np.array([0, 3])}, links(np.array([1, 1]), nobody, nobody))
    first, second = (cohort.state.belief.random["state"]["state"] for cohort in bank._cohorts)
    assert first != second, "random numbers of their own"
    mean = View.parse("expectation")
    low, high = bank.view(mean, "p1.at")
    assert low < 1.2
    assert high > 2.2
    bank.reset(np.array([True, False]))
    bank.step({}, links(nobody, nobody, nobody))
    assert bank.view(mean, "p1.at")[0] == pytest.approx(mean(np.array((0.4, 0.3, 0.2, 0.1)), PLACE), abs=0.2)


def test_a_refused_reading_leaves_every_belief_as_it_was():
    bank = FilterBank(Grounding(MODEL, OBJECTS), 2)
    whom, nobody = np.array([2, 3]), np.full(2, -1)
    bank.step({"p2.seen_at": np.array([1, 1])}, links(whom, nobody, nobody))
    before = bank.marginal("p2.at", 0).copy(), bank.log_likelihood.copy()
    with pytest.raises(EvidenceError, match=r"p2\.seen_at.*9 is no state"):
        bank.step({"p2.seen_at": Index(np.array([1, 9]))}, links(whom, nobody, nobody))
    with pytest.raises(EvidenceError, match=r"unknown variable 'p2\.sen_at'.*seen_at"):
        bank.step({"p2.sen_at": np.array([1, 1])}, links(whom, nobody, nobody))
    np.testing.assert_array_equal(bank.marginal("p2.at", 0), before[0])
    np.testing.assert_array_equal(bank.log_likelihood, before[1])
    with pytest.raises(ModelError, match=r"no variable 'p2\.nose'"):
        bank.marginal("p2.nose")


def test_impossible_readings_are_counted_and_begin_a_belief_anew():
    coin = PRMClass("Coin", attributes=(
        Attribute("side", ("heads", "tails"), parents=(prev("side"),), initial=Prior((0.5, 0.5)),
                  cpd=Table({("heads",): (1.0, 0.0), ("tails",): (0.0, 1.0)})),
        Attribute("shown", ("heads", "tails"), parents=("side",), cpd=Table({("heads",): (1.0, 0.0), ("tails",): (0.0, 1.0)})),
    ))  # fmt: skip
    grounding = Grounding(Model("coins", classes=(coin,)), {"coin": "Coin"})
    bank = FilterBank(grounding, 3, on_impossible="restart")
    bank.step({"coin.shown": np.array([0, 0, 1])})
    bank.step({"coin.shown": np.array([0, 1, -1])})
    np.testing.assert_array_equal(bank.impossible_count, [0, 1, 0])
    np.testing.assert_allclose([bank.marginal("coin.side", k)[0] for k in range(3)], [1.0, 0.0, 0.0])
    strict = FilterBank(grounding, 2)
    strict.step({"coin.shown": np.array([0, 1])})
    with pytest.raises(ImpossibleEvidence):
        strict.step({"coin.shown": np.array([1, 1])})
    strict.step({"coin.shown": np.array([0, 1])})
    np.testing.assert_allclose(strict.log_likelihood, np.log([0.5, 0.5]))


def test_a_relations_own_variable_is_told_and_read_for_each_agents_own_objects():
    win = Attribute("win", ("no", "yes"), Prior((0.5, 0.5)))
    seen = Attribute("seen", ("no", "yes"), Table({"yes": (0.2, 0.8), "no": (0.9, 0.1)}), parents=("win",))
    duel = Relation("duel", {"o": "Player"}, attributes=(win, seen))
    player = PRMClass("Player", (Attribute("at", ("a", "b"), Prior((0.5, 0.5))),))
    grounding = Grounding(Model("m", (player,), (duel,)), dict.fromkeys("pqr", "Player"))
    bank = FilterBank(grounding, 3)
    whom = Role("Player", np.array([1, 2, -1]))
    bank.step({"duel(q).seen": np.array([1, -1, -1]), "duel(r).seen": np.array([-1, 0, -1])}, (Link("duel", (whom,)),))
    assert bank.marginal("duel(q).win", 0)[1] == pytest.approx(0.8 / 0.9)
    assert bank.marginal("duel(r).win", 1)[1] == pytest.approx(0.2 / 1.1)
    read = bank.view(View.parse("probability(yes)"), "duel(r).win")
    assert np.isnan(read[[0, 2]]).all()
    assert read[1] == pytest.approx(0.2 / 1.1)
    with pytest.raises(EvidenceError, match=r"duel\(q\).seen.*does not exist for agent 2"):
        bank.step({"duel(q).seen": np.array([-1, -1, 1])}, (Link("duel", (whom,)),))


def test_a_step_names_what_is_no_link_and_no_truth_value():
    bank = FilterBank(Grounding(Model("m", (PLAYER,), (WATCHED,)), {"p": "Player"}), 2)
    with pytest.raises(ModelError, match=r"a filter bank takes Link\(relation, roles\), got str"):
        bank.step({}, "watched(p)")
    for due in ([1, 0], [True], True):
        with pytest.raises(ParameterError, match="due: expected 2 truth values"):
            bank.step({}, (), due)
    bank.step({}, (), [True, False])
