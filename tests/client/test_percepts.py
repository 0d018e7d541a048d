"""Text of the server, read back, is the arrays that the simulator makes: on whole matches, for every player."""

import numpy as np
import pytest

from cprm_gym.client.perceived import PerceivedSimulator, PlayerEar
from cprm_gym.client.percepts import D2R, read_body
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.protocol.messages import hear_text, referee_text, see_text, sense_body_text
from cprm_gym.simulator.senses import BodyColumn, new_body
from cprm_gym.simulator.state import PLAYERS

ROUNDED = (BodyColumn.STAMINA, BodyColumn.EFFORT, BodyColumn.CAPACITY, BodyColumn.FOCUS_DISTANCE, BodyColumn.FOCUS_DIRECTION)
"""Columns that are printed with six digits and not rounded before."""
NAMES = ("Left", "Right")


class Listening:
    """22 ears on the texts of one match."""

    def __init__(self, task):
        self.core = SoccerCore(task, 1, controlled=(), others="strong", seed=3)
        self.core.reset(3)
        sim = self.core.sim
        self.told = PerceivedSimulator(sim.parameters, sim.types)
        self.ears = [PlayerEar(self.told, row, NAMES[row // 11]) for row in range(PLAYERS)]

    def cycle(self, say=()):
        core, told = self.core, self.told
        sim = core.sim
        for row, text in say:
            data = text.encode()
            core._commands["say"][0, row, : len(data)] = np.frombuffer(data, np.uint8)
            core._commands["say_length"][0, row] = len(data)
        core.step(None)
        core._commands["say_length"] = 0
        referee = referee_text(sim, 0)
        for row, ear in enumerate(self.ears):
            for text in referee:
                ear.tell(text)
            ear.tell(sense_body_text(sim, 0, row + 1))
            for text in hear_text(sim, 0, row + 1):
                ear.tell(text)
            if sim.world["saw"][0, row] & 1:
                ear.tell(see_text(sim, 0, row + 1))
            assert ear.damaged == ear.stale == 0
        return told


def compare(sim, told):
    """Every array of the senses."""
    fresh = sim.see().fresh[0]
    assert np.array_equal(told.told_see.fresh[0], fresh)
    for name in ("ball_level", "players_level", "players_flags"):
        assert np.array_equal(getattr(told.told_see, name)[0][fresh], getattr(sim.see(), name)[0][fresh]), name
    marks = sim.landmarks()
    assert np.array_equal(told.told_landmarks.level[0][fresh], marks.level[0][fresh])
    assert np.array_equal(told.told_landmarks.line[0][fresh], marks.line[0][fresh])
    pairs = [(told.told_see.ball, sim.see().ball), (told.told_see.players, sim.see().players)]
    pairs += [(told.told_landmarks.landmarks, marks.landmarks), (told.told_landmarks.lines, marks.lines)]
    for mine, whole in pairs:
        # six digits say everything, to the last bit: what is decided at the edge of a distance is decided alike
        assert np.array_equal(mine[0][fresh], whole[0][fresh], equal_nan=True)
    body, felt = sim.sense_body()[0].copy(), told.told_body[0].copy()
    for column in ROUNDED:
        np.testing.assert_allclose(felt[:, column], body[:, column], rtol=5.1e-6)
        body[:, column] = felt[:, column] = 0
    body[:, BodyColumn.COUNT_FOUL] = 0  # not told
    assert np.array_equal(felt, body)
    heard, mine = sim.hear(), told.told_hear
    slots = heard.sender.shape[2]
    for name in ("sender", "level", "unum", "length", "text"):
        assert np.array_equal(getattr(mine, name)[:, :, :slots], getattr(heard, name)), name
    np.testing.assert_allclose(mine.direction[:, :, :slots], heard.direction, atol=1e-12)
    for name in ("mode", "time", "score"):
        assert np.array_equal(told.world[name], sim.world[name]), name


def listen(cycles):
    match = Listening(make_task("Soccer11v11"))
    seen = set()
    for n in range(cycles):
        told = match.cycle(say=((n % 22, f"c{n}"), ((n * 7) % 22, "x.y z")))
        compare(match.core.sim, told)
        levels = told.told_see.players_level[0]
        seen |= {int(level) for level in np.unique(levels)}
    return seen


def test_percepts_are_the_arrays_of_the_simulator():
    assert {0, 1, 3} <= listen(150)


@pytest.mark.slow
def test_percepts_of_a_whole_match():
    """`pytest -m slow tests/client/test_percepts.py`, 2 minutes of CPU time."""
    listen(6000)


def test_damaged_messages_are_counted_and_passed_over():
    match = Listening(make_task("Soccer11v11"))
    match.cycle()
    sim, ear = match.core.sim, match.ears[0]
    texts = [
        see_text(sim, 0, 1),
        sense_body_text(sim, 0, 1),
        '(hear 1 our 3 "hi")',
        "(change_player_type 1 99)",
        "(hear 5 referee goal_l_99999999999)",
    ]
    random = np.random.default_rng(0)
    for _ in range(1500):
        text = list(texts[random.integers(len(texts))])
        for _ in range(random.integers(1, 6)):
            at = int(random.integers(len(text)))
            text[at : at + int(random.integers(0, 3))] = chr(int(random.integers(32, 127)))
        ear.tell("".join(text))
    assert np.isfinite(match.told.told_body[0, 0]).all()
    ear.tell("(see " + "((p" * 5000)
    assert ear.damaged > 0


def test_lost_doubled_and_late_messages_are_told_apart():
    match = Listening(make_task("Soccer11v11"))
    match.cycle()
    first = sense_body_text(match.core.sim, 0, 1)
    match.cycle()
    ear = match.ears[0]
    ear.tell(first)
    assert (ear.stale, ear.lost) == (1, 0)
    match.core.step(None)
    match.core.step(None)
    ear.tell(sense_body_text(match.core.sim, 0, 1))
    assert (ear.stale, ear.lost) == (1, 1)


def test_a_cycle_in_which_the_clock_stands_is_none_that_came_twice():
    """The last of them comes after the referee has said how it goes on."""
    match = Listening(make_task("Soccer11v11"))
    match.cycle()
    ear, text = match.ears[0], sense_body_text(match.core.sim, 0, 1).replace("(sense_body 1 ", "(sense_body 9 ")
    ear.tell("(hear 9 referee offside_l)")
    ear.tell(text)
    ear.tell("(hear 9 referee free_kick_r)")
    ear.tell(text)
    assert ear.stale == 0
    ear.tell(text)
    assert ear.stale == 1


@pytest.mark.parametrize(
    ("printed", "distance", "change", "turn"),
    [
        ("49.4 -29 -0.988 -0.3", 494 * 0.1, 494 * 0.1 * (-1 * 0.02), -3 * 0.1),  # 49.4 is another number than 494 * 0.1
        ("64.1 3 123.457 0.3", 641 * 0.1, 123.457, 3 * 0.1),  # such a change is no multiple
        ("0.6 3 -0 0", 6 * 0.1, 0.0, 0.0),
        ("49.4001 3 0.29 0.3", 49.4001, 29 * 0.01, 3 * 0.1),  # of the Gaussian model: no multiple, and the change is one itself
    ],
)
def test_what_the_server_rounded_is_read_to_the_last_bit(printed, distance, change, turn):
    match = Listening(make_task("Soccer11v11"))
    match.ears[0].tell(f"(see 1 ((b) {printed}))")
    assert match.told.told_see.ball[0, 0].tolist() == [distance, int(printed.split()[1]) * D2R, change, turn * D2R]


def test_a_body_of_an_old_protocol_is_read():
    match = Listening(make_task("Soccer11v11"))
    out = new_body(1)[0, 0]
    for protocol in range(5, 20):
        read_body(sense_body_text(match.core.sim, 0, 1, protocol), out)
        assert out[BodyColumn.STAMINA] == 8000
