"""Nets of modules: conditions along every way, intervals chained, what works at once."""

import json

import pytest
from paths import SHARED

from cprm_gym.agents.skills.approach import APPROACH
from cprm_gym.architecture.analysis.high_level.analysis import high_level_analysis, high_level_concurrent_analysis
from cprm_gym.architecture.analysis.high_level.interference import groups, interferes
from cprm_gym.architecture.analysis.high_level.modules import Outcome, Summary, Wiring, summarise, wiring
from cprm_gym.architecture.analysis.logic.z3_terms import has_z3
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.generators import walk_chain
from cprm_gym.architecture.petri import PetriNet, Place
from cprm_gym.errors import ModelError, NetError

CASES = SHARED / "cases" / "markov" / "highlevel"


def point(p, after="1"):
    return Outcome((p, p), after)


LOOP = Wiring(
    ("approach",),
    {
        ("approach", "done"): ("kick",), ("approach", "failed"): ("retry",), ("retry", "again"): ("approach",),
        ("retry", "given up"): ("=fail",), ("kick", "goal"): ("=goal",), ("kick", "back"): ("approach",), ("kick", "lost"): ("=fail",),
    },
)  # fmt: skip
KNOWN = {
    "approach": Summary({"done": Outcome((0.7, 0.98)), "failed": Outcome((0.02, 0.3))}, steps=(5, 20)),
    "retry": Summary({"again": point(0.8), "given up": point(0.2)}, steps=(1, 1)),
    "kick": Summary({"goal": point(0.8), "back": point(0.15), "lost": point(0.05)}, steps=(1, 2)),
}


def test_intervals_are_chained_soundly_where_single_numbers_are_not():
    found = high_level_analysis(LOOP, KNOWN)
    assert found.outcomes["goal"] == pytest.approx((112 / 131, 784 / 837), abs=1e-9)
    exact = {"near": 3024 / 3275, "far": 112 / 131}
    assert all(found.outcomes["goal"].low - 1e-12 <= p <= found.outcomes["goal"].high + 1e-12 for p in exact.values())
    uniform = 336 / 373  # one number for both entries: wrong for either
    assert not any(abs(uniform - p) < 0.01 for p in exact.values())
    assert 1 < found.steps.low < found.steps.high < 100


@pytest.mark.skipif(not CASES.is_dir(), reason="data of ../shared absent")
def test_the_reference_case():
    case = json.loads((CASES / "compose_loop.json").read_text())
    assert high_level_analysis(LOOP, KNOWN).outcomes["goal"] == pytest.approx(case["interval_composition"]["float"], abs=1e-9)


def test_conditions_are_checked_along_every_way():
    summaries = {
        "orient": Summary({"facing": point(1.0, "abs(dir) < 8")}),
        "dash": Summary({"there": point(1.0, "dist < 1")}, before="abs(dir) < 10"),
    }
    ways = Wiring(("orient",), {("orient", "facing"): ("dash",), ("dash", "there"): ("=done",)})
    found = high_level_analysis(ways, summaries, after={"done": "dist < 1.1"})
    assert found.sound
    assert found.outcomes["done"] == pytest.approx((1.0, 1.0))
    broken = {**summaries, "dash": Summary({"there": point(1.0, "dist < 1")}, before="abs(dir) < 5")}
    refused = high_level_analysis(ways, broken)
    assert refused.sound is False
    assert refused.outcomes == {}
    (link,) = [x for x in refused.links if x.verdict.holds is False]
    assert (link.source, link.outcome, link.target) == ("orient", "facing", "dash")
    assert 5 <= abs(link.verdict.counterexample["dir"]) < 8


def test_a_summary_is_the_least_and_the_most_over_its_entries():
    solved = absorption(walk_chain(10))
    found = summarise(solved, [2, 3, 6])
    assert found.outcomes["rich"].probability == pytest.approx((0.2, 0.6), abs=1e-9)
    assert found.steps == pytest.approx((16.0, 24.0))
    with pytest.raises(ModelError, match="in which the module may begin"):
        summarise(solved, [])


def test_the_ways_of_the_approach_are_those_of_figure_3_1():
    ways = wiring(APPROACH)
    assert ways.first == ("orient",)
    assert ways.leads["orient", "facing"] == ("accelerate",)
    assert ways.leads["accelerate", "distant"] == ("cruise",)
    assert ways.leads["accelerate", "close"] == ("slow",)
    assert ways.leads["slow", "there"] == ("=arrived",)
    assert set(ways.leads["cruise", "strayed"]) == {"orient", "=failed"}


