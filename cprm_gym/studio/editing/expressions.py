"""Whether an expression can stand where it is being typed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ...architecture.expressions import FUNCTIONS, Expression
from ...architecture.petri.net.net import resolve_name
from ...errors import ExpressionError, did_you_mean, unknown_name
from .net_parts import readable


def check_expression(form: Mapping[str, Any], definition: str, text: str, candidate: str = "") -> dict[str, Any]:
    """Check a text by the parser of the architecture, and its names by the places of a definition.

    Parameters
    ----------
    form : dict
        A net's JSON form.
    definition : str
    text : str
    candidate : str
        In a selection, the name by which the candidate goes.

    Returns
    -------
    dict
        ``ok``; ``error`` and ``at``, the column of the mistake; ``names`` that it reads; ``known``, all that it might read.
    """
    definitions = form["definitions"]
    if definition not in definitions:
        raise unknown_name("definition", definition, definitions)
    scope = readable(definitions[definition], definitions)

    def unknown(name: str) -> str:
        if candidate and name.startswith(f"{candidate}."):
            return ""
        place, attribute = resolve_name(name, scope)
        if not place:
            return f"unknown place {name!r}.{did_you_mean(name, scope)}".strip()
        return f"{name!r}: an attribute has one part, got {attribute!r}" if "." in attribute else ""

    return _checked(text, sorted(scope), unknown)


def check_text(text: str, names: Iterable[str]) -> dict[str, Any]:
    """The same for an expression that reads these names and no others."""
    known = list(names)
    return _checked(text, known, lambda name: "" if name in known else f"unknown parent {name!r}.{did_you_mean(name, known)}".strip())


def _checked(text: str, known: list[str], unknown: Callable[[str], str]) -> dict[str, Any]:
    """What the parser says of a text, and `unknown` of each name: why it cannot stand there."""
    answer: dict[str, Any] = {"ok": False, "error": "", "at": 0, "names": [], "known": known, "functions": sorted(FUNCTIONS)}
    try:
        expression = Expression(text)
    except ExpressionError as error:
        message = str(error)
        caret = re.search(r"\n {4}( *)\^$", message)
        return {**answer, "error": message.partition("\n")[0], "at": len(caret[1]) if caret else 0}
    answer["names"] = list(expression.names)
    for node in sorted((n for n in expression.tree.walk() if n.op == "name"), key=lambda n: n.at):
        if wrong := unknown(node.name):
            return {**answer, "error": wrong, "at": node.at}
    return {**answer, "ok": True}
