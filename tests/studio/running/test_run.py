"""A run is the same whenever it is played, goes back to where it was, and is changed by hand."""

import numpy as np
import pytest

from cprm_gym.errors import CprmError, NetError, ParameterError, UnknownName
from cprm_gym.studio.playing.episodes import play_episodes
from cprm_gym.studio.running.changes import Change
from cprm_gym.studio.running.frames import frame
from cprm_gym.studio.running.memory import can_keep, runner_of
from cprm_gym.studio.running.run import Run
from cprm_gym.studio.running.setup import Setup


def seen(run):
    return frame(run, run.agents, {})


@pytest.fixture
def goalie():
    return Run(Setup("Goalie", seed=2))


def test_a_run_that_goes_back_goes_on_as_it_did(goalie):
    course = [seen(goalie)]
    while not goalie.over:
        goalie.advance()
        course.append(seen(goalie))
    for cycle in (0, 7, 3, len(course) - 1):
        goalie.go_to(cycle)
        assert seen(goalie) == course[cycle]
    goalie.go_to(4)
    for expected in course[5:]:
        goalie.advance()
        assert seen(goalie) == expected


def test_a_run_whose_moments_are_forgotten_is_played_anew(goalie):
    goalie.go_to(9)
    there = seen(goalie)
    goalie.go_to(12)
    goalie._moments.clear()
    goalie.go_to(9)
    assert seen(goalie) == there


@pytest.mark.parametrize(
    ("task", "controller"),
    [("KickOffShot", "cprm"), ("LostAndFound", "cprm"), ("PassAndAdvance", "cprm:model=bins"), ("PassAndAdvance", "cprm"),
     ("Goalie2v1", "cprm"), ("Goalie2v1", "cprm:tier=tracker"), ("LostAndFound", "cprm:tier=frozen")],
)  # fmt: skip
def test_all_that_players_remember_is_kept(task, controller):
    run = Run(Setup(task, controller, seed=1))
    assert all(can_keep(player) for player in run.players)
    run.go_to(25)
    there = seen(run)
    run.go_to(31)
    later = seen(run)
    run.go_to(25)
    assert seen(run) == there
    run.go_to(31)
    assert seen(run) == later


def test_players_of_other_kinds_are_played_anew():
    run = Run(Setup("Goalie", "fsm", seed=2))
    assert not run.keepable
    run.go_to(6)
    there = seen(run)
    run.go_to(8)
    run.go_to(6)
    assert seen(run) == there


def test_a_player_on_a_tier_of_knowledge_is_looked_into_as_well():
    run = Run(Setup("Goalie", "cprm:tier=belief", seed=2))
    run.go_to(2)
    inner = seen(run)["agents"]["left_1"]
    assert inner["fired"]
    assert inner["ball"]
    run.change(Change(2, "force", "left_1", "body.stamina", (1234.0,)))
    run.advance()
    assert seen(run)["agents"]["left_1"]["percepts"]["body.stamina"] == 1234


def test_the_ball_put_elsewhere_is_there_after_the_next_step(goalie):
    goalie.go_to(3)
    goalie.change(Change(3, "ball", values=(-20.0, 5.0)))
    goalie.advance()
    assert goalie.core.sim.world["pos"][0, 0] == pytest.approx([-20.0, 5.0], abs=0.5)


def test_changes_are_made_again_when_the_run_is_played_again_and_forgotten_behind_where_it_goes_on(goalie):
    goalie.go_to(3)
    goalie.change(Change(3, "player", "right_1", values=(-30.0, 0.0, 1.0)))
    goalie.go_to(8)
    changed = seen(goalie)
    goalie._moments.clear()
    goalie.go_to(5)
    goalie.go_to(8)
    assert seen(goalie) == changed
    goalie.go_to(2)
    assert goalie.hands.log == []
    goalie.go_to(8)
    assert seen(goalie)["world"] != changed["world"]


def test_who_is_blind_is_told_nothing_until_his_eyes_open_again(goalie):
    goalie.go_to(2)
    goalie.change(Change(2, "blind", "left_1", cycles=3))
    told = []
    for _ in range(6):
        goalie.advance()
        told.append(runner_of(goalie.players[0])._percepts["ball.age"][0])
    assert max(told[:4]) >= 3
    assert min(told[3:]) == 0


def test_a_percept_that_is_forced_reads_what_it_is_told_to(goalie):
    goalie.change(Change(0, "force", "left_1", "body.stamina", (1234.0,), cycles=2))
    stamina = []
    for _ in range(4):
        goalie.advance()
        stamina.append(float(runner_of(goalie.players[0])._percepts["body.stamina"][0]))
    assert stamina[:2] == [1234.0, 1234.0]
    assert 1234.0 not in stamina[2:]


