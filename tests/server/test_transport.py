"""The server on real sockets of this machine."""

import math
import os
import select
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cprm_gym.cli import app
from cprm_gym.errors import CprmError
from cprm_gym.server import Port, Server, Settings, Transport, run_in_real_time, run_synchronously
from cprm_gym.server import transport as transport_module
from cprm_gym.simulator.gamelog.commands import CommandLogReader
from cprm_gym.simulator.gamelog.reader import GameLogReader

ANY = (0, 0, 0)


class Program:
    """A client on a socket, which is closed when the block ends."""

    def __init__(self, port, first):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.socket.setblocking(False)
        self.peer = ("127.0.0.1", port)
        self.got = []
        self.send(first)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, text):
        self.socket.sendto(text.encode() + b"\0", self.peer)

    def take(self):
        new = []
        while True:
            try:
                data, self.peer = self.socket.recvfrom(8192)
            except OSError:
                break
            new.append(data.rstrip(b"\0").decode())
        self.got += new
        return new


def serve(settings, programs, cycles, run=run_synchronously, **options):
    """A server that plays `cycles`; before each, `programs(transport, n)` acts."""
    server = Server(settings)
    with Transport(server, ports=ANY) as transport:
        count = iter(range(cycles))

        def each():
            n = next(count, None)
            if n is not None:
                programs(transport, n)
            return n is not None

        run(transport, each=each, **options)
    return server


def test_a_client_gets_a_socket_of_its_own_and_plays():
    settings, made = Settings.from_words(["server::synch_mode=true"]), []

    def act(transport, n):
        if not made:
            made.append(Program(transport.ports[0], "(init Left (version 19))"))
        made[0].take()
        if n == 4:
            made[0].send("(move -7 3)(done)")
        elif n > 1:
            made[0].send("(done)")

    server = serve(settings, act, 8, fast=True)
    with made[0]:
        made[0].take()
    assert made[0].got[0] == "(init l 1 before_kick_off)"
    assert made[0].peer[1] not in (0, 6000)
    assert server.stadium.world["pos"][1].tolist() == [-7.0, 3.0]


AFTERWARDS = """
import sys
from numba.core.dispatcher import Dispatcher
from session_replay import SessionReplay
from cprm_gym.server import Server, Transport
with Transport(Server(), ports=(0, 0, 0)):
    pass
made, late = Dispatcher.compile, []
def watched(self, signature):
    late.append(self.py_func.__name__)
    return made(self, signature)
Dispatcher.compile = watched
replays = [SessionReplay(path).run() for path in sys.argv[1:]]
print(len(replays), late)
"""


def test_everything_is_compiled_when_the_ports_answer():
    """In a process of its own: sessions of players, coaches, trainers and monitors call no kernel that was not called before."""
    tests = Path(__file__).parents[1]
    sessions = sorted((tests / "server" / "data").glob("*.jsonl.gz"))
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tests.parent), str(tests / "helpers")])}
    done = subprocess.run([sys.executable, "-c", AFTERWARDS, *map(str, sessions)], capture_output=True, text=True, env=environment)
    assert done.stdout.strip() == f"{len(sessions)} []", done.stderr


def test_real_time_is_kept():
    settings, times = Settings.from_words(["server::simulator_step=20", "server::sense_body_step=20"]), []
    serve(settings, lambda transport, n: times.append(time.monotonic()), 20, run=run_in_real_time)
    assert 18 * 0.02 <= times[-1] - times[0] < 3.0


class Clock:
    """Virtual time: whoever waits for datagrams until a moment has waited."""

    def __init__(self, server, cycles):
        self.server, self.now, self.told, self.left = server, 0.0, [], cycles
        self.clients = {}

    def monotonic(self):
        return self.now

    def receive(self, timeout):
        self.now += timeout

    def send(self):
        for out in self.server.take_outbox():
            head = out.data.split(b" ", 1)[0].decode()
            if head in ("(sense_body", "(see", "(see_global"):
                self.told.append((round(self.now * 1000), out.address, head))

    def goes_on(self):
        self.left -= 1
        return self.left >= 0


