"""Agent and world as one chain: against a chain by hand, against its own runs, with clocks, relations and intervals."""

import numpy as np
import pytest

from cprm_gym.architecture.analysis.bounded.value_iteration import interval_bounds
from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.over_time import outcomes_over_time
from cprm_gym.architecture.analysis.product.explore import UNEXPLORED, product
from cprm_gym.architecture.analysis.product.learned_world import LearnedWorld, load_world, thresholds_of
from cprm_gym.architecture.analysis.product.prm_world import PRMWorld
from cprm_gym.architecture.analysis.product.runs import ProductRuns
from cprm_gym.architecture.analysis.rare.conditional import conditional
from cprm_gym.architecture.analysis.sampling.sample import sample
from cprm_gym.architecture.petri import Command, Input, Math, PetriNet, Place, Transition, compile_net
from cprm_gym.architecture.prm import BOOL, Attribute, Model, Prior, PRMClass, Relation, Replace, Table, prev
from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.errors import FormatError, ModelError, NetError

AHEAD = {"no": 0.05, "yes": 0.95}
"""Chance that the ball is ahead in the next cycle, without a turn."""
TURNED = {"no": 0.6, "yes": 0.8}
"""With one."""


def ball_world(**options):
    table = Table({"no": (1 - AHEAD["no"], AHEAD["no"]), "yes": (1 - AHEAD["yes"], AHEAD["yes"])})
    turned = Table({"no": (1 - TURNED["no"], TURNED["no"]), "yes": (1 - TURNED["yes"], TURNED["yes"])})
    ball = PRMClass("Ball", attributes=(Attribute("ahead", BOOL, table, parents=(prev("ahead"),), initial=Prior((0.9, 0.1))),))
    turning = Relation("turning", roles=(("b", "Ball"),), changes=(Replace("b.ahead", parents=(prev("b.ahead"),), cpd=turned),))
    return PRMWorld(
        Grounding(Model("ball", (ball,), (turning,)), {"ball": "Ball"}),
        {"ball.ahead": "ball.ahead"},
        relations={"turning(ball)": "turn"},
        **options,
    )


def turner(most=3, act="turn"):
    """Turns until the ball is ahead, at most so often; each turn takes a cycle."""
    return PetriNet(
        "turner",
        places=(
            Place("ready", capacity=1, tokens=1), Place("acted", capacity=1), Place("done", capacity=1), Place("failed", capacity=1),
            Place("turns", capacity=most), Input("ahead", observes="ball.ahead"),
        ),
        transitions=(
            Transition("arrive", ("ready",), ("done",), tests={"ahead": 1}, priority=5),
            Transition("give_up", ("ready",), ("failed",), tests={"turns": most}, inhibitors={"ahead": 1}),
            Transition("turn", ("ready",), ("acted", "turns"), inhibitors={"ahead": 1, "turns": most}, emits=Command(act)),
            Transition("tick", ("acted",), ("ready",), delay=1),
        ),
    )  # fmt: skip


OUTCOMES = {"done": "done", "failed": "failed"}


def test_the_product_is_the_chain_by_hand():
    found = product(turner(), ball_world(), OUTCOMES)
    assert found.complete
    # 0.1 at once; three turns, each brings it ahead with 0.6
    answer = absorption(found.chain)
    assert answer.probability("done").value == pytest.approx(0.1 + 0.9 * (1 - 0.4**3), abs=1e-12)
    over = outcomes_over_time(found.chain, 8)
    assert over.by("done")[:3].tolist() == pytest.approx([0.0, 0.1, 0.1 + 0.9 * 0.6], abs=1e-12)
    assert interval_bounds(found.bounded).probabilities["done"] == pytest.approx((answer.probability("done").value,) * 2, abs=1e-9)


def test_states_can_be_read_and_runs_told():
    found = product(turner(), ball_world(), OUTCOMES)
    names = [found.chain.name(i) for i in range(found.chain.n)]
    assert "done" in names
    assert any(name.startswith("[ready") and name.endswith("ball.ahead no") for name in names)
    run, _ = conditional(found.chain, "failed").likeliest_run()
    told = found.tell(run)
    assert sum("-> turn" in line for line in told) == 3
    assert told[-1].endswith("failed")


def test_relations_are_switched_by_what_the_net_commands():
    idle = product(turner(act="wait"), ball_world(), OUTCOMES)
    assert absorption(idle.chain).probability("done").value == pytest.approx(0.1 + 0.9 * (1 - 0.95**3), abs=1e-12)


def test_runs_of_the_product_have_its_probabilities():
    exact = absorption(product(turner(), ball_world(), OUTCOMES).chain)
    found = sample(ProductRuns(turner(), ball_world(), OUTCOMES), 1500, seed=2, properties_={"turns once at least": "F turn"})
    assert found.intervals()["done"].holds(exact.probability("done").value)
    assert found.properties["turns once at least"].true / 1500 == pytest.approx(0.9, abs=0.04)
    again = ProductRuns(turner(), ball_world(), OUTCOMES)
    assert again.play(range(40), 1, False)[9].outcome == again.play([9], 1, False)[0].outcome


def test_clocks_are_part_of_the_state():
    net = PetriNet("waits", (Place("a", tokens=1), Place("b")), (Transition("go", ("a",), ("b",), delay=4),))
    found = product(net, ball_world(), {"over": "b"})
    assert absorption(found.chain).expected_time.value == pytest.approx(5.0)  # ends within the fifth cycle
    assert any("clock" in key for marking in found.markings for key in marking)


