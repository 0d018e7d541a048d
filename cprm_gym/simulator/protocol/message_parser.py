"""Reading the server's messages to a player back: see, sense_body, hear (specification/protocol.md 5), long and short names."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from ...errors import FormatError

_TOKEN = re.compile(r'[()]|"[^"]*"|[^\s()"]+')
_KINDS = {"b": "ball", "g": "goal", "f": "flag", "p": "player", "l": "line"}
_LONG = {"ball": "b", "goal": "g", "flag": "f", "player": "p", "line": "l"}
_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
DEEPEST = 8
"""Lists in lists that a message may have; no message of the server has more than three."""
_Tree = list["str | _Tree"]


class SeenObject(NamedTuple):
    """One object of a see message; None where the message tells nothing. Angles are degrees, as on the wire."""

    kind: str
    """``ball``, ``player``, ``flag``, ``goal`` or ``line``."""
    name: str
    """Short name without the kind's letter: ``"c t"``, ``"r"``; empty for ball and players."""
    close: bool = False
    """Only felt: no name is told."""
    team: str | None = None
    unum: int | None = None
    goalie: bool = False
    distance: float | None = None
    direction: int = 0
    distance_change: float | None = None
    direction_change: float | None = None
    body: int | None = None
    head: int | None = None
    pointing: int | None = None
    tackling: bool = False
    kicking: bool = False


class SeeMessage(NamedTuple):
    """A see message."""

    time: int
    objects: tuple[SeenObject, ...]


class HearMessage(NamedTuple):
    """A hear message."""

    time: int
    sender: str
    """``referee``, ``coach``, ``online_coach_left``, ``online_coach_right``, ``self``, ``our``, ``opp``, or ``player`` (before 8)."""
    direction: int | None = None
    unum: int | None = None
    message: str | None = None
    """None when only told that somebody spoke."""


def _tree(text: str, head: str) -> _Tree:
    """The message as nested lists of words; its head must be `head`."""
    stack: list[_Tree] = [[]]
    for token in _TOKEN.findall(text):
        if token == "(":
            if len(stack) > DEEPEST:
                raise FormatError(f"not a {head} message, lists in lists more than {DEEPEST} deep: {text[:60]!r}")
            stack.append([])
        elif token == ")":
            if len(stack) == 1:
                raise FormatError(f"not a {head} message, one ')' too many: {text[:60]!r}")
            done = stack.pop()
            stack[-1].append(done)
        else:
            stack[-1].append(token)
    if len(stack) != 1 or len(stack[0]) != 1 or not isinstance(stack[0][0], list) or stack[0][0][:1] != [head]:
        raise FormatError(f"not a ({head} ...) message: {text[:60]!r}")
    return stack[0][0]


def parse_see(text: str) -> SeeMessage:
    """Read a see message of any protocol version.

    Raises
    ------
    FormatError
        When it is none.
    """
    items = _tree(text, "see")
    try:
        return SeeMessage(_whole(_word(items[1])), tuple(_object(item) for item in items[2:]))
    except (ValueError, IndexError, KeyError, TypeError) as error:
        raise FormatError(f"malformed see message ({str(error)[:100]}): {text[:60]!r}") from None


def _word(item: str | _Tree) -> str:
    if not isinstance(item, str):
        raise ValueError(f"a word was expected, not {str(item)[:40]}")
    return item


def _object(item: str | _Tree) -> SeenObject:
    if not isinstance(item, list) or not isinstance(item[0], list):
        raise ValueError(f"an object was expected, not {str(item)[:40]}")
    name, told = [_word(part) for part in item[0]], [_word(part) for part in item[1:]]
    letter = _LONG.get(name[0].lower(), name[0].lower())
    kind, close = _KINDS[letter], name[0][0].isupper()
    marks = {"tackling": told[-1] == "t", "kicking": told[-1] == "k"}
    numbers = [_real(number) for number in (told[:-1] if any(marks.values()) else told)]
    if len(numbers) == 1:
        distance, rest = None, numbers
    else:
        distance, rest = numbers[0], numbers[1:]
    direction = int(rest[0])
    if kind != "player":
        changes: list[float | None] = [*rest[1:]] or [None, None]
        return SeenObject(
            kind, " ".join(name[1:]), close, distance=distance, direction=direction, distance_change=changes[0],
            direction_change=changes[1],
        )  # fmt: skip
    team = name[1].strip('"') if len(name) > 1 else None
    unum = _whole(name[2]) if len(name) > 2 else None
    more: list[float | None] = list(rest[1:])
    pointing = more.pop() if len(more) in (1, 5) else None
    change, turn, body, head = more + [None] * (4 - len(more))
    return SeenObject(
        kind, "", close, team, unum, name[3:] == ["goalie"], distance, direction, change, turn, _int(body), _int(head),
        _int(pointing), **marks,
    )  # fmt: skip


