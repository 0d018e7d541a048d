"""What joins as either team: tasks mirrored, every controller, set plays on both sides; over sockets."""

import threading

import numpy as np
import pytest
from served_field import SYNCHRONOUS, Field
from typer.testing import CliRunner

from cprm_gym.cli import app
from cprm_gym.client.connection import Connection
from cprm_gym.envs.others.registry import controller_entries, load_controller
from cprm_gym.envs.play import rehearse
from cprm_gym.envs.tasks import TASKS, make_task
from cprm_gym.errors import CprmError
from cprm_gym.joining.player import JoinedPlayer, played_from
from cprm_gym.joining.team import JoinedTeam, formation
from cprm_gym.simulator.state import PlayMode

HOST = "127.0.0.1"


FIRST_TO_TRY = ("GoToBall", "Goalie", "KickOffShot", "Soccer11v11", *TASKS)
SHOOT_OUT = (
    "server::penalty_shoot_outs=true", "server::nr_extra_halfs=0", "server::pen_nr_kicks=2", "server::pen_max_extra_kicks=0",
    "server::pen_before_setup_wait=5", "server::pen_setup_wait=20", "server::pen_ready_wait=5", "server::pen_taken_wait=40",
)  # fmt: skip


def goals_from(side, name, cycles):
    """Goals of two CPRM agents who kick off on a side of the pitch, alone on it."""
    left, ready = side == "left", []

    def each():
        stadium = field.server.stadium
        if ready:
            stadium.sim.trainer.change_mode(ready.pop())
        return stadium.time < cycles and not stadium.world["score"].any()

    field = Field(*SYNCHRONOUS, "server::half_time=-1", fast=True, each=each)
    with field:
        port = field.transport.ports[0]
        if not left:
            first = Connection(HOST, port)
            first.ask("(init First (version 19))", lambda text: text.startswith("(init l 1 "), 20.0)
            first.send("(bye)")
            first.close()
        task = make_task(name)
        team = JoinedTeam(HOST, port, "Ours", task, load_controller("cprm"), players=2, goalie=False)
        assert [player.agent for player in team.players] == [f"{side}_1", f"{side}_2"]
        ready.append(PlayMode.kick_off_l if left else PlayMode.kick_off_r)
        team.play(field.thread.is_alive)
        team.leave()
        assert all(player.ear.damaged == player.tally.reconnections == 0 for player in team.players)
    return int(field.server.stadium.world["score"][0 if left else 1])


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("name", "cycles"), [("KickOffShot", 600), ("PassAndAdvance", 1000)])
def test_an_attack_is_the_same_from_either_side(side, name, cycles):
    assert goals_from(side, name, cycles) == 1


def test_a_task_is_mirrored_for_the_side_that_is_not_its_own():
    task = make_task("HFO2v1")
    assert played_from(task, "left", "l") is task
    assert played_from(task, "right", "r") is task
    other = played_from(task, "left", "r")
    assert (other.left, other.right, other.left_goalie, other.right_goalie) == (1, 2, 1, 0)
    assert played_from(task, "right", "l") == other


def test_who_plays_the_right_part_stands_where_the_right_side_starts():
    task = make_task("HFO2v1")
    keeper = formation(task, 3, "right")
    assert keeper.shape == (1, 2)
    assert keeper[0, 0] == pytest.approx(-51.0)  # in front of his own goal, in his own frame
    assert formation(task, 3).shape == (2, 2)
    assert (formation(make_task("Soccer11v11"), 0)[:, 0] <= 0).all()


def joined(name, controller, side="left", **options):
    """A player of ours in lock-step for ten decisions, on a side of the pitch."""
    there = []

    def each():
        return not there or (there[0].tally.decisions < 10 and field.server.stadium.time < 300)

    field = Field(*SYNCHRONOUS, "server::half_time=-1", fast=True, each=each)
    with field:
        port = field.transport.ports[0]
        if side == "right":
            first = Connection(HOST, port)
            first.ask("(init First (version 19))", lambda text: text.startswith("(init l 1 "), 20.0)
            first.send("(bye)")
            first.close()
        team = JoinedTeam(HOST, port, "Ours", make_task(name), load_controller(controller), players=1, **options)
        field.server.stadium.sim.trainer.change_mode(PlayMode.play_on)
        there.append(team.players[0])
        team.play(field.thread.is_alive)
        team.leave()
    return there[0]