def test_the_approach_from_its_modules():
    summaries = {
        "orient": Summary({"facing": Outcome((0.99, 1.0)), "failed": Outcome((0.0, 0.01)), "aborted": point(0.0)}),
        "accelerate": Summary({k: Outcome((0.0, h)) for k, h in {"distant": 1.0, "close": 1.0, "strayed": 0.02, "aborted": 0.0}.items()}),
        "cruise": Summary({"close": Outcome((0.95, 1.0)), "strayed": Outcome((0.0, 0.05)), "aborted": point(0.0)}),
        "slow": Summary({"there": Outcome((0.97, 1.0)), "strayed": Outcome((0.0, 0.03)), "aborted": point(0.0)}),
    }
    found = high_level_analysis(APPROACH, summaries)
    assert found.sound
    assert 0.8 < found.outcomes["arrived"].low <= found.outcomes["arrived"].high <= 1.0
    assert found.outcomes["failed"].low == pytest.approx(0.0, abs=1e-9)


@pytest.mark.skipif(not CASES.is_dir(), reason="data of ../shared absent")
def test_known_answers_on_interference():
    for case in json.loads((CASES / "predicates.json").read_text())["noninterference"]:
        if "coactive" in case:
            assert [list(g) for g in groups([tuple(p) for p in case["interferes"]])] == case["groups"]
            assert groups([("A", "B")]) == [("A", "B")]
            continue
        names, modules = list(case["modules"]), {}
        for name, m in case["modules"].items():
            modules[name] = Summary({"done": point(1.0)}, reads=tuple(m["reads"]), writes=tuple(m["writes"]), keeps=m.get("invariant", ""))
        (a, b), edges = names, [tuple(e) for e in case["env_edges"]]
        found = interferes(a, modules[a], b, modules[b], edges)
        assert found.holds == case.get("interfere", case.get("interfere_syntactic")), case["id"]
        if "interfere_semantic" in case and has_z3():
            action = {a: "next_d == d - c and 0 <= c and c <= d"}
            assert interferes(a, modules[a], b, modules[b], edges, actions=action).holds == case["interfere_semantic"]
            assert interferes(a, modules[a], b, modules[b], edges, actions={a: "next_d == d + c and c >= 0"}).holds is True


def test_modules_that_interfere_demand_a_joint_analysis():
    summaries = {
        "turn": Summary({"done": point(1.0)}, reads=("dir",), writes=("dir",)),
        "watch": Summary({"done": point(1.0)}, reads=("dir",), writes=("neck",)),
        "talk": Summary({"done": point(1.0)}, reads=("score",), writes=("voice",)),
    }
    ways = Wiring(("turn",), {("turn", "done"): ("talk",), ("watch", "done"): ("talk",), ("talk", "done"): ("=done",)})
    found = high_level_concurrent_analysis(ways, summaries, [("turn", "watch"), ("turn", "talk")])
    assert found.together == (("turn", "watch"),)
    assert found.sound is False
    assert "dir" in found.interference[0].why
    both = Summary({"turn.done": Outcome((0.9, 0.95)), "watch.done": Outcome((0.05, 0.1))})
    joint = high_level_concurrent_analysis(ways, summaries, [("turn", "watch")], joint={("turn", "watch"): both})
    assert joint.sound
    assert joint.outcomes["done"] == pytest.approx((1.0, 1.0))
    alone = high_level_concurrent_analysis(ways, summaries, [("turn", "talk")])
    assert alone.together == ()
    assert alone.outcomes["done"] == pytest.approx((1.0, 1.0))


def test_what_works_at_once_is_read_off_the_net():
    found = high_level_concurrent_analysis(
        APPROACH, {n: Summary({o: Outcome() for o in m.ports.outcomes}) for n, m in APPROACH.modules.items()}
    )
    assert found.together == ()
    assert found.outcomes["arrived"].high == pytest.approx(1.0)


def test_what_is_missing_is_named():
    with pytest.raises(ModelError, match="module 'kick' has no summary"):
        high_level_analysis(LOOP, {k: v for k, v in KNOWN.items() if k != "kick"})
    with pytest.raises(NetError, match="has no modules"):
        wiring(PetriNet("plain", (Place("a"),)))
    with pytest.raises(ModelError, match="cannot sum to one"):
        Summary({"done": Outcome((0.0, 0.4)), "failed": Outcome((0.0, 0.4))})
