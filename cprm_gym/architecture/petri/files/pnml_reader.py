"""PNML (ISO/IEC 15909-2), the exchange format of Petri nets: reading.

Plain place/transition nets of any tool load. Accepted beside the standard: inhibitor, test (read) and reset arcs in the spellings in
use (``type="inhibitor"``, ``<type value="inhibitor"/>``, ``<type><text>``, ``<arctype><text>``, ``<inhibitorArc>``), ``<value>`` for
``<text>``, nets without pages, nested pages and reference nodes, PIPE's markings (``Default,1``), capacities and priorities, WoPeD's
subprocess pages, TAPAAL's components with shared places and transitions, and our own extensions. Whatever is not understood is refused
with its element and line (`pnml_words.py`): an arc of an unknown kind taken for an ordinary one would be a different net. What the
standard lets a reader ignore is ignored, with one `FormatWarning` per file that names it: ``toolspecific`` of other tools, remarks, and
names where two nodes have the same (their ids are used); graphics never have a meaning.

Files come from strangers; `pnml_tree.py` parses them. Our own extensions are in `pnml_block.py`, writing is in `pnml_writer.py`.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from ....errors import FormatError, FormatWarning, did_you_mean
from ....files import read_bounded
from ..net.net import PetriNet
from .pnml_block import net_from_block
from .pnml_parts import RawPlace, RawTransition, build_net
from .pnml_tree import MAX_BYTES, TOOL, Node, parse_xml
from .pnml_words import Words

_NET_TYPES = re.compile(
    r"(.*/)?(ptnetb?|pt-net|p/t net|place/transition( net)?|epnml(-[\d.]+)?|pnmlcoremodel|coremodel|corenet|tpn)?", re.IGNORECASE
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
_LABELLED = frozenset(
    ("initialMarking", "capacity", "type", "timed", "rate", "priority", "infiniteServer", "inscription", "arctype", "weight")
)


def read_pnml(path: str | Path, *, net: str | None = None, rates: Literal["refuse", "plain"] = "refuse", block: bool = True) -> PetriNet:
    """Read one net from a PNML file.

    Parameters
    ----------
    path : path
    net : str, optional
        Id or name of the net, for files with several. Nets that share places or transitions are read together, as the one net that
        they mean.
    rates : {"refuse", "plain"}
        Exponential transitions have no meaning here: refuse them, or read them as transitions that fire at any time.
    block : bool
        Use our own extensions if there are any; else read the plain part only.

    Raises
    ------
    FormatError
        For files that cannot be read and content that is not understood, with element and line.

    Warns
    -----
    FormatWarning
        When something was ignored that may mean something to another tool.
    """
    file = Path(path)
    return parse_pnml(read_bounded(file, MAX_BYTES), str(file), net=net, rates=rates, block=block)


def parse_pnml(
    data: bytes | str,
    source: str = "<text>",
    *,
    net: str | None = None,
    rates: Literal["refuse", "plain"] = "refuse",
    block: bool = True,
) -> PetriNet:
    """The net in a PNML document; see `read_pnml`."""
    words = Words(source)
    nets, shared = _parts(words, parse_xml(data, source))
    if net is not None:
        chosen = [n for n in nets if net in _called(n)]
        if len(chosen) != 1:
            known = [name for n in nets for name in _called(n)]
            what = "no net" if not chosen else f"{len(chosen)} nets"
            raise FormatError(f"{source}: holds {what} {net!r}.{did_you_mean(net, known)} It holds {', '.join(map(repr, known)) or 'none'}")
        found = _Reader(words, rates, block, shared, alone=True).net(chosen[0])
    elif shared:
        found = _Reader(words, rates, block, shared).system([n for n in nets if n.attributes.get("active", "true").lower() != "false"])
    elif len(nets) == 1:
        found = _Reader(words, rates, block).net(nets[0])
    else:
        raise FormatError(f"{source}: holds {len(nets)} nets, expected one; name one of {[n.attributes.get('id') for n in nets]}")
    if words.ignored:
        what = ", ".join(f"{name} ({count} times)" if count > 1 else name for name, count in words.ignored.items())
        warnings.warn(FormatWarning(f"{source}: ignored: {what}"), stacklevel=2)
    return found


def pnml_names(data: bytes | str, source: str = "<text>") -> tuple[str, ...]:
    """The ids of the nets in a PNML document."""
    return tuple(n.attributes.get("id", "") for n in _parts(Words(source), parse_xml(data, source))[0])


def _parts(words: Words, root: Node) -> tuple[list[Node], list[Node]]:
    """The nets of a document, and the places and transitions that they share."""
    if root.tag != "pnml":
        raise words.refuse(root, "a PNML document starts with <pnml>")
    parts = list(words.children(root))
    return [n for n in parts if n.tag == "net"], [n for n in parts if n.tag.startswith("shared-")]


def _called(net: Node) -> tuple[str, ...]:
    """Id and, if it is another, name of a ``<net>``."""
    label = net.first("name")
    given = (net.attributes.get("id", ""), net.attributes.get("name", ""), label.label() if label is not None else "")
    return tuple(dict.fromkeys(filter(None, given)))


class _Reader:
    """Turns the trees of nets into one `PetriNet`.

    Parameters
    ----------
    words : Words
        Checks elements, and makes the errors.
    rates : {"refuse", "plain"}
    block : bool
        Whether our own extensions are read.
    shared : list of Node
        The places and transitions that the nets of the document share.
    alone : bool
        One net of several is read: it must not use what is shared.
    """

    def __init__(self, words: Words, rates: str, block: bool, shared: list[Node] | None = None, alone: bool = False) -> None:
        self.words = words
        self.refuse = words.refuse
        self.rates = rates
        self.block = block
        self.shared: dict[str, Node] = {}
        for node in shared or ():
            name = node.attributes.get("name", "")
            if not name or name in self.shared:
                raise self.refuse(node, f"the name {name!r} is used twice" if name else "has no `name`")
            list(words.children(node))
            self.shared[name] = node
        self.alone = alone
        self.prefix = ""
        self.places: dict[str, RawPlace] = {}
        self.transitions: dict[str, RawTransition] = {}
        self.references: dict[str, tuple[str, Node]] = {}
        self.fused: dict[str, str] = {}
        self.arcs: list[Node] = []
        self.subprocess = False
        self.called: dict[str, str] = {}
        self.capacities: dict[str, int] = {}
        self.lost: Node | None = None

    # -- nets -----------------------------------------------------------------------------------------------------------------

    def net(self, root: Node) -> PetriNet:
        """The net under a ``<net>`` element."""
        self.read(root)
        own = [n for n in root.all("toolspecific") if n.attributes.get("tool") == TOOL] if self.block else []
        if not own:
            if self.lost is not None:
                raise self.refuse(
                    self.lost, "only says what our block at the net defines, and that is gone; read with block=False to do without"
                )
            for name, capacity in self.capacities.items():
                self.places[name].capacity = capacity
            return self.build(root, self.title(root))
        if len(own) > 1:
            raise self.refuse(own[1], "our block stands twice")
        plain = self.build(root, self.title(root))
        capacities = {self.called[name]: capacity for name, capacity in self.capacities.items()}
        return net_from_block(own[0], plain, self.called, capacities, self.refuse)

    def system(self, roots: list[Node]) -> PetriNet:
        """The net that several nets with shared places and transitions mean together (TAPAAL's components)."""
        for name, node in self.shared.items():
            if node.tag == "shared-place":
                self.open_invariant(node)
                tokens = self.words.tokens(node, "a marking", node.attributes.get("initialMarking", "").strip())
                self.places[name] = RawPlace(node, name, tokens, None)
            else:
                self.transitions[name] = RawTransition(node, name, 0, 0, 1.0)
        for number, root in enumerate(roots):
            own = [n for n in root.all("toolspecific") if n.attributes.get("tool") == TOOL] if self.block else []
            if own:
                raise self.refuse(own[0], "our block is not read in files whose nets share places or transitions")
            self.prefix = f"{root.attributes.get('id') or number}."
            self.read(root)
        if self.lost is not None:
            raise self.refuse(self.lost, "is not read in files whose nets share places or transitions")
        for name, capacity in self.capacities.items():
            self.places[name].capacity = capacity
        if not roots:
            raise FormatError(f"{self.words.source}: every net is inactive")
        return self.build(roots[0], "net" if len(roots) > 1 else self.title(roots[0]))

    def read(self, root: Node) -> None:
        """Gather everything under one ``<net>`` element."""
        self.check_type(root)
        self.arcs, self.references = [], {}
        self.collect(root)
        for key, (_, node) in list(self.references.items()):
            target = self.follow(key, node)
            if (target in self.places) != (node.tag == "referencePlace"):
                raise self.refuse(node, f"refers to {node.attributes['ref']!r}, which is of the other kind")
        for node in self.arcs:
            self.arc(node)

    def check_type(self, net: Node) -> None:
        """Refuse a ``<net>`` of another type than place/transition nets."""
        kind = net.attributes.get("type", "")
        if not _NET_TYPES.fullmatch(kind.strip()):
            raise self.refuse(net, f"net type {kind[:80]!r} is not a place/transition net")

    def build(self, root: Node, title: str) -> PetriNet:
        """The value of what was read."""
        net, self.called = build_net(self.words, self.places, self.transitions, root, title)
        return net

    def title(self, root: Node) -> str:
        """What the net is called."""
        return self.name_of(root) if root.attributes.get("id") else "net"

    def collect(self, parent: Node) -> None:
        """Gather the nodes and arcs of a net or page, and of the pages in it."""
        for node in self.words.children(parent):
            if node.tag in ("page", "net"):
                if node.tag == "net":  # WoPeD writes the net of a subprocess into its page
                    self.check_type(node)
                    self.subprocess = True
                self.collect(node)
            elif node.tag == "place":
                self.place(node)
            elif node.tag == "transition":
                self.transition(node)
            elif node.tag in ("arc", "inhibitorArc"):
                self.arcs.append(node)
            elif node.tag in ("referencePlace", "referenceTransition"):
                list(self.words.children(node))
                target = node.attributes.get("ref")
                if not target:
                    raise self.refuse(node, "has no `ref`")
                self.references[self.identity(node)] = (self.prefix + target, node)

    def identity(self, node: Node) -> str:
        """The id of a node, checked to be new."""
        name = node.attributes.get("id", "")
        if not name:
            raise self.refuse(node, "has no `id`")
        key = self.prefix + name
        taken = (key in self.places and not (self.subprocess and node.tag == "place")) or key in self.transitions
        if taken or key in self.references or key in self.fused:
            raise self.refuse(node, f"the id {name!r} is used twice")
        return key

    def common(self, node: Node, key: str) -> bool:
        """Whether a node is one of those that several nets share; its id then means that one."""
        name = self.name_of(node)
        there = self.shared.get(name)
        if there is None:
            return False
        if there.tag != f"shared-{node.tag}":
            raise self.refuse(node, f"has the name of a <{there.tag}>")
        if self.alone:
            raise self.refuse(node, f"{name!r} is shared by several nets of this file; read them together, without naming a net")
        self.fused[key] = name
        return True

    # -- nodes ----------------------------------------------------------------------------------------------------------------

    def labels(self, node: Node) -> Iterator[tuple[Node, str]]:
        """The labels of a node that mean something, and what they say."""
        for child in self.words.children(node):
            if child.tag in _LABELLED:
                yield child, self.words.label(child)
            elif child.tag == "delay":
                yield child, ""

    def open_invariant(self, node: Node) -> None:
        """Refuse a bound on the age of tokens."""
        if node.attributes.get("invariant", "< inf").replace(" ", "") != "<inf":
            raise self.refuse(node, f"invariant {node.attributes['invariant'][:40]!r}: ages of tokens are not read here")

    def place(self, node: Node) -> None:
        """Read one place."""
        key = self.identity(node)
        said = [(node, node.attributes["initialMarking"].strip())] if "initialMarking" in node.attributes else []
        capacity = None
        self.open_invariant(node)
        for child, text in self.labels(node):
            if child.tag == "initialMarking":
                said.append((child, text))
            elif child.tag == "capacity" and text:
                capacity = self.words.tokens(child, "a capacity", text) or None
            elif child.tag == "type" and text.lower() not in ("", "place", "normal"):
                raise self.refuse(child, f"places of type {text[:40]!r} are not read here")
        if len(said) > 1:
            raise self.refuse(node, "its marking is given twice, in an attribute and an element")
        tokens = self.words.tokens(said[0][0], "a marking", said[0][1]) if said else 0
        hinted = self.hint(node, "capacity")
        if self.common(node, key):
            shared = self.places[self.fused[key]]
            if tokens not in (0, shared.tokens) or capacity is not None or hinted:
                raise self.refuse(node, f"differs from the shared place {shared.name!r} with {shared.tokens} tokens")
        elif key in self.places:  # the place at the border of a subprocess
            if (tokens, capacity) not in ((0, None), (self.places[key].tokens, self.places[key].capacity)):
                raise self.refuse(node, f"differs from the place of the same id in line {self.places[key].node.line}")
        else:
            self.places[key] = RawPlace(node, self.prefix + self.name_of(node), tokens, capacity)
            if hinted:
                self.capacities[key] = hinted

    def transition(self, node: Node) -> None:
        """Read one transition."""
        key = self.identity(node)
        timed, rate, priority = False, 1.0, 0
        if node.attributes.get("urgent", "false").strip().lower() != "false":
            raise self.refuse(node, "is urgent: that it must fire before time passes cannot be said of an untimed net")
        for child, text in self.labels(node):
            if child.tag == "timed":
                timed = self.words.truth(child, "<timed>", text)
            elif child.tag == "priority":
                priority = self.words.number(child, "a priority", text)
            elif child.tag == "delay" and not _is_any_time(child):
                raise self.refuse(child, "delays of other tools have no fixed meaning; ours are in <toolspecific>")
            elif child.tag == "rate":
                rate = self.words.real(child, "a rate", text)
                if rate <= 0:
                    raise self.refuse(child, f"a rate is more than 0, got {text[:80]!r}")
            elif child.tag == "type" and text.lower() not in ("", "and", "normal", "transition"):
                raise self.refuse(child, f"transitions of type {text[:40]!r} are not read here; write one transition for each choice")
        if timed and self.rates == "refuse":
            raise self.refuse(
                node, "is exponentially timed, and exponential rates have no meaning here; read with rates='plain' to drop them"
            )
        if timed or self.rates == "plain":
            rate, priority = 1.0, 0
        delay, priority = self.hint(node, "delay"), self.hint(node, "priority", priority)
        if self.common(node, key):
            if delay or priority or timed or rate != 1.0:
                raise self.refuse(node, f"says more than the shared transition {self.name_of(node)!r}")
            return
        self.transitions[key] = RawTransition(node, self.prefix + self.name_of(node), delay, priority, rate)

    def hint(self, node: Node, tag: str, default: int = 0) -> int:
        """A number that our own ``toolspecific`` on a node gives."""
        if not self.block:
            return default
        for tool in node.all("toolspecific"):
            if tool.attributes.get("tool") != TOOL:
                continue
            for part in tool.children:
                if part.tag not in ("kind", "capacity", "delay", "priority", "command"):
                    raise self.refuse(part, "is not understood in our extensions; known: capacity, command, delay, kind, priority")
                if part.tag in ("kind", "command") and self.lost is None:
                    self.lost = part
            found = tool.first(tag)
            if found is not None:
                text = self.words.label(found)
                if tag == "priority" and text.startswith("-"):
                    return -self.words.number(found, "a priority", text[1:])
                return self.words.number(found, f"a {tag}", text)
        return default

    def name_of(self, node: Node) -> str:
        """The name label of a node, or its id."""
        label = node.first("name")
        text = label.label() if label is not None else node.attributes.get("name", "")
        return re.sub(r"\s*[\r\n\t]+\s*", " ", text).strip() or node.attributes["id"]

    # -- arcs -----------------------------------------------------------------------------------------------------------------

    def follow(self, key: str, node: Node) -> str:
        """The place or transition that an id means, through reference nodes."""
        seen: set[str] = set()
        while key in self.references:
            if key in seen:
                raise self.refuse(self.references[key][1], f"refers to itself through {', '.join(sorted(seen))}")
            seen.add(key)
            key = self.references[key][0]
        for passed in seen:
            self.references[passed] = (key, self.references[passed][1])
        key = self.fused.get(key, key)
        if key not in self.places and key not in self.transitions:
            raise self.refuse(node, f"{key.removeprefix(self.prefix)!r} is neither a place nor a transition of this net")
        return key

    def end(self, node: Node, which: str) -> str:
        """The place or transition at one end of an arc."""
        name = node.attributes.get(which, "")
        key = self.prefix + name
        if key not in self.places and key not in self.transitions and key not in self.references and key not in self.fused:
            raise self.refuse(node, f"{which} {name!r} is neither a place nor a transition")
        return self.follow(key, node)

    def arc(self, node: Node) -> None:
        """Read one arc into its transition."""
        kind, weight = self.arc_labels(node)
        source, target = self.end(node, "source"), self.end(node, "target")
        if (source in self.places) == (target in self.places):
            raise self.refuse(node, f"joins {source!r} and {target!r}; an arc joins a place and a transition")
        into = source in self.places
        place, t = (source, self.transitions[target]) if into else (target, self.transitions[source])
        if kind in ("inhibitor", "test", "reset") and not into:
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

    def arc_labels(self, node: Node) -> tuple[str, int]:
        """Kind and weight of an arc, said once each."""
        kinds = [node.attributes["type"].strip()] if "type" in node.attributes else []
        weights = [(node, node.attributes["weight"].strip())] if "weight" in node.attributes else []
        for child, text in self.labels(node):
            if child.tag in ("type", "arctype"):
                kinds.append(text)
            elif text:
                weights.append((child, text))
        ages = node.attributes.get("inscription", "").replace(" ", "")
        if ages and ages != "[0,inf)":
            if "[" in ages or "(" in ages:
                raise self.refuse(
                    node, f"inscription {ages[:40]!r}: ages of tokens are not read here, nor arcs of type {', '.join(kinds) or 'normal'}"
                )
            weights.append((node, ages))
        kinds = ["normal" if ages == "[0,inf)" and kind == "timed" else kind.lower().rpartition("#")[2] for kind in kinds]
        kinds += ["inhibitor"] if node.tag == "inhibitorArc" else []
        found = set()
        for kind in kinds or [""]:
            if kind not in _ARC_TYPES:
                raise self.refuse(node, f"arcs of type {kind!r} are not read here; known: normal, inhibitor, test, read, reset")
            found.add(_ARC_TYPES[kind])
        amounts = {self.words.tokens(at, "an inscription", text) for at, text in weights}
        if node.attributes.get("weight") and ages == "1":  # TAPAAL writes both, and means the weight
            amounts = {self.words.tokens(node, "a weight", node.attributes["weight"].strip())}
        if len(found) > 1 or len(amounts) > 1:
            raise self.refuse(node, f"says several things: {', '.join(map(str, (*sorted(found), *sorted(amounts))))}")
        return found.pop(), amounts.pop() if amounts else 1


def _is_any_time(delay: Node) -> bool:
    """Whether a ``<delay>`` of Tina is the interval from 0 to infinity: no condition on time."""
    interval = delay.first("interval")
    if interval is None or len(delay.children) > 1 or delay.text.strip() or interval.attributes.get("closure", "closed").startswith("open"):
        return False
    return [child.text.strip() for child in interval.children] == ["0", "infty"]