@pytest.mark.parametrize(
    ("words", "in_step"), [((), 0), (("server::synch_see_offset=30",), 30), (("server::slow_down_factor=2",), 0)], ids=str
)
def test_messages_are_sent_at_their_offsets(monkeypatch, words, in_step):
    """In virtual time: sense_body and pictures with the step, see at the server's ticks of 10 ms not before every 37.5 ms."""
    server = Server(Settings.from_words(["server::synch_mode=false", "server::coach_w_referee=true", *words]))
    clock = Clock(server, 10)
    monkeypatch.setattr(transport_module, "time", clock)
    server.receive(Port.PLAYER, "old", b"(init Left (version 17))")
    server.receive(Port.PLAYER, "new", b"(init Left (version 18))")
    trainer = server.receive(Port.TRAINER, "trainer", b"(init (version 19))")
    old = server.stadium.teams[0].players[0]
    server.receive_from(old, b"(change_view narrow low)\0")
    server.receive_from(server.stadium.teams[0].players[1], b"(change_view narrow)\0")
    server.receive_from(trainer, b"(eye on)\0")
    server.take_outbox()
    run_in_real_time(clock, clock.goes_on)
    factor = server.settings.server.slow_down_factor
    cycles = [100 * factor * n for n in range(1, 10)]

    def at(who, head):
        return [moment for moment, whose, said in clock.told if (whose, said) == (who, head) and 100 * factor <= moment < 1000 * factor]

    assert at("old", "(sense_body") == at("new", "(sense_body") == at("trainer", "(see_global") == cycles
    assert at("new", "(see") == [moment + in_step * factor for moment in cycles]
    third = [120, 150, 190, 230, 270, 300, 340, 380] if factor == 1 else [230, 300, 380, 450, 530, 600, 680, 750]
    every = [moment + 300 * factor * n for n in range(-1, 4) for moment in third]
    assert at("old", "(see") == [moment for moment in every if 100 * factor <= moment < 1000 * factor]


@pytest.mark.parametrize(
    ("words", "bodies", "looks", "pictures"),
    [
        (("server::sense_body_step=50",), 50, 37.5, 100),
        (("server::sense_body_step=200", "server::send_vi_step=300"), 200, 37.5, 300),
        (("server::send_step=80", "server::send_vi_step=70"), 100, 20, 70),
        (("server::simulator_step=50",), 100, 37.5, 100),
        (("server::simulator_step=30", "server::slow_down_factor=2", "server::send_step=400"), 200, 200, 200),
    ],
    ids=str,
)
def test_other_periods_are_kept(monkeypatch, words, bodies, looks, pictures):
    """In virtual time: whatever has a period of its own comes in the first tick of 10 ms that is not before it."""
    server = Server(Settings.from_words(["server::synch_mode=false", "server::coach_w_referee=true", *words]))
    clock = Clock(server, 50)
    monkeypatch.setattr(transport_module, "time", clock)
    old = server.receive(Port.PLAYER, "old", b"(init Left (version 17))")
    trainer = server.receive(Port.TRAINER, "trainer", b"(init (version 19))")
    server.receive_from(old, b"(change_view narrow low)\0")
    server.receive_from(trainer, b"(eye on)\0")
    server.take_outbox()
    run_in_real_time(clock, clock.goes_on)
    for who, head, period in (("old", "(sense_body", bodies), ("old", "(see", looks), ("trainer", "(see_global", pictures)):
        at = [moment for moment, whose, said in clock.told if (whose, said) == (who, head) and 200 <= moment < 1200]
        assert at == sorted({math.ceil(k * period / 10) * 10 for k in range(1200) if 200 <= math.ceil(k * period / 10) * 10 < 1200}), head


