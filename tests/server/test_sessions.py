"""Recorded sessions of the real server, played against ours: the same answers in the same windows."""

import collections
import re
from pathlib import Path

import pytest
from paths import SHARED
from session_replay import SessionReplay, windows

from cprm_gym.simulator.protocol.messages import see_mismatches

HERE = Path(__file__).parent / "data"
SESSIONS = SHARED / "sessions"
ALWAYS_EQUAL = ("think", "init", "error", "warning", "score", "reconnect", "server_param", "player_param", "player_type")
"""Heads that the real server repeats to the letter."""


def replayed(name):
    """A session, from the test data or from the recordings beside the repository."""
    for folder in (HERE, SESSIONS):
        if (folder / f"{name}.jsonl.gz").exists():
            return SessionReplay(folder / f"{name}.jsonl.gz").run()
    pytest.skip(f"recording {name} is not here")


def check(name, **least):
    """Nothing is waited for in vain; what the real server repeats is equal; `least`: (equal, equal but for numbers) by head, percent."""
    replay = replayed(name)
    found = replay.agreements()
    assert replay.in_vain == [] or replay.server.over
    wanted = {kind: (100.0, 100.0) for kind in ALWAYS_EQUAL if kind in found} | least
    below = {
        kind: (found[kind].share(), found[kind].first)
        for kind, (equal, alike) in wanted.items()
        if found[kind].share()[0] < equal or found[kind].share()[1] < alike
    }
    assert below == {}


SURE = (100.0, 100.0)
ALIKE = (0.0, 100.0)


def test_coaches_and_who_hears_them():
    check("s07_coach", sense_body=SURE, hear=SURE, ok=SURE, see_global=SURE, msg=SURE, show=SURE, change_player_type=SURE, clang=SURE)


def test_names_of_teams_and_fixed_names():
    check("s05c_names", sense_body=SURE, hear=SURE, ok=SURE, see_global=SURE)


def test_monitors_that_come_late_are_told_of_graphics():
    check("s08c_monitor_bko", sense_body=SURE, ok=SURE, msg=ALIKE, show=ALIKE, team_graphic=SURE, change_player_type=SURE)


def test_a_golden_goal_ends_the_match_and_the_server():
    check("s09b_end_golden_goal", sense_body=ALIKE, hear=ALIKE, msg=ALIKE, show=ALIKE, ok=SURE, change_player_type=SURE)


def test_connecting_leaving_and_coming_back():
    """All but the window in which somebody takes another's place who is still there: his messages, doubled, begin one window off."""
    check("s05b_connect", think=(99.8, 99.8), sense_body=(92.0, 97.0), hear=SURE, ok=SURE, change_player_type=SURE)


@pytest.mark.parametrize("versions", ["v5_v6", "v7_v8", "v12_v13", "v15_v16"])
def test_coaches_of_every_version(versions):
    check(f"s07_coach_{versions}", hear=(0.0, 90.0), sense_body=(0.0, 90.0), change_player_type=SURE)


def test_every_command_of_a_trainer():
    """Look and pictures differ in numbers: everybody was moved onto everybody."""
    check(
        "s06a_trainer",
        ok=(93.0, 100.0),
        sense_body=(90.0, 99.8),
        fullstate=(6.5, 100.0),
        hear=(97.0, 99.0),
        change_player_type=SURE,
        see_global=ALIKE,
    )


def test_every_command_by_players_of_every_version():
    check("s05a_versions", sense_body=(65.0, 100.0), ok=SURE, fullstate=(9.4, 100.0), change_player_type=SURE, hear=(80.0, 94.0))


ITEM = re.compile(r"\(([a-z_]+) ((?:[^()]|\([^()]*\))*)\)")


def fields(text):
    """sense_body by its fields."""
    return dict(ITEM.findall(text[len("(sense_body ") :]))


THING = re.compile(r"\(\(?(b|ball|p [^()]*|[lr]_\d+)\)? ([^()]*)((?:\([^()]*\) ?)*)[^()]*\)")


def whole_state(text):
    """fullstate by what it tells, of every thing its place, its speed and more."""
    out, rest = {}, text
    for match in THING.finditer(text):
        name, numbers, parts = match.groups()
        values = numbers.split()
        out |= {(name, "place"): values[:2], (name, "speed"): values[2:4], (name, "body"): values[4:5], (name, "rest"): (values[5:], parts)}
        rest = rest.replace(match[0], name)
    return {**out, ("everything else", "text"): rest}


def heard_of_players(messages):
    """How many words of other players come in a window, and of which kind, if the clock runs: before, places are drawn by lot."""
    heard = [re.fullmatch(r"\(hear (\d+) (?!self|referee|coach|online)(?:-?\d+ )?(our|opp)?(.*)\)", text) for text in messages]
    return collections.Counter(
        (match[2], "hear" if match[3] and '"' in match[3] else "short") for match in heard if match and match[1] != "0"
    )


