"""The coaches' language as far as a server needs it: of which kind a message is, who understands it (specification/protocol.md 7).

What an advice or a definition says is for the players; the server looks at the form only: balanced lists with the words that begin them.
"""

from __future__ import annotations

import re
from typing import NamedTuple

LONGEST, DEEPEST = 2048, 16
"""Characters, and lists in lists, that a message may have."""
_TOKEN = re.compile(r'\s*(\(|\)|\{|\}|"[^"]*"|[^\s(){}"]+)')
_KINDS = {"freeform": (7, 8), "advice": (7,), "info": (7,), "meta": (7,), "define": (8,), "rule": (8,), "delete": (8,)}
"""Versions of the language that know each kind."""
_DEFINERS = {"definec", "defined", "definer", "definea", "definerule"}
_REGIONS = {"pt", "arc", "tri", "quad", "rec", "reg", "null"}
_Tree = list["str | _Tree"]


class Message(NamedTuple):
    """A message of a coach."""

    kind: str
    """``freeform``, ``advice``, ``info``, ``meta``, ``define``, ``rule`` or ``delete``."""
    text: str
    """As players hear it."""

    @property
    def quota(self) -> str:
        """The word that the error of too many such messages has."""
        return "del" if self.kind == "delete" else self.kind

    def is_understood(self, versions: tuple[int, int] | None) -> bool:
        """Whether a player who declared to know `versions`, lowest and highest, understands it."""
        return versions is not None and any(versions[0] <= version <= versions[1] for version in _KINDS[self.kind])


def read_message(text: str, longest_freeform: int = 128) -> Message | None:
    """The message in ``(say MESSAGE)``, None when it is none.

    Parameters
    ----------
    text : str
        The whole command.
    longest_freeform : int
        Characters that a free text may have (``say_coach_msg_size``).
    """
    tree = _read(text)
    if tree is None or len(tree) != 2 or tree[0] != "say" or not isinstance(tree[1], list) or not tree[1]:
        return None
    message = tree[1]
    kind = message[0]
    if not isinstance(kind, str) or kind not in _KINDS or len(message) < 2:
        return None
    if not _CHECKS[kind](message[1:], longest_freeform):
        return None
    return Message(kind, _text(message))


def _read(text: str) -> _Tree | None:
    """The first list of a text as nested lists of words; braces are lists that begin with a brace."""
    if len(text) > LONGEST:
        return None
    stack: list[_Tree] = [[]]
    at = 0
    while True:
        found = _TOKEN.match(text, at)
        if found is None:
            return None
        at, token = found.end(), found[1]
        if token in "({":
            if len(stack) > DEEPEST:
                return None
            stack.append(["{"] if token == "{" else [])
        elif token in ")}":
            if len(stack) == 1 or (stack[-1][:1] == ["{"]) != (token == "}"):
                return None
            done = stack.pop()
            stack[-1].append(done)
            if len(stack) == 1:
                return done
        elif len(stack) == 1:
            return None
        else:
            stack[-1].append(token)


def _text(tree: str | _Tree) -> str:
    if isinstance(tree, str):
        return tree
    if tree[:1] == ["{"]:
        return "{" + " ".join(map(_text, tree[1:])) + "}"
    return "(" + " ".join(map(_text, tree)) + ")"


def _is_string(item: str | _Tree) -> bool:
    return isinstance(item, str) and len(item) > 2 and item.startswith('"')


def _is_number(item: str | _Tree) -> bool:
    return isinstance(item, str) and re.fullmatch(r"[+-]?\d+(\.\d+)?", item) is not None


def _freeform(items: _Tree, longest: int) -> bool:
    return len(items) == 1 and _is_string(items[0]) and len(items[0]) - 2 <= longest


def _tokens(items: _Tree, longest: int) -> bool:
    """``(N CONDITION DIRECTIVE...)`` or ``(clear)``, one or more."""
    return all(isinstance(item, list) and (item == ["clear"] or _token(item)) for item in items)


def _token(item: _Tree) -> bool:
    return len(item) > 2 and _is_number(item[0]) and isinstance(item[1], (list, str)) and all(map(_directive, item[2:]))


def _directive(item: str | _Tree) -> bool:
    """``(do our {2} ACTION...)`` or a name."""
    if isinstance(item, str):
        return _is_string(item)
    return len(item) > 3 and item[0] in ("do", "dont") and item[1] in ("our", "opp") and isinstance(item[2], list)


def _definitions(items: _Tree, longest: int) -> bool:
    return all(
        isinstance(item, list)
        and len(item) > 2
        and item[0] in _DEFINERS
        and _is_string(item[1])
        and not (item[0] == "definea" and isinstance(item[2], list) and item[2][0] in _REGIONS)
        for item in items
    )


def _meta(items: _Tree, longest: int) -> bool:
    return all(isinstance(item, list) and len(item) == 2 and item[0] == "ver" and _is_number(item[1]) for item in items)


def _names(item: str | _Tree) -> bool:
    return isinstance(item, str) and (item == "all" or not item.startswith('"'))


def _rule(items: _Tree, longest: int) -> bool:
    return all(isinstance(item, list) and len(item) == 2 and item[0] in ("on", "off") for item in items)


def _delete(items: _Tree, longest: int) -> bool:
    return len(items) == 1 and (isinstance(items[0], list) or _names(items[0]))


_CHECKS = {
    "freeform": _freeform,
    "advice": _tokens,
    "info": _tokens,
    "meta": _meta,
    "define": _definitions,
    "rule": _rule,
    "delete": _delete,
}
