"""A CPRM that runs for many agents at once, and what explains its decisions."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import CprmError, EvidenceError, ModelError, NetError, ParameterError, did_you_mean
from ..petri import ObjectPlace, compile_net
from ..petri.execution.commands import Commands
from ..petri.execution.executor import Executor
from ..prm.grounding.grounding import Grounding
from ..prm.grounding.slices import GroundVariable
from ..prm.inference.alone.questions import Question
from ..prm.inference.compiled.cache import Recent
from ..prm.inference.evidence import UNOBSERVED, StateRows, state_of
from ..prm.inference.filter import make_engine
from ..prm.inference.filter_bank import FilterBank
from ..prm.inference.filtering import POLICIES
from ..prm.inference.links import Link, Role
from ..prm.model.formulas import Formula
from ..prm.model.schema import canonical_tuple
from .alone import imagine, questions_of
from .separate import Holding, Perceived, SeparateBeliefs, Told, separate_filters
from .sights import Columns, Sight, Sights
from .slow import SlowBeliefs, Timing, slow_banks, slow_separately
from .value import CPRM, Observe, view_of

Percepts = Mapping[str, NDArray[Any]]
"""Name -> (W,) numbers: what the agents perceive in a cycle."""


@dataclass(frozen=True)
class Decision:
    """One cycle of one agent, from what it perceived to what it did.

    Attributes
    ----------
    cycle : int
    percepts : dict of str to float
    evidence : dict of str to float or None
        What the model was told; None where not observed.
    beliefs : dict of str to float
        Belief places.
    relations : tuple of str
        Active in the model.
    marking : dict of str to float
        Places that hold something, after the cycle.
    fired : tuple of str
        Transitions in the order of firing.
    enabled : tuple of str
        Transitions enabled at some firing but not fired.
    commands : dict of str to dict of str to float
    """

    cycle: int
    percepts: Mapping[str, float]
    evidence: Mapping[str, float | None]
    beliefs: Mapping[str, float]
    relations: tuple[str, ...]
    marking: Mapping[str, float]
    fired: tuple[str, ...]
    enabled: tuple[str, ...]
    commands: Mapping[str, Mapping[str, float]]


def check_options(options: Mapping[str, Any], taken: Sequence[str] = ()) -> None:
    """Refuse options that no `CPRMRunner` takes, before one is made.

    Parameters
    ----------
    options : mapping of str to object
    taken : sequence of str
        Options that whoever makes the runner gives himself.

    Raises
    ------
    ParameterError
        For an unknown option, engine or policy; the message lists those that there are.
    """
    known = [name for name in inspect.signature(CPRMRunner).parameters if name not in ("cprm", "batch", *taken)]
    for name in options:
        if name not in known:
            raise ParameterError(f"there is no option {name!r}.{did_you_mean(name, known)} Known: {', '.join(known)}")
    for name in ("engine", "deep"):
        if options.get(name) is not None or (name == "engine" and name in options):
            make_engine(options[name])
    policy = options.get("on_impossible", POLICIES[0])
    if policy not in POLICIES:
        raise ParameterError(f"`on_impossible` is one of {', '.join(POLICIES)}, got {policy!r}.{did_you_mean(str(policy), POLICIES)}")


class CPRMRunner:
    """A CPRM that runs for a batch of agents.

    Parameters
    ----------
    cprm : CPRM
    batch : int
        W, the number of agents.
    exclusive : sequence of sequences of str
        Groups of commands of which one goes out per cycle (`Executor`).
    engine : str or engine
        How the model is filtered (`Filter`).
    on_impossible : str
        What happens to readings of probability zero; by default the agent's belief begins anew.
    trace : bool
        Keep what `explain` tells.
    seed : int, optional
    grounding : Grounding, optional
        Of the model and objects. Controllers that are given one grounding and one engine object share all that is made at the first
        use of a relation: slices and plans. Not for several threads at once.
    deep : {"exact", "projection"}, optional
        Engine of an occasional deep inference over the remembered readings (§2.3.3); `engine` is then the quick one.
    every : int
        Inferences from one deep one to the next.
    t_b, latency, demand
        When inferences begin and when their results come (`slow.Timing`): by default one ends each slice, at once.
    rehearsal : int
        Slices that one agent imagines before the first, so that plans and structures are there when they are needed: it costs some
        milliseconds for each that is new, and no answer depends on it. Of an exact or projecting engine, for a batch of one.

    Raises
    ------
    ParameterError
        For a timing that makes no sense, or of a CPRM without a model.
    """

    def __init__(
        self,
        cprm: CPRM,
        batch: int = 1,
        *,
        exclusive: Sequence[Sequence[str]] = (),
        engine: Any = "exact",
        grounding: Grounding | None = None,
        on_impossible: str = "restart",
        trace: bool = False,
        seed: int | None = None,
        deep: str | None = None,
        every: int = 50,
        t_b: int | None = None,
        latency: int = 0,
        demand: str = "",
        rehearsal: int = 0,
    ) -> None:
        self.cprm = cprm
        self.batch = batch
        self.timing = Timing.of(cprm, t_b, latency, demand)
        self.slow: SlowBeliefs[Any, Any] | None = None
        """What waits for an inference, where not every slice is inferred at once."""
        compiled = compile_net(cprm.net)
        self._by_class = {c: tuple(o for o, k in cprm.objects.items() if k == c) for c in cprm.objects.values()}
        counts = {p.class_name: len(self._by_class.get(p.class_name, ())) for p in compiled.net.places if isinstance(p, ObjectPlace)}
        self.executor = Executor(compiled, batch, objects=counts, exclusive=exclusive, trace=trace, seed=seed)
        read = list(self.executor.input_names)  # of percepts, and for the observations of places too
        self.places = set(self.executor.net.place_names)
        self._beliefs = [(p.name, p.variable, view_of(p), float(p.value)) for p in self.executor.belief_places]
        self._class_at = {p.name: p.class_name for p in compiled.net.places if isinstance(p, ObjectPlace)}
        self.bank: FilterBank | None = None
        """The agents' beliefs; None without a model, and where they are kept one by one."""
        self.separate: SeparateBeliefs | None = None
        """The agents' beliefs one by one, for a CPRM that says what a bank does not take (`CPRM.separate`)."""
        self.withheld: frozenset[str] = frozenset()
        """Variables whose readings the model is not told, whatever is perceived of them: to see what it does without."""
        at_once = self.timing.at_once(cprm.period)
        if cprm.model is not None:
            own = cprm.grounding()
            if grounding is None:
                grounding = own
            elif grounding.model != own.model or grounding.objects != own.objects or grounding.references != own.references:
                raise ModelError(f"cprm {cprm.name!r}: the grounding given is of another model or other objects")
            if cprm.separate or deep is not None:
                filters = separate_filters(grounding, batch, engine, deep, every, seed, on_impossible)
                self.separate = SeparateBeliefs(cprm, grounding, filters)
                if not at_once:
                    self.slow = slow_separately(self.separate, self.timing, self._tell_each)
                self._links_read = [(o, _formulas(o), Formula(o.when or "1")) for o in cprm.observations]
                self._present = {name: Formula(text) for name, text in cprm.present.items()}
            else:
                alike = not cprm.clusters and cprm.period == 1 and at_once
                self.bank = FilterBank(grounding, batch, engine, on_impossible=on_impossible, seed=seed, alike=alike)
                self._sights, self._domains = _sights(cprm.observations, self.bank.variables)
                self._observed = [s.name for s in self._sights]
                self._sight_names = tuple(dict.fromkeys(s.name for s in self._sights))
                read += [name for s in self._sights for formula in (s.value, s.when) for name in formula.names]
                if not at_once:
                    other = FilterBank(grounding, batch, self.bank.settings.engine, on_impossible=on_impossible, seed=seed)
                    self.slow = slow_banks(self.bank, other, self.timing, cprm.period)
        self._questions: tuple[Question, ...] = ()
        if self.bank is not None and batch == 1:
            self._questions = questions_of(self._beliefs, self._class_at, self.executor, self.bank)
        self._columns = Columns(tuple(dict.fromkeys(read)), self.executor)
        self._rows: NDArray[np.float64] | None = None
        self._reader: Sights | None = None
        """Of the observations; None where real numbers are observed, or nothing is."""
        if self.bank is not None and self._sights and not any(v.quantity is not None for v, _ in self._domains):
            self._reader = Sights(self._sights, self.bank.variables, {name: k for k, name in enumerate(self._columns.names)})
        self._demand = Formula(demand) if demand else None
        self._known_links: Recent[bytes, tuple[Link, ...]] = Recent(1024)  # of one agent, by whom he means
        self._trace = trace
        self._percepts: Percepts = {}
        self._seen: tuple[Iterable[str], Iterable[NDArray[np.float64]], Iterable[NDArray[np.bool_]]] = ((), (), ())
        self._in_force: tuple[Link, ...] = ()
        self._cycle = np.zeros(batch, np.int64)
        if not isinstance(rehearsal, int) or rehearsal < 0:
            raise ParameterError(f"`rehearsal` is a whole number of slices from 0, got {rehearsal!r}")
        if rehearsal and self.bank is not None and self._reader is not None and batch == 1 and self.bank.settings.engine.divisible:
            choices = [len(self._by_class.get(self._class_at[p], ())) for p in self.executor.object_names]
            imagine(cprm, self.bank, self._sights, self._class_at, self._questions, choices, rehearsal)

    # ------------------------------------------------------------------ life

    def reset(self, mask: NDArray[Any] | None = None) -> None:
        """Bring net and belief of agents back to their beginning.

        Parameters
        ----------
        mask : (W,) bool array, optional
            Which agents; all if not given.
        """
        mask = np.ones(self.batch, bool) if mask is None else np.asarray(mask, bool)
        self.executor.reset(mask)
        self._cycle[mask] = 0
        if self.bank is not None:
            self.bank.reset(mask)
        if self.separate is not None:
            self.separate.reset(mask)
        if self.slow is not None:
            self.slow.reset(mask)

    # ------------------------------------------------------------------ the cycle

    def step(self, percepts: Percepts, objects: Mapping[str, Mapping[str, Any]] | None = None) -> Commands:
        """Run one cycle.

        Parameters
        ----------
        percepts : mapping of str to (W,) numbers
            Everything that input places observe and observations read; more may be given.
        objects : mapping, optional
            Class -> attribute -> (n,) or (W, n) numbers of the candidates of object places (`Executor.see`).

        Returns
        -------
        Commands

        Raises
        ------
        UnknownName, NetError
            When a percept that is needed is missing, or is not a finite number.
        """
        self._percepts = percepts
        self._rows = self._columns.gather(percepts)
        if self._rows is None or not self.executor.observe_columns(self._rows):
            self.executor.observe({name: self._needed(percepts, name) for name in self.executor.input_names})
        due = self._cycle % self.cprm.period == 0
        if self.slow is not None:
            self._infer_slowly(self.slow, percepts)
        elif self.bank is not None and due.any():
            self._infer(self.bank, percepts, due)
        elif self.separate is not None and due.any():
            self._infer_each(self.separate, percepts, due)
        if objects is not None:
            self.executor.see(objects)
        commands = self.executor.run()
        self._cycle += 1
        return commands

    def _needed(self, percepts: Percepts, name: str) -> Any:
        if name not in percepts:
            raise NetError(f"cprm {self.cprm.name!r}: the net observes {name!r}; the percepts are {', '.join(percepts) or 'none'}")
        return percepts[name]

    def _infer(self, bank: FilterBank, percepts: Percepts, due: NDArray[np.bool_]) -> None:
        """One slice of the model for the agents that are due: observations, relations, posterior, belief places."""
        self._in_force = self._links()
        bank.step(self._read(bank, percepts), self._in_force, due)
        together = bank.views(self._questions, self.executor.held) if self._questions else None
        self.executor.believe(self._views(bank, due) if together is None else together)

    def _views(self, bank: FilterBank, agents: NDArray[np.bool_]) -> dict[str, NDArray[np.float64]]:
        """The belief places: of some agents what their last step answers, of the others as they are."""
        values = {}
        for name, variable, view, default in self._beliefs:
            owner, _, attribute = variable.partition(".")
            if owner in self._class_at:
                whom = Role(self._class_at[owner], self.executor.holds(owner))
                read = np.where(whom.index < 0, default, bank.view_of(view, whom, attribute))
            else:
                read = bank.view(view, variable)
            values[name] = read if agents.all() else np.where(agents, read, self.executor.read(name))
        return values

    def _infer_each(self, beliefs: SeparateBeliefs, percepts: Percepts, due: NDArray[np.bool_]) -> None:
        """As `_infer`, agent by agent."""
        self._in_force = self._links()
        perceived = self._perceived(percepts)
        before = [f.state for f in beliefs.filters]
        try:
            self._tell_each(beliefs, perceived, due, False)
        except CprmError:
            for one, state in zip(beliefs.filters, before):
                one.state = state
            raise
        self.executor.believe(self._views_each(beliefs, due))

    def _perceived(self, percepts: Percepts) -> Perceived:
        """What is told of everything that is observed, whom the object places hold, and who there is."""
        told = []
        for link, formulas, when in self._links_read:
            shown = self._evaluate([when], percepts)[0] >= 0.5
            told.append((link, self._evaluate(formulas, percepts), shown & (link.variable not in self.withheld)))
        self._seen = [l.variable for l, _, _ in told], [values[0] for _, values, _ in told], [shown for _, _, shown in told]
        present = {name: self._evaluate([formula], percepts)[0] >= 0.5 for name, formula in self._present.items()}
        return Perceived(told, {name: self.executor.holds(name) for name in self._class_at}, present)

    def _tell_each(self, beliefs: SeparateBeliefs, perceived: Perceived, due: NDArray[np.bool_], blind: bool) -> None:
        """One slice of each agent that is due; `blind`: with what is given alone."""
        for k in np.flatnonzero(due).tolist():
            seen = [_told(link, values[:, k], bool(shown[k])) for link, values, shown in perceived.told]
            there = [o for o in self.cprm.objects if o not in perceived.present or perceived.present[o][k]] if perceived.present else None
            beliefs.step(k, seen, self._holding(perceived.held, k), there, blind)

    def _views_each(self, beliefs: SeparateBeliefs, agents: NDArray[np.bool_]) -> dict[str, NDArray[np.float64]]:
        """As `_views`."""
        held = {name: self.executor.holds(name) for name in self._class_at}
        holdings = {k: self._holding(held, k) for k in np.flatnonzero(agents).tolist()}
        values = {}
        for name, variable, view, default in self._beliefs:
            read = self.executor.read(name).astype(np.float64)
            for k, holding in holdings.items():
                read[k] = beliefs.read(k, variable, view, holding, default)
            values[name] = read
        return values

    def _infer_slowly(self, slow: SlowBeliefs[Any, Any], percepts: Percepts) -> None:
        """What is told waits for an inference; the belief places are of what the last one whose result has come says of now."""
        self._in_force = self._links()
        demanded = self._evaluate([self._demand], percepts)[0] >= 0.5 if self._demand else np.zeros(self.batch, bool)
        if self.bank is not None:
            record: Any = (self._read(self.bank, percepts), self._in_force)
            slow.step(record, demanded, lambda bank, agents: self.executor.believe(self._views(bank, agents)))
        else:
            slow.step(self._perceived(percepts), demanded, lambda one, agents: self.executor.believe(self._views_each(one, agents)))

    def _holding(self, held: Mapping[str, NDArray[Any]], agent: int) -> Holding:
        """Whom an agent's object places hold, and which tuples its clusters make of them."""
        objects = {p: self._by_class[self._class_at[p]][index[agent]] if index[agent] >= 0 else None for p, index in held.items()}
        tuples: list[str | None] = []
        for cluster in self.cprm.clusters:
            names = [p[1:] if p.startswith("=") else objects[p] for p in cluster.places]
            tuples.append(None if None in names else canonical_tuple(cluster.relation, [str(n) for n in names]))
        return Holding(objects, tuple(tuples), {c.name: t for c, t in zip(self.cprm.clusters, tuples)})

    def _links(self) -> tuple[Link, ...]:
        """The relations that the object places ask for."""
        if self.batch > 1:
            return self._links_now()
        return self._known_links.fetch(self.executor.held.tobytes(), self._links_now)

    def _links_now(self) -> tuple[Link, ...]:
        return tuple(
            Link(c.relation, tuple(p[1:] if p.startswith("=") else Role(self._class_at[p], self.executor.holds(p)) for p in c.places))
            for c in self.cprm.clusters
        )

    def relations(self, copy: int) -> tuple[str, ...]:
        """Active relation tuples that the object places of an agent ask for."""
        return self._tuples(self._links(), copy)

    def _tuples(self, links: Sequence[Link], copy: int) -> tuple[str, ...]:
        active = []
        for link in links:
            indices = [role if isinstance(role, str) else int(role.index[copy]) for role in link.roles]
            if -1 not in indices:
                names = [i if isinstance(i, str) else self._by_class[r.class_name][i] for i, r in zip(indices, link.roles)]  # type: ignore[union-attr]
                active.append(canonical_tuple(link.relation, names))
        return tuple(dict.fromkeys(active))

    def _read(self, bank: FilterBank, percepts: Percepts) -> Mapping[str, Any]:
        """What the model is told: (W,) states of each name, -1 where not observed, and real numbers, NaN there."""
        if not self._sights:
            return StateRows((), np.empty((0, self.batch), np.int64))
        if self._reader is not None and self._rows is not None:
            read = self._reader.read(self._columns.add_places(self._rows), self.withheld)
            if read is not None:
                self._seen = self._observed, *read[1]
                return read[0]
        values = self._evaluate([s.value for s in self._sights], percepts)
        shown = self._evaluate([s.when for s in self._sights], percepts) >= 0.5
        if self.withheld:
            shown &= np.array([sight.name not in self.withheld for sight in self._sights])[:, None]
        states = np.full(values.shape, UNOBSERVED, np.int64)
        reals: dict[str, NDArray[np.float64]] = {}
        for variable, rows in self._domains:
            numbers, seen = values[rows], shown[rows]
            if variable.quantity is not None:
                for sight, row, mask in zip(self._sights[rows], numbers, seen):
                    reals[sight.name] = np.where(mask, row, reals.get(sight.name, np.nan))
                continue
            if variable.edges is None:
                values[rows] = numbers = np.rint(numbers)
                numbers = numbers.astype(np.int64)
            try:
                states[rows][seen] = state_of(variable, numbers[seen])
            except EvidenceError:  # again one by one: the message names the variable
                for sight, row, mask in zip(self._sights[rows], numbers, seen):
                    state_of(bank.variables[sight.name], row[mask])
                raise
        self._seen = self._observed, values, shown
        told = StateRows(self._sight_names, states if len(states) == len(self._sight_names) else self._merged(states))
        return {**told, **reals} if reals else told

    def _merged(self, states: NDArray[np.int64]) -> NDArray[np.int64]:
        """One row for each variable, where several observations are of the same: the last that sees it counts."""
        rows = {name: np.full(self.batch, UNOBSERVED, np.int64) for name in self._sight_names}
        for sight, row in zip(self._sights, states):
            rows[sight.name] = np.where(row >= 0, row, rows[sight.name])
        return np.stack(list(rows.values()))

    def _evaluate(self, formulas: Sequence[Formula], percepts: Percepts) -> NDArray[np.float64]:
        """(n, W) values of expressions over percepts and places."""
        out = np.empty((len(formulas), self.batch))
        for row, formula in zip(out, formulas):
            plain = percepts.get(formula.text)  # most are a percept as it is
            row[:] = formula({name: self._value(name, percepts) for name in formula.names}, self.batch) if plain is None else plain
        if not np.isfinite(out).all():
            for formula in formulas:
                formula({name: self._value(name, percepts) for name in formula.names}, self.batch)
        return out

    def _value(self, name: str, percepts: Percepts) -> NDArray[np.float64]:
        if name in percepts:
            return np.broadcast_to(np.asarray(percepts[name], np.float64), (self.batch,))
        if name in self.places:
            return self.executor.read(name)
        known = [*percepts, *self.places]
        raise NetError(f"cprm {self.cprm.name!r}: {name!r} is neither a percept nor a place.{did_you_mean(name, known)}")

    # ------------------------------------------------------------------ explanations

    @property
    def told(self) -> list[tuple[str, NDArray[np.float64], NDArray[np.bool_]]]:
        """Of the last slice each observed variable, its (W,) values, and for whom the model was told of it."""
        return list(zip(*self._seen))

    def explain(self, copy: int = 0) -> Decision:
        """The last decision of an agent; the controller must have been made with ``trace=True`` for what fired.

        Raises
        ------
        NetError
            When there is no such agent, or nothing has been decided yet.
        """
        if not 0 <= copy < self.batch or not self._percepts:
            raise NetError(f"cprm {self.cprm.name!r}: no decision of agent {copy!r} to explain; there are agents 0 to {self.batch - 1}")
        executor, cycle = self.executor, int(self._cycle[copy]) - 1
        fired: list[str] = []
        enabled: set[str] = set()
        if executor.trace is not None:
            for firing in executor.trace.firings(copy):
                if firing.cycle == cycle:
                    fired.append(firing.transition)
                    enabled.update(firing.enabled)
        row = executor.marking[copy]
        told = {name: float(values[copy]) if shown[copy] else None for name, values, shown in self.told}
        commands = {
            name: {key: float(v[copy]) for key, v in executor._commands.values[name].items()}
            for name, out in executor._commands.fired.items() if out[copy]
        }  # fmt: skip
        return Decision(
            cycle=cycle,
            percepts={name: float(np.broadcast_to(np.asarray(v, float), (self.batch,))[copy]) for name, v in self._percepts.items()},
            evidence=told,
            beliefs={name: float(executor.read(name)[copy]) for name, *_ in self._beliefs},
            relations=self._tuples(self._in_force, copy),
            marking={name: float(value) for name, value in zip(executor.net.place_names, row) if value != 0.0},
            fired=tuple(fired),
            enabled=tuple(sorted(enabled - set(fired))),
            commands=commands,
        )


def _formulas(link: Observe) -> list[Formula]:
    return [Formula(text) for text in ((link.value,) if link.value else link.likelihood)]


def _told(link: Observe, values: NDArray[np.float64], shown: bool) -> Told:
    """What one agent perceives of an observation."""
    if not shown:
        return Told(link, None, None)
    return Told(link, None, values) if link.likelihood else Told(link, float(values[0]), None)


def _sights(
    observations: Sequence[Observe], variables: Mapping[str, GroundVariable]
) -> tuple[list[Sight], list[tuple[GroundVariable, slice]]]:
    """Observations in an order in which those of one domain stand together, and where: they are read as one array."""
    groups: dict[Any, list[Sight]] = {}
    for link in observations:
        groups.setdefault(variables[link.variable].domain, []).append(Sight(link.variable, Formula(link.value), Formula(link.when or "1")))
    sights: list[Sight] = []
    places = []
    for group in groups.values():
        places.append((variables[group[0].name], slice(len(sights), len(sights) + len(group))))
        sights += group
    return sights, places
