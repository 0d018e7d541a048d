"""Recorded matches of real teams, cycle by cycle: one step from a monitor's frame with the commands of its window gives the next frame."""

import collections
import gzip
import json
import re

import numpy as np
import pytest
from paths import SHARED

from cprm_gym.client.monitor import read_frame
from cprm_gym.server import Settings
from cprm_gym.simulator.player_types import PlayerType
from cprm_gym.simulator.protocol.commands import command_record, parse_commands
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import Count, PlayerBit, PlayMode

SESSIONS = SHARED / "sessions"
_TACKLE = re.compile(r"\(tackle \(expires (\d+)\)")
_FOUL = re.compile(r"\(foul \(charged (\d+)\)")
_SHOWN = "kick dash turn catch move turn_neck change_view say tackle arm attention change_focus"
_COUNTS = tuple(Count[name.upper()] for name in _SHOWN.split())
_SET_PLAYS = ("kick_in", "goal_kick", "corner_kick", "free_kick", "kick_off")
RUNNING = {PlayMode.play_on, *(PlayMode[f"{name}_{side}"] for name in _SET_PLAYS for side in "lr")}


class Recorded:
    """Frames by time, and what each player sent in each window, in the order of arrival."""

    def __init__(self, name):
        path = SESSIONS / f"{name}.jsonl.gz"
        if not path.exists():
            pytest.skip(f"recording {name} is not here")
        with gzip.open(path, "rt") as stream:
            header = json.loads(stream.readline())
            rows = [json.loads(line) for line in stream]
        self.settings = Settings.from_words([f"{k}={v}" for k, v in header["parameters_not_default"].items()])
        self.frames, self.sent, self.frozen = {}, collections.defaultdict(list), collections.defaultdict(dict)
        self.types = {}
        now, seen = {}, set()
        for row in rows:
            client, text = row["client"], row.get("text", row.get("inflated")) or ""
            if row["to"] == "client" and text.startswith("(show "):
                frame = read_frame(text)
                # of stopped clocks only the last frame counts, and none that is followed by another of its time
                self.frames[frame.time] = None if frame.time in seen else frame
                seen.add(frame.time)
            elif row["to"] == "client" and text.startswith("(player_type"):
                number, kind = PlayerType.from_text(text)
                self.types[number] = kind
            elif re.fullmatch(r"[lr]\d+", client):
                index = int(client[1:]) - 1 + (0 if client[0] == "l" else 11)
                if row["to"] == "client" and text.startswith("(sense_body "):
                    now[client] = int(text[12:].split(" ", 1)[0])
                    self.frozen[now[client]][index] = int(_TACKLE.search(text)[1]), int(_FOUL.search(text)[1])
                elif row["to"] == "server" and client in now:
                    self.sent[now[client]].append((index, text))


def stand(sim, frame, frozen):
    """Put a world where a frame shows it."""
    w, rows = sim.world[0], frame.players
    w["time"], w["mode"] = frame.time, frame.mode
    w["pos"][0], w["vel"][0], w["acc"] = frame.ball[:2], frame.ball[2:], 0.0
    w["pos"][1:], w["vel"][1:] = rows["pos"], rows["vel"]
    w["body"] = w["body_staged"] = np.radians(rows["body"])
    w["neck"] = w["neck_staged"] = np.radians(rows["neck"])
    w["enabled"], w["type"] = rows["state"] != 0, rows["type"]
    w["goalie"] = (rows["state"] & PlayerBit.GOALIE) != 0
    for name in ("stamina", "effort", "recovery", "capacity"):
        w[name] = rows[name]
    w["counts"][:, list(_COUNTS)] = rows["counts"]
    w["busy"] = w["leg_busy"] = w["neck_busy"] = w["leg_dashed"] = 0
    w["kick_cycles"], w["dash_cycles"], w["tackle_cycles"], w["foul_cycles"], w["catch_ban"], w["ball_catcher"] = 0, 0, 0, 0, 0, 0
    for index, (tackle, foul) in frozen.items():
        w["tackle_cycles"][index], w["foul_cycles"][index] = tackle, foul
        w["busy"][index] = tackle > 0 or foul > 0


def errors(name, least):
    """(n, 22) distances between the players of the next frame and of ours, and (n,) of the ball, over cycles in which time ran."""
    recorded = Recorded(name)
    types = [recorded.types[number] for number in sorted(recorded.types)]
    sim = Simulator(1, recorded.settings.server, recorded.settings.player, types)
    names = next(frame for frame in recorded.frames.values() if frame is not None)
    sim.packed["auto_mode"] = 0
    players, ball, turned = [], [], []
    for time, frame in sorted(recorded.frames.items()):
        after = recorded.frames.get(time + 1)
        if frame is None or after is None or frame.mode not in RUNNING or after.mode != frame.mode:
            continue
        stand(sim, frame, recorded.frozen[time])
        for index, text in recorded.sent[time]:
            for command in parse_commands(text).commands:
                record = command_record(command, 1 if index < 11 else -1, (names.left.name, names.right.name))
                if record is not None:
                    sim.command_phase(0, index + 1, record)
        sim.advance()
        w = sim.world[0]
        there = after.players["state"] != 0
        gaps = np.hypot(*(w["pos"][1:] - after.players["pos"]).T)
        players.append(np.where(there, gaps, 0.0))
        ball.append(np.hypot(*(w["pos"][0] - after.ball[:2])))
        off = np.degrees(w["body"]) - after.players["body"]
        turned.append(np.where(there, np.abs((off + 180) % 360 - 180), 0.0))
    assert len(players) > least
    return np.array(players), np.array(ball), np.array(turned)


def test_without_noise_every_step_is_the_recorded_one():
    """s02, to what four decimals of a frame allow; a turn depends on the speed, of which they leave out up to 5e-5."""
    players, ball, turned = errors("s02_helios_helios_still", 150)
    assert players.max() <= 3e-4
    assert ball.max() <= 3e-4
    assert turned.max() <= 0.05


@pytest.mark.parametrize("name", ["s01_helios_helios", "s03_helios_pyrus"])
def test_with_noise_every_step_is_within_it(name):
    """A tenth of a player's speed, of the ball's a twentieth and the kick's own, of a turn a tenth."""
    players, ball, turned = errors(name, 80)
    assert (players <= 0.15).mean() > 0.998
    assert (ball <= 0.3).mean() > 0.98
    assert (turned <= 36).mean() > 0.998
