"""The text of players' and trainer's commands: the server's grammar read and written (specification/protocol.md 4 and 6).

`parse_commands` reads one datagram into commands in order; `command_record` turns one into a `COMMAND` record that the kernels
execute, `command_text` back. Reading stops at the first error, as in the server: what stands before it is executed, the rest
dropped.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import CommandError
from ..state import COMMAND, LEFT, RIGHT, SAY_SIZE, CommandKind, ViewWidth


class PlayerCommand(NamedTuple):
    """One command.

    ``name`` is the server's word, or one of ``dash_legs`` (powers and directions of left and right leg, NaN for a leg that is not
    named), ``pointto_off`` and ``attentionto_off``. Numbers are floats in the units of the protocol.
    """

    name: str
    args: tuple[Any, ...] = ()


class Parsed(NamedTuple):
    """What a datagram says: its commands up to the first error, and where that is (None: no error)."""

    commands: tuple[PlayerCommand, ...]
    error: int | None


_BLANK = re.compile(r"[ \t\r\n]*")
_NUMBER = re.compile(r"[+-]?(?:\d*\.\d+|\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_OPEN_NUMBER = re.compile(r"[+-]?\d+\.", re.ASCII)
_INTEGER = re.compile(r"[+-]?\d+\Z", re.ASCII)
_WORD = re.compile(r"[A-Za-z0-9_\-]+")
_STRING = re.compile(r'"[A-Za-z0-9 ().+\-*/?<>_]+"')
_SAY = re.compile(r"\(say ([A-Za-z0-9 ().+\-*/?<>_]+)\)")
_WIDTHS = {"narrow": ViewWidth.NARROW, "normal": ViewWidth.NORMAL, "wide": ViewWidth.WIDE}
_QUALITIES = {"high": 1, "low": 2}
_BOOLEANS = {"true": True, "on": True, "false": False, "off": False}
_TEAMS = ("our", "opp", "l", "left", "r", "right")
_EAR_MODES = {"p": "partial", "partial": "partial", "c": "complete", "complete": "complete"}
_PLAIN = {"synch_see", "gaussian_see", "sense_body", "score", "done", "bye"}
_NUMBERS = {"turn": 1, "turn_neck": 1, "kick": 2, "catch": 1, "move": 2, "change_focus": 2, "long_kick": 2}
_KEYWORDS = (
    {"dash", "tackle", "change_view", "say", "pointto", "attentionto", "ear", "clang", "ver", "compression", "off", "on"}
    | _PLAIN
    | set(_NUMBERS)
    | set(_WIDTHS)
    | set(_QUALITIES)
    | set(_BOOLEANS)
    | set(_TEAMS)
    | set(_EAR_MODES)
)


class _Mistake(Exception):
    """The text leaves the grammar at position ``at``; `done`, if any, is what the server has executed of the command by then."""

    def __init__(self, at: int, done: PlayerCommand | None = None) -> None:
        self.at, self.done = at, done


class _Lexer:
    """Tokens of a datagram: longest match, blanks between them skipped."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0

    def peek(self) -> tuple[str, str]:
        """Kind (``(``, ``)``, number, word, string, end) and text of the next token, which is not consumed."""
        found = _BLANK.match(self.text, self.at)
        assert found is not None
        self.at = found.end()
        if self.at == len(self.text):
            return "end", ""
        first = self.text[self.at]
        if first in "()":
            return first, first
        string = self._longest(_STRING) if first == '"' else ""
        word = self._longest(_WORD)
        number = "" if first.isalpha() else self._longest(_NUMBER)
        if not (string or word or number):
            raise _Mistake(self.at)
        if string:
            return "string", string
        return ("word", word) if len(word) > len(number) else ("number", number)

    def _longest(self, pattern: re.Pattern[str]) -> str:
        """What of the text here is of a pattern."""
        found = pattern.match(self.text, self.at)
        return found[0] if found is not None else ""

    def take(self, *kinds: str) -> str:
        """The text of the next token, which must be of one of `kinds`."""
        kind, text = self.peek()
        if kind not in kinds:
            raise _Mistake(self.at)
        self.at += len(text)
        return text

    def number(self) -> float:
        """A number; integers are read by C's ``atoi``, reals too large for a double are the largest one."""
        text = self.take("number")
        if _INTEGER.match(text):
            return float(_atoi(text))
        return _finite(text)

    def integer(self) -> int:
        """A number without point and exponent."""
        start = self.at
        text = self.take("number")
        if not _INTEGER.match(text):
            raise _Mistake(start)
        return _atoi(text)

    def choice(self, words: Any) -> str:
        """One of `words`."""
        kind, text = self.peek()
        if kind != "word" or text not in words:
            raise _Mistake(self.at)
        return self.take("word")

    def team(self) -> str:
        """``our``, ``opp``, ``l``, ``r``, or a name with a leading ``=`` so that it cannot be taken for one of those.

        Quotes belong to the name, which no team has then: the server looks for it as it stands.
        """
        kind, text = self.peek()
        if kind == "string":
            return "=" + self.take("string")
        if kind == "word" and text in _TEAMS:
            return {"left": "l", "right": "r"}.get(self.take("word"), text)
        if kind == "number" and _WORD.fullmatch(text) is None:
            raise _Mistake(self.at)
        if kind not in ("word",) or text in _KEYWORDS:
            raise _Mistake(self.at)
        return "=" + self.take("word")


