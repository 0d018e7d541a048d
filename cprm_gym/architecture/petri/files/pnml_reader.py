"""PNML (ISO/IEC 15909-2), the exchange format of Petri nets: reading.

Plain place/transition nets of any tool load. Accepted beside the standard: inhibitor, test (read) and reset arcs in the spellings in
use (``type="inhibitor"``, ``<type value="inhibitor"/>``, ``<type><text>``, ``<arctype><text>``, ``<inhibitorArc>``), ``<value>`` for
``<text>``, nets without pages, nested pages and reference nodes, PIPE's markings (``Default,1``), capacities and priorities, WoPeD's
subprocess pages, and our own extensions. Whatever is not understood is refused with its element and line: an arc of an unknown kind
taken for an ordinary one would be a different net.

Files come from strangers; `pnml_tree.py` parses them. Our own extensions are in `pnml_block.py`, writing is in `pnml_writer.py`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from ....errors import FormatError, NetError
from ...expressions import CONSTANTS, FUNCTIONS
from ..net.net import PetriNet
from ..net.places import MAX_WEIGHT, AnyPlace, Place, Transition
from .pnml_block import net_from_block
from .pnml_tree import TOOL, Node, parse_xml

_NET_TYPES = re.compile(r"^$|ptnet|tina/tpn|P/T net|p/t net|place/transition|epnml|pt-?net|corenet|core(model)?$", re.IGNORECASE)
_IGNORED = frozenset(
    ("name", "graphics", "toolspecific", "documentation", "comment", "description", "labels", "label", "token", "definition")
    + ("orientation", "arcpath", "tagged", "infiniteServer", "rateDefinition", "finalmarkings", "variables")
)
_ARC_TYPES = {
    "normal": "normal",
    "": "normal",
    "ptarc": "normal",
    "standard": "normal",
    "inhibitor": "inhibitor",
    "tapninhibitor": "inhibitor",
    "inhibit": "inhibitor",
    "test": "test",
    "read": "test",
    "reset": "reset",
}


def read_pnml(path: str | Path, *, net: str | None = None, rates: Literal["refuse", "plain"] = "refuse", block: bool = True) -> PetriNet:
    """Read one net from a PNML file.

    Parameters
    ----------
    path : path
    net : str, optional
        Id of the net, for files with several.
    rates : {"refuse", "plain"}
        Exponential transitions have no meaning here: refuse them, or read them as transitions that fire at any time.
    block : bool
        Use our own extension block if there is one; else read the plain part only.

    Raises
    ------
    FormatError
        For files that cannot be read and content that is not understood, with element and line.
    """
    file = Path(path)
    try:
        data = file.read_bytes()
    except OSError as error:
        raise FormatError(f"{file}: cannot be read: {error.strerror}") from None
    return parse_pnml(data, str(file), net=net, rates=rates, block=block)


def parse_pnml(
    data: bytes | str,
    source: str = "<text>",
    *,
    net: str | None = None,
    rates: Literal["refuse", "plain"] = "refuse",
    block: bool = True,
) -> PetriNet:
    """The net in a PNML document; see `read_pnml`."""
    root = parse_xml(data, source)
    if root.tag != "pnml":
        raise FormatError(f"{source}, line {root.line}, <{root.tag}>: a PNML document starts with <pnml>")
    nets = root.all("net")
    if net is not None:
        chosen = [n for n in nets if n.attributes.get("id") == net]
        if not chosen:
            raise FormatError(f"{source}: no net {net!r}; it holds {', '.join(repr(n.attributes.get('id')) for n in nets) or 'none'}")
        nets = chosen
    if len(nets) != 1:
        raise FormatError(f"{source}: holds {len(nets)} nets, expected one; name one of {[n.attributes.get('id') for n in nets]}")
    return _Reader(source, rates).net(nets[0], block)


@dataclass
class RawPlace:
    """A place as the file has it."""

    node: Node
    name: str
    tokens: int
    capacity: int | None


@dataclass
class RawTransition:
    """A transition as the file has it."""

    node: Node
    name: str
    delay: int
    priority: int
    weight: float
    inputs: dict[str, int] = field(default_factory=dict)
    outputs: dict[str, int] = field(default_factory=dict)
    tests: dict[str, int] = field(default_factory=dict)
    inhibitors: dict[str, int] = field(default_factory=dict)
    sets: dict[str, int] = field(default_factory=dict)


class _Reader:
    """Turns the tree of one net into a `PetriNet`."""

    def __init__(self, source: str, rates: str) -> None:
        self.source = source
        self.rates = rates
        self.places: dict[str, RawPlace] = {}
        self.transitions: dict[str, RawTransition] = {}
        self.references: dict[str, tuple[str, Node]] = {}
        self.arcs: list[tuple[Node, bool]] = []
        self.subprocess = False
        self.called: dict[str, str] = {}
        self.capacities: dict[str, int] = {}

    def refuse(self, node: Node, why: str) -> FormatError:
        """The error for `node`."""
        return FormatError(f"{self.source}, line {node.line}, <{node.tag}>: {why}")

    def net(self, root: Node, block: bool) -> PetriNet:
        """The net under a ``<net>`` element."""
        kind = root.attributes.get("type", "")
        if not _NET_TYPES.search(kind):
            raise self.refuse(root, f"net type {kind!r} is not a place/transition net")
        self.collect(root, top=True)
        for node, inhibitor in self.arcs:
            self.arc(node, "inhibitor" if inhibitor else None)
        own = [n for n in root.all("toolspecific") if n.attributes.get("tool") == TOOL]
        if not block or not own:
            for name, capacity in self.capacities.items():
                self.places[name].capacity = capacity if block else None
            return self.build(root)
        plain = self.build(root)
        capacities = {self.called[name]: capacity for name, capacity in self.capacities.items()}
        return net_from_block(own[0], plain, self.called, capacities, self.refuse)

    def collect(self, parent: Node, top: bool = False) -> None:
        """Gather the nodes and arcs of a net or page, and of the pages in it."""
        for node in parent.children:
            if node.tag == "page":
                inner = node.first("net")
                if inner is not None:  # WoPeD writes the net of a subprocess here
                    self.subprocess = True
                    self.collect(inner)
                else:
                    self.collect(node)
            elif node.tag == "place":
                self.place(node)
            elif node.tag == "transition":
                self.transition(node)
            elif node.tag in ("arc", "inhibitorArc"):
                self.arcs.append((node, node.tag == "inhibitorArc"))
            elif node.tag in ("referencePlace", "referenceTransition"):
                target = node.attributes.get("ref")
                if not target:
                    raise self.refuse(node, "has no `ref`")
                self.references[self.identity(node)] = (target, node)
            elif node.tag not in _IGNORED:
                raise self.refuse(node, "is not part of a place/transition net as read here")

    def identity(self, node: Node) -> str:
        """The id of a node, checked to be new."""
        name = node.attributes.get("id", "")
        if not name:
            raise self.refuse(node, "has no `id`")
        if (name in self.places and not self.subprocess) or name in self.transitions or name in self.references:
            raise self.refuse(node, f"the id {name!r} is used twice")
        return name

    def children(self, node: Node, known: frozenset[str]) -> Iterator[Node]:
        """The children that mean something; others are refused."""
        for child in node.children:
            if child.tag in known:
                yield child
            elif child.tag not in _IGNORED:
                raise self.refuse(child, f"is not understood inside <{node.tag}>; known: {', '.join(sorted(known))}")

    def number(self, node: Node, what: str, text: str | None = None) -> int:
        """A whole number from 0 in a label."""
        content = node.label() if text is None else text
        try:
            value = int(content)
        except ValueError:
            raise self.refuse(node, f"{what} is a whole number, got {content!r}") from None
        if not 0 <= value <= MAX_WEIGHT:
            raise self.refuse(node, f"{what} is 0 to {MAX_WEIGHT}, got {value}")
        return value

    def tokens(self, node: Node, what: str, text: str | None = None) -> int:
        """A number of tokens, also written ``Default,1`` as PIPE does; in a label, or the `text` of an attribute."""
        for child in node.children if text is None else ():
            if child.tag not in ("text", "value", "graphics", "toolspecific"):
                raise self.refuse(child, f"is not understood inside <{node.tag}>; known: text, value")
        content = node.label() if text is None else text
        if "," not in content:
            return self.number(node, what, content) if content else 0
        parts = [p.strip() for p in content.split(",")]
        amounts = [self.number(node, what, p) for p in parts[1::2]]
        if len(parts) % 2 or sum(a > 0 for a in amounts) > 1 or (parts[0].lower() != "default" and amounts[0]):
            raise self.refuse(node, f"{what} {content!r}: coloured tokens are not read here")
        return amounts[0]

    def place(self, node: Node) -> None:
        """Read one place."""
        name = self.identity(node)
        if name in self.places:
            return
        tokens, capacity = self.tokens(node, "a marking", node.attributes.get("initialMarking", "")), None
        if node.attributes.get("invariant", "< inf").replace(" ", "") != "<inf":
            raise self.refuse(node, f"invariant {node.attributes['invariant']!r}: ages of tokens are not read here")
        for child in self.children(node, frozenset(("initialMarking", "capacity", "type"))):
            if child.tag == "initialMarking":
                tokens = self.tokens(child, "a marking")
            elif child.tag == "capacity":
                limit = child.label()
                capacity = (self.number(child, "a capacity") or None) if limit else None
        if hinted := self.hint(node, "capacity"):
            self.capacities[name] = hinted
        self.places[name] = RawPlace(node, self.name_of(node), tokens, capacity)

    def transition(self, node: Node) -> None:
        """Read one transition."""
        name = self.identity(node)
        timed, rate, priority = False, 1.0, 0
        if node.attributes.get("urgent", "false").lower() == "true":
            raise self.refuse(node, "is urgent: that it must fire before time passes cannot be said of an untimed net")
        for child in self.children(node, frozenset(("timed", "rate", "priority", "delay", "type"))):
            text = child.label()
            if child.tag == "timed":
                timed = text.lower() in ("true", "1")
            elif child.tag == "priority":
                priority = self.number(child, "a priority")
            elif child.tag == "delay" and not _is_any_time(child):
                raise self.refuse(child, "delays of other tools have no fixed meaning; ours are in <toolspecific>")
            elif child.tag == "rate":
                try:
                    rate = float(text)
                except ValueError:
                    raise self.refuse(child, f"a rate is a number, got {text!r}") from None
        if timed and self.rates == "refuse":
            raise self.refuse(
                node, "is exponentially timed, and exponential rates have no meaning here; read with rates='plain' to drop them"
            )
        if timed or self.rates == "plain":
            rate, priority = 1.0, 0
        delay = self.hint(node, "delay")
        priority = self.hint(node, "priority", priority)
        self.transitions[name] = RawTransition(node, self.name_of(node), delay, priority, rate if rate > 0 else 1.0)

    def hint(self, node: Node, tag: str, default: int = 0) -> int:
        """A number that our own ``toolspecific`` on a node gives."""
        for tool in node.all("toolspecific"):
            found = tool.first(tag) if tool.attributes.get("tool") == TOOL else None
            if found is not None:
                try:
                    return int(found.label())
                except ValueError:
                    raise self.refuse(found, f"is a whole number, got {found.label()!r}") from None
        return default

    def name_of(self, node: Node) -> str:
        """The name label of a node, or its id."""
        label = node.first("name")
        text = label.label() if label is not None else node.attributes.get("name", "")
        return re.sub(r"\s*[\r\n\t]+\s*", " ", text).strip() or node.attributes["id"]

    def resolve(self, node: Node, end: str) -> str:
        """The id that an end of an arc means, through reference nodes."""
        name = node.attributes.get(end, "")
        seen: set[str] = set()
        while name in self.references:
            if name in seen:
                raise self.refuse(self.references[name][1], f"refers to itself through {', '.join(sorted(seen))}")
            seen.add(name)
            name = self.references[name][0]
        if name not in self.places and name not in self.transitions:
            raise self.refuse(node, f"{end} {name!r} is neither a place nor a transition")
        return name

    def arc(self, node: Node, kind: str | None) -> None:
        """Read one arc into its transition."""
        source, target = self.resolve(node, "source"), self.resolve(node, "target")
        weight = self.number(node, "a weight", node.attributes.get("weight", "1"))
        spelled = node.attributes.get("type", "")
        if spelled == "timed" and node.attributes.get("inscription", "[0,inf)").replace(" ", "") == "[0,inf)":
            spelled = "normal"
        for child in self.children(node, frozenset(("inscription", "type", "arctype", "weight"))):
            if child.tag in ("type", "arctype"):
                spelled = child.label()
            elif child.label():
                weight = self.tokens(child, "an inscription")
        kind = kind or _ARC_TYPES.get(spelled.lower().rpartition("#")[2])
        if kind is None:
            raise self.refuse(node, f"arcs of type {spelled!r} are not read here; known: normal, inhibitor, test, read, reset")
        if (source in self.places) == (target in self.places):
            raise self.refuse(node, f"joins {source!r} and {target!r}; an arc joins a place and a transition")
        into = source in self.places
        place, t = (source, self.transitions[target]) if into else (target, self.transitions[source])
        if kind in ("inhibitor", "test") and not into:
            raise self.refuse(node, f"an arc of type {kind} goes from a place to a transition")
        if weight < 1 and kind != "reset":
            raise self.refuse(node, "an inscription is at least 1, got 0")
        if kind == "normal":
            arcs = t.inputs if into else t.outputs
            arcs[place] = arcs.get(place, 0) + weight
        elif kind == "inhibitor":
            t.inhibitors[place] = min(weight, t.inhibitors.get(place, weight))
        elif kind == "test":
            t.tests[place] = max(weight, t.tests.get(place, 0))
        else:
            t.sets[place] = 0

    def build(self, root: Node) -> PetriNet:
        """The value of what was read."""
        names = _names({key: p.name for key, p in self.places.items()})
        called = _names({key: t.name for key, t in self.transitions.items()})
        self.called = {**names, **called}
        node = root
        try:
            places: list[AnyPlace] = []
            for key, p in self.places.items():
                node = p.node
                places.append(Place(names[key], capacity=p.capacity, tokens=p.tokens))
            transitions = []
            for key, t in self.transitions.items():
                node = t.node
                inputs, outputs, tests, inhibitors, sets = (
                    {names[p]: w for p, w in arcs.items()} for arcs in (t.inputs, t.outputs, t.tests, t.inhibitors, t.sets)
                )
                transitions.append(
                    Transition(
                        called[key],
                        inputs,
                        outputs,
                        tests=tests,
                        inhibitors=inhibitors,
                        sets=sets,
                        delay=t.delay,
                        priority=t.priority,
                        weight=t.weight,
                        set_wins=bool(t.sets),
                    )
                )
            node = root
            title = self.name_of(root) if root.attributes.get("id") else "net"
            return PetriNet(_word(title, set()), tuple(places), tuple(transitions))
        except NetError as error:
            raise self.refuse(node, str(error)) from None


def _is_any_time(delay: Node) -> bool:
    """Whether a ``<delay>`` of Tina is the interval from 0 to infinity: no condition on time."""
    interval = delay.first("interval")
    if interval is None:
        return False
    ends = [child.text.strip() for child in interval.children]
    return ends == ["0", "infty"]


def _names(labels: dict[str, str]) -> dict[str, str]:
    """Id -> name in our nets: the name labels if they are all different, else the ids; words of the expression language get a ``_``."""
    distinct = len(set(labels.values())) == len(labels)
    used: set[str] = set()
    return {key: _word(name if distinct else key, used) for key, name in labels.items()}


def _word(text: str, used: set[str]) -> str:
    """`text` as a legal, unused name; added to `used`."""
    name = "".join(c if c.isprintable() else "_" for c in text).strip()[:190] or "_"
    while name in used or name in FUNCTIONS or name in CONSTANTS:
        name += "_"
    used.add(name)
    return name