def test_a_world_may_end_a_run_itself():
    found = product(turner(99), ball_world(ends={"rolled in": "ball.ahead == 1"}), OUTCOMES)
    answer = absorption(found.chain)
    assert answer.probability("rolled in").value == pytest.approx(1.0)
    assert answer.probability("done").value == 0.0
    runs = ProductRuns(turner(99), ball_world(ends={"rolled in": "ball.ahead == 1"}), OUTCOMES, ends=("rolled in",))
    assert sample(runs, 30).count("rolled in") + sample(runs, 30).count("done") == 30


def test_a_budget_leaves_an_outcome_that_says_so():
    net = turner(40)
    found = product(net, ball_world(), OUTCOMES, budget=Budget(states=9))
    assert not found.complete
    whole, part = absorption(product(net, ball_world(), OUTCOMES).chain), absorption(found.chain)
    rest = part.probability(UNEXPLORED).value
    assert rest > 0
    assert part.probability("done").value <= whole.probability("done").value <= part.probability("done").value + rest


def test_a_broken_behaviour_is_told_by_its_run():
    """It gives up before it looks: the ball is there, and he fails."""
    good = turner()
    panic = Transition("panic", ("ready",), ("failed",), tests={"turns": 1}, priority=9)
    broken = PetriNet("hasty", places=good.places, transitions=(*good.transitions, panic))
    found = product(broken, ball_world(), OUTCOMES)
    assert absorption(found.chain).probability("failed").value == pytest.approx(0.9)
    run, _ = conditional(found.chain, "failed").likeliest_run()
    assert any("ball.ahead yes" in line for line in found.tell(run))


def test_percepts_and_places_must_be_there():
    with pytest.raises(NetError, match=r"observes 'ball.ahead'; the world gives ball.seen"):
        product(turner(), PRMWorld(ball_world().grounding, {"ball.seen": "ball.ahead"}), OUTCOMES)
    with pytest.raises(NetError, match=r"unknown place 'don'. Did you mean 'done'"):
        product(turner(), ball_world(), {"done": "don"})
    with pytest.raises(ModelError, match=r"unknown variable 'ball.ahed'"):
        PRMWorld(ball_world().grounding, {"ball.ahead": "ball.ahed"})


# ------------------------------------------------------------------------------------------------- learned


def learned(runs=400, seed=0):
    """Counts of a ball that comes nearer when he dashes."""
    net = PetriNet(
        "runner",
        places=(Place("ready", capacity=1, tokens=1), Place("acted", capacity=1), Place("there", capacity=1),
                Input("seen", observes="ball.distance"), Math("distance", "max(seen, 0)")),
        transitions=(
            Transition("arrive", ("ready",), ("there",), inhibitors={"distance": 1.0}, priority=3),
            Transition("dash", ("ready",), ("acted",), tests={"distance": 1.0}, emits=Command("dash")),
            Transition("tick", ("acted",), ("ready",), delay=1),
        ),
    )  # fmt: skip
    rng = np.random.default_rng(seed)
    edges = {"distance": (*thresholds_of(compile_net(net))["distance"], 2.0, 3.0)}
    world = LearnedWorld(edges)
    for _ in range(runs):
        d = 4.0
        cell = world.cell({"distance": d})
        world.begin(cell, {"ball.distance": d})
        while d >= 1.0:
            d -= rng.uniform(0.0, 1.0)
            then = world.cell({"distance": d})
            world.saw(cell, ("dash",), then, {"ball.distance": d})
            cell = then
    return net, world


def test_a_learned_world_gives_exact_bounded_and_sampled_answers():
    net, world = learned()
    found = product(net, world, {"there": "there"})
    p = absorption(found.chain)
    assert p.probability("there").value == pytest.approx(1.0)
    bounds = interval_bounds(found.bounded)
    assert bounds.probabilities["there"].low < 1.0
    assert bounds.probabilities["there"].high == pytest.approx(1.0)
    assert bounds.probabilities["unseen"].holds(0.0)
    assert bounds.time.low <= p.expected_time.value <= bounds.time.high
    more = interval_bounds(product(*learned(4000), {"there": "there"}).bounded)
    assert more.probabilities["there"].width < 0.3 * bounds.probabilities["there"].width


def test_what_was_never_seen_is_an_outcome_of_its_own():
    net, world = learned(20)
    kick = Transition("dash", ("ready",), ("acted",), tests={"distance": 1.0}, emits=Command("kick"))
    other = PetriNet("kicker", places=net.places, transitions=tuple(kick if t.name == "dash" else t for t in net.transitions))
    answer = absorption(product(other, world, {"there": "there"}).chain)
    assert answer.probability("unseen").value == pytest.approx(1.0)


def test_a_learned_world_comes_back_from_its_file(tmp_path):
    net, world = learned(30)
    world.save(tmp_path / "world.json")
    back = load_world(tmp_path / "world.json")
    assert back.to_json() == world.to_json()
    times = [absorption(product(net, w, {"there": "there"}).chain).expected_time for w in (back, world)]
    assert times[0] == times[1]
    for text in ("{", "[]", '{"edges": {}}'):
        (tmp_path / "bad.json").write_text(text)
        with pytest.raises(FormatError, match=r"bad\.json"):
            load_world(tmp_path / "bad.json")
