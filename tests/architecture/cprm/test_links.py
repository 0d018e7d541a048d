"""A CPRM says what a model can: each link against a filter that is told the same by hand."""

from dataclasses import replace

import numpy as np
import pytest
from watcher import OBJECTS, PITCH, WATCHER

from cprm_gym.architecture.cprm import CPRM, Cluster, CPRMRunner, Event, Observe, cprm_from_json, cprm_to_json
from cprm_gym.architecture.petri import Belief, ObjectPlace, PetriNet, Selection
from cprm_gym.architecture.prm import (
    BOOL,
    Attribute,
    Filter,
    Grounding,
    Index,
    Model,
    PRMClass,
    Reference,
    Table,
)
from cprm_gym.architecture.prm.inference.deep_filter import DeepFilter
from cprm_gym.architecture.prm.inference.views import View
from cprm_gym.errors import CprmError, ImpossibleEvidence, ModelError

PLAIN = {"ball": 3.0, "ball_seen": 1.0, "holder": 1.0, "kick": 1.0, "kick_heard": 0.0, "told": 0.0, "noise": 0.5, "p2_there": 1.0}


def script(seed, steps=8, batch=3):
    """Percepts and candidates at random; who is meant changes on the way."""
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        percepts = {name: np.full(batch, value) for name, value in PLAIN.items()}
        percepts |= {"ball": rng.uniform(0, 6, batch), "holder": rng.uniform(0, 6, batch), "noise": rng.uniform(0, 2, batch)}
        percepts |= {n: rng.integers(0, 2, batch).astype(float) for n in ("ball_seen", "kick", "kick_heard", "told", "p2_there")}
        yield percepts, {"Player": {"one": rng.random((batch, 3)), "two": rng.random((batch, 3))}}


def by_hand(one, k, percepts, held):
    """The same slice, told to a filter; places read as the net reads them."""
    first, second = (None if i < 0 else f"p{i}" for i in held)
    objects = ["ball", "p0", "p1", *(["p2"] if percepts["p2_there"][k] else [])]
    clusters = [None if p is None else f"holds({p},ball)" for p in (first, second)]
    active = tuple(dict.fromkeys(c for c, p in zip(clusters, (first, second)) if p in objects))
    evidence, soft = {}, {}
    if percepts["ball_seen"][k]:
        evidence["ball.seen_at"] = float(percepts["ball"][k])
    if first in objects:
        evidence[f"{first}.seen_at"] = float(percepts["holder"][k])
    if clusters[0] in active and percepts["kick_heard"][k]:
        evidence[f"{clusters[0]}.shoots"] = Index(int(percepts["kick"][k]))
    if len(active) == 2 and percepts["told"][k]:
        evidence["ball.selector"] = clusters[0]
    if "p2" in objects:
        soft["p2.at"] = [1 + percepts["noise"][k], 2, 1]
    seen = one.step(evidence, active, objects=objects, soft=soft)
    out = dict.fromkeys(("shot", "whose", "doubt"), -1.0)
    if clusters[0] in active:
        out["shot"] = seen[f"{clusters[0]}.shoots"][0, 1]
    if len(active) == 2:
        out["whose"] = seen["ball.selector"][0, seen.variables["ball.selector"].states.index(clusters[0])]
        out["doubt"] = View("entropy")(seen["ball.selector"], seen.variables["ball.selector"])[0]
    out["where"] = seen.read("ball.at")[0]
    out["gone"] = seen.read("p2.at")[0] if "p2" in objects else -5.0
    out["both"] = seen.joint("ball.at", f"{first}.at")[0, 0, :2].sum() if first in objects else 0.0
    return out


@pytest.mark.parametrize("seed", range(4))
def test_every_link_says_to_the_model_what_a_filter_is_told_by_hand(seed):
    """Relation variables and selectors read and observed, objects that come and go, soft evidence, a joint view, for three agents."""
    runner = CPRMRunner(WATCHER, batch=3)
    alone = [Filter(Grounding(PITCH, OBJECTS), on_impossible="restart") for _ in range(3)]
    held = np.full((2, 3), -1)
    for percepts, objects in script(seed):
        held = np.stack([runner.executor.holds("first"), runner.executor.holds("second")])
        runner.step(percepts, objects)
        for k, one in enumerate(alone):
            for place, value in by_hand(one, k, percepts, held[:, k]).items():
                assert runner.executor.read(place)[k] == pytest.approx(value, abs=1e-12), place
    assert (held >= 0).all()


def test_agents_begin_anew_one_by_one():
    runner, other = CPRMRunner(WATCHER, batch=2), CPRMRunner(WATCHER, batch=1)
    steps = list(script(9, batch=2))
    for percepts, objects in steps[:3]:
        runner.step(percepts, objects)
    runner.reset(np.array([False, True]))
    for percepts, objects in steps[3:]:
        runner.step(percepts, objects)
        other.step({n: v[1:] for n, v in percepts.items()}, {"Player": {n: v[1:] for n, v in objects["Player"].items()}})
        assert np.allclose(runner.executor.marking[1], other.executor.marking[0], atol=1e-12)