def test_a_reading_that_is_lost_is_not_told_to_the_model(goalie):
    goalie.go_to(1)
    goalie.change(Change(1, "lose", "left_1", "ball.seen_x", cycles=1))
    goalie.advance()
    assert seen(goalie)["agents"]["left_1"]["evidence"]["ball.seen_x"] is None


def test_a_skill_that_fails_marks_its_error(goalie):
    goalie.go_to(2)
    runner = runner_of(goalie.players[0])
    before = runner.executor.net.place_names
    goalie.change(Change(2, "fail", "left_1", "save"))
    goalie.hands.touch()
    port = next(name for name in before if name == f"save.{runner.cprm.net.modules['save'].ports.errors[0]}")
    assert runner.executor.read(port)[0] == 1
    assert runner.executor.read(f"save.{runner.cprm.net.modules['save'].ports.ongoing}")[0] == 0


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (Change(0, "force", "left_1", "ball.colour", (1,)), UnknownName, "unknown percept 'ball.colour'"),
        (Change(0, "lose", "left_1", "ball.x"), UnknownName, "unknown reading 'ball.x'"),
        (Change(0, "hold", "left_1", "nobody", (1,)), UnknownName, "unknown object place 'nobody'"),
        (Change(0, "mark", "left_1", "ball_x", (1,)), UnknownName, "unknown place 'ball_x'"),
        (Change(0, "mark", "left_1", "guard", (1e20,)), NetError, "place 'guard' holds 0 to 1 tokens"),
        (Change(0, "mark", "left_1", "guard", (0.5,)), NetError, "place 'guard' holds whole numbers"),
        (Change(0, "hold", "left_1", "watched_1", (7,)), NetError, "place 'watched_1' holds an object of"),
        (Change(0, "fail", "left_1", "none"), UnknownName, "unknown module with an error port 'none'"),
        (Change(0, "blind", "right_1"), UnknownName, "unknown agent 'right_1'"),
        (Change(0, "player", "left_7", values=(0, 0)), UnknownName, "unknown player 'left_7'"),
        (Change(3, "blind", "left_1"), ParameterError, "where the run stands, 0, not 3"),
    ],
)
def test_a_change_that_cannot_be_made_is_refused_when_it_is_asked_for(goalie, change, error, words):
    runner = runner_of(goalie.players[0])
    before = runner.executor.marking.copy()
    with pytest.raises(error, match=words):
        goalie.change(change)
    assert goalie.hands.log == []
    np.testing.assert_array_equal(runner.executor.marking, before)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"kind": "bal"}, "unknown change 'bal'"),
        ({"kind": "ball", "values": (1,)}, "takes 2 to 4 finite numbers"),
        ({"kind": "ball", "values": ("a", 2)}, "values are numbers"),
        ({"kind": "ball", "values": (900, 0)}, "are at most"),
        ({"kind": "ball", "values": (float("nan"), 0)}, "takes 2 to 4 finite numbers"),
        ({"kind": "blind", "cycles": 0}, "lasts 1 to"),
    ],
)
def test_a_change_that_is_none_is_refused(given, words):
    with pytest.raises(CprmError, match=words):
        Change(0, **given)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"task": "Golie"}, "unknown task 'Golie'"),
        ({"task": "Goalie", "controller": "cprn"}, "unknown controller 'cprn'"),
        ({"task": "Goalie", "disturbance": "rain"}, "unknown disturbance 'rain'"),
        ({"task": "Goalie", "seed": -1}, "seed: a whole number"),
    ],
)
def test_a_setup_that_is_none_is_refused(given, words):
    with pytest.raises(CprmError, match=words):
        Setup(**given)


def test_a_net_that_nobody_plays_with_is_refused():
    from cprm_gym.agents.catalogue import shipped_net

    with pytest.raises(ParameterError, match="nobody in Goalie plays with a net called striker"):
        Run(Setup("Goalie", nets={"striker": shipped_net("striker")}))


def test_nothing_comes_after_the_end(goalie):
    while not goalie.over:
        goalie.advance()
    with pytest.raises(CprmError, match="the episode is over"):
        goalie.advance()


def test_an_episode_of_many_is_the_run_of_its_world():
    setup = Setup("Goalie", seed=4, disturbance="ball displaced")
    (batch,) = play_episodes(setup, 3)
    for episode in batch:
        run = Run(Setup("Goalie", seed=4, world=episode.world, disturbance="ball displaced"))
        while not run.over:
            run.advance()
        assert (run.success, run.status, run.cycle, run.struck) == (episode.success, episode.status, episode.cycles, episode.struck)