def _real(word: str) -> float:
    """A finite number as the server prints it."""
    if not _NUMBER.fullmatch(word) or not math.isfinite(number := float(word)):
        raise ValueError(f"a finite number was expected, not {word[:20]!r}")
    return number


def _whole(word: str) -> int:
    if not word.isascii() or not word.removeprefix("-").isdigit():
        raise ValueError(f"a whole number was expected, not {word[:20]!r}")
    return int(word)


def _int(value: float | None) -> int | None:
    return None if value is None else int(value)


def parse_sense_body(text: str) -> dict[str, tuple[str | float, ...]]:
    """Read a sense_body message: what stands in each list, numbers as numbers; the time under ``time``.

    Lists in lists have names with a dot: ``arm.movable``, ``tackle.expires``.

    Raises
    ------
    FormatError
        When it is none.
    """
    items = _tree(text, "sense_body")
    if len(items) < 2 or not isinstance(items[1], str):
        raise FormatError(f"malformed sense_body message: {text[:60]!r}")
    told: dict[str, tuple[str | float, ...]] = {"time": (_value(items[1]),)}
    for item in items[2:]:
        lists = [part for part in item[1:] if isinstance(part, list)] if isinstance(item, list) else []
        if not isinstance(item, list) or any(not part or not isinstance(part[0], str) for part in (item, *lists)):
            raise FormatError(f"malformed sense_body message, a list with a name was expected, not {str(item)[:40]}: {text[:60]!r}")
        name = str(item[0])
        told[name] = tuple(_value(part) for part in item[1:] if isinstance(part, str))
        if name == "collision":
            told[name] += tuple(str(part[0]) for part in lists)
            continue
        for part in lists:
            told[f"{name}.{part[0]}"] = tuple(_value(word) for word in part[1:] if isinstance(word, str))
    return told


def _value(word: str) -> str | float:
    return float(word) if _NUMBER.fullmatch(word) and math.isfinite(float(word)) else word


_HEAR = re.compile(
    r"\(hear (?P<time>\d{1,9}) (?:(?P<by>referee|coach|online_coach_left|online_coach_right|self) (?P<rest>.+)"
    r'|(?:(?P<direction>-?\d{1,9}) )?(?:(?P<side>our|opp) ?)?(?P<unum>\d{1,9})? ?(?P<message>"[^"]*")?)\)',
    re.DOTALL | re.ASCII,
)
_OLD_HEAR = re.compile(r'\(hear (?P<time>\d{1,9}) (?P<direction>-?\d{1,9}) (?P<message>[^"]+)\)', re.DOTALL | re.ASCII)


def parse_hear(text: str) -> HearMessage:
    """Read a hear message of any protocol version; those before 7 have no quotes round what was said.

    Raises
    ------
    FormatError
        When it is none.
    """
    match = _HEAR.fullmatch(text)
    if match is None or (match["direction"] and not match["message"]):
        old = _OLD_HEAR.fullmatch(text)
        if old is None:
            raise FormatError(f"not a (hear ...) message: {text[:60]!r}")
        return HearMessage(int(old["time"]), "player", int(old["direction"]), message=old["message"])
    time = int(match["time"])
    if match["by"]:
        return HearMessage(time, match["by"], message=match["rest"].strip('"'))
    direction, unum = match["direction"], match["unum"]
    if not match["side"] and direction is None:
        raise FormatError(f"a hear message without sender: {text[:60]!r}")
    return HearMessage(
        time, match["side"] or "player", None if direction is None else int(direction), None if unum is None else int(unum),
        match["message"] and match["message"].strip('"'),
    )  # fmt: skip