def _atoi(text: str) -> int:
    """C's ``atoi`` on a machine with 64-bit long: saturated to 64 bits, then cut to 32."""
    sign, digits = (-1 if text.startswith("-") else 1), text.lstrip("+-").lstrip("0")
    read = sign * int(digits or "0") if len(digits) < 20 else sign * 2**63
    value = max(-(2**63), min(read, 2**63 - 1)) & 0xFFFFFFFF
    return value - 2**32 if value >= 2**31 else value


def parse_commands(text: str) -> Parsed:
    """Read a player's datagram.

    Parameters
    ----------
    text : str
        ``(dash 100 30)(turn_neck 10)`` and the like, without the final NUL.

    Returns
    -------
    Parsed
        The commands before the first error, and the position of the error or None. The server answers an error with
        ``(error illegal_command_form)`` after executing the commands.
    """
    lexer = _Lexer(text.rstrip("\0"))
    commands: list[PlayerCommand] = []
    try:
        while lexer.peek()[0] != "end":
            commands.append(_command(lexer))
    except _Mistake as mistake:
        return Parsed((*commands, mistake.done) if mistake.done else tuple(commands), mistake.at)
    return Parsed(tuple(commands), None)


def _command(lexer: _Lexer) -> PlayerCommand:
    """One command in its parentheses."""
    said = _SAY.match(lexer.text, lexer.at)
    if said:
        lexer.at = said.end()
        return PlayerCommand("say", (said[1],))
    lexer.take("(")
    start = lexer.at
    name = lexer.take("word")
    if name in _PLAIN:
        args: tuple[Any, ...] = ()
    elif name in _NUMBERS:
        args = tuple(lexer.number() for _ in range(_NUMBERS[name]))
    elif name in _SPECIAL:
        name, args = _SPECIAL[name](lexer)
    else:
        raise _Mistake(start)
    command = PlayerCommand(name, args)
    try:
        lexer.take(")")
    except _Mistake as mistake:
        raise _Mistake(mistake.at, command if name == "dash_legs" else None) from None
    return command


def _dash(lexer: _Lexer) -> tuple[str, tuple[Any, ...]]:
    if lexer.peek()[0] == "number":
        power = lexer.number()
        return "dash", (power, lexer.number() if lexer.peek()[0] == "number" else 0.0)
    legs: dict[str, tuple[float, float]] = {}
    try:
        while not legs or (len(legs) < 2 and lexer.peek()[0] == "("):
            leg, way = _leg(lexer, legs)
            legs[leg] = way
    except _Mistake as mistake:
        # a leg has been moved when its list ends, whatever follows
        raise _Mistake(mistake.at, PlayerCommand("dash_legs", _both(legs)) if legs else None) from None
    return "dash_legs", _both(legs)


