"""Comparing the messages that players received with those the simulator would send."""

from __future__ import annotations

import copy
import math
import re
from typing import Any

from cprm_gym.simulator.command_text import parse_commands
from cprm_gym.simulator.conformance_recording import KEYS, ROW, Recording
from cprm_gym.simulator.conformance_report import Result
from cprm_gym.simulator.messages import hear_text, referee_text, see_mismatches, sense_body_text
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import Announcement, Count

_BROADCASTS = (Announcement.CHANGE_PLAYER_TYPE, Announcement.PROMOTE_GOALIE)
_ITEM = re.compile(r"\((\w+) ((?:[^()]|\([^()]*\))*)\)")
_COUNTERS = {
    "kick": Count.KICK, "dash": Count.DASH, "turn": Count.TURN, "say": Count.SAY, "turn_neck": Count.TURN_NECK, "catch": Count.CATCH,
    "move": Count.MOVE, "change_view": Count.CHANGE_VIEW, "change_focus": Count.CHANGE_FOCUS, "arm": Count.ARM,
    "focus": Count.ATTENTION, "tackle": Count.TACKLE,
}
_HEARD_ELSEWHERE = ("referee", "coach", "online_coach_left", "online_coach_right")


class Listener:
    """Which messages a recording keeps of whom, and since when the phase of a player's see messages is known.

    Parameters
    ----------
    recording : Recording
    """

    def __init__(self, recording: Recording) -> None:
        self.version = {key: int(version) for key, version in recording.header["client_versions"].items()}
        self.referee_key = _first_to_hear_the_referee(recording)
        self.counted: set[str] = set()

    def copy(self) -> Listener:
        """A copy that goes its own way."""
        other = copy.copy(self)
        other.counted = set(self.counted)
        return other

    def forget(self) -> None:
        """Cycles passed that are not recorded: how many commands the players gave is unknown again."""
        self.counted.clear()

    def adopt_counts(self, world: Any, step: dict[str, Any]) -> None:
        """Take over the counters of players whose first sense_body since unrecorded cycles this step has."""
        for key, texts in (step.get("msgs") or {}).items():
            if key in self.counted:
                continue
            for text in texts:
                if text.startswith("(sense_body "):
                    told = dict(_ITEM.findall(text.split(" ", 2)[2]))
                    for name, column in _COUNTERS.items():
                        found = re.search(r"(?:^|\(count )(\d+)\)?$", told.get(name, ""))
                        if found:
                            world["counts"][ROW[key], column] = int(found[1])

    def advance(self, step: dict[str, Any]) -> None:
        """The step is done: from now on its players' counters must agree."""
        for key, texts in (step.get("msgs") or {}).items():
            if any(text.startswith("(sense_body ") for text in texts):
                self.counted.add(key)

    def announcements(self, step: dict[str, Any]) -> list[str] | None:
        """The referee's messages of a step in order, None if the recording keeps none."""
        if self.referee_key is None:
            return None
        texts = []
        for name in ("msgs_inphase", "msgs"):
            texts += [text for text in (step.get(name) or {}).get(self.referee_key, ()) if is_referee(text)]
        return texts


def is_referee(text: str) -> bool:
    """Whether a message is the referee's."""
    words = text.split(" ", 3)
    return words[0] == "(hear" and len(words) > 2 and words[2] == "referee"


def _first_to_hear_the_referee(recording: Recording) -> str | None:
    for record in recording.records:
        for step in record.get("steps", ()):
            for name in ("msgs", "msgs_inphase"):
                for key, texts in (step.get(name) or {}).items():
                    if any(is_referee(text) for text in texts):
                        return str(key)
    return None


def said_by_referee(simulator: Simulator) -> list[str]:
    """What the referee said since the commands began, as players hear it."""
    world = simulator.world[0]
    kinds = world["announcement"][: int(world["announced"]), 0]
    return [text for text, kind in zip(referee_text(simulator, 0), kinds) if kind not in _BROADCASTS]


def compare_messages(
    result: Result, case: str, cycle: int, simulator: Simulator, step: dict[str, Any], skip: frozenset[int]
) -> None:
    """Compare the recorded sense_body, hear and see of a step with the simulator's, player by player."""
    time = int(simulator.world["time"][0])
    for key, texts in (step.get("msgs") or {}).items():
        row = ROW[key]
        if row + 1 in skip or not simulator.world["enabled"][0, row]:
            continue
        for told in [text for text in texts if text.startswith("(sense_body ")]:
            _compare_body(result, case, cycle, key, told, sense_body_text(simulator, 0, row + 1), simulator.world[0])
        for told in [text for text in texts if text.startswith(f"(see {time} ")]:
            if not skip:
                result.equal(case, cycle, key, "see", [], see_mismatches(simulator, 0, row + 1, told))
        heard = [text for text in texts if text.startswith("(hear ") and text.split(" ", 3)[2] not in _HEARD_ELSEWHERE]
        if heard or simulator.world["heard_count"][0, row]:
            result.equal(case, cycle, key, "hear", heard, hear_text(simulator, 0, row + 1))


def _compare_body(result: Result, case: str, cycle: int, key: str, told: str, own: str, world: Any) -> None:
    """Compare two sense_body messages; a difference is reported item by item.

    Head angle and direction of speed are cut to whole degrees: an angle within 1e-9 of one, which the recorded state gives in degrees with
    the last bit lost, may fall to either side.
    """
    if told == own or told.split(" ", 2)[:2] != own.split(" ", 2)[:2]:
        result.equal(case, cycle, key, "sense_body", told, own)
        return
    mine = dict(_ITEM.findall(own.split(" ", 2)[2]))
    for name, value in _ITEM.findall(told.split(" ", 2)[2]):
        if mine.get(name) != value and not _tie(name, value, mine.get(name, ""), world, ROW[key]):
            result.equal(case, cycle, key, "sense_body", f"({name} {value})", f"({name} {mine.get(name)})")


def _tie(name: str, told: str, own: str, world: Any, row: int) -> bool:
    """Whether two truncated angles differ because the angle is a whole number of degrees up to rounding."""
    if name not in ("head_angle", "speed") or told.split()[:-1] != own.split()[:-1]:
        return False
    angle = float(world["neck"][row])
    if name == "speed":
        vx, vy = world["vel"][row + 1]
        angle = (math.atan2(vy, vx) if vx or vy else 0.0) - float(world["body"][row]) - angle
    degrees = math.degrees(angle)
    difference = (int(told.split()[-1]) - int(own.split()[-1])) % 360
    return abs(degrees - round(degrees)) < 1e-9 and difference in (1, 359)


def illegal_commands(step: dict[str, Any]) -> dict[str, int]:
    """Player -> datagrams of a step that the grammar refuses."""
    return {key: 1 for key, text in (step.get("cmd") or {}).items() if key in KEYS and parse_commands(text).error is not None}