def test_an_impossible_reading_leaves_every_belief_as_it_was():
    sure = PRMClass("C", (Attribute("x", BOOL, Table({"yes": (0.0, 1.0), "no": (1.0, 0.0)}), parents=("prev.x",), initial=(0.5, 0.5)),))
    net = PetriNet("n", places=(Belief("p", variable="c.x", view="probability", state="yes"),))
    cprm = CPRM("sure", net, Model("m", (sure,)), {"c": "C"}, (Observe("c.x", "x"),), present={"c": "1"})
    runner = CPRMRunner(cprm, batch=2, on_impossible="raise")
    runner.step({"x": np.array([1.0, 0.0])})
    with pytest.raises(ImpossibleEvidence):
        runner.step({"x": np.array([1.0, 1.0])})
    assert [f.step_count for f in runner.separate.filters] == [1, 1]
    runner.step({"x": np.array([1.0, 0.0])})
    assert runner.executor.read("p").tolist() == [1.0, 0.0]


@pytest.mark.parametrize("every", [1, 3])
def test_deep_inference_is_that_of_a_deep_filter(every):
    first = ObjectPlace("first", "Player", select=Selection("Player", best="player.one"))
    net = PetriNet("reader", places=(Belief("where", variable="ball.at"), first))
    observations = (Observe("ball.seen_at", "ball"), Observe("p0.seen_at", "holder"))
    cprm = CPRM("reader", net, PITCH, OBJECTS, observations, (Cluster("holds", ("first", "=ball")),))
    runner = CPRMRunner(cprm, engine="projection", deep="exact", every=every)
    one = DeepFilter(Grounding(PITCH, OBJECTS), 1, "projection", deep="exact", every=every, on_impossible="restart")
    for percepts, objects in script(3, batch=1):
        holder = int(runner.executor.holds("first")[0])
        runner.step(percepts, {"Player": {"one": objects["Player"]["one"]}})
        active = () if holder < 0 else (f"holds(p{holder},ball)",)
        seen = one.step({"ball.seen_at": percepts["ball"], "p0.seen_at": percepts["holder"]}, active)
        assert runner.executor.read("where")[0] == pytest.approx(seen.read("ball.at")[0], abs=1e-12)


FARM = Model("farm", (
    PRMClass("House", (Attribute("lit", BOOL, (0.5, 0.5)),)),
    PRMClass("Cat", (Attribute("in", BOOL, Table({"yes": (0.1, 0.9), "no": (0.8, 0.2)}), parents=("home.lit",)),),
             references=(Reference("home", "House"),)),
))  # fmt: skip
CAT = PetriNet("cat", places=(Belief("lit", variable="b.lit", view="probability", state="yes"),))


def test_references_say_which_object_is_meant():
    houses = {"a": "House", "b": "House", "cat": "Cat"}
    with pytest.raises(ModelError, match="several could be meant: a, b; say which in `references`"):
        CPRM("farm", CAT, FARM, houses, (Observe("cat.in", "1"),))
    cprm = CPRM("farm", CAT, FARM, houses, (Observe("cat.in", "1"),), references={"cat": {"home": "b"}})
    runner = CPRMRunner(cprm, batch=2)
    assert runner.bank is not None, "references need no filter of one's own"
    runner.step({})
    assert runner.executor.read("lit") == pytest.approx([0.9 / 1.1] * 2)
    assert cprm_from_json(cprm_to_json(cprm)) == cprm
    with pytest.raises(ModelError, match="grounding given is of another model"):
        CPRMRunner(cprm, grounding=Grounding(FARM, houses, {"cat": {"home": "a"}}))


def test_json_keeps_every_link():
    assert cprm_from_json(cprm_to_json(WATCHER)) == WATCHER


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"observations": (Observe("one.shots", "1"),)}, "relation 'holds' has no variable 'shots'. Did you mean 'shoots'"),
        ({"observations": (Observe("p2.at", likelihood=("1", "2")),)}, "has 2 likelihoods for 3 states"),
        ({"observations": Observe("p2.at", "1")}, "`observations` takes a tuple, got Observe"),
        ({"observations": ("p2.at",)}, "`observations` holds Observe values, got 'p2.at'"),
        ({"clusters": Cluster("holds", ("first", "=ball"))}, "`clusters` takes a tuple"),
        ({"clusters": (Cluster("holds", ("first", "=ball")), Cluster("holds", ("second", "=ball")))}, "unknown variable 'one.shoots'"),
        ({"clusters": (Cluster("holds", ("first", "=ball"), "p0"),)}, "a cluster is called 'p0', as an object"),
        ({"present": {"p3": "1"}}, "`present` names the unknown object 'p3'"),
        ({"present": {"p2": 1}}, "`present` of 'p2' is an expression"),
        ({"present": {"p2": "1 +"}}, "formula '1 \\+'"),
        ({"present": ["p2"]}, "`present` is a mapping"),
        ({"objects": ["ball"]}, "`objects` is a mapping"),
        ({"events": (Event("near", {"ball.att": "..2"}),)}, "event 'near': unknown variable 'ball.att'. Did you mean 'ball.at'"),
        ({"events": (Event("near", {"ball.at": "7.."}),)}, "lies outside the bins"),
        ({"events": ()}, "unknown variable 'near'"),
        ({"references": {"p0": {"friend": "p1"}}}, "has no such reference"),
    ],
)  # fmt: skip
def test_a_link_to_what_is_not_there_is_refused(change, message):
    with pytest.raises(CprmError, match=message):
        replace(WATCHER, **change)


def test_an_observation_says_a_value_or_likelihoods():
    for wrong in ({}, {"value": "1", "likelihood": ("1", "2")}, {"likelihood": "12"}):
        with pytest.raises(ModelError, match=r"observation of 'a\.x'"):
            Observe("a.x", **wrong)
    with pytest.raises(ModelError, match="`states` says for each variable"):
        Event("e", {})
