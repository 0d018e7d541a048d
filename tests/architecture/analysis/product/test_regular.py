"""Bounds from what most runs keep to: they hold as often as said, and say something where every row by itself says nothing."""

import json
from itertools import pairwise

import numpy as np
import pytest

from cprm_gym.architecture.analysis.bounded.regular import LEFT, Division, Regular, RegularBounds, counted, path_bounds
from cprm_gym.architecture.analysis.bounded.value_iteration import interval_bounds
from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.chain import MarkovChain
from cprm_gym.architecture.analysis.markov.over_time import outcomes_over_time
from cprm_gym.architecture.analysis.product.explore import product
from cprm_gym.architecture.analysis.product.learned_world import LearnedWorld, load_world
from cprm_gym.architecture.analysis.product.regular import regular_bounds
from cprm_gym.architecture.petri import Command, Input, PetriNet, Place, Transition
from cprm_gym.errors import FormatError, ModelError

CELLS = 12
WALKER = PetriNet(
    "walker",
    places=(
        Place("on", capacity=1, tokens=1),
        Place("home", capacity=1),
        Place("lost", capacity=1),
        Place("legs", capacity=1, tokens=1),
        Place("walked", capacity=1),
        Input("x", observes="x"),
    ),
    transitions=(
        Transition("arrive", ("on",), ("home",), tests={"x": CELLS - 1.5}, priority=2),
        Transition("stray", ("on",), ("lost",), inhibitors={"x": 0.5}, priority=1),
        Transition("walk", ("legs",), ("walked",), emits=Command("walk")),
        Transition("again", ("walked",), ("legs",), delay=1),
    ),
)
OUTCOMES = {"home": "home", "lost": "lost"}
EDGES = {"x": tuple(k + 0.5 for k in range(CELLS - 1))}
STEPS = {1: 0.9, -1: 0.06, -3: 0.04}
"""How far a step leads, and how likely."""


def truth():
    rows = [{} for _ in range(CELLS)]
    for s in range(1, CELLS - 1):
        for by, p in STEPS.items():
            to = min(max(s + by, 0), CELLS - 1)
            rows[s][to] = rows[s].get(to, 0.0) + p
    return MarkovChain.from_rows(rows, {"home": [CELLS - 1], "lost": [0]}, {4: 0.5, 6: 0.5})


def walked(runs, seed, world=None):
    """A world learned from walks; half of them are told once more."""
    world = world or LearnedWorld(EDGES, acts=("walk",))
    rng = np.random.default_rng(seed)
    ways, chances = list(STEPS), np.cumsum(list(STEPS.values()))
    for k in range(runs):
        at = int(rng.choice([4, 6]))
        path = [at]
        while 0 < path[-1] < CELLS - 1:
            by = ways[int(np.searchsorted(chances, rng.random(), "right"))]
            path.append(min(max(path[-1] + by, 0), CELLS - 1))
        cells = [(p,) for p in path]
        world.begin(cells[0], {"x": float(path[0])})
        for a, b in pairwise(cells):
            world.saw(a, ("walk",), b, {"x": float(b[0])})
        if k >= runs - runs // 2:
            world.later.append([*((c, ("walk",)) for c in cells[:-1]), (cells[-1], None)])
    return world


def test_bounds_hold_also_cycle_by_cycle():
    exact = absorption(truth())
    world = walked(600, 1)
    found = regular_bounds(WALKER, world, OUTCOMES, cycles=40)
    for outcome in OUTCOMES:
        assert found.probabilities[outcome].holds(exact.probability(outcome).value)
    plain = interval_bounds(product(WALKER, world, OUTCOMES).bounded).probabilities["home"]
    assert found.probabilities["home"].width < 0.35
    assert plain.width > found.probabilities["home"].width
    over = outcomes_over_time(truth(), 40)
    for outcome in OUTCOMES:
        low, high = found.over_time[outcome]
        assert (low[1:] <= over.by(outcome)[:-1] + 1e-9).all()  # the net notices a cycle later
        assert (high[1:] >= over.by(outcome)[:-1] - 1e-9).all()
        assert low[-1] == pytest.approx(found.probabilities[outcome].low, abs=1e-3)


def test_runs_in_which_the_net_did_something_else_count_as_having_left():
    world = walked(600, 1)
    for run in world.later[:60]:
        run[0] = (run[0][0], ("stand",))
        world.counts.setdefault((run[0][0], ("stand",)), {run[1][0]: 100})
    found = regular_bounds(WALKER, world, OUTCOMES)
    assert found.least["home"][1].left >= 60
    assert found.probabilities["home"].high == 1.0
    assert found.probabilities["home"].low < regular_bounds(WALKER, walked(600, 1), OUTCOMES).probabilities["home"].low - 0.15


def test_more_runs_narrow_them():
    widths = [regular_bounds(WALKER, walked(n, 2), OUTCOMES).probabilities["home"].width for n in (100, 1000, 10_000)]
    assert widths[2] < 0.5 * widths[1] < 0.3 * widths[0]


