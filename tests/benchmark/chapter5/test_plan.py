"""What the suite ``chapter5`` plays: cells, plans, claims."""

import json
from dataclasses import replace

import pytest

from cprm_gym.benchmark.chapter5 import Chapter5Plan
from cprm_gym.benchmark.chapter5.cells import FACT, QUICK, Cell, Size, Wanted, blocks_of
from cprm_gym.benchmark.chapter5.claims import CLAIMS
from cprm_gym.benchmark.chapter5.command import Asked, benchmark, plan_of, spoken
from cprm_gym.benchmark.chapter5.conditions import condition
from cprm_gym.benchmark.chapter5.experiments import EXPERIMENTS
from cprm_gym.benchmark.chapter5.players import make_player
from cprm_gym.benchmark.plan import Block
from cprm_gym.envs.tasks import TASKS
from cprm_gym.errors import CprmError, ParameterError, UnknownName


def test_every_cell_of_full_and_quick_names_tasks_conditions_and_players_that_there_are():
    for plan in (Chapter5Plan(), Chapter5Plan.quick()):
        wanted = plan.wanted()
        assert set(plan.experiments) == set(EXPERIMENTS)
        for one in wanted:
            if one.episodes == FACT:
                continue
            assert one.cell.task in TASKS
            condition(one.cell.condition).task(one.cell.task)
            make_player(one.cell.player, condition(one.cell.condition))
            assert Cell.of(Block(one.cell.task, one.cell.key, 0, 1, 0)) == one.cell


def test_a_cell_that_several_ask_for_is_played_once_with_the_most_episodes():
    cell = Cell("Goalie", "default", "fsm")
    blocks = blocks_of([Wanted(cell, 20), Wanted(cell, 2400), Wanted(Cell("3", "concurrency", "net"))], seed=4)
    assert [(b.first, b.count) for b in blocks] == [(0, 1000), (1000, 1000), (2000, 400), (0, FACT)]
    plan = Chapter5Plan.quick()
    keys = [(b.task, b.controller, b.first) for b in plan.blocks()]
    assert len(keys) == len(set(keys))
    assert len(plan.wanted()) > len({one.cell for one in plan.wanted()})


def test_floors_and_curves_of_the_full_suite_are_as_large_as_they_have_to_be_and_it_stays_within_four_hours():
    plan = Chapter5Plan()
    assert plan.size == Size(table=2000, curve=300, full=True)
    assert plan.seconds < 4 * 3600
    assert Chapter5Plan.quick().seconds < 360
    assert plan.at_most(100).size == replace(plan.size, table=100, curve=100)


@pytest.mark.parametrize(
    ("given", "message"),
    [({"experiments": ()}, "none given"), ({"experiments": ("table", "table")}, "named twice"), ({"seed": -1}, "seed: -1 given"),
     ({"size": replace(QUICK, table=1)}, "episodes: 1 given")],
)  # fmt: skip
def test_plans_that_make_no_sense_are_refused(given, message):
    with pytest.raises(ParameterError, match=message):
        Chapter5Plan(**given)


def test_an_unknown_experiment_is_named_with_those_there_are():
    with pytest.raises(UnknownName, match=r"unknown experiment 'sences'\. Did you mean 'senses'"):
        Chapter5Plan(("sences",))


def test_every_claim_has_an_experiment_that_speaks_of_it():
    assert {claim.experiment for claim in CLAIMS.values()} == set(EXPERIMENTS)


def test_the_command_that_is_told_makes_the_same_plan():
    asked = Asked(True, ("table", "memory"), 12, 7)
    assert spoken(asked, 2) == "cprm-gym benchmark --suite chapter5 --quick --only table --only memory --episodes 12 --seed 7 --workers 2"
    assert plan_of(asked) == Chapter5Plan(("table", "memory"), replace(QUICK, table=12, curve=12), 7)


def test_a_new_folder_is_made_only_for_a_new_run(tmp_path):
    with pytest.raises(CprmError, match="as it was planned"):
        benchmark(Asked(quick=True), tmp_path, lambda: pytest.fail("made"), 1, 60.0, None, str)


def test_a_plan_of_other_numbers_is_not_taken_up(tmp_path):
    Chapter5Plan.quick().write(tmp_path)
    assert Chapter5Plan.read(tmp_path) == Chapter5Plan.quick()
    data = json.loads((tmp_path / "plan.json").read_text())
    data["constants"]["Goalie"]["run"] += 0.01
    (tmp_path / "plan.json").write_text(json.dumps(data))
    with pytest.raises(CprmError, match="the constants of the players are others by now"):
        Chapter5Plan.read(tmp_path)
