"""Comparing the messages that players received with those the simulator would send."""

from __future__ import annotations

import copy
import itertools
import math
import re
from typing import Any

from ..kernels.audio import hear_degrees, hears_at_once
from ..protocol.messages import hear_text, referee_text, see_mismatches, sense_body_text
from ..simulator import Simulator
from ..state import Count
from .recording import ROW, Recording
from .report import Result

_ITEM = re.compile(r"\((\w+) ((?:[^()]|\([^()]*\))*)\)")
_COUNTERS = {
    "kick": Count.KICK,
    "dash": Count.DASH,
    "turn": Count.TURN,
    "say": Count.SAY,
    "turn_neck": Count.TURN_NECK,
    "catch": Count.CATCH,
    "move": Count.MOVE,
    "change_view": Count.CHANGE_VIEW,
    "change_focus": Count.CHANGE_FOCUS,
    "arm": Count.ARM,
    "focus": Count.ATTENTION,
    "tackle": Count.TACKLE,
}
_HEARD_ELSEWHERE = ("referee", "coach", "online_coach_left", "online_coach_right")


class Listener:
    """What is known of the hidden side of a recording: who is listened to, whose counters, view and see phase are known.

    A recording has gaps in which its clients gave commands that it does not tell. Afterwards a player's counters are taken from his first
    sense_body, his view width and the phase of his see messages from his first see; from then on they must agree.

    Parameters
    ----------
    recording : Recording
    """

    def __init__(self, recording: Recording) -> None:
        self.see_bits: list[str] = recording.header.get("see_bits", [])
        self.referee_key = _first_to_hear_the_referee(recording)
        self.counted: set[str] = set()
        self.viewed: set[str] = set()
        self.phased: set[str] = set()
        self.watched: set[str] = set()
        self.interval: dict[str, int] = {}
        self.first_step = False

    def copy(self) -> Listener:
        """A copy that goes its own way."""
        other = copy.copy(self)
        other.counted, other.viewed, other.phased = set(self.counted), set(self.viewed), set(self.phased)
        return other

    def begin(self, case: dict[str, Any]) -> None:
        """A case begins: find out whose see messages it keeps."""
        self.first_step = True
        seen: dict[str, list[int]] = {}
        turned = set()
        for number, step in enumerate(case["steps"]):
            for key, texts in (step.get("msgs") or {}).items():
                if any(text.startswith("(see ") for text in texts):
                    seen.setdefault(key, []).append(number)
            turned |= {key for key, text in (step.get("cmd") or {}).items() if "view" in text or "synch" in text}
        self.watched = set(seen)
        self.interval = {
            key: min(later - earlier for earlier, later in itertools.pairwise(numbers))
            for key, numbers in seen.items()
            if len(numbers) > 1 and key not in turned
        }

    def forget(self) -> None:
        """Cycles passed that are not recorded."""
        self.counted.clear()
        self.viewed.clear()
        self.phased.clear()

    def adopt(self, simulator: Simulator, step: dict[str, Any]) -> None:
        """After a step and before its comparison: take over what the recording now tells for the first time."""
        world = simulator.world[0]
        time = int(world["time"])
        for key, texts in (step.get("msgs") or {}).items():
            row = ROW[key]
            if not world["enabled"][row]:
                continue
            for text in texts:
                if text.startswith("(sense_body ") and key not in self.counted:
                    told = dict(_ITEM.findall(text.split(" ", 2)[2]))
                    for name, column in _COUNTERS.items():
                        found = re.search(r"(?:^|\(count )(\d+)\)?$", told.get(name, ""))
                        if found:
                            world["counts"][row, column] = int(found[1])
                elif is_see(text, time):
                    if key not in self.viewed:
                        _adopt_width(simulator, row, text, self.interval.get(key))
                    if key not in self.phased and world["synchronous"][row]:
                        world["see_counter"][row], world["saw"][row] = 0, 1
        for key in self.seers(step) or ():
            if key not in self.phased:
                world["see_counter"][ROW[key]], world["saw"][ROW[key]] = 0, 1

    def seers(self, step: dict[str, Any]) -> set[str] | None:
        """Who got a see in this step, if the recording tells it of everybody (bits of ``aux.see``)."""
        bits = step.get("aux", {}).get("see")
        return None if bits is None else {key for index, key in enumerate(self.see_bits) if bits >> index & 1}

    def advance(self, step: dict[str, Any]) -> None:
        """The step is done: what it told must agree from now on."""
        self.first_step = False
        for key, texts in (step.get("msgs") or {}).items():
            if any(text.startswith("(sense_body ") for text in texts):
                self.counted.add(key)
            if any(text.startswith("(see ") for text in texts):
                self.viewed.add(key)
                self.phased.add(key)
        self.phased |= self.seers(step) or set()

    def announcements(self, step: dict[str, Any]) -> list[str] | None:
        """The referee's messages of a step in order, None if the recording keeps none."""
        if self.referee_key is None:
            return None
        texts = []
        for name in ("msgs_inphase", "msgs"):
            texts += [text for text in (step.get(name) or {}).get(self.referee_key, ()) if is_referee(text)]
        return texts


