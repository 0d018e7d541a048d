"""The value: a net, a model and what links them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ...errors import ModelError, NetError, did_you_mean
from ..petri import Belief, ObjectPlace, PetriNet, compile_net
from ..petri.net.values import FrozenMap
from ..prm.grounding.grounding import Grounding
from ..prm.inference.views import View
from ..prm.model.formulas import Formula
from ..prm.model.model import Model


@dataclass(frozen=True)
class Observe:
    """A variable, or an input, of the model that is read from percepts and places.

    Parameters
    ----------
    variable : str
        ``"ball.seen_dist"``.
    value : str
        Expression over percepts and places of the net. A place is read as the cycle before left it, since a place that follows from a
        belief must not be counted as fresh evidence for it. Named states take their index.
    when : str
        Expression; the variable is observed where it is true. Empty: always.
    """

    variable: str
    value: str
    when: str = ""

    def __post_init__(self) -> None:
        for text in (self.value, self.when):
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
    """

    relation: str
    places: tuple[str, ...]

    def __post_init__(self) -> None:
        if isinstance(self.places, str):
            raise ModelError(f"cluster {self.relation!r}: `places` takes a tuple, got the string {self.places!r}; write ({self.places!r},)")
        object.__setattr__(self, "places", tuple(self.places))


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

    def __post_init__(self) -> None:
        object.__setattr__(self, "objects", FrozenMap(self.objects))
        object.__setattr__(self, "observations", tuple(self.observations))
        object.__setattr__(self, "clusters", tuple(self.clusters))
        if isinstance(self.period, bool) or not isinstance(self.period, int) or self.period < 1:
            raise ModelError(f"cprm {self.name!r}: `period` is a number of cycles from 1, got {self.period!r}")
        _check_links(self)


def _check_links(cprm: CPRM) -> None:
    """Refuse links to places, variables, relations and objects that do not exist."""
    where = f"cprm {cprm.name!r}"
    net = compile_net(cprm.net)
    beliefs = [p for p in net.net.places if isinstance(p, Belief)]
    if cprm.model is None:
        if beliefs or cprm.observations or cprm.clusters:
            raise ModelError(f"{where}: belief places, observations and clusters need a model, and there is none")
        return
    ground = Grounding(cprm.model, cprm.objects).ground((), first=True)
    for place in beliefs:
        owner = place.variable.partition(".")[0]
        held = next((p for p in net.net.places if isinstance(p, ObjectPlace) and p.name == owner), None)
        names = {f"{o}.{place.variable.partition('.')[2]}" for o, c in cprm.objects.items() if held and c == held.class_name}
        for variable in names or {place.variable}:
            if variable not in ground.variables:
                hint = did_you_mean(variable, ground.variables)
                raise ModelError(f"{where}, belief place {place.name!r}: unknown variable {variable!r}.{hint}")
            view_of(place).check(ground.variables[variable])
    for link in cprm.observations:
        if link.variable not in ground.variables:
            hint = did_you_mean(link.variable, ground.variables)
            raise ModelError(f"{where}: observation of unknown variable {link.variable!r}.{hint}")
    relations = {r.name: r for r in cprm.model.relations}
    places = {p.name: p for p in net.net.places if isinstance(p, ObjectPlace)}
    for cluster in cprm.clusters:
        if cluster.relation not in relations:
            raise ModelError(f"{where}: cluster of unknown relation {cluster.relation!r}.{did_you_mean(cluster.relation, relations)}")
        roles = relations[cluster.relation].roles
        if len(roles) != len(cluster.places):
            given = len(cluster.places)
            raise ModelError(f"{where}: relation {cluster.relation!r} has {len(roles)} roles, its cluster names {given} places")
        for place_name in cluster.places:
            if place_name.startswith("="):
                if place_name[1:] not in cprm.objects:
                    raise ModelError(f"{where}: cluster {cluster.relation!r} names unknown object {place_name[1:]!r}")
            elif place_name not in places:
                raise NetError(f"{where}: cluster {cluster.relation!r} names {place_name!r}, which is not an object place of the net")


def view_of(place: Belief) -> View:
    """The view of a belief place as the model knows it."""
    return View.parse(f"{place.view}({place.state})" if place.state else place.view)
