"""The net: a frozen value, checked when it is written."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from ....errors import NetError, did_you_mean
from ...expressions import Expression
from .checks import check_name, shown
from .places import PLACE_KINDS, AnyPlace, Belief, Continuous, Input, Math, ObjectPlace, Place, Selection
from .ports import Ports
from .semantics import Semantics
from .transitions import Transition
from .values import FrozenMap

_KIND_NAMES = {Place: "discrete", Continuous: "continuous", Input: "input", Belief: "belief", Math: "math", ObjectPlace: "object"}


MAX_DEPTH = 64
"""Most levels of modules in modules."""
MAX_PARTS = 200_000
"""Most places and transitions that a hierarchy may have in all, unless another number is given where it is flattened."""


@dataclass(frozen=True, eq=False, repr=False)
class PetriNet:
    """A Petri net, or a module when it has ports.

    Parameters
    ----------
    name : str
    places : tuple of Place, Continuous, Input, Belief, Math, ObjectPlace
    transitions : tuple of Transition
    modules : mapping from instance name to PetriNet
        The ports of instance ``orient`` are then places of this net by the name ``orient.begin``.
    fuse : mapping from "instance.port" to place
        The port and that place of this net (or port of another instance) are one place, defined by the latter.
    ports : Ports
    semantics : Semantics
        Of the whole, when this net is the outermost.

    Attributes
    ----------
    depth : int
        Levels of modules below it; at most `MAX_DEPTH`.
    parts : int
        Places, transitions and modules of the whole hierarchy, each counted as often as it occurs.

    Raises
    ------
    NetError
        When anything in it does not fit; the message names the net, the part, what was given and the nearest allowed.
    """

    name: str
    places: tuple[AnyPlace, ...] = ()
    transitions: tuple[Transition, ...] = ()
    modules: Mapping[str, PetriNet] = field(default_factory=FrozenMap)
    fuse: Mapping[str, str] = field(default_factory=FrozenMap)
    ports: Ports = field(default_factory=Ports)
    semantics: Semantics = field(default_factory=Semantics)
    depth: int = field(init=False, default=0)
    parts: int = field(init=False, default=0)
    _hash: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        check_name(self.name, "net")
        where = f"net {self.name!r}"
        for key, what in (("places", "places"), ("transitions", "transitions")):
            object.__setattr__(self, key, _tuple(getattr(self, key), what, where))
        for key, what in (("modules", "instance name to net"), ("fuse", "port to place")):
            value = getattr(self, key)
            if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
                raise NetError(f"{where}: `{key}` takes a mapping from {what}, got {shown(value)}")
            object.__setattr__(self, key, FrozenMap(value))
        for part, cls in ((self.ports, Ports), (self.semantics, Semantics)):
            if not isinstance(part, cls):
                raise NetError(f"{where}: `{cls.__name__.lower()}` takes a {cls.__name__}, got {shown(part)}")
        try:
            _Check(self).run()
        except NetError as error:
            message = str(error)
            raise NetError(message if message.startswith(where) else f"{where}, {message}") from None
        inside = self.modules.values()
        object.__setattr__(self, "depth", 1 + max((m.depth for m in inside), default=-1))
        object.__setattr__(self, "parts", len(self.places) + len(self.transitions) + 1 + sum(m.parts for m in inside))
        everything = (self.name, self.places, self.transitions, self.modules, self.fuse, self.ports, self.semantics)
        object.__setattr__(self, "_hash", hash(everything))
        if self.depth > MAX_DEPTH:
            raise NetError(f"{where}: its modules are nested {self.depth} deep, more than {MAX_DEPTH}")

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PetriNet) and _equal(self, other, set())

    def __repr__(self) -> str:
        """What it holds; modules by their names alone."""
        parts = [f"{self.name!r}, places={self.places!r}, transitions={self.transitions!r}"]
        if self.modules:
            parts.append("modules={" + ", ".join(f"{instance!r}: {module.name}" for instance, module in self.modules.items()) + "}")
        parts += [f"fuse={self.fuse!r}"] if self.fuse else []
        parts += [f"{key}={part!r}" for key, part in (("ports", self.ports), ("semantics", self.semantics)) if part != type(part)()]
        return f"PetriNet({', '.join(parts)})"

    def place(self, name: str) -> AnyPlace:
        """The place of that name, own or port of an instance (``"orient.begin"``)."""
        known = {p.name: p for p in self.places} | self.port_places()
        if name not in known:
            raise NetError(f"net {self.name!r}: unknown place {name!r}.{did_you_mean(name, known)}")
        return known[name]

    def transition(self, name: str) -> Transition:
        """The transition of that name."""
        known = {t.name: t for t in self.transitions}
        if name not in known:
            raise NetError(f"net {self.name!r}: unknown transition {name!r}.{did_you_mean(name, known)}")
        return known[name]

    def port_places(self) -> dict[str, AnyPlace]:
        """``"instance.port"`` -> place as the module declares it, for every port of every instance."""
        found: dict[str, AnyPlace] = {}
        for instance, module in self.modules.items():
            own = {p.name: p for p in module.places}
            found.update({f"{instance}.{port}": own[port] for port in module.ports.all})
        return found


def _tuple(value: object, what: str, where: str) -> tuple[object, ...]:
    """`value`, a tuple or other collection of parts, as a tuple."""
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable):
        hint = "" if isinstance(value, (str, bytes, Mapping)) or value is None else "; write (part,) for one"
        raise NetError(f"{where}: `{what}` takes a tuple, got {shown(value)}{hint}")
    return tuple(value)


def _equal(a: PetriNet, b: PetriNet, seen: set[tuple[int, int]]) -> bool:
    """Whether two nets are equal; `seen` holds the pairs of modules found equal, each of which is compared once."""
    if a is b or (id(a), id(b)) in seen:
        return True
    if hash(a) != hash(b) or a.modules.keys() != b.modules.keys():
        return False
    own = all(getattr(a, key) == getattr(b, key) for key in ("name", "places", "transitions", "fuse", "ports", "semantics"))
    if own and all(_equal(a.modules[instance], b.modules[instance], seen) for instance in a.modules):
        seen.add((id(a), id(b)))
        return True
    return False


def check_size(net: PetriNet, limit: int, what: str) -> None:
    """Refuse a hierarchy of more than `limit` parts before anything is made of it.

    Raises
    ------
    NetError
    """
    if net.modules and net.parts > limit:
        raise NetError(f"net {net.name!r}: {what} {net.parts:,} places, transitions and modules, more than {limit:,} (`max_parts`)")


def resolve_name(name: str, scope: Mapping[str, AnyPlace]) -> tuple[str, str]:
    """Split a dotted name of an expression into a place of `scope` and an attribute of the object it holds.

    Returns
    -------
    place, attribute : str
        `attribute` is empty when the whole name is a place. `place` is empty when neither fits.
    """
    if name in scope:
        return name, ""
    cut = name.rfind(".")
    while cut > 0:
        place = name[:cut]
        if isinstance(scope.get(place), ObjectPlace):
            return place, name[cut + 1 :]
        cut = name.rfind(".", 0, cut)
    return "", ""


def math_order(places: Iterable[AnyPlace], scope: Mapping[str, AnyPlace]) -> tuple[Math, ...]:
    """The math places of a net so that each comes after those it reads.

    Raises
    ------
    NetError
        When they read each other in a circle, which the message shows.
    """
    maths = {p.name: p for p in places if isinstance(p, Math)}
    operands = {}
    for name, place in maths.items():
        read = (resolve_name(n, scope)[0] for n in Expression(place.expression).names)
        operands[name] = [q for q in read if q in maths]
    order = depth_first_order(operands, lambda circle: f"math places read each other in a circle: {circle}")
    return tuple(maths[name] for name in order)


def depth_first_order(edges: Mapping[str, Iterable[str]], complain: Callable[[str], str]) -> list[str]:
    """Nodes so that each comes after those it points to; a circle raises `NetError` with the circle written out."""
    order: list[str] = []
    state: dict[str, int] = {}
    for root in edges:
        stack = [(root, iter(edges[root]))] if root not in state else []
        if stack:
            state[root] = 1
        while stack:
            node, rest = stack[-1]
            for target in rest:
                if state.get(target) == 1:
                    path = [n for n, _ in stack]
                    circle = [*path[path.index(target) :], target]
                    raise NetError(complain(" -> ".join(repr(n) for n in circle)))
                if target not in state:
                    state[target] = 1
                    stack.append((target, iter(edges.get(target, ()))))
                    break
            else:
                state[node] = 2
                order.append(node)
                stack.pop()
    return order


class _Check:
    """Every rule that a net must meet; the first that fails raises."""

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        self.scope: dict[str, AnyPlace] = {}

    def run(self) -> None:
        net = self.net
        for place in net.places:
            if not isinstance(place, PLACE_KINDS):
                raise NetError(f"`places` takes Place, Continuous, Input, Belief, Math and ObjectPlace, got {shown(place)}")
        for transition in net.transitions:
            if not isinstance(transition, Transition):
                raise NetError(f"`transitions` takes Transition, got {shown(transition)}")
        self.names()
        self.scope = {p.name: p for p in net.places} | net.port_places()
        self.fused()
        for place in net.places:
            self.reads(place)
        math_order(net.places, self.scope)
        for transition in net.transitions:
            self.transition(transition)
        self.port_rules()

    def names(self) -> None:
        net = self.net
        for what, names in (("place", [p.name for p in net.places]), ("transition", [t.name for t in net.transitions])):
            for name, count in Counter(names).items():
                if count > 1:
                    raise NetError(f"{what} {name!r} is declared {count} times")
        for instance, module in net.modules.items():
            check_name(instance, "module instance")
            if not instance.isidentifier() or instance.startswith("_"):
                raise NetError(f"instance {instance!r}: the name of an instance is a plain word, without dots")
            if not isinstance(module, PetriNet):
                raise NetError(f"instance {instance!r}: `modules` maps names to nets, got {shown(module)}")
        for name in [p.name for p in net.places] + [t.name for t in net.transitions]:
            instance = name.partition(".")[0]
            if instance in net.modules:
                raise NetError(f"{name!r} is declared although {instance!r} is an instance of a module")

    def known(self, name: str, where: str) -> AnyPlace:
        if name in self.scope:
            return self.scope[name]
        instance, _, inner = name.partition(".")
        if instance in self.net.modules:
            module = self.net.modules[instance]
            ports = f"Its ports are {', '.join(module.ports.all) or 'none'}"
            if any(p.name == inner for p in module.places):
                raise NetError(f"{where}: place {inner!r} is inside the module of instance {instance!r}. {ports}")
            raise NetError(f"{where}: instance {instance!r} has no port {inner!r}.{did_you_mean(inner, module.ports.all)} {ports}")
        raise NetError(f"{where}: unknown place {name!r}.{did_you_mean(name, self.scope)}")

    def fused(self) -> None:
        for port, target in self.net.fuse.items():
            where = f"fuse {port!r} with {shown(target)}"
            if not isinstance(target, str):
                raise NetError(f"{where}: a port is fused with a place, by its name")
            if port not in self.net.port_places():
                self.known(port, where)
                raise NetError(f"{where}: only ports of instances are fused")
            inner, outer = self.scope[port], self.known(target, where)
            if target in self.net.fuse:
                raise NetError(f"{where}: {target!r} is itself fused with {self.net.fuse[target]!r}; name that place")
            _check_fusion(inner, outer, where)

    def names_read(self, text: str, what: str, candidate: str = "") -> None:
        for name in Expression(text).names:
            if candidate and name.startswith(candidate + "."):
                continue
            place, attribute = resolve_name(name, self.scope)
            if not place:
                self.known(name, what)
            if "." in attribute:
                raise NetError(f"{what}: {name!r}: an attribute has one part, got {attribute!r}")

    def reads(self, place: AnyPlace) -> None:
        if isinstance(place, Math):
            self.names_read(place.expression, f"math place {place.name!r}")
        elif isinstance(place, ObjectPlace) and place.select is not None:
            self.selection(place.name, place.select)
        elif isinstance(place, Input) and resolve_name(place.observes, self.scope)[1]:
            raise NetError(
                f"input place {place.name!r}: {place.observes!r} is an attribute of the object in a place; "
                f"write Math({place.name!r}, {place.observes!r})"
            )

    def selection(self, name: str, select: Selection) -> None:
        for key, text in (("best", select.best), ("where", select.where)):
            if text:
                self.names_read(text, f"object place {name!r}: selection, {key}", select.candidate)
        if not any(n.startswith(select.candidate + ".") for n in Expression(select.best).names):
            raise NetError(
                f"object place {name!r}: selection, best: {select.best!r} reads no attribute of the candidate; "
                f"write for example {select.candidate + '.distance'!r}"
            )

    def transition(self, t: Transition) -> None:
        where = f"transition {t.name!r}"
        for kind, arcs in (("inputs", t.inputs), ("outputs", t.outputs), ("sets", t.sets)):
            for name, weight in arcs.items():
                self.moves(t, kind, name, weight, where)
        for kind, thresholds in (("tests", t.tests), ("inhibitors", t.inhibitors)):
            for name, threshold in thresholds.items():
                self.threshold(kind, name, threshold, where)
        objects_in = [p for p in t.inputs if isinstance(self.scope[p], ObjectPlace)]
        objects_out = [p for p in t.outputs if isinstance(self.scope[p], ObjectPlace)]
        if len(objects_in) > 1 and objects_out:
            raise NetError(f"{where}: several object inputs, {', '.join(objects_in)}: which object goes on?")
        for out in objects_out:
            if not objects_in:
                raise NetError(f"{where}: object output {out!r} without an object input to take an object from")
            got, wanted = _class(self.scope[objects_in[0]]), _class(self.scope[out])
            if got != wanted:
                raise NetError(f"{where}: moves a {got} from {objects_in[0]!r} into {out!r}, which holds a {wanted}")
        for name in t.sets:
            if name in t.outputs and not t.set_wins:
                raise NetError(f"{where}: set and output arc to {name!r}; write set_wins=True if the set value shall stand")
        if t.emits is not None:
            for key, value in t.emits.params.items():
                if isinstance(value, str):
                    self.known(value, f"{where}: command {t.emits.name!r}, parameter {key!r}")

    def moves(self, t: Transition, kind: str, name: str, weight: int, where: str) -> None:
        place = self.known(name, f"{where}: `{kind}`")
        if isinstance(place, ObjectPlace):
            if kind == "sets" and weight != 0:
                raise NetError(f"{where}: an object place can only be set to 0, got {{{name!r}: {weight}}}")
            if kind != "sets" and weight != 1:
                raise NetError(f"{where}: an object place holds one object, got weight {weight} for {name!r}")
            if kind == "outputs" and place.select is not None:
                raise NetError(f"{where}: object place {name!r} is set by its selection and takes no object from a transition")
        elif not isinstance(place, Place):
            raise NetError(
                f"{where}: `{kind}` names the {_KIND_NAMES[type(place)]} place {name!r}; transitions move tokens of discrete and "
                f"object places only. Read it with tests or inhibitors"
            )
        elif place.capacity is not None and weight > place.capacity:
            raise NetError(f"{where}: `{kind}`: {weight} tokens for place {name!r} of capacity {place.capacity}")
        self.direction(kind, name, weight, where)

    def direction(self, kind: str, name: str, weight: int, where: str) -> None:
        """Inputs of a module only receive tokens, its outputs only lose them (§2.2.6)."""
        if name not in self.net.port_places():
            return
        instance, _, port = name.partition(".")
        ports = self.net.modules[instance].ports
        if port in ports.entries and (kind == "inputs" or (kind == "sets" and weight == 0)):
            raise NetError(f"{where}: takes tokens from {name!r}, an input of its module; from outside it only receives them")
        if port in ports.exits and (kind == "outputs" or (kind == "sets" and weight > 0)):
            raise NetError(f"{where}: puts tokens into {name!r}, an output of its module; from outside it only loses them")

    def threshold(self, kind: str, name: str, threshold: float, where: str) -> None:
        place = self.known(name, f"{where}: `{kind}`")
        if not isinstance(place, (Place, ObjectPlace)):
            return
        capacity = 1 if isinstance(place, ObjectPlace) else place.capacity
        if threshold != int(threshold) or threshold < 1:
            raise NetError(f"{where}: `{kind}`: threshold of {name!r} is a whole number from 1, got {threshold}")
        if kind == "tests" and capacity is not None and threshold > capacity:
            raise NetError(f"{where}: tests {threshold} tokens of place {name!r} of capacity {capacity}")

    def port_rules(self) -> None:
        own = {p.name: p for p in self.net.places}
        ports = self.net.ports
        for port in ports.all:
            if port not in own:
                raise NetError(f"ports: unknown place {port!r}.{did_you_mean(port, own)}")
        for port in filter(None, (ports.begin, ports.ongoing, *ports.outcomes, *ports.interrupts)):
            place = own[port]
            if not isinstance(place, Place) or place.capacity != 1:
                raise NetError(f"ports: {port!r} must be a discrete place of capacity 1, it is {place!r}")
        for port in ports.inputs:
            if not isinstance(own[port], (Place, ObjectPlace)):
                raise NetError(f"ports: input {port!r} must be a discrete or object place; continuous ones are parameters")
        for port in ports.parameters:
            if not isinstance(own[port], (ObjectPlace, Continuous, Input)):
                raise NetError(f"ports: parameter {port!r} must be an object, continuous or input place, it is {own[port]!r}")


def _class(place: AnyPlace) -> str:
    return place.class_name if isinstance(place, ObjectPlace) else ""


def _check_fusion(inner: AnyPlace, outer: AnyPlace, where: str) -> None:
    """Refuse to make one place of two that do not fit; `outer` is the one that stays."""
    kinds = f"the {_KIND_NAMES[type(inner)]} place with the {_KIND_NAMES[type(outer)]} place"
    if isinstance(inner, Place):
        if not isinstance(outer, Place):
            raise NetError(f"{where}: cannot fuse {kinds}")
        if inner.capacity != outer.capacity:
            raise NetError(f"{where}: their capacities differ, {inner.capacity} and {outer.capacity}")
        if inner.tokens not in (0, outer.tokens):
            raise NetError(f"{where}: their initial tokens differ, {inner.tokens} and {outer.tokens}")
    elif isinstance(inner, ObjectPlace):
        if not isinstance(outer, ObjectPlace) or inner.class_name != outer.class_name:
            raise NetError(f"{where}: cannot fuse {kinds}; both must hold a {inner.class_name}")
        if inner.select is not None:
            raise NetError(f"{where}: the module selects the object itself")
    elif isinstance(inner, (Continuous, Input)):
        if isinstance(outer, ObjectPlace):
            raise NetError(f"{where}: cannot fuse {kinds}")
    else:
        raise NetError(f"{where}: the module writes its {_KIND_NAMES[type(inner)]} place itself; read it by its name")
