"""What trainer and online coaches have in common: reading a command, and the questions both may ask."""

from __future__ import annotations

import re
from typing import Any

from ...errors import CommandError
from ...simulator.protocol.commands import parse_trainer
from ..clients import Official
from ..stadium import Stadium
from ..texts.pictures import picture, team_name

FORM = "(error illegal_command_form)"
_HEAD = re.compile(r"\s*\(\s*([A-Za-z0-9_]+)")
SAID = re.compile(r"[A-Za-z0-9 ().+\-*/?<>_]*")
LONGEST_SAY = 128


def head_of(text: str) -> str | None:
    """The word that a command begins with, None when it is none."""
    found = _HEAD.match(text)
    return found[1] if found else None


def arguments(text: str) -> tuple[Any, ...] | None:
    """Arguments of a command as words, numbers and tuples; None when it is not one balanced list."""
    try:
        return parse_trainer(text).args
    except CommandError:
        return None


def said(text: str) -> str:
    """What a trainer or an old coach says: the longest run of characters allowed, without one last parenthesis."""
    found = SAID.match(text, len("(say "))
    words = found[0] if found else ""
    return words.removesuffix(")") if len(words) <= LONGEST_SAY else words[:LONGEST_SAY]


def answer_question(stadium: Stadium, client: Official, head: str, text: str) -> bool:
    """Answer what both may ask; False when `head` is no such command."""
    if head == "look":
        stadium.send(client, picture(stadium.sim, client, look=True))
    elif head == "check_ball":
        stadium.send(client, f"(ok check_ball {stadium.time} {stadium.sim.trainer.check_ball(0)[0]})")
    elif head == "team_names":
        named = [
            f"(team {letter} {team_name(stadium.sim, client, letter == 'l')})" for letter, team in zip("lr", stadium.teams) if team.name
        ]
        stadium.send(client, f"(ok {' '.join(('team_names', *named))})\n")
    elif head == "eye":
        switch(stadium, client, "eye", text)
    elif head == "compression":
        _compression(stadium, client, text)
    elif head == "done":
        client.done = True
    else:
        return False
    return True


def switch(stadium: Stadium, client: Official, name: str, text: str) -> None:
    """``(eye on)``, ``(ear off)``."""
    found = re.match(rf"\s*\(\s*{name}\s+(on|off)\s*\)", text)
    if found is None:
        stadium.send(client, FORM)
        return
    setattr(client, name, found[1] == "on")
    stadium.send(client, f"(ok {name} {found[1]})")


def _compression(stadium: Stadium, client: Official, text: str) -> None:
    found = re.match(r"\s*\(\s*compression\s+([+-]?\d{1,9})", text)
    if found is None or int(found[1]) > 9:
        stadium.send(client, FORM)
        return
    stadium.send(client, f"(ok compression {int(found[1])})")
    client.compression = int(found[1])


def hear_trainer(stadium: Stadium, text: str) -> None:
    """Everybody hears what the trainer says: old clients and coaches at once, players from version 8 on after the step."""
    for player in stadium.players():
        if player.version >= 8:
            player.pending.append(f'coach "{text}"')
        elif player.version == 7:
            stadium.send(player, f'(hear {stadium.time} coach "{text}")')
        else:
            stadium.send(player, f"(hear {stadium.time} referee {text})")
    for coach in stadium.coaches():
        stadium.send(coach, f"(hear {stadium.time} referee {text})")
    trainer = stadium.trainer
    if trainer is not None and trainer.ear:
        stadium.send(trainer, f'(hear {stadium.time} referee "{text}")')
    if stadium.settings.server.send_comms:
        stadium.board(f"(referee {text})")