def test_as_many_are_heard_as_were():
    """In every window of every client from protocol 5 to 19, whatever its ears: how many of each team with words, and without."""
    replay, compared = replayed("s05a_versions"), 0
    for name, mine in replay.of.items():
        for n, (wanted, got) in enumerate(zip(windows(mine.wanted), windows(mine.got))):
            assert heard_of_players(wanted) == heard_of_players(got), (name, n, wanted, got)
            compared += bool(heard_of_players(wanted))
    assert compared > 100


@pytest.mark.parametrize(
    ("name", "chance"), [("s05a_versions", {"speed"}), ("s06a_trainer", {"speed", "collision"}), ("s09c_end_normal", {"speed"})]
)
def test_what_differs_is_what_noise_moves(name, chance):
    """Beside `README`'s table: sense_body differs in the speed alone (and one collision of two players on one place), clocks never.

    fullstate differs in places, speeds and where bodies face.

    Of what is heard only words of players differ, by direction and by which of several is heard; never the own, the referee's or a coach's.
    """
    found = replayed(name).agreements()
    for wanted, got in found["sense_body"].unequal:
        assert wanted.split(" ", 2)[1] == got.split(" ", 2)[1]
        ours, theirs = fields(got), fields(wanted)
        assert ours.keys() == theirs.keys()
        assert {field for field in theirs if theirs[field] != ours[field]} <= chance, (wanted, got)
    for wanted, got in found["fullstate"].unequal if "fullstate" in found else ():
        ours, theirs = whole_state(got), whole_state(wanted)
        assert ours.keys() == theirs.keys()
        assert {what[-1] for what in theirs if theirs[what] != ours[what]} <= {"place", "speed", "body"}, (wanted, got)
    pairs = found["hear"].unequal
    wanted, got = (collections.Counter(filter(None, side)) for side in zip(*pairs))
    assert not [text for text in ((wanted - got) + (got - wanted)) if re.search(r" (self|referee|coach|online_coach_\w+) ", text)]


@pytest.mark.parametrize("name", ["s09a_end_extra_time", "s09c_end_normal", "s09d_end_one_team"])
def test_matches_end_as_they_ended(name):
    check(name, sense_body=ALIKE, hear=ALIKE, msg=ALIKE, show=ALIKE, ok=SURE)


@pytest.mark.parametrize("name", ["s09e_end_penalties", "s09g_end_penalty_fouls", "s09h_end_penalty_random_winner"])
def test_shoot_outs_end_as_they_ended(name):
    """Where the ball went is chance; who shoots and what counts is not."""
    check(name, sense_body=(0.0, 99.0), hear=(0.0, 85.0), msg=(0.0, 96.0), ok=SURE)


def test_a_drawn_shoot_out_has_the_same_order():
    """s09f in structure: who shoots, what counts and the draw; whether a taker reaches the ball in time, and so the clock, is noise."""
    replay = replayed("s09f_end_penalty_draw")
    said = [
        [name[1] for text in messages if (name := re.fullmatch(r"\(hear \d+ referee (.+)\)", text)) and "taken" not in name[1]]
        for messages in (replay.of["l1"].wanted, replay.of["l1"].got)
    ]
    assert said[0] == said[1]
    assert said[0][-2:] == ["penalty_draw", "time_over"]
    assert len(said[0]) > 25
    assert replay.server.over == "the match is over"


@pytest.mark.parametrize("name", ["s08a_monitors", "s08b_monitors"])
def test_every_command_of_monitors(name):
    check(name, sense_body=SURE, hear=SURE, ok=SURE, msg=(90.0, 100.0))


class Looking(SessionReplay):
    """Compares every recorded see message with what the player could be told then: which words are left out far away is a draw.

    Messages that are sent between the commands and the step are counted apart: here the step has been made when they are compared.
    """

    possible, late = 0, 0

    def expect(self, row, mine):
        super().expect(row, mine)
        text = row.get("text") or ""
        if not text.startswith("(see ") or mine.client is None or mine.client.version < 3:
            return
        stadium = self.server.stadium
        if int(text[5:-1].split(" ", 1)[0]) != stadium.time:
            self.late += 1
            return
        assert see_mismatches(stadium.sim, 0, mine.client.row + 1, text) == [], (row["n"], row["client"])
        self.possible += 1


@pytest.mark.parametrize(("name", "least"), [("s07_coach", 400), ("s05c_names", 150)])
def test_everything_seen_could_be_seen(name, least):
    """In sessions in which no noise moves anybody: object by object, to the letter, in every version from 5 to 19."""
    looking = Looking(HERE / f"{name}.jsonl.gz").run()
    assert looking.possible >= least
    assert looking.late <= looking.possible / 20