def _leg(lexer: _Lexer, legs: Mapping[str, object]) -> tuple[str, tuple[float, float]]:
    """``(l 50 0)``: which leg, that none of `legs` is, power and direction."""
    lexer.take("(")
    start = lexer.at
    leg = lexer.choice(("l", "left", "r", "right"))[0]
    if leg in legs:
        raise _Mistake(start)
    way = lexer.number(), lexer.number()
    lexer.take(")")
    return leg, way


def _both(legs: Mapping[str, tuple[float, float]]) -> tuple[float, float, float, float]:
    """Powers and directions of left and right leg."""
    missing = math.nan, math.nan
    return legs.get("l", missing) + legs.get("r", missing)


def _tackle(lexer: _Lexer) -> tuple[str, tuple[Any, ...]]:
    angle = lexer.number()
    return "tackle", (angle, lexer.peek()[0] == "word" and _BOOLEANS[lexer.choice(_BOOLEANS)])


def _change_view(lexer: _Lexer) -> tuple[str, tuple[Any, ...]]:
    width = _WIDTHS[lexer.choice(_WIDTHS)]
    return "change_view", (width, _QUALITIES[lexer.choice(_QUALITIES)] if lexer.peek()[0] == "word" else 0)


def _say(lexer: _Lexer) -> tuple[str, tuple[Any, ...]]:
    return "say", (lexer.take("string")[1:-1],)


def _pointto(lexer: _Lexer) -> tuple[str, tuple[Any, ...]]:
    if lexer.peek()[0] == "word":
        lexer.choice(("off",))
        return "pointto_off", ()
    return "pointto", (lexer.number(), lexer.number())


def _attentionto(lexer: _Lexer) -> tuple[str, tuple[Any, ...]]:
    if lexer.peek() == ("word", "off"):
        lexer.take("word")
        return "attentionto_off", ()
    return "attentionto", (lexer.team(), lexer.integer())


def _ear(lexer: _Lexer) -> tuple[str, tuple[Any, ...]]:
    lexer.take("(")
    on = lexer.choice(("on", "off")) == "on"
    team: str | None = None
    mode: str | None = None
    kind, text = lexer.peek()
    if kind != ")" and text not in _EAR_MODES:
        team = lexer.team()
    if lexer.peek()[0] != ")":
        mode = _EAR_MODES[lexer.choice(_EAR_MODES)]
    lexer.take(")")
    return "ear", (on, team, mode)


def _clang(lexer: _Lexer) -> tuple[str, tuple[Any, ...]]:
    lexer.take("(")
    lexer.choice(("ver",))
    versions = lexer.integer(), lexer.integer()
    lexer.take(")")
    return "clang", versions


def _compression(lexer: _Lexer) -> tuple[str, tuple[Any, ...]]:
    return "compression", (lexer.integer(),)


_SPECIAL = {
    "dash": _dash,
    "tackle": _tackle,
    "change_view": _change_view,
    "say": _say,
    "pointto": _pointto,
    "attentionto": _attentionto,
    "ear": _ear,
    "clang": _clang,
    "compression": _compression,
}

_NOTHING = np.zeros((), COMMAND)
for _name in ("a", "b", "c", "d", "turn_neck", "focus", "point"):
    _NOTHING[_name] = np.nan
_NUMERIC_KINDS = {
    "dash": CommandKind.DASH,
    "turn": CommandKind.TURN,
    "kick": CommandKind.KICK,
    "tackle": CommandKind.TACKLE,
    "catch": CommandKind.CATCH,
    "move": CommandKind.MOVE,
    "dash_legs": CommandKind.DASH_LEGS,
}


def nothing() -> npt.NDArray[Any]:
    """A `COMMAND` array of shape (1,) that says nothing."""
    return np.array([_NOTHING])


def side_of_team(team: str, own: int, names: tuple[str, str]) -> int | None:
    """Side (+1, -1) that a team in a command means, None if there is no such team.

    Parameters
    ----------
    team : str
        ``our``, ``opp``, ``l``, ``r``, or ``=`` and a name.
    own : int
        Side of the player who says it.
    names : two str
        Names of the left and the right team.
    """
    if team.startswith("="):
        return {names[0]: LEFT, names[1]: RIGHT}.get(team[1:]) if team[1:] else None
    return {"our": own, "opp": -own, "l": LEFT, "r": RIGHT}.get(team)


