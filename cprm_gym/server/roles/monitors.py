"""Monitors: connecting and commands (specification/protocol.md 10)."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Hashable

from ...simulator.kernels.referee.fouls import RED, YELLOW, show_card
from ...simulator.kernels.referee.modes import RULING_DROP_BALL, RULING_FREE_KICK, rule
from ...simulator.kernels.referee.rulings import carry_out
from ...simulator.state import LEFT, PlayerBit, player_index
from ..clients import Monitor, Refused
from ..stadium import PLAYERS_PER_TEAM, Stadium
from ..texts.frames import VERSIONS
from .coaches import graphic_text
from .officials import FORM, head_of
from .players import read_version
from .trainers import command

_INIT = re.compile(r"\(dispinit(?:\s+version\s+([^\s()]+))?\s*\)")
_SIXTEENTH = 1 / 16
MOST_MONITORS = 128
"""Monitors at once, whatever ``max_monitors`` says."""


def connect(stadium: Stadium, address: Hashable, text: str) -> Monitor:
    """Answer ``(dispinit [version V])`` at the well-known port."""

    found = _INIT.match(text)
    version = 1 if found is not None and found[1] is None else read_version(found[1]) if found is not None else None
    if found is None or version is None:
        raise Refused("unknown_command")
    limit = stadium.settings.server.max_monitors
    if 0 < limit <= len(stadium.monitors) or len(stadium.monitors) >= MOST_MONITORS:
        raise Refused("no_more_monitor")
    if version not in VERSIONS:
        raise Refused("illegal_client_version")
    monitor = Monitor(address, version)
    stadium.monitors.append(monitor)
    for data in stadium.frames.parameters(version):
        stadium.send_raw(monitor, data)
    for tile in stadium.graphics:
        stadium.board(graphic_text(*tile), only=monitor)
    return monitor


def receive(stadium: Stadium, monitor: Monitor, text: str) -> None:
    """Execute one command of a monitor; answers are shown on its board."""
    head = head_of(text)
    if head == "dispbye":
        stadium.close(monitor)
        return
    if head == "compression":
        _compression(stadium, monitor, text)
        return
    action = _COMMANDS.get(head or "")
    if action is not None:
        found = action[0].match(text)
        if found is not None and action[1](stadium, *found.groups()):
            stadium.world_changed()
            return
    elif head is not None and _as_trainer(stadium, monitor, head, text):
        return
    stadium.board(FORM, only=monitor)


def _as_trainer(stadium: Stadium, monitor: Monitor, head: str, text: str) -> bool:
    """Trainer's commands, in trainer mode."""
    server = stadium.settings.server
    if not (server.coach or server.coach_w_referee):
        return False

    def reply(answer: str) -> None:
        stadium.board(answer.rstrip("\n"), only=monitor)

    if head == "check_ball":
        reply(f"(ok check_ball {stadium.time} {stadium.sim.trainer.check_ball(0)[0]})")
        return True
    return command(stadium, head, text, reply)


def _compression(stadium: Stadium, monitor: Monitor, text: str) -> None:
    found = re.match(r"\s*\(\s*compression\s+([+-]?\d{1,9})", text)
    if found is None or int(found[1]) > 9:
        stadium.board(FORM, only=monitor)
        return
    stadium.board(f"(ok compression {int(found[1])})", only=monitor)
    monitor.compression = int(found[1])


# ---------------------------------------------------------------------------------------------- what they may do


def _side(word: str) -> int | None:
    """+1 or -1 of a number, None for another."""
    return {1: 1, -1: -1}.get(int(word))


def _start(stadium: Stadium) -> bool:
    stadium.kick_off()
    return True


def _foul(stadium: Stadium, x: str, y: str, side: str) -> bool:
    """A free kick for a side, or a drop ball."""
    w, p, to = stadium.world, stadium.sim.packed[0], _side(side) or 0
    if to:
        stadium.referee_says(f"foul_{'r' if to == LEFT else 'l'}")
    rule(w, RULING_FREE_KICK if to else RULING_DROP_BALL, to, int(x) * _SIXTEENTH, int(y) * _SIXTEENTH)
    carry_out(w, p)
    return True


def _discard(stadium: Stadium, side: str, unum: str) -> bool:
    """Send a player off, or let him come back."""
    row = _row(side, unum)
    if row is None:
        return True
    player = stadium.teams[row // PLAYERS_PER_TEAM].players[row % PLAYERS_PER_TEAM]
    bits = int(stadium.world["bits"][row])
    if bits & PlayerBit.DISCARD:
        stadium.world["bits"][row] = bits & ~int(PlayerBit.DISCARD)
    else:
        stadium.world["bits"][row] = bits | PlayerBit.DISCARD
        if player is not None:
            stadium.disable(player)
    return True


def _place(stadium: Stadium, side: str, unum: str, x: str, y: str, angle: str) -> bool:
    """Put a player somewhere."""
    row = _row(side, unum)
    if row is not None:
        body = math.radians(max(-180, min(int(angle), 180)))
        stadium.sim.trainer.place_player(row + 1, int(x) * _SIXTEENTH, int(y) * _SIXTEENTH, body, (0.0, 0.0))
    return True


def _card(stadium: Stadium, side: str, unum: str, colour: str) -> bool:
    """Show a card."""
    row = _row(side, unum)
    if row is not None and stadium.world["enabled"][row]:
        show_card(stadium.world, row, YELLOW if colour == "yellow" else RED)
    return True


def _row(side: str, unum: str) -> int | None:
    """Row of a player, None when there is none."""
    team, number = _side(side), int(unum)
    return player_index(team, number) - 1 if team is not None and 1 <= number <= PLAYERS_PER_TEAM else None


_INTEGER = r"\s+([+-]?\d{1,9})"
_COMMANDS: dict[str, tuple[re.Pattern[str], Callable[..., bool]]] = {
    "dispstart": (re.compile(r"\s*\(\s*dispstart\s*\)"), _start),
    "dispfoul": (re.compile(rf"\s*\(\s*dispfoul{_INTEGER * 3}\s*\)"), _foul),
    "dispdiscard": (re.compile(rf"\s*\(\s*dispdiscard{_INTEGER * 2}\s*\)"), _discard),
    "dispplayer": (re.compile(rf"\s*\(\s*dispplayer{_INTEGER * 5}\s*\)"), _place),
    "dispcard": (re.compile(rf"\s*\(\s*dispcard{_INTEGER * 2}\s+(yellow|red)\s*\)"), _card),
}