def played_by(controller):
    """A task that a controller plays."""
    factory = load_controller(controller)
    for name in FIRST_TO_TRY:
        try:
            factory(make_task(name), "left_1")
        except CprmError:
            continue
        return name
    raise AssertionError(f"{controller} plays no task")


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("controller", controller_entries())
def test_every_registered_controller_joins(controller, side):
    player = joined(played_by(controller), controller, side)
    assert player.agent == f"{side}_1"
    assert player.tally.decisions >= 10
    assert player.ear.damaged == 0
    twice = "(error only_init_allowed_on_init_port)"  # he asked to join again, because the server took long to answer
    assert [text for text in player.ear.answers if text.startswith("(error ") and text != twice] == []


def test_a_goalie_of_ours_is_the_goalie_on_either_side():
    for side in ("left", "right"):
        player = joined("Goalie", "cprm", side, goalie=True)
        world = player.core.sim.world[0]
        assert (player.ear.goalie, int(world["goalie"][player.row])) == (True, 1)


def test_what_is_lost_doubled_or_late_ends_nothing():
    """A player whose messages are lost, doubled and come in another order decides in every cycle that he is told of."""
    random = np.random.default_rng(0)
    field = Field(*SYNCHRONOUS, "server::half_time=-1", fast=True, each=lambda: field.server.stadium.time < 80)
    with field:
        player = JoinedPlayer(HOST, field.transport.ports[0], "Ours", make_task("KickOffShot"), load_controller("cprm"))
        whole, late = player.connection.receive, list[str]()

        def damaged():
            texts = list[str]()
            for text in whole():
                if text == "(think)":
                    texts.append(text)  # without it the server only waits
                elif random.uniform() < 0.2:
                    late.append(text)
                elif random.uniform() < 0.8:
                    texts += [text] * int(random.integers(1, 3))
            if late and random.uniform() < 0.5:
                texts.insert(0, late.pop(int(random.integers(len(late)))))
            return texts

        player.connection.receive = damaged
        field.server.stadium.sim.trainer.change_mode(PlayMode.play_on)
        while field.thread.is_alive():
            player.take()
            if player.due == 0.0:
                player.act()
        player.leave()
    assert player.tally.decisions > 40
    assert player.ear.lost > 0
    assert player.ear.stale > 0
    assert player.ear.damaged == 0


def test_a_shoot_out_is_played_to_its_end():
    words = (*SYNCHRONOUS, "server::auto_mode=true", "server::half_time=1", "server::kick_off_wait=3", "server::game_over_wait=3",
             "server::connect_wait=2000", *SHOOT_OUT)  # fmt: skip
    task, teams = make_task("Soccer11v11"), []
    rehearse(task, load_controller("scripted"), "left_1")  # a match waits for its teams, not for their compiler
    field = Field(*words, fast=True)
    with field:

        def join(name):
            team = JoinedTeam(HOST, field.transport.ports[0], name, task, load_controller("scripted"))
            teams.append(team)
            team.play(field.thread.is_alive)
            team.leave()

        threads = [threading.Thread(target=join, args=(name,)) for name in ("Alpha", "Beta")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(200)
        field.thread.join(30)
    assert field.server.over == "the match is over"
    world = field.server.stadium.world
    assert int(world["pen_score"].sum() + world["pen_miss"].sum()) >= 2
    assert all(player.ear.damaged == 0 for team in teams for player in team.players)


@pytest.mark.parametrize(
    ("words", "expected"), [([], 6002), (["--port", "7000"], 7002), (["--port", "7000", "--coach-port", "6002"], 6002)]
)
def test_the_coach_asks_where_serve_has_put_it(words, expected, monkeypatch):
    asked = []

    def join(*_, **options):
        asked.append(options["coach_port"])
        raise CprmError("nobody there")

    monkeypatch.setattr("cprm_gym.joining.team.JoinedTeam", join)
    CliRunner().invoke(app, ["join", "Alpha", "--coach", *words])
    assert asked == [expected]