def test_what_is_said_is_heard_once_whatever_the_periods():
    """Bodies are told of twice in a cycle, or in every third: each word comes once, with the next of them."""
    for step in (50, 300):
        server = Server(Settings.from_words(["server::synch_mode=true", f"server::sense_body_step={step}"]))
        mouth, ear = (server.receive(Port.PLAYER, name, b"(init Left (version 19))") for name in ("mouth", "ear"))
        server.stadium.sim.trainer.change_mode("play_on")
        server.take_outbox()
        heard = []
        for n in range(1, 13):
            server.receive_from(mouth, b'(say "w%d")\0' % n)
            server.step()
            server.look_again()
            server.think()
            server.look_late()
            heard += [out.data.split(b'"')[1] for out in server.take_outbox() if out.source is ear and b'our 1 "w' in out.data]
        assert heard == [b"w%d" % n for n in range(1, 13)]


def test_a_late_cycle_shifts_none_of_the_next(monkeypatch):
    """In virtual time: something takes 270 ms; two steps are missed, the others stay on their marks."""
    server = Server(Settings.from_words(["server::synch_mode=false"]))
    clock = Clock(server, 8)
    monkeypatch.setattr(transport_module, "time", clock)
    server.receive(Port.PLAYER, "a", b"(init Left (version 18))")

    def each():
        clock.now += 0.27 if clock.left == 5 else 0.0
        return clock.goes_on()

    late = run_in_real_time(clock, each)
    assert [moment for moment, _, head in clock.told if head == "(sense_body"] == [100, 200, 300, 570, 600, 700, 800, 900]
    assert (late.cycles, late.late, round(late.worst, 3)) == (8, 1, 0.17)


def test_a_port_in_use_is_said():
    with Transport(Server(), ports=ANY) as transport:
        taken = transport.ports[0]
        with pytest.raises(CprmError, match=f"port {taken} of 127.0.0.1 cannot be used: .*choose other ports"):
            Transport(Server(), ports=(taken, 0, 0))


def test_a_folder_for_logs_that_is_not_there_is_said_before_ports_are_opened(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        words = [f"server::port={taken.getsockname()[1]}", "--log", str(tmp_path / "nowhere")]
        ended = CliRunner().invoke(app, ["serve", *words])
    assert ended.exit_code == 2
    assert "there is no such folder" in ended.output


def test_ctrl_c_ends_the_match_with_complete_logs(tmp_path):
    free = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3)]
    for sock in free:
        sock.bind(("127.0.0.1", 0))
    ports = [sock.getsockname()[1] for sock in free]
    for sock in free:
        sock.close()
    words = [f"server::{name}={port}" for name, port in zip(("port", "coach_port", "olcoach_port"), ports)]
    command = [sys.executable, "-m", "cprm_gym", "serve", *words, "server::coach_w_referee=true", "--clock", "fast", "--log", str(tmp_path)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": "1"})
    try:
        assert select.select([process.stdout], [], [], 900)[0]  # it compiles first, if nobody has
        assert "listening at 127.0.0.1" in process.stdout.readline()
        with Program(ports[0], "(init Left (version 19))") as player, Program(ports[1], "(init (version 19))") as trainer:
            end, thought = time.monotonic() + 60, 0
            while thought < 30 and time.monotonic() < end:
                time.sleep(0.005)
                if trainer.take():
                    trainer.send("(start)")
                for text in player.take():
                    if text == "(think)":
                        thought += 1
                        player.send("(dash 50)(done)")
            process.send_signal(signal.SIGINT)
            out, _ = process.communicate(timeout=120)
    finally:
        process.kill()
    assert process.returncode == 0
    assert "Left 0 : 0 nobody" in out
    game, text = (next(tmp_path.glob(f"*{ending}")) for ending in (".rcg", ".rcl"))
    assert game.name.endswith("Left_0-vs-null.rcg")
    frames = list(GameLogReader(game))
    assert len(frames) > 5
    assert frames[0].mode.name == "kick_off_l"
    assert any(line.command == "(dash 50)(done)" and line.player == ("Left", 1) for line in CommandLogReader(text))
