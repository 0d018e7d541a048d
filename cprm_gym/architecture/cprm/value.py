"""The value: a net, a model and what links them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...errors import ModelError, NetError, did_you_mean
from ..petri import Belief, ObjectPlace, PetriNet, compile_net
from ..petri.net.values import FrozenMap
from ..prm.grounding.grounding import Grounding
from ..prm.inference.views import View
from ..prm.model.domains import Domain
from ..prm.model.formulas import Formula
from ..prm.model.model import Model
from ..prm.model.schema import as_tuple

SELECTOR = "selector"
"""The variable, ``ball.selector``, that a conflict rule "mixture" adds: which of several tuples is behind a change."""


@dataclass(frozen=True)
class Observe:
    """A variable of the model, or something given to it, that is read from percepts and places.

    Parameters
    ----------
    variable : str
        ``"ball.seen_dist"``. Where the first part names an object place of the net, the attribute of the object that it holds; where it
        names a cluster, the variable that the relation itself has, ``"pass.intended"``. ``"ball.selector"`` takes the number of a
        cluster, from 0 in their order.
    value : str
        Expression over percepts and places of the net. A place is read as the cycle before left it, since a place that follows from a
        belief must not be counted as fresh evidence for it. Named states take their index.
    when : str
        Expression; the variable is observed where it is true. Empty: always.
    likelihood : tuple of str
        Instead of `value`: soft evidence, an expression for each state that says how likely what was perceived is in that state, on
        any scale.
    """

    variable: str
    value: str = ""
    when: str = ""
    likelihood: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        where = f"observation of {self.variable!r}"
        object.__setattr__(self, "likelihood", as_tuple(self.likelihood, where, "likelihood"))
        if bool(self.value) == bool(self.likelihood):
            raise ModelError(f"{where}: give a `value` or a `likelihood` for each state")
        for text in (self.value, self.when, *self.likelihood):
            if text:
                Formula(text)


@dataclass(frozen=True)
class Cluster:
    """Object places that switch a relation: it is active on the objects that they hold (§2.3.4).

    Parameters
    ----------
    relation : str
    places : tuple of str
        For each role, in the relation's order, an object place of the net, or ``"=name"`` for a fixed object.
    name : str
        By which `Observe`, belief places and events mean the relation's own variables, ``"pass.intended"``; default: the relation.
    """

    relation: str
    places: tuple[str, ...]
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "places", as_tuple(self.places, f"cluster {self.relation!r}", "places"))
        if not self.name:
            object.__setattr__(self, "name", self.relation)


@dataclass(frozen=True)
class Event:
    """Something that several variables say together: a belief place of variable ``name`` reads the probability of all of it.

    Parameters
    ----------
    name : str
    states : mapping of str to str
        Variable -> a state, several, or an interval, as in the view ``probability(...)``: ``{"ball.dist": "..2", "o1.dist": "5.."}``.
    """

    name: str
    states: Mapping[str, str]

    def __post_init__(self) -> None:
        if not isinstance(self.states, Mapping) or not self.states:
            raise ModelError(f"event {self.name!r}: `states` says for each variable what it is")
        object.__setattr__(self, "states", FrozenMap(self.states))
        for text in self.states.values():
            View("probability", text)


@dataclass(frozen=True)
class CPRM:
    """Net, model and the links between them.

    Parameters
    ----------
    name : str
    net : PetriNet
    model : Model, optional
        Without one the net must have no belief places.
    objects : mapping of str to str
        Object -> class; the order within a class is that of the indices in object places.
    observations : tuple of Observe
    clusters : tuple of Cluster
    period : int
        t_B: cycles between inferences; a slice of the model is that long.
    references : mapping of str to mapping
        Object -> reference -> object or objects, as for `Grounding`, where they are not obvious.
    present : mapping of str to str
        Object -> expression over percepts and places: the object exists in the slices in which it is true. Others always exist.
    events : tuple of Event

    Raises
    ------
    ModelError, NetError
        When a link names what is not there; the message says what is.
    """

    name: str
    net: PetriNet
    model: Model | None = None
    objects: Mapping[str, str] = field(default_factory=FrozenMap)
    observations: tuple[Observe, ...] = ()
    clusters: tuple[Cluster, ...] = ()
    period: int = 1
    references: Mapping[str, Mapping[str, tuple[str, ...]]] = field(default_factory=FrozenMap)
    present: Mapping[str, str] = field(default_factory=FrozenMap)
    events: tuple[Event, ...] = ()

    def __post_init__(self) -> None:
        where = f"cprm {self.name!r}"
        for name in ("objects", "references", "present"):
            if not isinstance(getattr(self, name), Mapping):
                raise ModelError(f"{where}: `{name}` is a mapping, got {getattr(self, name)!r}")
        object.__setattr__(self, "objects", FrozenMap(self.objects))
        slots = {name: FrozenMap({s: _names(to) for s, to in given.items()}) for name, given in self.references.items()}
        object.__setattr__(self, "references", FrozenMap(slots))
        object.__setattr__(self, "present", FrozenMap(self.present))
        for name, kind in (("observations", Observe), ("clusters", Cluster), ("events", Event)):
            items = as_tuple(getattr(self, name), where, name)
            for item in items:
                if not isinstance(item, kind):
                    raise ModelError(f"{where}: `{name}` holds {kind.__name__} values, got {item!r}")
            object.__setattr__(self, name, items)
        if isinstance(self.period, bool) or not isinstance(self.period, int) or self.period < 1:
            raise ModelError(f"{where}: `period` is a number of cycles from 1, got {self.period!r}")
        _Links(self).check()

    def grounding(self) -> Grounding:
        """The model with its objects and references.

        Raises
        ------
        ModelError
            Without a model.
        """
        if self.model is None:
            raise ModelError(f"cprm {self.name!r} has no model")
        return Grounding(self.model, self.objects, self.references)

    @property
    def separate(self) -> bool:
        """Whether each agent needs a filter of its own: what a `FilterBank` does not take is said in some link."""
        if self.present or self.events or any(o.likelihood for o in self.observations):
            return True
        clusters = {c.name for c in self.clusters}
        places = compile_net(self.net).net.places
        beliefs = [p.variable for p in places if isinstance(p, Belief)]
        held = {p.name for p in places if isinstance(p, ObjectPlace)}
        told = [o.variable for o in self.observations]
        return any(
            v.partition(".")[0] in clusters or v.endswith(f".{SELECTOR}") or "(" in v or (v in told and v.partition(".")[0] in held)
            for v in (*beliefs, *told)
        )


def _names(value: Any) -> tuple[str, ...]:
    return (value,) if isinstance(value, str) else tuple(value)


class _Links:
    """Refuses links to places, variables, relations and objects that do not exist."""

    def __init__(self, cprm: CPRM) -> None:
        self.cprm, self.where = cprm, f"cprm {cprm.name!r}"
        net = compile_net(cprm.net).net
        self.beliefs = [p for p in net.places if isinstance(p, Belief)]
        self.held = {p.name: p.class_name for p in net.places if isinstance(p, ObjectPlace)}

    def check(self) -> None:
        cprm = self.cprm
        if cprm.model is None:
            if self.beliefs or cprm.observations or cprm.clusters or cprm.present or cprm.events:
                raise ModelError(f"{self.where}: belief places, observations and clusters need a model, and there is none")
            return
        self.grounding = cprm.grounding()
        self.variables = {name: v.domain for name, v in self.grounding.ground((), first=True).variables.items()}
        self.clusters()
        self.presence()
        events = {e.name for e in cprm.events}
        for event in cprm.events:
            for variable, text in event.states.items():
                domain = self.domain(variable, f"event {event.name!r}")
                View("probability", text).check(domain)
        for place in self.beliefs:
            here = f"belief place {place.name!r}"
            if place.variable in events:
                if (place.view, place.state) not in (("probability", ""), ("probability", "yes")):
                    raise ModelError(f"{self.where}, {here}: of an event the view is 'probability'")
            elif self.is_selector(place.variable):
                self.selector_view(place, here)
            else:
                domain = self.domain(place.variable, here)
                view_of(place).check(domain)
        for link in cprm.observations:
            if self.is_selector(link.variable):
                if link.likelihood:
                    raise ModelError(f"{self.where}: {link.variable!r} is observed by the number of a cluster, not by likelihoods")
                continue
            domain = self.domain(link.variable, "observation")
            if link.likelihood and len(link.likelihood) != len(domain):
                given = len(link.likelihood)
                raise ModelError(f"{self.where}: observation of {link.variable!r} has {given} likelihoods for {len(domain)} states")

    def is_selector(self, variable: str) -> bool:
        owner, _, attribute = variable.partition(".")
        return attribute == SELECTOR and variable not in self.variables and (owner in self.cprm.objects or owner in self.held)

    def selector_view(self, place: Belief, here: str) -> None:
        names = [c.name for c in self.cprm.clusters]
        if place.view == "probability" and names.count(place.state) != 1:
            hint = did_you_mean(place.state, names)
            raise ModelError(
                f"{self.where}, {here}: the states of {place.variable!r} are the clusters {', '.join(names)}, got {place.state!r}.{hint}"
            )
        if place.view not in ("probability", "entropy"):
            raise ModelError(f"{self.where}, {here}: of a selector there are the views 'probability' and 'entropy'")

    def domain(self, variable: str, here: str) -> Domain:
        """Domain of a variable as links name it.

        Raises
        ------
        ModelError
        """
        cprm = self.cprm
        owner, _, attribute = variable.partition(".")
        if owner in self.held:
            names = [f"{o}.{attribute}" for o, c in cprm.objects.items() if c == self.held[owner]] or [variable]
        else:
            meant = [c.relation for c in cprm.clusters if c.name == owner]
            if len(meant) > 1:
                raise ModelError(f"{self.where}, {here}: {len(meant)} clusters are called {owner!r}; give each a `name`")
            relation = meant[0] if meant else ""
            if "(" in variable:
                text, _, attribute = variable.rpartition(".")
                relation = self.grounding.canonical(text).partition("(")[0]
            if relation:
                own = self.grounding.model.checked.relations[relation].attributes
                if attribute not in own:
                    known = ", ".join(own) or "none"
                    hint = did_you_mean(attribute, own)
                    raise ModelError(f"{self.where}, {here}: relation {relation!r} has no variable {attribute!r}.{hint} Known: {known}")
                return own[attribute].domain
            names = [variable]
        for name in names:
            if name not in self.variables:
                raise ModelError(f"{self.where}, {here}: unknown variable {name!r}.{did_you_mean(name, self.variables)}")
        return self.variables[names[0]]

    def clusters(self) -> None:
        assert self.cprm.model is not None
        relations = {r.name: r for r in self.cprm.model.relations}
        seen: set[str] = set()
        for cluster in self.cprm.clusters:
            if cluster.relation not in relations:
                hint = did_you_mean(cluster.relation, relations)
                raise ModelError(f"{self.where}: cluster of unknown relation {cluster.relation!r}.{hint}")
            roles = relations[cluster.relation].roles
            if len(roles) != len(cluster.places):
                given = len(cluster.places)
                raise ModelError(f"{self.where}: relation {cluster.relation!r} has {len(roles)} roles, its cluster names {given} places")
            for place_name in cluster.places:
                if place_name.startswith("="):
                    if place_name[1:] not in self.cprm.objects:
                        raise ModelError(f"{self.where}: cluster {cluster.relation!r} names unknown object {place_name[1:]!r}")
                elif place_name not in self.held:
                    raise NetError(
                        f"{self.where}: cluster {cluster.relation!r} names {place_name!r}, which is not an object place of the net"
                    )
            if cluster.name in seen and cluster.name != cluster.relation:
                raise ModelError(f"{self.where}: two clusters are called {cluster.name!r}")
            if cluster.name in self.cprm.objects or cluster.name in self.held:
                raise ModelError(f"{self.where}: a cluster is called {cluster.name!r}, as an object or an object place is")
            seen.add(cluster.name)

    def presence(self) -> None:
        for name, text in self.cprm.present.items():
            if name not in self.cprm.objects:
                hint = did_you_mean(name, self.cprm.objects)
                raise ModelError(f"{self.where}: `present` names the unknown object {name!r}.{hint}")
            if not isinstance(text, str):
                raise ModelError(f"{self.where}: `present` of {name!r} is an expression, got {text!r}")
            Formula(text)


def view_of(place: Belief) -> View:
    """The view of a belief place as the model knows it."""
    return View.parse(f"{place.view}({place.state})" if place.state else place.view)
