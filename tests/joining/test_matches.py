"""Whole teams of ours on a server of ours, over sockets; and the same match, bit for bit, with and without a network."""

import threading
import time

import numpy as np
import pytest
from served_field import SYNCHRONOUS, Field

from cprm_gym.envs.others.registry import load_controller
from cprm_gym.envs.play import rehearse
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import CprmError
from cprm_gym.joining.coach import choose_types
from cprm_gym.joining.player import JoinedPlayer
from cprm_gym.joining.team import JoinedTeam
from cprm_gym.server import Port, Server, Settings, run_in_real_time
from cprm_gym.simulator.protocol.commands import command_record, parse_commands
from cprm_gym.simulator.simulator import Simulator


def test_the_core_and_a_simulator_play_the_same_match():
    """The server adds nothing: commands given to a `Simulator` in the same order give the same states."""
    settings = Settings.from_words([*SYNCHRONOUS, "player::random_seed=7"])
    server = Server(settings, 4)
    clients = []
    for n in range(22):
        first = f"(init {'Left' if n < 11 else 'Right'} (version 19){' (goalie)' if n % 11 == 0 else ''})".encode()
        clients.append(server.receive(Port.PLAYER, n, first))
    trainer = server.receive(Port.TRAINER, "t", b"(init (version 19))")
    sim = Simulator(1, settings.server, settings.player, settings.types, seed=4)
    random = np.random.default_rng(3)
    for cycle in range(60):
        if cycle == 2:
            server.receive_from(trainer, b"(start)\0")
            sim.trainer.start()
        for n in random.permutation(22):
            power, angle, neck = random.uniform(-100, 100), random.uniform(-180, 180), random.uniform(-90, 90)
            body = random.choice(["dash", "kick", "turn", "tackle", "move", "catch"])
            said = f"({body} {angle:.3f})" if body in ("turn", "tackle", "catch") else f"({body} {power:.3f} {angle:.3f})"
            text = f'{said}(turn_neck {neck:.2f})(say "c{cycle}")(done)'
            server.receive_from(clients[n], text.encode() + b"\0")
            for command in parse_commands(text).commands:
                record = command_record(command, 1 if n < 11 else -1)
                if record is not None:
                    sim.command_phase(0, int(n) + 1, record)
        server.step()
        server.take_outbox()
        sim.advance()
        assert server.stadium.sim.state_hash() == sim.state_hash(), cycle


def test_two_teams_join_and_play_a_match():
    words = (*SYNCHRONOUS, "server::auto_mode=true", "server::half_time=3", "server::kick_off_wait=3", "server::game_over_wait=3")
    task = make_task("Soccer11v11")
    rehearse(task, load_controller("scripted"), "left_1")  # a match waits for its teams, not for their compiler
    with Field(*words, fast=True) as field:
        teams = []
        host, ports = "127.0.0.1", field.transport.ports

        def join(name):
            team = JoinedTeam(host, ports[0], name, task, load_controller("scripted"), coach=name == "Alpha", coach_port=ports[2])
            teams.append(team)
            team.play()
            team.leave()

        threads = [threading.Thread(target=join, args=(name,)) for name in ("Alpha", "Beta")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(120)
        field.thread.join(30)  # teams leave a moment after the end is called, the server a few cycles later
        assert len(teams) == 2
    assert field.server.over == "the match is over"
    assert field.server.stadium.time == 60
    for team in teams:
        assert sum(player.tally.decisions for player in team.players) > 11 * 40
        assert all(player.ear.damaged == player.ear.lost == 0 for player in team.players)
    (coached,) = [team for team in teams if team.coach is not None]
    assert coached.coach.chosen  # what the kick-off did not overtake
    assert "decisions" in coached.summary()


def test_a_player_in_real_time_who_loses_the_server_connects_again():
    words = ("server::simulator_step=50", "server::sense_body_step=50")
    task = make_task("Soccer11v11")
    with Field(*words, run=run_in_real_time) as field:
        ports = field.transport.ports
        player = JoinedPlayer("127.0.0.1", ports[0], "Alpha", task, load_controller("scripted"))
        spend(player, lambda: player.tally.decisions > 5)
    with Field(*words, run=run_in_real_time, ports=tuple(ports)) as field:
        player.connection.heard -= 10
        spend(player, lambda: player.tally.reconnections and field.server.stadium.teams[0].joined and player.ear.time >= 0)
        assert player.agent == "left_1"
        player.leave()


def spend(player, enough):
    end = time.monotonic() + 60
    while not enough():
        assert time.monotonic() < end
        player.take()
        if player.due <= time.monotonic():
            player.act()
        elif player.silent:
            player.reconnect()
        time.sleep(0.002)


def test_who_has_no_part_in_the_task_leaves_no_seat_behind():
    with Field(*SYNCHRONOUS, fast=True) as field:
        places, task = ("127.0.0.1", field.transport.ports[0], "Alpha"), make_task("GoToBall")
        first = JoinedPlayer(*places, task, load_controller("random"))
        with pytest.raises(CprmError, match="player 2 of Alpha: on the side that it plays the task GoToBall has 1"):
            JoinedPlayer(*places, task, load_controller("random"), rehearsed=True)
        end = time.monotonic() + 60
        while len(field.server.stadium.players()) > 1 and time.monotonic() < end:
            time.sleep(0.01)
        assert [player.unum for player in field.server.stadium.players()] == [1]
        first.leave()


def test_nobody_answers():
    with pytest.raises(CprmError, match=r"no answer from 127.0.0.1:9 within 0.3 s; is a server running there\?"):
        JoinedPlayer("127.0.0.1", 9, "Alpha", make_task("Soccer11v11"), load_controller("scripted"), patience=0.3)


def test_a_coach_gives_every_type_once_and_the_fastest_to_the_front():
    types = Settings.from_words(["player::random_seed=3"]).types
    chosen = choose_types(types, 11)
    assert sorted(chosen) == list(range(2, 12))
    assert len(set(chosen.values())) == 10
    speeds = [types[chosen[unum]].real_speed_max() for unum in range(11, 1, -1)]
    assert speeds == sorted(speeds, reverse=True)