def command_record(command: PlayerCommand, own: int = LEFT, names: tuple[str, str] = ("Left", "Right")) -> npt.NDArray[Any] | None:
    """A `COMMAND` array of shape (1,) for `command`, or None for one that a record does not hold or that has no effect.

    Parameters
    ----------
    command : PlayerCommand
    own : int
        Side of the player, +1 or -1.
    names : two str
        Names of the teams, for ``attentionto``.
    """
    name, args = command
    record = nothing()
    if name in _NUMERIC_KINDS:
        record["kind"] = _NUMERIC_KINDS[name]
        for field, value in zip("abcd", args):
            record[field] = value
    elif name == "turn_neck":
        record["turn_neck"] = args[0]
    elif name == "change_view":
        record["view_width"], record["view_quality"] = args
    elif name == "change_focus":
        record["focus"] = args
    elif name == "pointto":
        record["point"] = args
    elif name == "pointto_off":
        record["point"] = np.inf
    elif name == "attentionto_off":
        record["attention_side"] = 3
    elif name == "attentionto":
        side = side_of_team(args[0], own, names)
        if side is None or not 1 <= args[1] <= 11:
            return None
        record["attention_side"], record["attention_unum"] = (1 if side == own else 2), args[1]
    elif name == "say" and 0 < len(args[0]) <= SAY_SIZE:
        data = args[0].encode("ascii")
        record["say_length"] = len(data)
        record["say"][0, : len(data)] = np.frombuffer(data, np.uint8)
    else:
        return None
    return record


def _n(value: float) -> str:
    """A number of the grammar that reads back as `value`."""
    if not math.isfinite(value):
        raise CommandError(f"commands take finite numbers, got {value!r}")
    return str(int(value)) if value == int(value) and abs(value) < 2**31 else repr(float(value))


def format_command(command: PlayerCommand) -> str:
    """The text of `command` in the server's grammar; `parse_commands` reads it back.

    Raises
    ------
    CommandError
        For a command that cannot be said: not finite, unknown, or a text with characters that say does not take.
    """
    name, args = command
    if name in _PLAIN:
        return f"({name})"
    if name in ("pointto_off", "attentionto_off"):
        return f"({name.removesuffix('_off')} off)"
    if name == "dash_legs":
        legs = [f"({leg} {_n(args[i])} {_n(args[i + 1])})" for leg, i in (("l", 0), ("r", 2)) if not math.isnan(args[i])]
        if not legs:
            raise CommandError("a dash with legs takes at least one leg, got none")
        return f"(dash {' '.join(legs)})"
    if name == "dash":
        return f"(dash {_n(args[0])})" if args[1] == 0 else f"(dash {_n(args[0])} {_n(args[1])})"
    if name == "tackle":
        return f"(tackle {_n(args[0])} on)" if args[1] else f"(tackle {_n(args[0])})"
    if name == "say":
        if not _STRING.fullmatch(f'"{args[0]}"'):
            raise CommandError(f"say takes letters, digits, blanks and ().+-*/?<>_, got {args[0]!r}")
        return f'(say "{args[0]}")'
    if name == "change_view":
        width = {value: word for word, value in _WIDTHS.items()}[ViewWidth(int(args[0]))]
        return f"(change_view {width})" if not args[1] else f"(change_view {width} {'high' if args[1] == 1 else 'low'})"
    if name == "attentionto":
        return f"(attentionto {_team_text(args[0])} {args[1]})"
    if name == "ear":
        words = ["on" if args[0] else "off"] + ([_team_text(args[1])] if args[1] else []) + ([args[2]] if args[2] else [])
        return f"(ear ({' '.join(words)}))"
    if name == "clang":
        return f"(clang (ver {args[0]} {args[1]}))"
    if name in _NUMBERS or name in ("pointto", "compression"):
        return f"({name} {' '.join(_n(value) for value in args)})"
    raise CommandError(f"unknown command {name!r}")


