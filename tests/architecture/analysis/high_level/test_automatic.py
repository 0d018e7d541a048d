"""Nets of modules taken to pieces by themselves: what the whole does lies within what follows from the pieces."""

import pytest

from cprm_gym.agents.worlds.learned import learn_world
from cprm_gym.architecture.analysis.bounded.value_iteration import interval_bounds
from cprm_gym.architecture.analysis.high_level.automatic import automatic_analysis
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.product.explore import product
from cprm_gym.architecture.analysis.product.prm_world import PRMWorld
from cprm_gym.architecture.petri import Command, Input, PetriNet, Place, Ports, Transition
from cprm_gym.architecture.prm import BOOL, Attribute, Model, Prior, PRMClass, Relation, Replace, Table, prev
from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.errors import NetError

PORTS = Ports(begin="begin", ongoing="ongoing", done="done", errors=("failed",))


def world(near=0.7):
    """A ball that comes ahead when he turns, and near when he runs while it is ahead."""
    ahead = Attribute("ahead", BOOL, Table({"no": (0.9, 0.1), "yes": (0.2, 0.8)}), parents=(prev("ahead"),), initial=Prior((0.7, 0.3)))
    far = {"no": (1.0, 0.0), "yes": (0.1, 0.9)}
    came = {"no": (0.9, 0.1), "yes": (1 - near, near)}
    near_ = Attribute("near", BOOL, Table({"no": far["no"], "yes": far["yes"]}), parents=(prev("near"),), initial=Prior((1.0, 0.0)))
    ball = PRMClass("Ball", attributes=(ahead, near_))
    turning = Relation("turning", roles=(("b", "Ball"),), changes=(
        Replace("b.ahead", parents=(prev("b.ahead"),), cpd=Table({"no": (0.4, 0.6), "yes": (0.1, 0.9)})),))  # fmt: skip
    running = Relation("running", roles=(("b", "Ball"),), changes=(
        Replace("b.near", parents=(prev("b.ahead"),), cpd=Table(came)),))  # fmt: skip
    model = Model("ball", (ball,), (turning, running))
    return PRMWorld(
        Grounding(model, {"ball": "Ball"}),
        {"ahead": "ball.ahead", "near": "ball.near"},
        relations={"turning(ball)": "turn", "running(ball)": "dash"},
    )


def module(name, sees, command, most):
    """Gives a command until a percept is there, at most so often."""
    return PetriNet(
        name,
        ports=PORTS,
        places=(
            Place("begin", capacity=1), Place("ongoing", capacity=1), Place("done", capacity=1), Place("failed", capacity=1),
            Place("ready", capacity=1), Place("acted", capacity=1), Place("count", capacity=most), Input("sees", observes=sees),
        ),
        transitions=(
            Transition("start", ("begin",), ("ongoing", "ready")),
            Transition("finish", ("ready", "ongoing"), ("done",), tests={"sees": 1}, sets={"count": 0}, priority=3),
            Transition("give_up", ("ready", "ongoing"), ("failed",), tests={"count": most}, sets={"count": 0}, priority=2),
            Transition("act", ("ready",), ("acted", "count"), emits=Command(command)),
            Transition("tick", ("acted",), ("ready",), delay=1),
        ),
    )  # fmt: skip


def seeker(tries=2, pause=0):
    """Turns, then runs; runs astray, he begins anew, so often."""
    return PetriNet(
        "seeker",
        ports=PORTS,
        places=(
            Place("begin", capacity=1, tokens=1), Place("ongoing", capacity=1), Place("done", capacity=1), Place("failed", capacity=1),
            Place("tries", capacity=tries), Place("astray", capacity=1),
        ),
        modules={"turn": module("turn", "ahead", "turn", 3), "run": module("run", "near", "dash", 2)},
        transitions=(
            Transition("start", ("begin",), ("ongoing", "turn.begin")),
            Transition("go", ("turn.done",), ("run.begin",)),
            Transition("lose", ("turn.failed", "ongoing"), ("failed",)),
            Transition("finish", ("run.done", "ongoing"), ("done",)),
            Transition("stray", ("run.failed",), ("astray", "tries")),
            Transition("again", ("astray",), ("turn.begin",), inhibitors={"tries": tries}, delay=pause),
            Transition("give_up", ("astray", "ongoing"), ("failed",), tests={"tries": tries}, priority=1),
        ),
    )  # fmt: skip


