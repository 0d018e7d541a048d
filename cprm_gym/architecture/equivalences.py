"""Two simpler architectures written in ours, so that the equivalences of chapter 5 can be run.

* A finite state machine is a net with one token in which every transition has one input and one output arc (Fig. 5.1): `machine_net`.
* A policy that maps regions of belief space to actions (Fig. 5.2) is a CPRM whose net only compares belief places (Fig. 5.3):
  `regions_cprm`.

Both come with a plain interpreter, `MachineRunner` and `RegionsRunner`, that knows no Petri net; on the same percepts it emits the same
commands.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import NetError, did_you_mean
from .cprm import CPRM, Observe, view_of
from .petri import Belief, Command, Input, Math, PetriNet, Place, Transition
from .petri.net.values import FrozenMap
from .prm.grounding.grounding import Grounding
from .prm.inference.filter import Filter
from .prm.model.formulas import Formula
from .prm.model.model import Model

Emitted = dict[str, dict[str, float]]
"""Command -> parameter -> value."""


@dataclass(frozen=True)
class Rule:
    """A transition of a state machine, taken in one cycle.

    Parameters
    ----------
    source, target : str
        States.
    when : str
        Expression over percepts and quantities; empty for always. Of the rules of a state the first that holds is taken.
    emits : Command, optional
        Its parameters are names of percepts or quantities, or numbers.
    """

    source: str
    target: str
    when: str = ""
    emits: Command | None = None


@dataclass(frozen=True)
class StateMachine:
    """A finite state machine with outputs on its transitions.

    Parameters
    ----------
    name : str
    states : tuple of str
        The first is where it begins.
    rules : tuple of Rule
    percepts : mapping of str to str
        Short name -> observed quantity.
    quantities : mapping of str to str
        Name -> expression over percepts (and quantities before it).

    Raises
    ------
    NetError
        When a rule names a state that does not exist.
    """

    name: str
    states: tuple[str, ...]
    rules: tuple[Rule, ...]
    percepts: Mapping[str, str] = field(default_factory=FrozenMap)
    quantities: Mapping[str, str] = field(default_factory=FrozenMap)

    def __post_init__(self) -> None:
        object.__setattr__(self, "percepts", FrozenMap(self.percepts))
        object.__setattr__(self, "quantities", FrozenMap(self.quantities))
        for rule in self.rules:
            for state in (rule.source, rule.target):
                if state not in self.states:
                    raise NetError(f"machine {self.name!r}: unknown state {state!r}.{did_you_mean(state, self.states)}")


def machine_net(machine: StateMachine) -> PetriNet:
    """The machine as a net with one token (Fig. 5.1).

    A state is two places, ``run`` where its rules are tried and ``run.entered`` where the token waits for the next cycle; every
    transition has one input and one output arc of weight 1, so the token is never lost nor doubled.
    """
    places: list[Any] = [Input(name, observes=observed) for name, observed in machine.percepts.items()]
    places += [Math(name, text) for name, text in machine.quantities.items()]
    for k, state in enumerate(machine.states):
        places += [Place(state, capacity=1, tokens=int(k == 0)), Place(f"{state}.entered", capacity=1)]
    transitions = [Transition(f"next.{state}", (f"{state}.entered",), (state,), delay=1) for state in machine.states]
    for k, rule in enumerate(machine.rules):
        if rule.when:
            places.append(Math(f"guard_{k}", f"1 if {rule.when} else 0"))
        guarded = {f"guard_{k}": 1.0} if rule.when else {}
        entered = (f"{rule.target}.entered",)
        priority = len(machine.rules) - k
        transitions.append(Transition(f"rule_{k}", (rule.source,), entered, tests=guarded, emits=rule.emits, priority=priority))
    return PetriNet(machine.name, tuple(places), tuple(transitions))


class MachineRunner:
    """The machine, run as such."""

    def __init__(self, machine: StateMachine) -> None:
        self.machine = machine
        self.state = machine.states[0]
        self._quantities = {name: Formula(text) for name, text in machine.quantities.items()}
        self._guards = [Formula(rule.when) if rule.when else None for rule in machine.rules]

    def step(self, percepts: Mapping[str, float]) -> Emitted:
        """One cycle: the commands of the first rule of the state that holds."""
        values = {name: np.array([float(percepts[observed])]) for name, observed in self.machine.percepts.items()}
        for name, formula in self._quantities.items():
            values[name] = formula({n: values[n] for n in formula.names}, 1)
        for rule, guard in zip(self.machine.rules, self._guards):
            if rule.source == self.state and (guard is None or guard({n: values[n] for n in guard.names}, 1)[0]):
                self.state = rule.target
                return {} if rule.emits is None else {rule.emits.name: _parameters(rule.emits, values)}
        return {}


def _parameters(command: Command, values: Mapping[str, np.ndarray]) -> dict[str, float]:
    return {key: float(values[of][0]) if isinstance(of, str) else float(of) for key, of in command.params.items()}


@dataclass(frozen=True)
class Region:
    """A region of belief space and the action in it.

    Parameters
    ----------
    name : str
    where : str
        Expression over the views; the region is where it holds. Regions may overlap: then several actions go out at once.
    emits : Command
        Its parameters are names of views or quantities, or numbers.
    """

    name: str
    where: str
    emits: Command


@dataclass(frozen=True)
class RegionPolicy:
    """Inference, and a map from regions of distributions to actions (Fig. 5.2).

    Parameters
    ----------
    name : str
    model : Model
    objects : mapping of str to str
        Object -> class.
    observations : tuple of Observe
        Of percepts only.
    views : tuple of Belief
        The measures of the distributions that regions and parameters read.
    regions : tuple of Region
    quantities : mapping of str to str
        Name -> expression over views.
    """

    name: str
    model: Model
    objects: Mapping[str, str]
    observations: tuple[Observe, ...]
    views: tuple[Belief, ...]
    regions: tuple[Region, ...]
    quantities: Mapping[str, str] = field(default_factory=FrozenMap)


def regions_cprm(policy: RegionPolicy) -> CPRM:
    """The policy as a CPRM (Fig. 5.3): belief places, one math place and one transition for each region, no state but the pace."""
    places: list[Any] = [*policy.views, *(Math(name, text) for name, text in policy.quantities.items())]
    transitions: list[Transition] = []
    for region in policy.regions:
        ready, acted, inside = f"{region.name}.ready", f"{region.name}.acted", f"{region.name}.inside"
        places += [Place(ready, capacity=1, tokens=1), Place(acted, capacity=1), Math(inside, f"1 if {region.where} else 0")]
        transitions += [
            Transition(region.name, (ready,), (acted,), tests={inside: 1}, emits=region.emits),
            Transition(f"{region.name}.tick", (acted,), (ready,), delay=1),
        ]
    net = PetriNet(policy.name, tuple(places), tuple(transitions))
    return CPRM(policy.name, net, policy.model, policy.objects, policy.observations)


class RegionsRunner:
    """The policy, run as such: filter, measure, compare."""

    def __init__(self, policy: RegionPolicy, engine: Any = "exact") -> None:
        self.policy = policy
        grounding = Grounding(policy.model, policy.objects)
        self._filter = Filter(grounding, 1, engine, on_impossible="restart")
        self._variables = self._filter.grounding.ground((), first=True).variables
        self._links = [(o.variable, Formula(o.value), Formula(o.when) if o.when else None) for o in policy.observations]
        self._quantities = {name: Formula(text) for name, text in policy.quantities.items()}
        self._where = [Formula(region.where) for region in policy.regions]

    def step(self, percepts: Mapping[str, float]) -> Emitted:
        """One cycle: the commands of all regions in which the posterior lies."""
        given = {name: np.array([float(value)]) for name, value in percepts.items()}
        evidence: dict[str, Any] = {}
        for variable, value, when in self._links:
            observed = when is None or when({n: given[n] for n in when.names}, 1)[0] >= 0.5
            number = value({n: given[n] for n in value.names}, 1)
            if observed:
                found = self._variables[variable]
                plain = found.edges is not None or found.quantity is not None
                evidence[variable] = number if plain else np.rint(number).astype(np.int64)
        posterior = self._filter.step(evidence, relations=())
        values = {view.name: view_of(view)(posterior[view.variable], self._variables[view.variable]) for view in self.policy.views}
        for name, formula in self._quantities.items():
            values[name] = formula({n: values[n] for n in formula.names}, 1)
        return {
            region.emits.name: _parameters(region.emits, values)
            for region, where in zip(self.policy.regions, self._where)
            if where({n: values[n] for n in where.names}, 1)[0]
        }
