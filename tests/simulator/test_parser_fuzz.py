"""A hundred thousand damaged inputs for every parser: what is wrong is an error of ours, and nothing else happens.

The inputs are mutations of real texts, drawn from seeds that stand here: a failure can be run again.
"""

import io
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from senses_recordings import random_worlds

from cprm_gym.errors import CommandError, CprmError, FormatError, ParameterError
from cprm_gym.simulator.gamelog.binary import BinaryParser
from cprm_gym.simulator.gamelog.commands import CommandLogReader
from cprm_gym.simulator.gamelog.json import JsonParser
from cprm_gym.simulator.gamelog.text import TextParser
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import PlayerParameters, PlayerType
from cprm_gym.simulator.protocol.commands import command_record, format_command, parse_commands, parse_trainer
from cprm_gym.simulator.protocol.message_parser import parse_hear, parse_see, parse_sense_body
from cprm_gym.simulator.protocol.messages import see_text, sense_body_text

INPUTS = 100_000
PIECES = (
    "(", ")", "((", "))", '"', "-", "+", ".", "e", "E", "9", "0", " ", "\t", "\n", "\0", "inf", "nan", "1e999", "0x", "9999999999",
    "-0", "()", "(b)", "(p", "true", "null", ",", ":", "[", "]", "{", "}", "\\", "\u00e9", "1.5", "_",
)  # fmt: skip


def damaged(draw: random.Random, text: str) -> str:
    """`text` with one to four pieces cut out, doubled or put in."""
    for _ in range(draw.randint(1, 4)):
        at, size = draw.randint(0, len(text)), draw.choice((0, 0, 1, 1, 2, 5, 20))
        put = draw.choice(PIECES) if draw.random() < 0.7 else text[at : at + draw.randint(0, 30)]
        text = text[:at] + put + text[at + size :]
    return text


def harmless(parse: Callable[[str], object], seeds: list[str], own: type[CprmError] | tuple[type[CprmError], ...], seed: int) -> None:
    draw, refused = random.Random(seed), 0
    for number in range(INPUTS):
        text = damaged(draw, draw.choice(seeds))
        try:
            parse(text)
        except own:
            refused += 1
        except Exception as error:
            raise AssertionError(f"input {number} of seed {seed} raised {type(error).__name__}: {text!r}") from error
    assert refused > INPUTS // 20


def messages(write) -> list[str]:
    sim = random_worlds(2, seed=3, spread=0.3)
    return [write(sim, world, player, protocol)[:400] for world in (0, 1) for player, protocol in ((1, 19), (5, 7), (13, 4))]


HEARD = [
    '(hear 12 -30 our 4 "ab c")', "(hear 12 self Yab0Y)", "(hear 3 referee goal_l_2)", "(hear 1 opp)", "(hear 7 15 ()", '(hear 5 coach "")',
]  # fmt: skip
SEEN = [
    '(see 3 ((b) 10.5 -3 0.1 2) ((p "L" 4) 20 30 0 0 10 20 t) ((f c t) 30 2) ((P) 1 2))',
    "(see 0 ((player L 1 goalie) 5 -7))",
    "(see 7)",
]


