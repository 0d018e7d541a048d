"""PNML (ISO/IEC 15909-2): which elements and attributes are understood where, and the numbers in them.

Everything else is refused with its element and line. What the standard lets a reader ignore (``toolspecific`` of other tools) is counted in
`Words.ignored`, of which the reader warns.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping

from ....errors import FormatError, did_you_mean
from ..net.checks import MAX_WEIGHT
from .pnml_tree import TOOL, Node

_PICTURE = frozenset(("graphics", "orientation", "arcpath", "tagged", "labels", "label", "token"))
"""Elements that say where something is drawn; the standard gives them no meaning."""
_REMARKS = frozenset(("toolspecific", "documentation", "comment", "description", "finalmarkings"))
"""Elements that a reader may leave aside, and is told of."""
_FRAME = ("page", "place", "transition", "arc", "inhibitorArc", "referencePlace", "referenceTransition", "name")

CHILDREN: Mapping[str, frozenset[str]] = {
    "pnml": frozenset(("net", "name", "shared-place", "shared-transition")),
    "net": frozenset(_FRAME),
    "page": frozenset((*_FRAME, "net")),
    "place": frozenset(("name", "initialMarking", "capacity", "type")),
    "transition": frozenset(("name", "timed", "rate", "priority", "delay", "type", "infiniteServer")),
    "arc": frozenset(("name", "inscription", "type", "arctype", "weight")),
    "inhibitorArc": frozenset(("name", "inscription", "weight")),
    "referencePlace": frozenset(("name",)),
    "referenceTransition": frozenset(("name",)),
    "shared-place": frozenset(),
    "shared-transition": frozenset(),
}
"""Element -> the children that mean something to the reader."""

ASIDE: Mapping[str, frozenset[str]] = {
    "pnml": frozenset(("constant", "queries", "query", "k-bound", "feature")),
    "net": frozenset(("definition", "variables", "rateDefinition")),
}
"""Element -> further children that do not change the net; a name that they define is not understood where it is used."""

_LAYOUT = ("x", "y", "positionX", "positionY", "angle", "displayName", "nameOffsetX", "nameOffsetY", "markingOffsetX", "markingOffsetY")
ATTRIBUTES: Mapping[str, frozenset[str]] = {
    "pnml": frozenset(("id",)),
    "net": frozenset(("id", "name", "type", "active")),
    "page": frozenset(("id", "name")),
    "place": frozenset(("id", "name", "initialMarking", "invariant", *_LAYOUT)),
    "transition": frozenset(("id", "name", "urgent", "infiniteServer", "priority", "player", *_LAYOUT)),
    "arc": frozenset(("id", "name", "source", "target", "type", "weight", "inscription", *_LAYOUT)),
    "inhibitorArc": frozenset(("id", "name", "source", "target", "weight", *_LAYOUT)),
    "referencePlace": frozenset(("id", "name", "ref", *_LAYOUT)),
    "referenceTransition": frozenset(("id", "name", "ref", *_LAYOUT)),
    "shared-place": frozenset(("name", "initialMarking", "invariant", *_LAYOUT)),
    "shared-transition": frozenset(("name", "urgent", "player", *_LAYOUT)),
}
"""Element -> its attributes that are understood."""

_DEFAULTS = {"priority": "0", "player": "0", "urgent": "false"}
"""Attributes of other tools that are read where they say nothing: with the value they have by default."""


class Words:
    """Checks elements and reads labels of one document.

    Parameters
    ----------
    source : str
        What the errors call it.
    """

    def __init__(self, source: str) -> None:
        self.source = source
        self.ignored: Counter[str] = Counter()

    def refuse(self, node: Node, why: str) -> FormatError:
        """The error for `node`."""
        return FormatError(f"{self.source}, line {node.line}, <{node.tag}>: {why}")

    def children(self, node: Node) -> Iterator[Node]:
        """The children of `node` that mean something, after a check of everything else on it.

        Raises
        ------
        FormatError
            For an attribute, a child or a text that is not understood.
        """
        self.attributes(node, ATTRIBUTES[node.tag])
        if node.text.strip():
            raise self.refuse(node, f"the text {node.text.strip()[:40]!r} is not understood here")
        known = CHILDREN[node.tag]
        aside = ASIDE.get(node.tag, frozenset())
        once = node.tag not in ("pnml", "net", "page")
        seen: set[str] = set()
        for child in node.children:
            if child.namespace:
                raise self.refuse(child, f"is of the namespace {child.namespace!r}, which is not understood inside <{node.tag}>")
            if child.tag in known:
                if child.tag in seen and (once or child.tag == "name"):
                    raise self.refuse(child, f"stands twice inside <{node.tag}>")
                seen.add(child.tag)
                yield child
            elif child.tag in _REMARKS or child.tag in aside:
                self.leave(child)
            elif child.tag not in _PICTURE:
                listed = f"Known: {', '.join(sorted(known)) or 'none'}"
                raise self.refuse(child, f"is not understood inside <{node.tag}>.{did_you_mean(child.tag, known)} {listed}")

    def leave(self, node: Node) -> None:
        """Note that `node` is left aside."""
        if node.tag == "toolspecific":
            tool = node.attributes.get("tool", "")
            if tool != TOOL:
                self.ignored[f"<toolspecific> of {tool!r}"] += 1
        else:
            self.ignored[f"<{node.tag}>"] += 1

    def attributes(self, node: Node, known: frozenset[str]) -> None:
        """Refuse attributes that are not known, or have another value than the one that says nothing."""
        for key, value in node.attributes.items():
            if key not in known:
                listed = f"Known: {', '.join(sorted(known)) or 'none'}"
                raise self.refuse(node, f"the attribute {key}={value[:40]!r} is not understood.{did_you_mean(key, known)} {listed}")
            if key in _DEFAULTS and value.strip().lower() != _DEFAULTS[key]:
                raise self.refuse(node, f"{key}={value[:40]!r} has no meaning here; only {_DEFAULTS[key]!r} is read")

    def label(self, node: Node) -> str:
        """The content of a label, once it is known that nothing else stands in it.

        Raises
        ------
        FormatError
            When it has a child beside ``<text>``, ``<value>``, ``<graphics>`` and ``<toolspecific>``, or says two things.
        """
        self.attributes(node, frozenset(("value",)))
        contents = [node.attributes["value"].strip()] if "value" in node.attributes else []
        contents += [node.text.strip()] if node.text.strip() else []
        for child in node.children:
            if child.tag in ("text", "value") and not child.namespace:
                self.attributes(child, frozenset())
                if child.children:
                    raise self.refuse(child.children[0], f"is not understood inside <{child.tag}>, which holds text")
                contents.append(child.text.strip())
            elif child.tag == "toolspecific" and not child.namespace:
                self.leave(child)
            elif child.tag != "graphics" or child.namespace:
                raise self.refuse(child, f"is not understood inside <{node.tag}>. Known: text, value")
        if len(contents) > 1:
            raise self.refuse(node, f"says several things: {', '.join(repr(c[:40]) for c in contents[:4])}")
        return contents[0] if contents else ""

    def number(self, node: Node, what: str, text: str) -> int:
        """The whole number from 0 that `text` is."""
        if not re.fullmatch(r"\+?[0-9]{1,20}", text) and not re.fullmatch(r"-[0-9]{1,20}", text):
            raise self.refuse(node, f"{what} is a whole number, got {text[:80]!r}")
        value = int(text)
        if not 0 <= value <= MAX_WEIGHT:
            raise self.refuse(node, f"{what} is 0 to {MAX_WEIGHT}, got {value}")
        return value

    def real(self, node: Node, what: str, text: str) -> float:
        """The finite number that `text` is."""
        if not re.fullmatch(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,3})?", text) or len(text) > 400:
            raise self.refuse(node, f"{what} is a number, got {text[:80]!r}")
        return float(text)

    def truth(self, node: Node, what: str, text: str) -> bool:
        """Whether `text` says yes."""
        if text.lower() not in ("true", "false", "1", "0", ""):
            raise self.refuse(node, f"{what} is true or false, got {text[:80]!r}")
        return text.lower() in ("true", "1")

    def tokens(self, node: Node, what: str, text: str) -> int:
        """The number of tokens that `text` is, also written ``Default,1`` as PIPE does; 0 for none."""
        if "," not in text:
            return self.number(node, what, text) if text else 0
        parts = [p.strip() for p in text.split(",")]
        amounts = [self.number(node, what, p) for p in parts[1::2]]
        if len(parts) % 2 or sum(a > 0 for a in amounts) > 1 or (parts[0].lower() != "default" and amounts[0]):
            raise self.refuse(node, f"{what} {text[:80]!r}: coloured tokens are not read here")
        return amounts[0]
