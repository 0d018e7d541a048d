"""Environments on a server: the same spaces, rewards and infos; what happens there is what the trainer sees."""

import itertools
import socket
import threading
import time

import gymnasium
import numpy as np
import pytest
from typer.testing import CliRunner

import cprm_gym  # noqa: F401
from cprm_gym.cli import app
from cprm_gym.client.connection import Connection
from cprm_gym.client.remote import check_trainer, server_place
from cprm_gym.envs.core import SoccerCore
from cprm_gym.errors import CprmError, ParameterError
from cprm_gym.server import Port, Server, Settings, Transport, run_in_real_time, run_synchronously
from cprm_gym.simulator.state import PlayMode

ENDLESS = ("server::half_time=-1", "server::coach=true")


class Field:
    """A server in a thread of its own."""

    def __init__(self, *words, run=run_synchronously, **options):
        self.server = Server(Settings.from_words(words))
        self.transport = Transport(self.server, ports=(0, 0, 0))
        self.place = "udp://127.0.0.1:{}/{}".format(*self.transport.ports[:2])
        self.thread = threading.Thread(target=run, args=(self.transport,), kwargs=options)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.server.over = self.server.over or "told to end"
        self.thread.join(30)
        self.transport.close()


@pytest.fixture
def field():
    with Field(*ENDLESS, "server::synch_mode=true", fast=True) as served:
        yield served


def test_a_task_plays_on_a_server_as_in_process(field):
    here = gymnasium.make("cprm/GoToBall-v2", action_mode="hybrid", observation="raw")
    there = gymnasium.make("cprm/GoToBall-v2", action_mode="hybrid", observation="raw", backend=field.place)
    assert there.observation_space == here.observation_space
    assert there.action_space == here.action_space
    try:
        for seed in (3, 4):
            ours, _ = here.reset(seed=seed)
            theirs, _ = there.reset(seed=seed)
            # the same start, seen by two servers' luck: what is told of the ball differs by noise at most
            assert (theirs["level"][0] > 0) == (ours["level"][0] > 0)
            assert theirs["ball"][0] == pytest.approx(ours["ball"][0], rel=0.15, abs=0.2)
            assert theirs["ball"][1] == pytest.approx(ours["ball"][1], abs=0.05)
            world = there.unwrapped.core.sim.world[0]
            for _ in range(25):
                off = theirs["ball"][1] if theirs["level"][0] else 2.0
                turning = abs(off) > 0.2
                params = np.array([off / np.pi if turning else 1.0, 0, 0, 0], np.float32)
                action = {"type": 2 if turning else 1, "params": params, "turn_neck": np.zeros(1, np.float32), "view": 1}
                theirs, reward, over, cut, info = there.step(action)
                match = field.server.stadium.world
                assert np.allclose(world["pos"][1], match["pos"][1], atol=1e-4)
                if over or cut:
                    break
            ours_info = here.step(here.action_space.sample())[4]
            assert set(info) == set(ours_info)
            assert isinstance(reward, float)
        assert int(world["time"]) < 60
    finally:
        there.close()
        here.close()


def test_what_a_task_changes_reaches_the_server(field):
    core = SoccerCore("KickOffShot", 1, backend=field.place, others="hold")
    try:
        core.reset(1)
        match = field.server.stadium.world
        assert np.allclose(core.sim.world["pos"][0, 1:3], match["pos"][1:3], atol=1e-6)
        for _ in range(core.task.wait + 2):
            core.step({"type": np.zeros((1, 1), int), "params": np.zeros((1, 1, 4))})
        assert PlayMode(int(match["mode"])) == PlayMode.kick_off_l
        assert int(core.sim.world["mode"][0]) == PlayMode.kick_off_l
        with pytest.raises(CprmError, match="a saved state cannot be set on a server"):
            core.load_state(core.save_state())
    finally:
        core.close()