OUTCOMES = {"done": "done", "failed": "failed"}


@pytest.mark.parametrize("pause", [0, 2])
@pytest.mark.parametrize("tries", [1, 3])
def test_the_whole_lies_within_what_follows_from_the_pieces(tries, pause):
    net = seeker(tries, pause)
    exact = absorption(product(net, world(), OUTCOMES).chain)
    found = automatic_analysis(net, world())
    assert found.complete
    assert found.answer.sound
    assert found.begins.value == 1.0
    for outcome in OUTCOMES:
        bounds, p = found.answer.outcomes[outcome], exact.probability(outcome).value
        assert bounds.low - 1e-9 <= p <= bounds.high + 1e-9
        assert bounds.width < 0.9
    assert found.answer.steps.low <= exact.expected_time.value <= found.answer.steps.high + 1.0


def test_modules_are_summarised_apart_for_each_way_in():
    found = automatic_analysis(seeker(3, 2), world())
    assert {"turn after the beginning", "run after turn.done"} <= set(found.summaries)
    assert "turn after run.failed" in found.summaries
    # after a run that failed the ball is never near; at the beginning neither, but it may be ahead more often
    assert found.entries["turn after run.failed"] >= 2
    for name, summary in found.summaries.items():
        assert sum(o.probability[0] for o in summary.outcomes.values()) <= 1.0 + 1e-9, name
    run = found.summaries["run after turn.done"]
    assert "ahead >= 1" in run.before
    assert run.outcomes["done"].probability.width < 1e-9  # it begins in one state alone


def test_a_chain_of_sure_modules_is_as_sharp_as_the_whole():
    """One way in for each, from one state: nothing is lost."""
    net = seeker(1)
    exact = absorption(product(net, world(), OUTCOMES).chain)
    found = automatic_analysis(net, world())
    run = found.summaries["run after turn.done"].outcomes["done"].probability
    turned = found.summaries["turn after the beginning"].outcomes["done"].probability
    assert turned.low * run.low <= exact.probability("done").value <= turned.high * run.high
    assert turned.high - turned.low > 0.0


def test_a_worse_module_is_seen_in_its_summary():
    good, bad = automatic_analysis(seeker(), world(0.7)), automatic_analysis(seeker(), world(0.2))
    name = "run after turn.done"
    assert bad.summaries[name].outcomes["done"].probability.high < good.summaries[name].outcomes["done"].probability.low
    assert bad.answer.outcomes["done"].low < good.answer.outcomes["done"].low - 0.3


def test_intervals_of_the_world_go_into_the_summaries():
    net, outcomes, learned = learn_world("approach", 400, heed="parts")
    exact = absorption(product(net, learned, outcomes).chain)
    likely, whole = automatic_analysis(net, learned, "skill"), automatic_analysis(net, learned, "skill", bounded=True)
    for found in (likely, whole):
        assert found.complete
        arrived = found.answer.outcomes["arrived"]
        assert arrived.low - 1e-9 <= exact.probability("arrived").value / found.begins.value <= arrived.high + 1e-9
        assert all(link.verdict.holds for link in found.answer.links)
    assert whole.answer.outcomes["arrived"].width >= likely.answer.outcomes["arrived"].width
    assert likely.answer.outcomes["arrived"].low > 0.8
    assert max(likely.states.values()) < product(net, learned, outcomes).chain.n
    bounds = interval_bounds(product(net, learned, outcomes).bounded).probabilities["arrived"]
    assert whole.answer.outcomes["arrived"].low <= bounds.low + 1e-6  # the pieces cannot say more than the whole


def test_what_cannot_be_taken_to_pieces_is_refused():
    with pytest.raises(NetError, match="needs modules"):
        automatic_analysis(module("turn", "ahead", "turn", 3), world())
    with pytest.raises(NetError, match="unknown module 'skil'"):
        automatic_analysis(seeker(), world(), "skil")
