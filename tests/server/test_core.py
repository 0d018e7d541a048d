"""The server without sockets: who gets which datagram, and what strangers cannot do."""

import numpy as np
import pytest

from cprm_gym.server import Port, Server, Settings
from cprm_gym.simulator.kernels import Kernel

WORDS = ("server::synch_mode=true", "server::coach_w_referee=true")
SYNCHRONOUS = Settings.from_words(WORDS)


class Desk:
    """A core and what it sent to each address."""

    def __init__(self, settings=SYNCHRONOUS, seed=0):
        self.server = Server(settings, seed)
        self.clients = {}

    def say(self, who, text, port=Port.PLAYER):
        """A datagram, from the client's own socket once he has one; the answers to him."""
        data = text if isinstance(text, bytes) else text.encode("latin-1") + b"\0"
        if who in self.clients and port == Port.PLAYER:
            self.server.receive_from(self.clients[who], data)
        else:
            client = self.server.receive(port, who, data)
            if client is not None:
                self.clients[who] = client
        return self.sent().get(who, [])

    def sent(self):
        told = {}
        for out in self.server.take_outbox():
            told.setdefault(out.address, []).append(out.data.rstrip(b"\0").decode("latin-1"))
        return told

    def cycle(self):
        self.server.step()
        self.server.look_again()
        self.server.think()
        return self.sent()


def test_a_team_of_eleven_has_no_twelfth():
    desk = Desk()
    for n in range(11):
        assert desk.say(n, "(init Left (version 18))")[0] == f"(init l {n + 1} before_kick_off)"
    assert desk.say("x", "(init Left (version 18))") == ["(error no_more_player_or_goalie_or_illegal_client_version)"]


def test_commands_before_a_mistake_are_executed():
    desk = Desk()
    desk.say("a", "(init Left (version 19))")
    assert desk.say("a", "(turn_neck 30)(nonsense)(turn_neck 40)") == ["(error illegal_command_form)"]
    desk.cycle()
    assert np.degrees(desk.server.stadium.world["neck"][0]) == pytest.approx(30)


def test_a_cycle_hands_no_single_record_to_a_kernel(monkeypatch):
    """That takes a hundred times as long as an array: what everybody says and sees would fill the cycle."""
    desk = Desk(Settings.from_words([*WORDS, "server::auto_mode=true", "server::fullstate_l=true", "server::fullstate_r=true"]))
    for n in range(22):
        desk.say(n, f"(init {'Left' if n < 11 else 'Right'} (version {19 if n % 3 else 7}))")
    call, records = Kernel.__call__, []

    def watched(self, *args):
        records.extend(self.__name__ for arg in args if isinstance(arg, np.void))
        return call(self, *args)

    monkeypatch.setattr(Kernel, "__call__", watched)
    for _ in range(3):
        players = list(desk.clients.items())
        desk.server.receive_many([(client, b'(dash 50)(say "hello")(attentionto our 3)(sense_body)(done)\0') for _, client in players])
        heard = desk.cycle()
        desk.server.look_late()
    assert any("hello" in text for text in heard[1])
    assert records == []


def test_everybody_is_asked_and_waited_for():
    desk = Desk()
    desk.say("a", "(init Left (version 19))")
    desk.say("b", "(init Right (version 8))")
    told = desk.cycle()
    assert told["a"][-1] == told["b"][-1] == "(think)"
    assert not desk.server.is_complete
    desk.say("a", "(dash 100)(done)")
    assert not desk.server.is_complete
    desk.say("b", "(done)")
    assert desk.server.is_complete
    desk.say("b", "(bye)")
    assert [client.unum for client in desk.server.awaited()] == [1]


def test_twenty_one_windows_without_answer_end_the_match():
    desk = Desk()
    desk.say("a", "(init Left (version 19))")
    desk.say("t", "(init (version 19))", Port.TRAINER)
    desk.say("t", "(start)", Port.TRAINER)
    desk.server.receive_from(desk.clients["t"], b"(start)\0")
    for _ in range(21):
        assert desk.server.over == ""
        desk.cycle()
        desk.server.close_window(False)
    assert desk.server.over == "players do not answer"


def test_the_same_seed_and_commands_give_the_same_datagrams():
    def played():
        desk = Desk(seed=5)
        for n in range(6):
            desk.say(n, f"(init {'Left' if n % 2 else 'Right'} (version 19))")
        desk.clients["t"] = desk.server.receive(Port.TRAINER, "t", b"(init (version 19))\0")
        desk.server.receive_from(desk.clients["t"], b"(start)\0")
        told = []
        for _ in range(40):
            told.append(desk.cycle())
            for n in range(6):
                desk.say(n, f"(dash {60 + n})(turn_neck 5)(say hi)(done)")
        return told

    assert played() == played()


def test_a_compressed_client_is_read_and_answered_in_streams_of_their_own():
    import zlib

    desk = Desk()
    desk.say("a", "(init Left (version 19))")
    assert desk.say("a", "(compression 6)") == ["(ok compression 6)"]
    packed = zlib.compress(b"(score)\0")
    desk.server.receive_from(desk.clients["a"], packed)
    (answer,) = [out.data for out in desk.server.take_outbox()]
    assert zlib.decompressobj().decompress(answer) == b"(score 0 0 0)\0"
    desk.server.receive_from(desk.clients["a"], b"(score)\0")  # no stream: not understood, and nothing breaks
    assert desk.server.take_outbox() == []


