"""Who plays the suite ``chapter5``, and in which conditions."""

from dataclasses import replace

import pytest

from cprm_gym.benchmark.chapter5 import Chapter5Plan, play_cell, players, summarise
from cprm_gym.benchmark.chapter5.cells import FULL, QUICK
from cprm_gym.benchmark.chapter5.conditions import CONDITIONS, SHIFTS, condition, shifts_of
from cprm_gym.benchmark.chapter5.experiments import EXPERIMENTS
from cprm_gym.benchmark.chapter5.players import INTERNAL, LATE, NET, ON, WATCHED, make_player, plays
from cprm_gym.benchmark.chapter5.slow import Slow
from cprm_gym.benchmark.plan import Block
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ControllerError, UnknownName


def play(task, key, count=12, first=0, seed=3):
    return play_cell(Block(task, key, first, count, seed))


def test_players_by_name():
    task, how = make_task("Goalie"), condition("noise 1")
    assert type(make_player("fsm", how)(task, "left_1")).__name__ == "Player"
    assert make_player(f"{NET}{ON}belief", how)(task, "left_1").tier.name == "belief"
    assert isinstance(make_player(f"{NET}{ON}memory{LATE}", how)(task, "left_1"), Slow)
    assert type(make_player(f"fsm{WATCHED}", how)(task, "left_1")).__name__ == "Watchdog"
    assert plays("fsm", "Goalie")
    assert not plays("fsm", "Soccer")
    assert not plays(INTERNAL, "Goalie")
    with pytest.raises(UnknownName, match="unknown controller 'fms'"):
        make_player("fms", how)
    with pytest.raises(UnknownName, match="unknown tier 'beleif'"):
        make_player(f"{NET}{ON}beleif", how)(task, "left_1")


def test_the_cprm_under_another_name_is_not_played_again_and_what_is_weak_on_purpose_is_not_compared():
    assert not {"lesion", "goalie_memory"} & set(players.registered())
    assert set(players.WEAKENED) <= set(players.registered())
    plan = Chapter5Plan(("table",), replace(QUICK, table=2))
    results = [play("Goalie", f"default/{name}", 2) for name in ("cprm", "fsm", "random", "eased", "goalie_raw")]
    (told,) = summarise(plan, results).told
    assert {row[1] for row in told.tables[0].rows} == {"cprm", "fsm", "random", "eased", "goalie_raw"}
    assert [(c.first, c.second) for c in told.comparisons] == [("cprm", "fsm")]


def test_trained_policies_are_taken_to_other_worlds_wherever_one_comes_with_the_project():
    cells = {one.cell for one in EXPERIMENTS["transfer"].wanted(FULL)}
    for task in ("GoToBall", "Goalie", "HFO1v0"):
        assert plays("policy", task)
        assert {cell.condition for cell in cells if (cell.task, cell.player) == (task, "policy")} == {"default", *shifts_of(task)}
    # where nothing was tuned, the net is not played twice
    assert {cell.player for cell in cells if cell.task == "GoToBall"} & {"cprm", NET, players.UNTUNED} == {"cprm"}
    for task in ("Goalie", "HFO1v0"):
        assert {cell.player for cell in cells if cell.task == task} >= {"cprm", NET, players.UNTUNED}


def test_a_controller_without_its_package_is_left_out_and_said_so(monkeypatch):
    def load(name):
        if name == "code":
            missing = ModuleNotFoundError("No module named 'py_trees'", name="py_trees")
            said = ControllerError("trees need py_trees")
            said.__cause__ = missing
            raise ControllerError("cannot be loaded") from said
        return original(name)

    original = players.load_controller
    monkeypatch.setattr(players, "load_controller", load)
    players.plays.cache_clear()
    players.not_installed.cache_clear()
    try:
        assert players.not_installed() == {"code": "py_trees"}
        assert not plays("code", "Hike")
    finally:
        players.plays.cache_clear()
        players.not_installed.cache_clear()


def test_shifts_change_the_task_and_nothing_else_does():
    for task in ("Goalie", "Goalie2v1", "GoToBall", "LostAndFound", "HFO1v0"):
        for name in SHIFTS:
            changed = condition(name).task(task) != make_task(task)
            assert changed == (name in shifts_of(task)), (task, name)
    for name, how in CONDITIONS.items():
        if name not in SHIFTS:
            assert how.task("Goalie") == make_task("Goalie")


def test_the_hiker_who_infers_what_he_is_about_comes_home_and_belief_alone_does_not():
    with_it, without = play("Hike", f"default/{INTERNAL}"), play("Hike", "default/belief_region")
    assert all(with_it.success)
    assert not any(without.success)


def test_what_the_architecture_contains_plays_as_such_and_as_its_net():
    for what in ("state machine", "belief regions"):
        one, other = (play("GoToBall", f"default/{name}", 3) for name in (what, f"{what} as a net"))
        assert not one.error
        assert one.success == [True] * 3
        assert (one.cycles, one.reward) == (other.cycles, other.reward)
    assert not plays("state machine", "Goalie")
