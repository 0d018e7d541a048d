"""When asynchronous players of a recording see: their views and counts of sub-ticks, and the phase of the 300 ms period.

A recording of clients before protocol 18 does not tell how many of the server's sub-ticks had passed when it began. The moments of all
see messages leave one phase for all players and, for each of them, one view and count; these are found by trying all.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ...errors import FormatError
from ..kernels.senses import late_messages_due
from ..protocol.commands import parse_commands
from ..protocol.message_parser import parse_see
from ..protocol.messages import see_mismatches
from ..simulator import Simulator
from ..state import ViewWidth
from .recording import ROW, Recording

_INTERVALS = {ViewWidth.NARROW: 2, ViewWidth.NORMAL: 4, ViewWidth.WIDE: 8}
_SUB_TICKS = (2, 2, 1)
"""Sub-ticks from a step to the commands after it, by the number of steps modulo 3; one more lies before the next step."""


class View(NamedTuple):
    """How an asynchronous player looks."""

    width: int
    quality: int
    """1 high, 2 low."""

    @property
    def interval(self) -> int:
        """Sub-ticks from one message to the next."""
        return _INTERVALS[ViewWidth(self.width)] // self.quality


class Moment(NamedTuple):
    """What a recorded step tells of one player's seeing."""

    before: int
    """Messages after the commands that show the state before the step."""
    after: int
    """Messages that show the state after it."""
    view: View | None
    """The view that the player chose in this step."""
    quality: int
    """Quality of the messages: 1, 2, or 0 if they do not tell."""
    idle: int
    """Cycles that passed unrecorded before this step."""


def _times(step: dict[str, Any], key: str) -> Iterator[tuple[int, str]]:
    """(cycles after the step's beginning, message) of the see messages of one player."""
    for text in (step.get("msgs") or {}).get(key, ()):
        if text.startswith("(see "):
            yield int(text[5:].split(" ")[0].rstrip(")")) - int(step["T"]), text


def _quality(text: str) -> int:
    """Quality of a see message: without distances it is low; nothing seen tells nothing."""
    try:
        objects = parse_see(text).objects
    except FormatError:
        return 0
    return 0 if not objects else 2 if objects[0].distance is None else 1


def _moments(recording: Recording, key: str) -> list[Moment]:
    """The steps of a recording until the player becomes synchronous."""
    moments: list[Moment] = []
    time = None
    for case in recording.records:
        for step in case.get("steps", ()):
            view, idle = None, 0 if time is None else max(int(step["T"]) - time, 0)
            time = int(step["T"]) + 1
            for command in parse_commands((step.get("cmd") or {}).get(key, "")).commands:
                if command.name == "synch_see":
                    return moments
                if command.name == "change_view":
                    view = View(int(command.args[0]), 2 if int(command.args[1]) == 2 else 1)
            told = list(_times(step, key))
            quality = max((_quality(text) for later, text in told if later), default=0)
            counts = [sum(later == after for later, _ in told) for after in (0, 1)]
            moments.append(Moment(counts[0], counts[1], view, quality, idle))
    return moments


def _fits(moments: list[Moment], phase: int, view: View, counter: int) -> bool:
    """Whether a player who began like this gets the recorded messages."""

    def ticks(count: int) -> int:
        nonlocal counter
        told = 0
        for _ in range(count):
            counter += 1
            if counter >= view.interval:
                counter, told = 0, told + 1
        return told

    for moment in moments:
        for _ in range(moment.idle):
            phase = (phase + 1) % 3
            ticks(1 + _SUB_TICKS[phase])
        view = moment.view or view
        if ticks(1) != moment.before:
            return False
        phase = (phase + 1) % 3
        if ticks(_SUB_TICKS[phase]) != moment.after or moment.quality not in (0, view.quality):
            return False
    return True


def set_asynchronous_clocks(simulator: Simulator, recording: Recording) -> None:
    """Give the asynchronous players the views, counts and phase that a recording implies; nothing changes if none fit.

    Parameters
    ----------
    simulator : Simulator
        Stands where the recording begins.
    recording : Recording
    """
    world = simulator.world[0]
    found: dict[str, dict[int, tuple[View, int]]] = {}
    for key, version in recording.header["client_versions"].items():
        moments = _moments(recording, key) if version < 18 else []
        if not any(moment.before or moment.after for moment in moments):
            continue
        found[key] = {}
        for phase in range(3):
            for view in (View(width, quality) for width in (2, 1, 3) for quality in (1, 2)):
                for counter in range(view.interval):
                    if phase not in found[key] and _fits(moments, phase, view, counter):
                        found[key][phase] = view, counter
    phases = [phase for phase in range(3) if found and all(phase in starts for starts in found.values())]
    if not phases:
        return
    world["steps"] += (phases[0] - int(world["steps"])) % 3
    for key, starts in found.items():
        row = ROW[key]
        view, world["see_counter"][row] = starts[phases[0]]
        world["view_width"][row], world["view_quality"][row] = view


def compare_late(simulator: Simulator, step: dict[str, Any]) -> list[tuple[str, str, Any, Any]]:
    """Compare the messages that asynchronous players get between commands and step: (player, quantity, recorded, own).

    Parameters
    ----------
    simulator : Simulator
        Just before the step.
    step : dict
        The recorded step.
    """
    world = simulator.world[0]
    late_messages_due(world)
    compared: list[tuple[str, str, Any, Any]] = []
    for key in step.get("msgs") or {}:
        row = ROW[key]
        if world["enabled"][row] and not world["synchronous"][row] and int(step["T"]) == int(world["time"]):
            told = [text for later, text in _times(step, key) if later == 0]
            compared.append((key, "late see messages", len(told), int(world["saw"][row]) >> 2 & 1))
            compared += [(key, "late see", [], see_mismatches(simulator, 0, row + 1, text)) for text in told]
    return compared
