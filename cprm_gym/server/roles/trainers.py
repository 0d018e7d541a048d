"""The trainer: connecting and commands (specification/protocol.md 6)."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Hashable
from typing import Any

from ...errors import CprmError
from ...simulator.state import PlayMode, player_index
from ..clients import Refused, Trainer
from ..stadium import PLAYERS_PER_TEAM, Stadium
from ..texts.parameter_texts import parameter_texts
from .officials import FORM, answer_question, arguments, head_of, hear_trainer, said, switch
from .players import read_version

_INIT = re.compile(r"\(init(?:\s*\(\s*version\s+([^\s()]+)\s*\))?\s*\)")
_FARTHEST = 1e6
_OBJECT_FORM = "(error illegal_object_form)"
Reply = Callable[[str], None]


def connect(stadium: Stadium, address: Hashable, text: str) -> Trainer | None:
    """Answer a datagram that somebody sent to the trainer's port."""
    server = stadium.settings.server
    if not (server.coach or server.coach_w_referee):
        raise Refused("connected_offline_coach_without_coach_mode")
    if stadium.trainer is not None:
        raise Refused("already_have_offline_coach")
    if not text.startswith("(init"):
        stadium.kick_off()  # an old habit of trainers that never say who they are
        stadium.world_changed()
        return None
    found = _INIT.match(text)
    version = 3 if found is None or found[1] is None else read_version(found[1])
    if found is None or version is None or version < 1:
        raise Refused("illegal_command_form")
    trainer = stadium.trainer = Trainer(address, version)
    stadium.send(trainer, "(init ok)")
    settings = stadium.settings
    for message in parameter_texts(settings.server, settings.player, settings.types, version):
        stadium.send(trainer, message)
    return trainer


def receive(stadium: Stadium, trainer: Trainer, text: str) -> None:
    """Execute one command of the trainer."""

    def reply(answer: str) -> None:
        stadium.send(trainer, answer)

    head = head_of(text)
    if head is None:
        reply(FORM)
    elif answer_question(stadium, trainer, head, text) or command(stadium, head, text, reply):
        pass
    elif head == "ear":
        switch(stadium, trainer, "ear", text)
    elif head == "say":
        _say(stadium, text, reply)
    elif head == "change_player_type":
        _change_player_type(stadium, text, reply)
    else:
        reply("(error unknown_command)")


def command(stadium: Stadium, head: str, text: str, reply: Reply) -> bool:
    """Execute what trainers and, in trainer mode, monitors may do to a match; False when `head` is no such command."""
    if head == "start":
        stadium.kick_off()
        stadium.world_changed()
        reply("(ok start)")
    elif head == "recover":
        stadium.sim.trainer.recover()
        reply("(ok recover)\n")
    elif head == "change_mode":
        _change_mode(stadium, text, reply)
    elif head == "move":
        reply(_move(stadium, text))
        stadium.world_changed()
    else:
        return False
    return True


def _change_mode(stadium: Stadium, text: str, reply: Reply) -> None:
    args = arguments(text)
    if args is None or not args:
        reply(FORM)
    elif args[0] not in PlayMode.__members__ or args[0] == "null":
        reply("(error illegal_mode)")
    else:
        stadium.sim.trainer.change_mode(args[0])
        stadium.world_changed()
        reply("(ok change_mode)")


def _move(stadium: Stadium, text: str) -> str:
    """``(move (ball) x y [a [vx vy]])`` or ``(move (player T U) x y [a [vx vy]])``: the answer."""
    args = arguments(text)
    if args is None:
        return FORM
    if len(args) < 3 or not isinstance(args[0], tuple):
        return _OBJECT_FORM
    thing, numbers = args[0], args[1:]
    if not all(isinstance(number, float) and math.isfinite(number) for number in numbers[:2]):
        return _OBJECT_FORM
    if len(numbers) not in (2, 3, 5) or not all(isinstance(number, float) and math.isfinite(number) for number in numbers):
        return FORM
    x, y, *more = (max(-_FARTHEST, min(number, _FARTHEST)) for number in numbers)
    if thing == ("ball",):
        stadium.sim.trainer.place_ball(x, y, *(more[1:] or (0.0, 0.0)))
        return "(ok move)"
    if len(thing) != 3 or thing[0] != "player" or not isinstance(thing[2], float):
        return _OBJECT_FORM
    unum = thing[2]
    if not 1 <= unum <= PLAYERS_PER_TEAM:
        return _OBJECT_FORM
    side = stadium.side_named(_word(thing[1]))
    if side is not None and stadium.world["enabled"][player_index(side, int(unum)) - 1]:
        body = math.radians(max(-180.0, min(more[0], 180.0))) if more else None
        velocity = (more[1], more[2]) if len(more) == 3 else None
        stadium.sim.trainer.place_player(player_index(side, int(unum)), x, y, body, velocity)
    return "(ok move)"


def _word(word: Any) -> str:
    return f"{word:g}" if isinstance(word, float) else str(word)


def _say(stadium: Stadium, text: str, reply: Reply) -> None:
    if not text.startswith("(say ") or text.startswith('(say "'):
        reply(FORM)
        return
    hear_trainer(stadium, said(text))
    reply("(ok say)")


def _change_player_type(stadium: Stadium, text: str, reply: Reply) -> None:
    """Exchange a player without limits."""
    args = arguments(text)
    if args is None or len(args) != 3 or not all(isinstance(number, float) and number == int(number) for number in args[1:]):
        reply(FORM)
        return
    name, unum, kind = _word(args[0]), int(args[1]), int(args[2])
    side = stadium.side_named(name)
    if side is None:
        reply("(warning no_team_found)")
        return
    if not 0 <= kind < len(stadium.settings.types):
        reply("(error out_of_range_player_type)")
        return
    try:
        stadium.sim.trainer.change_player_type(player_index(side, unum), kind)
    except (CprmError, ValueError):
        reply("(warning no_such_player)")
        return
    stadium.world_changed()
    reply(f"(ok change_player_type {name} {unum} {kind})")
