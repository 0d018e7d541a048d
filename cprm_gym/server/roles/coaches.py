"""Online coaches: connecting, what they say, whom they exchange, their team's picture (specification/protocol.md 7)."""

from __future__ import annotations

import re
from collections.abc import Hashable
from typing import NamedTuple

from ...simulator.state import LEFT, PlayMode
from ..clients import Coach, Refused
from ..stadium import PLAYERS_PER_TEAM, Stadium
from ..texts.parameter_texts import parameter_texts
from .clang import Message, read_message
from .officials import FORM, answer_question, head_of, said
from .players import read_version, tell_language, tell_types

OLDEST, NEWEST = 5, 19
CLANG_FROM, GOALIE_FROM = 7, 16
LONGEST_NAME = 127
TILE, TILES_ACROSS, TILES_DOWN = 8, 32, 8
_INIT = re.compile(r"\(init ([+-_a-z]+)(?: +([^\s()]+))?(?:\s*\(\s*version\s+([^\s()]+)\s*\))?\s*\)")
_NAME = re.compile(r"[A-Za-z0-9_.+\-*/<>]+")
_CHANGE = re.compile(r"\s*\(\s*change_player_type\s+([+-]?\d{1,9})\s+([+-]?\d{1,9}|goalie)\s*\)")
_GRAPHIC = re.compile(r'\s*\(\s*team_graphic\s*\(\s*([+-]?\d{1,9})\s+([+-]?\d{1,9})((?:\s*"[^"]*")*)\s*\)\s*\)')


class Waiting(NamedTuple):
    """A message that is not delivered yet."""

    message: Message
    said: int


class Speech:
    """What one team's coach may still say, and what waits to be delivered."""

    def __init__(self, freeform: int) -> None:
        self.freeform = freeform
        self.windows: dict[str, tuple[int, int]] = {}
        self.waiting: list[Waiting] = []