def whole(text: str) -> str:
    """A message cut behind one of its lists, its brackets closed."""
    text = text[: text.rindex(" ((" if text.startswith("(see ") else " (")]
    return text + ")" * (text.count("(") - text.count(")"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parse", "seeds"),
    [
        (parse_see, [*SEEN, *map(whole, messages(see_text))]),
        (parse_sense_body, [*map(whole, messages(sense_body_text))]),
        (parse_hear, HEARD),
    ],
    ids=["see", "sense_body", "hear"],
)
def test_messages(parse, seeds):
    for text in seeds:
        parse(text)
    harmless(parse, seeds, FormatError, seed=1)


COMMANDS = [
    "(dash 100 30)(turn_neck 10)", "(dash (l 60 0) (r 20 -10))", '(say "hello")(kick 50 -20.5)', "(attentionto our 7)(change_view wide)",
    "(tackle 10 on)(pointto 10 5)", "(ear (off opp partial))(clang (ver 7 8))", "(catch -9)(move -10 5.5)(change_focus 1 2)(done)(bye)",
]  # fmt: skip
TRAINER = [
    '(move (player "L" 7) 1 2 90 0.1 0)',
    "(move (ball) 0 0)",
    "(change_mode play_on)",
    "(change_player_type L 3 5)",
    "(say hi)",
    "(ear on)",
]


def execute(text: str) -> None:
    """Read, made a record, written and read again; what is wrong ends the list, it raises nothing."""
    parsed = parse_commands(text)
    for command in parsed.commands:
        command_record(command)
        assert parse_commands(format_command(command)).error is None
    if parsed.error is not None:
        assert 0 <= parsed.error <= len(text)
        raise CommandError("illegal_command_form")


@pytest.mark.slow
@pytest.mark.parametrize(("parse", "seeds"), [(execute, COMMANDS), (parse_trainer, TRAINER)], ids=["player", "trainer"])
def test_commands(parse, seeds):
    harmless(parse, seeds, CommandError, seed=2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parse", "seeds"),
    [
        (
            ServerParameters.from_text,
            ['(server_param (ball_decay 0.94)(half_time 300)(coach 1)(landmark_file "~/x.xml")(wind_dir -3.5e-05))'],
        ),
        (PlayerParameters.from_text, ["(player_param (player_types 18)(pt_max 1)(random_seed -1)(allow_mult_default_type 0)(subs_max 3))"]),
        (PlayerType.from_text, ["(player_type (id 3)(player_speed_max 1.05)(player_decay 0.43)(effort_max 0.9)(kick_rand 0.08))"]),
    ],
    ids=["server_param", "player_param", "player_type"],
)
def test_parameters(parse, seeds):
    harmless(parse, seeds, ParameterError, seed=3)


TEXT_LOG = """(server_param (goal_width 14.02)(coach true))
(player_type (id 0)(player_speed_max 1.05))
(playmode 1 play_on)
(team 1 L R 0 1 1 0 0 2)
(msg 1 1 "hello")
(show 1 ((b) 0 0 0.5 -1) ((l 1) 0 0x9 -3.15 2 0 0 0 90 (v h 120) (fp 0 0) (s 7921 1 1 100) (f r 3) (c 0 1 2 3 4 5 6 7 8 9 10 11)))
(show 2 ((b) 0 0 0 0) ((r 11) 1 1 3 3 0 0 -180 0 1 2 (v l 60) (s 8000 1 1) (c 0 0 0 0 0 0 0 0)))
"""
JSON_LOG = """[
{"server_param":{"goal_width":14.02,"coach":true}},
{"player_type":{"id":0,"player_speed_max":1.05}},
{"playmode":{"time":1,"mode":"play_on"}},
{"team":{"time":1,"l":{"name":"L","score":0},"r":{"name":null,"score":1,"pen_score":1}}},
{"msg":{"time":1,"board":1,"message":"hello"}},
{"show":{"time":1,"stime":2,"ball":{"x":0,"y":0,"vx":0.5,"vy":-1},"players":[{"side":"l","unum":1,"type":0,"state":9,"x":1,"y":2,"vx":0,"vy":0,
"body":3,"neck":4,"px":1,"py":2,"vq":"h","vw":90,"fdist":1,"fdir":2,"stamina":8000,"effort":1,"fside":"r","fnum":3,"kick":1}]}}
]
"""


def read_all(make: Callable[[io.BufferedReader], TextParser | JsonParser | BinaryParser], data: bytes) -> None:
    parser = make(io.BufferedReader(io.BytesIO(data)))  # type: ignore[arg-type]
    for _ in parser.frames():
        pass
    parser.header.types()
    parser.header.parameters()


@pytest.mark.slow
@pytest.mark.parametrize("version", [4, 5, 6])
def test_text_logs(version):
    def parse(text: str) -> None:
        read_all(lambda stream: TextParser(Path("x.rcg"), stream, version), f"ULG{version}\n{text}".encode("utf-8", "surrogateescape"))

    parse(TEXT_LOG)
    harmless(parse, [TEXT_LOG], (FormatError, ParameterError), seed=version)


@pytest.mark.slow
def test_json_logs():
    def parse(text: str) -> None:
        read_all(lambda stream: JsonParser(Path("x.rcg"), stream), text.encode("utf-8", "surrogateescape"))

    parse(JSON_LOG)
    harmless(parse, [JSON_LOG], (FormatError, ParameterError), seed=7)


def binary_log(version: int) -> bytes:
    """The beginning of the recorded log of a version, up to its first frames."""
    whole_log = (Path(__file__).parents[1] / "conformance" / "data" / "formats" / f"v{version}.rcg").read_bytes()
    return whole_log[4 if version > 1 else 0 :][: 4400 if version > 1 else 2052 * 3]


@pytest.mark.slow
@pytest.mark.parametrize("version", [1, 2, 3])
def test_binary_logs(version):
    draw, whole_log, refused = random.Random(version), binary_log(version), 0
    for number in range(INPUTS):
        data = bytearray(whole_log)
        for _ in range(draw.randint(1, 5)):
            at = draw.randrange(len(data) if draw.random() < 0.3 else 700)
            data[at : at + draw.choice((0, 1, 1, 1, 2))] = draw.choice((b"", b"\0", b"\xff", b"\x7f\xff", bytes([draw.randrange(256)])))
        try:
            read_all(lambda stream: BinaryParser(Path("x.rcg"), stream, version), bytes(data))
        except (FormatError, ParameterError):
            refused += 1
        except Exception as error:
            raise AssertionError(f"input {number} of version {version} raised {type(error).__name__}") from error
    assert refused > INPUTS // 20


@pytest.mark.slow
def test_command_logs(tmp_path):
    path = tmp_path / "x.rcl"
    lines = "0,0\tRecv L_1: (init L)\n1,0\tRecv L_1: (dash 100)\n1,2\t(referee play_on)\n2,0\tRecv L_Coach: (bye)\n3,0\tx\ny\n"

    def parse(text: str) -> None:
        path.write_bytes(text.encode("utf-8", "surrogateescape"))
        for clock, group in CommandLogReader(path).cycles():
            assert len(clock) == 2
            for line in group:
                assert line.player is None or line.sender is not None
                assert line.referee is None or line.command is None

    parse(lines)
    draw, refused = random.Random(9), 0
    for number in range(INPUTS):
        text = damaged(draw, lines if draw.random() < 0.7 else lines[:20])
        try:
            parse(text)
        except FormatError:
            refused += 1
        except Exception as error:
            raise AssertionError(f"input {number} raised {type(error).__name__}: {text!r}") from error
    assert refused > INPUTS // 100