def test_they_hold_at_least_as_often_as_said():
    """60 repetitions, nominal 80 %."""
    exact = absorption(truth()).probability("home").value
    missed = 0
    for seed in range(60):
        found = regular_bounds(WALKER, walked(60, 100 + seed), OUTCOMES, confidence=0.8)
        missed += not found.probabilities["home"].holds(exact)
    assert missed <= 12


def test_rows_that_were_hardly_ever_begun_are_counted_once():
    first = {(("a",), ("go",)): {("b",): 5, ("c",): 1}, (("b",), ("go",)): {("d",): 1}}
    runs = [
        [(("a",), ("go",)), (("b",), None)],
        [(("a",), ("go",)), (("b",), ("go",)), (("d",), None)],
        [(("a",), ("go",)), (("z",), None)],
    ]
    often = Regular(first, {("a",): 6}, runs, 2, 0.95)
    assert [often.keeps(run) for run in runs] == [True, False, False]
    assert often.division.left == 2
    assert often.row((("b",), ("go",))) == {}
    assert [round(p, 3) for p, _ in often.row((("a",), ("go",))).values()] == [0.875, 0.125]
    once = Regular(first, {("a",): 6}, runs, 1, 0.95)
    assert [once.keeps(run) for run in runs] == [True, True, False]
    assert not once.keeps([(("a",), ("go",)), (("b",), ("go",))])  # cut off before its end
    assert counted(runs)[("a",), ("go",)] == {("b",): 2, ("z",): 1}


def test_what_the_budget_leaves_unexplored_may_be_anything():
    found = regular_bounds(WALKER, walked(600, 1), OUTCOMES, budget=Budget(states=5))
    assert found.probabilities["home"].holds(absorption(truth()).probability("home").value)
    assert found.probabilities["home"].high == 1.0


def test_coarser_cells_of_the_same_runs():
    world = walked(300, 3)
    kept = {"x": (0.5, 3.5, CELLS - 1.5)}
    coarse = world.coarser(kept)
    assert dict(coarse.edges) == kept
    assert sum(coarse.begins.values()) == sum(world.begins.values()) == 300
    assert sum(n for row in coarse.counts.values() for n in row.values()) == sum(n for row in world.counts.values() for n in row.values())
    assert len(coarse.counts) == 2
    assert len(coarse.later) == 150
    with pytest.raises(ModelError, match="'x' is cut at"):
        world.coarser({"x": (0.7,)})


def test_runs_that_were_held_out_are_kept_in_files_and_checked(tmp_path):
    world = walked(40, 4)
    world.save(tmp_path / "world.json")
    again = load_world(tmp_path / "world.json")
    assert again.later == world.later
    assert regular_bounds(WALKER, again, OUTCOMES).probabilities == regular_bounds(WALKER, world, OUTCOMES).probabilities
    data = json.loads((tmp_path / "world.json").read_text())
    for damage, message in (
        (lambda d: d["later"].append([999]), "a row that there is not"),
        (lambda d: d["later"].extend(d["later"] * 50), "was not counted"),
        (lambda d: d["later"].append([]), "last cell"),
    ):
        wrong = json.loads(json.dumps(data))
        damage(wrong)
        (tmp_path / "wrong.json").write_text(json.dumps(wrong))
        with pytest.raises(FormatError, match=message):
            load_world(tmp_path / "wrong.json")


def test_a_world_without_runs_held_out_has_no_such_bounds():
    world = walked(30, 5)
    world.later.clear()
    with pytest.raises(ModelError, match="some were held out"):
        regular_bounds(WALKER, world, OUTCOMES)


def test_a_division_that_leaves_too_much_is_not_looked_at():
    found = RegularBounds(100, {"goal": (0.9, Division(1, 3, 4, 0, 0.02))}, {"goal": (1.0, Division(1, 3, 4, 0, 0.02))})
    assert found.useful(Division(3, 2, 3, 5, 0.09))
    assert not found.useful(Division(10, 1, 2, 100, 1.0))
    assert LEFT == "unseen"


def test_bounds_of_runs_that_are_known_by_their_states_alone():
    exact = absorption(truth()).probability("home").value
    rng = np.random.default_rng(9)
    chain, paths = truth(), []
    for _ in range(800):
        at, path = int(rng.choice([4, 6])), []
        while 0 < at < CELLS - 1:
            path.append(at)
            row = slice(chain.offsets[at], chain.offsets[at + 1])
            at = int(rng.choice(chain.targets[row], p=chain.chances[row]))
        paths.append([*path, "home" if at else "lost"])
    found = path_bounds(paths[:400], paths[400:], ("home", "lost")).probabilities
    assert found["home"].holds(exact)
    assert found["home"].width < 0.35
    cut = [path[:-1] for path in paths[400:]]
    assert path_bounds(paths[:400], cut, ("home", "lost")).probabilities["home"] == (0.0, 1.0)
    with pytest.raises(ModelError, match="runs of both kinds"):
        path_bounds(paths, [], ("home",))