class Coaches:
    """The online coaches of a match.

    Parameters
    ----------
    stadium : Stadium
    """

    def __init__(self, stadium: Stadium) -> None:
        self._stadium = stadium
        allowance = stadium.settings.server.say_coach_cnt_max
        self._speech = {LEFT: Speech(allowance), -LEFT: Speech(allowance)}
        self._old_says = {LEFT: allowance, -LEFT: allowance}
        self._include = _include_text(stadium.settings.coach_message)

    # ------------------------------------------------------------------------------------------ connecting

    def connect(self, address: Hashable, text: str) -> Coach:
        """Answer ``(init TEAM [NAME] [(version V)])`` at the coaches' port."""
        stadium = self._stadium

        found = _INIT.match(text)
        if found is None or (found[2] is None and found[3] is None):
            raise Refused("illegal_command_form")
        version = 5 if found[3] is None else read_version(found[3])
        if version is None:
            raise Refused("illegal_command_form")
        name = found[2] or ""
        if name and (len(name) > LONGEST_NAME or not _NAME.fullmatch(name)):
            raise Refused("illegal_coachname_or_too_long_coachname")
        side = stadium.side_named(found[1])
        if side is None:
            raise Refused("no_such_team")
        team = stadium.team_of(side)
        if team.coach is not None and team.coach.connected:
            raise Refused("already_have_coach")
        if not OLDEST <= version <= NEWEST:
            raise Refused("illegal_client_version")
        if team.coached:
            raise Refused("connection_failed")
        coach = team.coach = Coach(address, version, side, name)
        team.coached, team.coach_name = True, name
        stadium.send(coach, "(init ok)" if version < 6 else f"(init {coach.letter} ok)")
        settings = stadium.settings
        for message in parameter_texts(settings.server, settings.player, settings.types, version):
            stadium.send(coach, message)
        tell_types(stadium, coach, side)
        for player in stadium.players():
            tell_language(stadium, coach, player)
        if version >= 11 and self._include:
            stadium.send(coach, self._include)
        return coach

    # ------------------------------------------------------------------------------------------ commands

    def receive(self, coach: Coach, text: str) -> None:
        """Execute one command of a coach."""
        stadium = self._stadium
        head = head_of(text)
        if head is None:
            stadium.send(coach, FORM)
        elif head == "bye":
            stadium.close(coach)
        elif answer_question(stadium, coach, head, text):
            pass
        elif head == "say":
            if coach.version >= CLANG_FROM:
                self._say(coach, text)
            else:
                self._say_plainly(coach, text)
        elif head == "change_player_type":
            self._change(coach, text)
        elif head == "team_graphic":
            self._graphic(coach, text)
        else:
            stadium.send(coach, "(error unknown_command)")

    def _change(self, coach: Coach, text: str) -> None:
        stadium, found = self._stadium, _CHANGE.match(text)
        if found is None:
            return stadium.send(coach, FORM)
        unum = int(found[1])
        if found[2] == "goalie":
            if not 1 <= unum <= PLAYERS_PER_TEAM:
                return stadium.send(coach, "(warning no_such_player)")
            answer = stadium.sim.coach.promote_goalie(_object(coach, unum), 0)[0]
        elif not 1 <= unum <= PLAYERS_PER_TEAM:
            # what is wrong beside the number comes first; a place that nobody ever had tells it
            answer = "(warning no_such_player)"
        else:
            answer = stadium.sim.coach.change_player_type(_object(coach, unum), int(found[2]), 0)[0]
        stadium.world_changed()
        stadium.send(coach, answer)

    def _graphic(self, coach: Coach, text: str) -> None:
        """A tile of the team's picture, passed on to monitors."""
        stadium = self._stadium
        if stadium.mode != PlayMode.before_kick_off:
            return stadium.send(coach, "(warning only_before_kick_off)")
        found = _GRAPHIC.match(text)
        lines = tuple(found[3].split('"')[1::2]) if found else ()
        size = _tile_size(lines)
        if found is None or size is None:
            return stadium.send(coach, "(error invalid_xpm_data)")
        if size != (TILE, TILE):
            return stadium.send(coach, "(warning invalid_tile_size)")
        x, y = (int(number) % 2**32 for number in found.groups()[:2])
        if x >= TILES_ACROSS or y >= TILES_DOWN:
            stadium.send(coach, "(warning invalid_tile_location)")
        tile = coach.letter, x, y, lines
        if x < TILES_ACROSS and y < TILES_DOWN:
            stadium.graphics = [old for old in stadium.graphics if old[:3] != tile[:3]] + [tile]
        stadium.send(coach, f"(ok team_graphic {x} {y})")
        stadium.late_board.append(graphic_text(*tile))

    def _say_plainly(self, coach: Coach, text: str) -> None:
        """Coaches before version 7 say plain text to everybody."""
        stadium = self._stadium
        if stadium.mode == PlayMode.play_on:
            return stadium.send(coach, "(warning cannot_say_while_playon)")
        if self._old_says[coach.side] <= 0:
            return stadium.send(coach, "(error said_too_many_messages)")
        self._old_says[coach.side] -= 1
        words = said(text)
        who = _speaker(coach)
        for player in stadium.players():
            if player.version >= 8:
                player.pending.append(f'{who} "{words}"')
            else:
                stadium.send(
                    player, f'(hear {stadium.time} {who} "{words}")' if player.version == 7 else f"(hear {stadium.time} {who} {words})"
                )
        stadium.send(coach, "(ok say)")

    def _say(self, coach: Coach, text: str) -> None:
        """A message in the coaches' language: queued, if the rules allow."""
        stadium, speech = self._stadium, self._speech[coach.side]
        server = stadium.settings.server
        message = read_message(text, server.say_coach_msg_size)
        if message is None:
            return stadium.send(coach, "(error could_not_parse_say)")
        playing = stadium.mode == PlayMode.play_on
        if message.kind == "freeform":
            if playing and not self._freeform_window():
                return stadium.send(coach, "(error cannot_say_freeform_while_playon)")
            if speech.freeform <= 0:
                return stadium.send(coach, "(error said_too_many_freeform_messages)")
            speech.freeform -= 1
        elif playing:
            limit = getattr(server, f"clang_{message.quota}_win")
            start, count = speech.windows.get(message.kind, (stadium.time, 0))
            if stadium.time - start >= server.clang_win_size:
                start, count = stadium.time, 0
            if count >= limit:
                return stadium.send(coach, f"(error said_too_many_{message.quota}_messages)")
            speech.windows[message.kind] = start, count + 1
        speech.waiting.append(Waiting(message, stadium.time))
        stadium.send(coach, "(ok say)")

    def _freeform_window(self) -> bool:
        """Whether play has gone on long enough for a free text."""
        server, passed = self._stadium.settings.server, self._stadium.time - int(self._stadium.world["last_play_on_start"])
        if passed <= server.freeform_wait_period or server.freeform_wait_period <= 0:
            return False
        return passed % server.freeform_wait_period < server.freeform_send_period

    # ------------------------------------------------------------------------------------------ time

    def deliver(self) -> None:
        """In a step, before anything moves: messages that are due reach the players of the team."""
        stadium, server = self._stadium, self._stadium.settings.server
        playing = stadium.mode == PlayMode.play_on
        for coach in stadium.coaches():
            coach.done = False
        for side, speech in self._speech.items():
            if not speech.waiting or not server.clang_mess_per_cycle:
                continue
            due = [item for item in speech.waiting if not playing or stadium.time - item.said >= server.clang_mess_delay]
            speech.waiting = [item for item in speech.waiting if item not in due]
            who = f"online_coach_{'left' if side == LEFT else 'right'}"
            for message, _ in due:
                for player in stadium.players():
                    if player.side == side:
                        heard = message.text if message.is_understood(player.clang) else "(unsupported_clang)"
                        stadium.send(player, f"(hear {stadium.time} {who} {heard})")

    def count_time(self) -> None:
        """After a step: another allowance of free texts for every normal game length."""
        server, time = self._stadium.settings.server, self._stadium.time
        length = server.nr_normal_halfs * server.half_cycles
        if self._stadium.stoppage == 0 and time > 0 and length > 0 and time % length == 0:
            for side in self._speech:
                self._speech[side].freeform += server.say_coach_cnt_max
                self._old_says[side] += server.say_coach_cnt_max


def _object(coach: Coach, unum: int) -> int:
    return unum if coach.side == LEFT else PLAYERS_PER_TEAM + unum


def _speaker(coach: Coach) -> str:
    return f"online_coach_{'left' if coach.side == LEFT else 'right'}"


def _include_text(text: str) -> str:
    return f"(include {len(text.encode('latin-1', 'replace'))} {text})" if text else ""


def graphic_text(letter: str, x: int, y: int, lines: tuple[str, ...]) -> str:
    """A tile as monitors get it, without the last parenthesis, as the server sends it."""
    rows = " ".join(f'"{line}"' for line in lines)
    return f"(team_graphic_{letter} ({x} {y} {rows})"


def _tile_size(lines: tuple[str, ...]) -> tuple[int, int] | None:
    """Width and height of a picture in XPM, None when it is none."""
    head = lines[0].split() if lines else []
    if len(head) != 4 or not all(word.isascii() and word.isdigit() and len(word) < 4 for word in head):
        return None
    width, height, colours, characters = map(int, head)
    rows = lines[1 + colours :]
    if len(rows) != height or any(len(row) != width * characters for row in rows):
        return None
    return width, height