HOSTILE = [
    b"",
    b"\x00",
    b"(",
    b"((((((((((((((((",
    b")" * 5000,
    b"(init ",
    b"(init " + b"A" * 8000,
    b"(reconnect Left 999999999999)",
    b"(dispinit version 1e999)",
    b"(init Left (version 9e999))",
    b"(reconnect Left -1)",
    b"\xff" * 8192,
    b"(say " + b"a" * 8000 + b")",
    b"(move (ball) 1e400 1)",
    b"(move (player Left 1e300) 0 0)",
    b"(change_mode null)",
    b"(change_player_type Left 1e300 1)",
    b"(dispplayer 1 1 999999999 999999999 999999999)",
    b"(dispfoul 999999999 -999999999 1)",
    b"(dispcard 1 99 red)",
    b"(dispdiscard 7 7)",
    b"(team_graphic (0 0))",
    b'(team_graphic (1 1 "8 8 99 1"))',
    b"(say (freeform " + b"(" * 4000,
    b"(compression 99999999999)",
    b"(ear (on nobody))",
    b"(attentionto nobody 99999999999999999999)",
    b"(clang (ver 99999999999999999999 1))",
    b"(dash 99999999999999999999999999)",
    b"(dash 1e308 1e308)",
    b"(kick -1e308 1e308)",
    b"(turn 0.0000000000000000000000000001)",
    b"(change_focus 1e308 1e308)",
    b"(pointto 1e308 1e308)",
    b"(catch 1e308)",
    b"(move 1e308 1e308)",
    b"(tackle 1e308 on)",
    b"(dash (l 1 1) (l 1 1))",
    b"(change_player_type 1 goalie)",
]


def test_hostile_datagrams_break_nothing():
    desk = Desk()
    desk.say("a", "(init Left (version 19) (goalie))")
    desk.say("old", "(init Right (version 3))")
    roles = [desk.clients["a"], desk.clients["old"]]
    for who, port, text in (("t", Port.TRAINER, "(init (version 19))"), ("c", Port.COACH, "(init Left (version 19))")):
        roles.append(desk.server.receive(port, who, text.encode()))
    roles.append(desk.server.receive(Port.PLAYER, "m", b"(dispinit version 5)"))
    random = np.random.default_rng(0)
    for round_ in range(3):
        for data in HOSTILE:
            for port in Port:
                desk.server.receive(port, f"stranger {round_}", data)
            for client in roles:
                desk.server.receive_from(client, data)
                cut = data[: int(random.integers(0, len(data) + 1))]
                desk.server.receive_from(client, cut)
        desk.cycle()
        world = desk.server.stadium.world
        assert all(np.isfinite(world[name]).all() for name in ("pos", "vel", "body", "neck", "stamina"))
    desk.say("a", "(score)")


def test_settings_say_what_is_wrong(tmp_path):
    file = tmp_path / "server.conf"
    file.write_text("# a comment\nserver::half_time = 10\nslow_down_factor : 2\n")
    with pytest.raises(Exception, match=r"server.conf, line 3: .*server::name=value"):
        Settings.from_words(files=[file])
    file.write_text("half_time = 10\n")
    assert Settings.from_words(["server::half_time=20"], [file]).server.half_time == 20
    with pytest.raises(Exception, match="Did you mean 'half_time'"):
        Settings.from_words(["server::half_tim=20"])


@pytest.mark.parametrize("version", [-1, 1, 3, 4, 5, 6])
def test_logs_of_every_version_are_complete(tmp_path, version):
    from cprm_gym.server.logs import MatchLogs, append_result, result_line
    from cprm_gym.simulator.gamelog.commands import CommandLogReader
    from cprm_gym.simulator.gamelog.reader import GameLogReader

    desk = Desk(
        Settings.from_words([f"server::game_log_version={version}", "server::coach_w_referee=true", "server::record_messages=true"])
    )
    logs = MatchLogs(desk.server, tmp_path)
    desk.say("a", "(init Left (version 19))")
    desk.say("b", "(init Right (version 19))")
    trainer = desk.server.receive(Port.TRAINER, "t", b"(init (version 19))")
    desk.server.receive_from(trainer, b"(start)\0")
    for _ in range(12):
        desk.cycle()
        desk.say("a", "(dash 40)(done)")
    game, text = logs.close()
    assert game.name.endswith("Left_0-vs-Right_0.rcg")
    assert [frame.time for frame in GameLogReader(game)] == list(range(1, 13))
    lines = list(CommandLogReader(text))
    assert sum(line.command == "(dash 40)(done)" for line in lines) == 12
    assert any(line.referee == "kick_off_l" for line in lines)
    assert result_line(desk.server.stadium) == "Left 0 : 0 Right, 12 cycles"
    for _ in range(2):
        append_result(desk.server.stadium, tmp_path / "results.csv")
    assert len((tmp_path / "results.csv").read_text().splitlines()) == 3
