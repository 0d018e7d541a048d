"""What differs from the recordings is chance: the recording agrees with our matches as they agree with each other.

Were noise, draws and the order of datagrams the only differences, then the real server's session would be one more draw of what our server
draws with another seed, and nobody could tell it from ours by how many messages it shares with them.
"""

import collections
import functools
import re

import numpy as np
import pytest
from paths import SHARED
from session_chance import Draws
from session_replay import SessionReplay, phase_of

SESSIONS = SHARED / "sessions"
SURELY = 3.0
"""Standard deviations."""
REAL = {
    "s07_coach": {"see": 37},
    "s06a_trainer": {"ok": 93, "sense_body": 91, "fullstate": 6.5, "see": 7, "hear": 97},
    "s05a_versions": {"sense_body": 65, "fullstate": 9.5, "see": 5, "hear": 41},
    "s09c_end_normal": {"sense_body": 9, "see": 1, "hear": 67},
}
"""Per cent of messages that the real server repeats of itself, in one replay, rounded (the recordings' README)."""
ROUNDED = 0.5
ALL_SPEAK = "s05a_versions"
"""The session in which sixteen players speak at a time: who of them is heard follows from the order in which the server reads them."""


def session(name):
    path = SESSIONS / f"{name}.jsonl.gz"
    if not path.exists():
        pytest.skip(f"recording {name} is not here")
    return path


@functools.cache
def draws(name, seeds):
    return Draws(session(name), seeds, mixed=name == ALL_SPEAK)


def many(*names):
    """A few matches of the first session, and twenty of all with ``pytest -m slow tests/server/test_session_chance.py``, some minutes."""
    return [(names[0], 8), *(pytest.param(name, 20, marks=pytest.mark.slow) for name in names)]


@pytest.mark.parametrize(("name", "seeds"), many("s06a_trainer", "s07_coach", "s05a_versions", "s09c_end_normal", "s09a_end_extra_time"))
def test_a_recording_agrees_with_our_matches_as_they_do_with_each_other(name, seeds):
    drawn, far = draws(name, seeds), {}
    for kind in drawn.texts:
        for numbers in (True, False):
            recorded, ours = drawn.compared(kind, numbers)
            if recorded < ours.mean() - SURELY * ours.std(ddof=1) - 1e-9:
                far[kind, numbers] = recorded, ours.min(), ours.mean()
    assert far == {}


@pytest.mark.parametrize(("name", "seeds"), many("s06a_trainer", "s07_coach", "s05a_versions", "s09c_end_normal", "s09a_end_extra_time"))
def test_what_is_the_same_in_all_our_matches_is_as_recorded(name, seeds):
    """Draw by draw: where seeds make no difference there is none to the recording. (Some words are nearly always left out of see.)"""
    drawn = draws(name, seeds)
    assert {kind: drawn.never_as_recorded(kind)[:3] for kind in drawn.texts if kind != "see" and drawn.never_as_recorded(kind)} == {}


@pytest.mark.parametrize(("name", "seeds"), many(*["s06a_trainer", "s07_coach", "s05a_versions", "s09c_end_normal"]))
def test_what_the_real_server_repeats_of_itself_is_among_what_ours_repeats(name, seeds):
    drawn = draws(name, seeds)
    for kind, real in REAL[name].items():
        pairs = drawn.agreement(kind)[1:, 1:][~np.eye(seeds, dtype=bool)]
        assert pairs.max() >= real - ROUNDED, kind


@pytest.mark.parametrize("name", ["s07_coach", "s06a_trainer"])
def test_see_messages_come_when_they_came(name):
    """In the window and at the time of the recording, every one, in the phase of the real server's clock when the first client came."""
    path = session(name)
    assert SessionReplay(path, phase=phase_of(path)).run().seen_in_time() == 1.0


def referee(replay, clock):
    """What the referee says to a player, with its time or without."""
    found = (re.fullmatch(r"\(hear (\d+) referee (.+)\)", text) for text in clock)
    return [(int(match[1]), match[2]) for match in found if match]


@pytest.mark.slow
def test_the_clock_of_a_shoot_out_is_noise():
    """s09f: how long a ball that misses rolls is drawn. Waits are in vain where our match was over earlier, and there alone.

    Over twenty seeds the order of all that the referee says is the recorded one; matches end before the recorded cycle, in it and after it.
    """
    path, ends = session("s09f_end_penalty_draw"), collections.Counter()
    for seed in range(20):
        replay = SessionReplay(path, seed=seed).run()
        wanted, got = (referee(replay, of) for of in (replay.of["l1"].wanted, replay.of["l1"].got))
        end = replay.server.stadium.time
        ends[int(np.sign(end - wanted[-1][0]))] += 1
        assert (replay.in_vain == []) == (end >= wanted[-1][0])
        said = [[word for _, word in of if "taken" not in word] for of in (wanted, got)]
        assert said[1] == said[0][: len(said[1])]
        # what comes after the end of the recording: the last miss, the draw, the end
        assert len(said[0]) - len(said[1]) <= (3 if end > wanted[-1][0] else 0)
    assert sorted(ends) == [-1, 0, 1]