def test_in_real_time():
    with Field(
        *ENDLESS, "server::simulator_step=50", "server::sense_body_step=50", "server::send_vi_step=50", run=run_in_real_time
    ) as field:
        core = SoccerCore("GoToBall", 1, backend=field.place)
        try:
            core.reset(2)
            world = core.sim.world[0]
            before, times = world["pos"][1].copy(), [int(world["time"])]
            # how many cycles pass between two commands is the machine's business
            while np.hypot(*(world["pos"][1] - before)) <= 1.0 and len(times) < 200:
                core.step({"type": np.ones((1, 1), int), "params": np.array([[[1.0, 0, 0, 0]]])})
                times.append(int(world["time"]))
            assert np.hypot(*(world["pos"][1] - before)) > 1.0
            assert all(earlier < later for earlier, later in itertools.pairwise(times))
        finally:
            core.close()


def test_what_cannot_be_is_said():
    with pytest.raises(CprmError, match=r"udp://host:port"):
        server_place("tcp://h:1")
    assert server_place("udp://h") == ("h", 6000, 6001)
    with pytest.raises(ParameterError, match="a server plays 1 world, 2 were asked for"):
        SoccerCore("GoToBall", 2, backend="udp://h")
    with Field("server::synch_mode=true", fast=True) as field:
        for attempt in (lambda: SoccerCore("GoToBall", 1, backend=field.place), lambda: check_trainer(field.place)):
            with pytest.raises(CprmError, match="connected_offline_coach_without_coach_mode; start the server with server::coach=true"):
                attempt()


def test_a_benchmark_without_a_server_makes_nothing(field, tmp_path):
    """One line and status 2, before the work; whether a server is there is asked without taking the trainer's seat."""
    check_trainer(field.place)
    assert field.server.stadium.trainer is None
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as nobody:
        nobody.bind(("127.0.0.1", 0))
        place = "udp://127.0.0.1:{0}/{0}".format(nobody.getsockname()[1])
        with pytest.raises(CprmError, match=r"no answer from 127.0.0.1:.* within 0.2 s; is a server running there"):
            check_trainer(place, seconds=0.2)
    with Field("server::synch_mode=true", fast=True) as other:
        command = [
            "benchmark",
            "--tasks",
            "GoToBall",
            "--controllers",
            "fsm",
            "--backend",
            other.place,
            "--output",
            str(tmp_path / "results"),
        ]
        ended = CliRunner().invoke(app, command)
    assert ended.exit_code == 2
    assert not (tmp_path / "results").exists()


def test_a_refusal_says_what_to_do(field):
    for name, place in ((b"Left", 9), (b"Right", 7)):
        field.server.receive(Port.PLAYER, ("127.0.0.1", place), b"(init " + name + b")")
    connection = Connection("127.0.0.1", field.transport.ports[0])
    try:
        with pytest.raises(CprmError, match=r"refuses .init Third.: no_more_team; two other teams are there; join under the name of one"):
            connection.ask("(init Third)", lambda text: text.startswith("(init"), 10.0)
    finally:
        connection.close()


def test_who_is_refused_leaves_no_seat_behind():
    """The trainer comes in, his players find foreign teams; the next one is told the same, not that there is a trainer."""
    field = Field(*ENDLESS, "server::synch_mode=true", fast=True)
    for name, place in ((b"Left", 9), (b"Right", 7)):
        field.server.receive(Port.PLAYER, ("127.0.0.1", place), b"(init " + name + b")")
    with field:
        for _ in range(2):
            with pytest.raises(CprmError, match=r"no_more_team.*it must have nobody else's teams"):
                SoccerCore("GoToBall", 1, backend=field.place)
            end = time.monotonic() + 60
            while field.server.stadium.trainer is not None and time.monotonic() < end:
                time.sleep(0.01)
            assert field.server.stadium.trainer is None


def test_a_benchmark_plays_on_a_server(field, tmp_path):
    """Several controllers after each other: those who have left come back."""
    from cprm_gym.benchmark.plan import BlockResult, Plan
    from cprm_gym.benchmark.runner import run

    plan = Plan(tasks=("GoToBall",), controllers=("fsm", "random"), episodes=3, backend=field.place)
    plan.write(tmp_path)
    assert Plan.read(tmp_path) == plan
    fsm, random = list(run(plan))
    assert (fsm.error, random.error) == (None, None)
    assert fsm.success == [True] * 3
    assert BlockResult.from_json(fsm.to_json()) == fsm
