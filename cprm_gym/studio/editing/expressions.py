"""Whether an expression can stand where it is being typed."""

from __future__ import annotations

import re
from collections.abc import Mapping
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
    known = sorted(scope)
    answer: dict[str, Any] = {"ok": False, "error": "", "at": 0, "names": [], "known": known, "functions": sorted(FUNCTIONS)}
    try:
        expression = Expression(text)
    except ExpressionError as error:
        message = str(error)
        caret = re.search(r"\n {4}( *)\^$", message)
        return {**answer, "error": message.partition("\n")[0], "at": len(caret[1]) if caret else 0}
    answer["names"] = list(expression.names)
    for node in sorted((n for n in expression.tree.walk() if n.op == "name"), key=lambda n: n.at):
        if candidate and node.name.startswith(f"{candidate}."):
            continue
        place, attribute = resolve_name(node.name, scope)
        if not place:
            return {**answer, "error": f"unknown place {node.name!r}.{did_you_mean(node.name, known)}".strip(), "at": node.at}
        if "." in attribute:
            return {**answer, "error": f"{node.name!r}: an attribute has one part, got {attribute!r}", "at": node.at}
    return {**answer, "ok": True}