def _adopt_width(simulator: Simulator, row: int, told: str, interval: int | None) -> None:
    """Find the view width with which the player sees what he saw, as often as he saw; keep the present one if none fits."""
    world = simulator.world[0]
    present = int(world["view_width"][row])
    # in synchronous mode the interval is 1, 2 or 3 cycles for narrow, normal, wide: the numbers of the widths
    known = interval is not None and bool(world["synchronous"][row])
    for width in (interval,) if known else (present, 1, 2, 3):
        world["view_width"][row] = width
        if not see_mismatches(simulator, 0, row + 1, told):
            return
    world["view_width"][row] = present


def is_see(text: str, time: int) -> bool:
    """Whether a message is a see of `time`; one in which nothing is seen ends behind the time."""
    return text.startswith(f"(see {time} ") or text == f"(see {time})"


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
    return referee_text(simulator, 0)


def compare_messages(
    result: Result, case: str, cycle: int, simulator: Simulator, step: dict[str, Any], listener: Listener, skip: frozenset[int]
) -> None:
    """Compare the recorded sense_body, hear and see of a step with the simulator's, player by player.

    Parameters
    ----------
    result, case, cycle
        Where it is noted.
    simulator : Simulator
        After the step.
    step : dict
        The recorded step.
    listener : Listener
        Whose see messages are all recorded.
    skip : frozenset of int
        Object numbers left to chance; nobody's see is compared then.
    """
    world = simulator.world[0]
    time = int(world["time"])
    messages = step.get("msgs") or {}
    for key in messages | (step.get("msgs_inphase") or {}):
        row, texts = ROW[key], messages.get(key, [])
        if row + 1 in skip or not world["enabled"][row]:
            continue
        for told in [text for text in texts if text.startswith("(sense_body ")]:
            _compare_body(result, case, cycle, key, told, sense_body_text(simulator, 0, row + 1), world, listener.first_step)
        for told in [text for text in texts if is_see(text, time)]:
            if not skip:
                result.equal(case, cycle, key, "see", [], see_mismatches(simulator, 0, row + 1, told))
        at_once = (step.get("msgs_inphase") or {}).get(key, []) if hears_at_once(world, row) else []
        heard = [text for text in at_once + texts if text.startswith("(hear ") and text.split(" ", 3)[2] not in _HEARD_ELSEWHERE]
        if heard or world["heard_count"][row]:
            own = hear_text(simulator, 0, row + 1)
            if heard != own and hears_by_chance(simulator, row, heard, own):
                own = heard
            result.equal(case, cycle, key, "hear", heard, own)
    seers = listener.seers(step)
    if seers is not None:
        due = {key for key in listener.phased if world["enabled"][ROW[key]] and world["saw"][ROW[key]] & 3}
        result.equal(case, cycle, "game", "see messages", sorted(seers & listener.phased), sorted(due))
        return
    for key in sorted(listener.watched & listener.phased):
        row = ROW[key]
        if world["enabled"][row]:
            told_times = sum(is_see(text, time) for text in messages.get(key, ()))
            result.equal(case, cycle, key, "see messages", told_times, int(world["saw"][row] & 3).bit_count())


def _kind_of_hear(text: str) -> str:
    """Who spoke, as far as it counts for the capacity of hearing, and whether it was understood."""
    return ("self" if " self " in text else "our" if " our " in text else "opp") + ('"' if '"' in text else "")


def hears_by_chance(simulator: Simulator, row: int, told: list[str], own: list[str]) -> bool:
    """Whether other draws could have let a player hear `told` instead of `own`.

    Which of several messages is heard is drawn, and their order; not drawn is how many of each team are heard in full and in short, that
    the target of attention comes first, and what anybody said.
    """
    world = simulator.world[0]
    version = int(world["protocol"][row]) or 19
    full, short, attended = [], [], []
    for k in range(int(world["audio_count"])):
        speaker = int(world["audio_from"][k]) - 1
        if speaker == row or not int(world["audio_listeners"][k]) >> row & 1:
            continue
        mate = (speaker < 11) == (row < 11)
        who = f"our {speaker % 11 + 1}" if mate else "opp"
        text = bytes(world["audio_text"][k, : world["audio_length"][k]]).decode("ascii")
        direction = int(hear_degrees(world, row, speaker, version == 7))
        full.append(f'(hear {int(world["time"])} {direction} {who} "{text}")')
        short.append(f"(hear {int(world['time'])} {who})")
        if world["attention"][row] == speaker + 1:
            attended.append(full[-1])

    if sorted(map(_kind_of_hear, told)) != sorted(map(_kind_of_hear, own)):
        return False
    others = [text for text in told if " self " not in text]
    if [text for text in told if " self " in text] != [text for text in own if " self " in text]:
        return False
    possible = full + short
    for text in others:
        if text not in possible:
            return False
        possible.remove(text)
    return not attended or not others or others[0] in attended


def _compare_body(result: Result, case: str, cycle: int, key: str, told: str, own: str, world: Any, first_step: bool) -> None:
    """Compare two sense_body messages; a difference is reported item by item.

    Head angle and direction of speed are cut to whole degrees: an angle within 1e-9 of one, which the recorded state gives in degrees with
    the last bit lost, may fall to either side.
    """
    if told == own or told.split(" ", 2)[:2] != own.split(" ", 2)[:2]:
        result.equal(case, cycle, key, "sense_body", told, own)
        return
    mine = dict(_ITEM.findall(own.split(" ", 2)[2]))
    for name, value in _ITEM.findall(told.split(" ", 2)[2]):
        if name == "collision" and first_step and mine.get(name) in (value, "none"):
            continue  # the first message of a case tells of the placements before it too, and not all of those are recorded
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
