"""Messages of the real server, recorded, read by our clients: nothing is damaged, nothing is missed."""

import gzip
import json
import re

import pytest
from paths import ROOT, SHARED

from cprm_gym.client.monitor import read_frame
from cprm_gym.client.perceived import PerceivedSimulator, PlayerEar, ServerTold

HERE = ROOT / "tests" / "server" / "data"
SESSIONS = SHARED / "sessions"


def rows_of(name):
    for folder in (HERE, SESSIONS):
        path = folder / f"{name}.jsonl.gz"
        if path.exists():
            with gzip.open(path, "rt") as stream:
                next(stream)
                return [json.loads(line) for line in stream]
    pytest.skip(f"recording {name} is not here")


def listen(name):
    """Ears of all players who came with names and numbers of protocol 8 or later, and how many messages they were told."""
    told, ears, teams, versions = {}, {}, {}, {}
    count = 0
    for row in rows_of(name):
        client, text = row["client"], row.get("text", row.get("inflated")) or ""
        if row["to"] == "server":
            found = re.match(r"\(init (\S+?)[ )].*?version (\d+)", text)
            if found:
                teams[client], versions[client] = found[1], int(found[2])
            continue
        if not re.fullmatch(r"[lr]\d+", client) or versions.get(client, 0) < 8:
            continue
        parameters = told.setdefault(client, ServerTold())
        if parameters.tell(text):
            continue
        if client not in ears:
            if not text.startswith("(init "):
                continue
            row_ = int(client[1:]) - 1 + (0 if client[0] == "l" else 11)
            ears[client] = PlayerEar(PerceivedSimulator(parameters.parameters, parameters.player_types), row_, teams[client])
            ears[client].connected(text, False)
            continue
        ears[client].tell(text)
        count += 1
        assert not ears[client].damaged, (client, text[:200])
    return ears, count


@pytest.mark.parametrize("name", ["s07_coach", "s09b_end_golden_goal", "s02_helios_helios_still", "s04_helios_realtime", "s05a_versions"])
def test_players_read_every_message(name):
    ears, count = listen(name)
    assert len(ears) >= 4
    assert count > 200
    assert all(ear.time >= 0 for ear in ears.values())


def test_a_match_in_real_time_has_the_structure_of_ours():
    """s04: every cycle tells the body; a see comes every second cycle at most, unless the view is narrow; all end at one time."""
    ears, _ = listen("s04_helios_realtime")
    assert len(ears) == 22
    assert len({ear.time for ear in ears.values()}) == 1
    assert all(ear.lost == 0 for ear in ears.values())


@pytest.mark.parametrize("name", ["s07_coach", "s08c_monitor_bko", "s01_helios_helios"])
def test_monitors_read_every_frame(name):
    frames = [row["text"] for row in rows_of(name) if row["to"] == "client" and row.get("text", "").startswith("(show ")]
    assert len(frames) > 10
    for text in frames:
        assert read_frame(text).players["unum"].tolist() == [*range(1, 12)] * 2