def _team_text(team: str) -> str:
    return team.removeprefix("=")


def command_text(record: Any) -> str:
    """The text of a `COMMAND` record: its body command first, then the free ones. Empty when it says nothing.

    A command with numbers that are not finite cannot be said, and the simulator ignores it: it is left out.
    """
    commands = []
    kinds = {kind: name for name, kind in _NUMERIC_KINDS.items()}
    kind = int(record["kind"])
    if kind:
        name = kinds[CommandKind(kind)]
        count = {"dash": 2, "kick": 2, "tackle": 2, "move": 2, "dash_legs": 4}.get(name, 1)
        commands.append(PlayerCommand(name, tuple(float(record[field]) for field in "abcd"[:count])))
    if not math.isnan(record["turn_neck"]):
        commands.append(PlayerCommand("turn_neck", (float(record["turn_neck"]),)))
    if record["view_width"] != ViewWidth.KEEP:
        commands.append(PlayerCommand("change_view", (int(record["view_width"]), int(record["view_quality"]))))
    if not math.isnan(record["focus"][0]):
        commands.append(PlayerCommand("change_focus", tuple(map(float, record["focus"]))))
    if math.isinf(record["point"][0]):
        commands.append(PlayerCommand("pointto_off"))
    elif not math.isnan(record["point"][0]):
        commands.append(PlayerCommand("pointto", tuple(map(float, record["point"]))))
    if record["attention_side"] == 3:
        commands.append(PlayerCommand("attentionto_off"))
    elif record["attention_side"]:
        team = "our" if record["attention_side"] == 1 else "opp"
        commands.append(PlayerCommand("attentionto", (team, int(record["attention_unum"]))))
    if record["say_length"]:
        commands.append(PlayerCommand("say", (bytes(record["say"][: record["say_length"]]).decode("ascii"),)))
    return "".join(map(_said, commands))


def _said(command: PlayerCommand) -> str:
    try:
        return format_command(command)
    except CommandError:
        return ""


# --- the trainer

DEEPEST = 8
"""Lists in lists that a command of the trainer may have; no command has more than two."""
_ITEM = re.compile(r'\s*(\(|\)|"[^"]*"|[^\s()"]+)')


def parse_trainer(text: str) -> PlayerCommand:
    """One command of the trainer: ``(move (ball) 0 0)`` is ``("move", (("ball",), 0.0, 0.0))``.

    Words that are numbers become floats, nested lists tuples; ``say`` keeps its text as it is.

    Raises
    ------
    CommandError
        For a text that is not one parenthesised list.
    """
    text = text.rstrip("\0")
    if text.startswith("(say "):
        return PlayerCommand("say", (text[5:].removesuffix(")"),))
    stack: list[list[Any]] = [[]]
    at, end = 0, len(text.rstrip())
    while at < end:
        found = _ITEM.match(text, at)
        if not found:
            break
        at = found.end()
        word = found[1]
        if word == "(":
            if len(stack) > DEEPEST:
                raise CommandError(f"a trainer's command has lists in lists up to {DEEPEST} deep, got {text[:60]!r}")
            stack.append([])
        elif word == ")" and len(stack) > 1:
            done = tuple(stack.pop())
            stack[-1].append(done)
            if len(stack) == 1:
                break
        elif word != ")":
            stack[-1].append(_trainer_word(word))
    if len(stack) != 1 or not stack[0] or not isinstance(stack[0][0], tuple) or not stack[0][0]:
        raise CommandError(f"a trainer's command is one list in parentheses, got {text[:60]!r}")
    name, *args = stack[0][0]
    return PlayerCommand(str(name), tuple(args))


def _finite(text: str) -> float:
    """A real number; one too large for a double is the largest one."""
    return max(-sys.float_info.max, min(float(text), sys.float_info.max))


def _trainer_word(word: str) -> Any:
    if word.startswith('"'):
        return word[1:-1]
    return _finite(word) if _NUMBER.fullmatch(word) or _OPEN_NUMBER.fullmatch(word) else word
