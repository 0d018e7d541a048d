"""The beliefs of many agents whose relations differ, filtered together.

A `Filter` takes agents with the same relations in the same slice. In a `FilterBank` each agent has its own relations, begins anew
when it wants to and makes its steps when they are due. Agents whose beliefs have the same form and who ask for the same
relations make one step of one filter: a *cohort*. After the step, cohorts whose beliefs have the same form are one again.

Objects of a class are alike: what is true of one agent and object o7 is true of another agent and o3. So every agent numbers the
objects of such a class for itself, those in its relations first, and *attended(o7)* of one agent and *attended(o3)* of another are
both *attended* of the first. Readings are renumbered on the way in, answers on the way out, and a belief is renamed when an
agent turns from one object to another. This is exact: it is the same net with other names. With eleven opponents of whom two
are attended there are a handful of cohorts instead of fifty-five.

References
----------
Dissertation section 2.3.4 (clusters of relations that follow object tokens).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import EvidenceError, ModelError, ParameterError, did_you_mean
from ..grounding.grounding import Grounding
from ..grounding.slices import GroundVariable
from ..model.schema import canonical_tuple, one_or_many, parse_tuple
from . import filtering
from .alone.questions import Asked, Question, find
from .alone.ways import Way, Ways
from .compiled.cache import Recent
from .compiled.slice_info import SliceInfo
from .continuous.number_evidence import Numbers, nothing, read_numbers
from .engines.engine import Engine
from .engines.exact import FactoredResult
from .evidence import UNOBSERVED, Readings, StateRows, read_hard, state_of
from .filter import Filter, make_engine, make_settings
from .filtering import FilterState
from .forms import Renamings, fronted, rename_tuple
from .links import Indices, Link, Role, Tie, as_sets, tuples_of
from .posterior import Posterior
from .views import View


class _Cohort(NamedTuple):
    """Agents whose beliefs have the same form, and the state of a filter for them, in their order."""

    agents: Indices
    state: FilterState


class _Rows(NamedTuple):
    """Where the readings of a slice stand among those of the bank, -1 for nowhere, and which of the bank's it lacks."""

    found: Indices
    lost: Indices


class FilterBank:
    """Filters of W agents, each with its own relations.

    One class because all of it moves agents between the same cohorts: to let one turn, begin anew, step or be read means to find, split
    and join the cohorts that the others are in.

    Parameters
    ----------
    grounding : Grounding
    batch : int
        W.
    engine, on_impossible, seed
        As for `Filter`.
    alike : bool
        All agents always step together and have the same relations. Then engines that sample can take them as one batch, too.
    """

    def __init__(
        self,
        grounding: Grounding,
        batch: int = 1,
        engine: str | Engine = "exact",
        *,
        on_impossible: str = "raise",
        seed: Any = None,
        alike: bool = False,
    ) -> None:
        self.batch = batch
        self.settings = make_settings(grounding, make_engine(engine, seed), on_impossible)
        assert isinstance(self.settings.grounding, Grounding)
        self.grounding = grounding = self.settings.grounding
        base = grounding.ground((), first=True)
        self.variables = base.variables
        """Of a slice without relations."""
        self._names = tuple(base.variables)
        self._row = {name: i for i, name in enumerate(self._names)}
        self._cards = np.array([v.card for v in base.variables.values()], np.int64)
        defaults = grounding.defaults(base)
        self._given = [(self._row[name], name, defaults.get(name, UNOBSERVED)) for name in base.given]
        self.members: dict[str, tuple[str, ...]] = {}
        """Class -> its objects, without those of its subclasses."""
        for name, class_name in grounding.objects.items():
            self.members[class_name] = (*self.members.get(class_name, ()), name)
        self._alike = alike
        self._divisible = self.settings.engine.divisible
        if self._divisible and not alike:
            for relations in ((), *self._examples()):
                filtering.indexed(self.settings, grounding.ground(relations), {})
        continuous = grounding.model.continuous
        self._quantities = grounding.quantities(base)
        refers = any(c.references for c in grounding.model.classes)
        self._exchangeable = self._divisible and not continuous and not refers and not grounding.static
        self._rows_in: Recent[SliceInfo, _Rows] = Recent(256)
        self._renamings = Renamings(self.settings, grounding)
        self._ways = Ways()
        self._gone: tuple[Way, Posterior] | None = None  # the way of the last step, and its answer
        self._asked: Recent[tuple[Any, ...], list[Asked] | None] = Recent(2048)
        self._continuous = continuous
        self._nothing = np.full((len(self._names) + 1, batch), UNOBSERVED, np.int64)
        self._told_rows: dict[tuple[str, ...], Indices] = {}
        self._rows_of: dict[str, Indices] = {}
        self.object_in: dict[str, Indices] = {}
        """By class whose objects are alike, an array (W, n) of the object in each place of an agent's own order."""
        self._place_of: dict[str, Indices] = {}
        self.impossible_count = np.zeros(batch, np.int64)
        """How often an agent's readings were impossible."""
        self.log_likelihood = np.zeros(batch)
        """ln P(readings since the agent began)."""
        self.answers: list[tuple[Indices, Posterior]] = []
        """Of the last step: agents and their posteriors, in their own order of objects."""
        self._answered_for: dict[str, Indices] = {}
        self._cohorts: list[_Cohort] = []
        self.reset()

    def _examples(self) -> list[tuple[str, ...]]:
        """One tuple of each relation that can hold."""
        found: list[tuple[str, ...]] = []
        for relation in self.grounding.model.relations:
            names: list[str] = []
            for _, class_name in relation.roles:
                free = [o for o in self.grounding.members[class_name] if o not in names]
                names += free[:1]
            if len(names) == len(relation.roles):
                found.append((canonical_tuple(relation.name, names),))
        return found

    # ------------------------------------------------------------------------------------------------- life

    def reset(self, agents: Any = None) -> None:
        """Let agents begin anew from the prior.

        Parameters
        ----------
        agents : (W,) bool array or indices, optional
            Which; all if not given.
        """
        chosen = np.zeros(self.batch, bool)
        chosen[slice(None) if agents is None else agents] = True
        self.log_likelihood[chosen] = 0.0
        for orders in (self.object_in, self._place_of):
            for class_name, order in orders.items():
                orders[class_name] = np.where(chosen[:, None], np.arange(order.shape[1]), order)
        if not self._divisible:
            self._reset_undivided(chosen)
            return
        kept = [self._those(c, c.agents[~chosen[c.agents]]) for c in self._cohorts if not chosen[c.agents].all()]
        if chosen.any():
            kept.append(self._beginners(np.flatnonzero(chosen)))
        self._settle(kept)

    def _reset_undivided(self, chosen: NDArray[np.bool_]) -> None:
        """As `reset`, for a belief that cannot be divided among agents: one cohort of all, or one for each."""
        if not self._cohorts:
            everybody = np.arange(self.batch)
            self._settle([self._beginners(part) for part in ([everybody] if self._alike else np.split(everybody, self.batch))])
            return
        renewed = []
        for cohort in self._cohorts:
            mask = chosen[cohort.agents]
            if mask.all():
                cohort = self._beginners(cohort.agents)
            elif mask.any():
                cohort = cohort._replace(state=filtering.begin_anew(cohort.state, mask))
            renewed.append(cohort)
        self._settle(renewed)

    def take(self, other: FilterBank, agents: NDArray[np.bool_]) -> None:
        """Give agents, a (W,) bool array, the beliefs that they have in another bank of the same grounding, batch and engine."""
        kept = [self._those(c, c.agents[~agents[c.agents]]) for c in self._cohorts if not agents[c.agents].all()]
        taken = [other._those(c, c.agents[agents[c.agents]]) for c in other._cohorts if agents[c.agents].any()]
        for mine, theirs in ((self.object_in, other.object_in), (self._place_of, other._place_of)):
            for class_name in {*mine, *theirs}:
                usual = np.broadcast_to(np.arange(len(self.members[class_name])), (self.batch, len(self.members[class_name])))
                mine[class_name] = np.where(agents[:, None], theirs.get(class_name, usual), mine.get(class_name, usual))
        for numbers, given in ((self.log_likelihood, other.log_likelihood), (self.impossible_count, other.impossible_count)):
            numbers[agents] = given[agents]
        self._settle([*kept, *taken])

    def _beginners(self, agents: Indices) -> _Cohort:
        """A cohort that has made no step."""
        return _Cohort(agents, filtering.begin(self.settings, len(agents)))

    def _those(self, cohort: _Cohort, agents: Indices) -> _Cohort:
        """Some agents of a cohort; all of them stay in its order."""
        if len(agents) == len(cohort.agents):
            return cohort
        return _Cohort(agents, filtering.select(self.settings, cohort.state, self._position[agents]))

    def _settle(self, cohorts: Sequence[_Cohort]) -> None:
        """Join cohorts of one form, and note who is in which."""
        if len(cohorts) > 1 and self._divisible:
            by_form: dict[Any, list[_Cohort]] = {}
            for cohort in cohorts:
                by_form.setdefault(self._form(cohort.state), []).append(cohort)
            cohorts = [
                same[0]
                if len(same) == 1
                else _Cohort(np.concatenate([c.agents for c in same]), filtering.join(self.settings, [c.state for c in same]))
                for same in by_form.values()
            ]
        self._cohorts = list(cohorts)
        self._cohort_of = np.empty(self.batch, np.int64)
        self._position = np.empty(self.batch, np.int64)
        for k, cohort in enumerate(self._cohorts):
            self._cohort_of[cohort.agents] = k
            self._position[cohort.agents] = np.arange(len(cohort.agents))

    def _form(self, state: FilterState) -> Any:
        """What two beliefs must share to be one."""
        return self.settings.engine.form(state.belief), state.relations, state.step == 0, state.late

    # ------------------------------------------------------------------------------------------------- steps

    def step(self, evidence: Mapping[str, Any], relations: Sequence[Link] = (), due: NDArray[np.bool_] | None = None) -> None:
        """Go on by one slice.

        Parameters
        ----------
        evidence : dict of name to observation
            Of variables of objects and of relation tuples, and of what is given, as for `Filter.step`, for all W agents.
        relations : sequence of Link
            Which relations hold for whom in this slice.
        due : (W,) bool array, optional
            The agents that make a step; default all.

        Raises
        ------
        EvidenceError, ImpossibleEvidence, CostError
            As `Filter.step`; every belief is as it was.
        ParameterError
            For `due` of another shape.
        ModelError
            For relations that are no links.
        """
        due = np.ones(self.batch, bool) if due is None else np.asarray(due)
        if due.shape != (self.batch,) or due.dtype != bool:
            raise ParameterError(f"due: expected {self.batch} truth values, one for each agent, got {due.dtype} of shape {due.shape}")
        if not isinstance(evidence, Mapping):
            raise EvidenceError(f"evidence is a mapping of variables to what was observed, got {evidence!r:.60}")
        evidence, numbers = self._numbers(evidence)
        hard, others = self._read(evidence, numbers)
        if self._goes_alone(due, others, numbers):
            self._step_alone(hard, one_or_many(relations, "relations"))
            return
        ties = [self._tie(link, due) for link in one_or_many(relations, "relations")]
        self._turn(self._engaged(ties), due)
        hard = self._renumbered(hard)
        after: list[_Cohort] = []
        answers: list[tuple[Indices, Posterior]] = []
        settings, grounding = self.settings, self.grounding
        for cohort, tuples in self._groups(ties, due):
            if tuples is None:
                after.append(cohort)
                continue
            agents, state = cohort
            situation = grounding.situation(tuples, None, state.relations if state.step else None)
            info = filtering.slice_info(settings, state, grounding.ground(situation, first=state.step == 0))
            readings = self._readings(info, hard, others, numbers, agents)
            state, posterior = filtering.advance(settings, state, readings, situation, info)
            answers.append((agents, posterior))
            after.append(_Cohort(agents, state))
        for agents, posterior in answers:
            self.log_likelihood[agents] += posterior.increment
            self.impossible_count[agents] += posterior.impossible
        self.answers, self._answered_for = answers, dict(self._place_of)
        self._settle(after)

    def _goes_alone(self, due: NDArray[np.bool_], others: Mapping[str, Any], numbers: Mapping[str, Numbers]) -> bool:
        """Whether this is a step of one agent whose next slice follows from whom he means."""
        return self.batch == 1 and self._divisible and bool(due[0]) and not others and not numbers

    def _step_alone(self, hard: NDArray[np.int64], links: Sequence[Link]) -> None:
        """As `step`, of the only agent: what follows from his relations is looked up where he has been there before."""
        agents, state = self._cohorts[0]
        stand = self._ways.stand(state, self.object_in)
        way = stand.way(links)
        if way is None:
            way = stand.leads(links, self._way(links))
            state = self._cohorts[0].state
        elif way.names:
            state = self._renamings.of(state, way.names)
        if len(way.lost) and (hard[way.lost] >= 0).any():
            self._readings(way.info, self._renumbered(hard), {}, {}, agents)  # says which
        readings = Readings(hard[way.rows], {})
        state, posterior = filtering.advance(self.settings, state, readings, way.situation, way.info)
        self.log_likelihood += posterior.increment
        self.impossible_count += posterior.impossible
        self.object_in, self._place_of = dict(way.object_in), dict(way.place_of)
        self.answers, self._answered_for = [(agents, posterior)], dict(way.place_of)
        self._cohorts = [_Cohort(agents, state)]
        self._ways.went(way, state, self.object_in)
        self._gone = way, posterior

    def _way(self, links: Sequence[Link]) -> Way:
        """Turn to the objects in relations, and what the next slice of the only agent is then."""
        everybody = np.ones(1, bool)
        ties = [self._tie(link, everybody) for link in links]
        names = self._turn(self._engaged(ties), everybody).get(0, {})
        ((cohort, tuples),) = self._groups(ties, everybody)
        state = cohort.state
        situation = self.grounding.situation(tuples or (), None, state.relations if state.step else None)
        info = filtering.slice_info(self.settings, state, self.grounding.ground(situation, first=state.step == 0))
        told, rows = self._renumbered(np.arange(len(self._names) + 1)[:, None])[:, 0], self._rows(info)
        return Way(names, situation, info, told[rows.found], told[rows.lost], dict(self.object_in), dict(self._place_of))

    def _numbers(self, evidence: Mapping[str, Any]) -> tuple[Mapping[str, Any], dict[str, Numbers]]:
        """What is told of states, and of real numbers, with the defaults of those that are given."""
        if not self._continuous:
            return evidence, {}
        numbers: dict[str, Numbers] = {}
        rest: dict[str, Any] = {}
        for name, value in evidence.items():
            variable = self.variable(name)
            if variable.quantity is None:
                rest[name] = value
            else:
                numbers[name] = read_numbers(variable, value, self.batch)
        for name, default in self._quantities.items():
            numbers[name] = numbers.get(name, nothing(self.batch)).filled(default)
        return rest, numbers

    def _read(self, evidence: Mapping[str, Any], numbers: Mapping[str, Numbers]) -> tuple[NDArray[np.int64], dict[str, NDArray[np.int64]]]:
        """What is told of objects, with a last row of nothing, and what is told of variables that only some relations have."""
        others: dict[str, NDArray[np.int64]] = {}
        if isinstance(evidence, StateRows) and evidence.checked and not numbers and self._all_known(evidence.names):
            hard = self._nothing.copy()
            hard[self._told_rows[evidence.names]] = evidence.states
            self._fill_in(hard)
            return hard, others
        if not evidence.keys() <= self._row.keys():
            for name in evidence.keys() - self._row.keys():
                others[name] = np.broadcast_to(np.asarray(state_of(self.variable(name), evidence[name]), np.int64), (self.batch,))
            evidence = {name: value for name, value in evidence.items() if name in self._row}
        hard = read_hard(self.variables, self._names, self._cards, self._row, evidence, self.batch)
        for name, read in numbers.items():
            if name in self._row:
                hard[self._row[name]] = np.where(read.seen, 0, UNOBSERVED)
            else:
                others[name] = np.where(read.seen, 0, UNOBSERVED)
        self._fill_in(hard)
        return np.concatenate([hard, self._nothing[:1]]), others

    def _all_known(self, names: tuple[str, ...]) -> bool:
        """Whether all variables are objects'; then their rows are in `_told_rows`."""
        if names not in self._told_rows:
            if not all(name in self._row for name in names):
                return False
            self._told_rows[names] = np.array([self._row[name] for name in names], np.int64)
        return True

    def _fill_in(self, hard: NDArray[np.int64]) -> None:
        """Put the defaults of what is given where nothing is told, in place."""
        for row, name, default in self._given:
            missing = hard[row] < 0
            if missing.any():
                if default < 0:
                    raise EvidenceError(f"{name!r} must be given for every agent in every slice: it has no default")
                hard[row, missing] = default

    def variable(self, name: str) -> GroundVariable:
        """A variable of an object, or of a relation tuple, ``"possesses(o3,ball).shoot"``.

        Raises
        ------
        EvidenceError
        """
        if name in self.variables:
            return self.variables[name]
        owner = name.partition(".")[0]
        known = self.grounding.ground((owner,)).variables if "(" in owner else self.variables
        if name not in known:
            raise EvidenceError(f"evidence for unknown variable {name!r}.{did_you_mean(name, known)}")
        return known[name]

    def _readings(
        self,
        info: SliceInfo,
        hard: NDArray[np.int64],
        others: Mapping[str, NDArray[np.int64]],
        numbers: Mapping[str, Numbers],
        agents: Indices,
    ) -> Readings:
        """Readings as a slice wants them."""
        rows = self._rows_in.fetch(info, lambda: self._rows(info))
        if len(rows.lost) and (hard[np.ix_(rows.lost, agents)] >= 0).any():
            seen = rows.lost[(hard[np.ix_(rows.lost, agents)] >= 0).any(axis=1)]
            raise EvidenceError(f"evidence for {self._names[seen[0]]!r}, which does not exist with {', '.join(info.slice.relations)}")
        out = hard[rows.found] if len(agents) == self.batch and self._in_order(agents) else hard[rows.found[:, None], agents]
        for name, states in others.items():
            for k in np.flatnonzero(states[agents] >= 0):
                own = self._own_name(name, int(agents[k]), self._place_of)
                if own not in info.row:
                    raise EvidenceError(f"evidence for {name!r}, which does not exist for agent {agents[k]} in this slice")
                out[info.row[own], k] = states[agents[k]]
        return Readings(out, {}, {name: read.rows(agents) for name, read in numbers.items() if name in info.row})

    def _in_order(self, agents: Indices) -> bool:
        return bool((agents[:-1] < agents[1:]).all())

    def _rows(self, info: SliceInfo) -> _Rows:
        found = np.array([self._row.get(name, -1) for name in info.names], np.int64)
        return _Rows(found, np.array([row for name, row in self._row.items() if name not in info.row], np.int64))

    def _tie(self, link: Link, due: NDArray[np.bool_]) -> Tie:
        """A link with a role for every object, and for whom it holds."""
        if not isinstance(link, Link):
            raise ModelError(f"relations: a filter bank takes Link(relation, roles), got {type(link).__name__} {link!r:.60}")
        roles = []
        for role in link.roles:
            if isinstance(role, str):
                class_name = self.grounding.objects.get(role)
                if class_name is None:
                    raise ModelError(f"a link names the unknown object {role!r}.{did_you_mean(role, self.grounding.objects)}")
                role = Role(class_name, np.full(self.batch, self.members[class_name].index(role)))
            roles.append(role)
        return Tie(link.relation, tuple(roles), due & np.logical_and.reduce([role.index >= 0 for role in roles]))

    def _engaged(self, ties: Sequence[Tie]) -> dict[str, NDArray[np.bool_]]:
        """For each class of several objects that are alike: (W, n), which of them stand in relations."""
        engaged: dict[str, NDArray[np.bool_]] = {}
        for tie in ties:
            for role in tie.roles:
                if self._are_alike(role.class_name):
                    marks = engaged.setdefault(role.class_name, np.zeros((self.batch, len(self.members[role.class_name])), bool))
                    marks[tie.held, role.index[tie.held]] = True
        return engaged

    def _turn(self, engaged: Mapping[str, NDArray[np.bool_]], due: NDArray[np.bool_]) -> dict[int, dict[str, str]]:
        """Let every agent's own order begin with the objects in its relations, and rename beliefs accordingly; the new names by agent.

        Who is in front already keeps his place; who was and is no longer comes next, so that a belief's form says little about
        where it comes from.
        """
        renamed: dict[int, dict[str, str]] = {}
        for class_name, marks in engaged.items():
            if class_name not in self.object_in:
                self.object_in[class_name] = self._place_of[class_name] = np.broadcast_to(np.arange(marks.shape[1]), marks.shape)
            last = np.where(marks, self._place_of[class_name], -1).max(axis=1)
            turning = np.flatnonzero((last >= marks.sum(axis=1)) & due)
            if not len(turning):
                continue
            self.object_in[class_name] = order = self.object_in[class_name].copy()
            names = self.members[class_name]
            for k in turning.tolist():
                came_from = fronted(marks[k][order[k]].tolist())
                order[k] = order[k][came_from]
                renamed.setdefault(k, {}).update({names[old]: names[new] for new, old in enumerate(came_from) if new != old})
            self._place_of[class_name] = np.argsort(order, axis=1)
        if not renamed:
            return renamed
        parts: dict[Any, list[int]] = {}
        for k in range(self.batch):
            parts.setdefault((self._cohort_of[k], tuple(renamed.get(k, {}).items())), []).append(k)
        cohorts = []
        for (number, pairs), members in parts.items():
            part = self._those(self._cohorts[number], np.array(members))
            cohorts.append(part._replace(state=self._renamings.of(part.state, dict(pairs))) if pairs else part)
        self._settle(cohorts)
        return renamed

    def _codes(self, ties: Sequence[Tie]) -> dict[tuple[str, ...], NDArray[np.int64]]:
        """For each kind of tie the tuples that hold for an agent, as sorted numbers (W, k) that `tuples_of` reads; -1 fills up."""
        kinds: dict[tuple[str, ...], list[NDArray[np.int64]]] = {}
        everybody = np.arange(self.batch)
        for tie in ties:
            code = np.zeros(self.batch, np.int64)
            for role in tie.roles:
                index = np.maximum(role.index, 0)
                if role.class_name in self._place_of:
                    index = self._place_of[role.class_name][everybody, index]
                code = code * len(self.members[role.class_name]) + index
            kind = (tie.relation, *(role.class_name for role in tie.roles))
            kinds.setdefault(kind, []).append(np.where(tie.held, code, -1))
        return {kind: as_sets(np.stack(columns, axis=1)) for kind, columns in kinds.items()}

    def _are_alike(self, class_name: str) -> bool:
        """Whether the several objects of a class differ in their names only: nothing refers to them."""
        return self._exchangeable and len(self.members[class_name]) > 1

    def _renumbered(self, hard: NDArray[np.int64]) -> NDArray[np.int64]:
        """Readings in every agent's own order of objects."""
        out = hard
        for class_name, order in self.object_in.items():
            rows = self._rows_of.get(class_name)
            if rows is None:
                names = self.members[class_name]
                attributes = [n.partition(".")[2] for n in self._names if n.partition(".")[0] == names[0]]
                rows = self._rows_of[class_name] = np.array([[self._row[f"{o}.{a}"] for o in names] for a in attributes])
            out = out.copy() if out is hard else out
            out[rows] = np.take_along_axis(hard[rows], order.T[None], axis=1)
        return out

    def _groups(self, ties: Sequence[Tie], due: NDArray[np.bool_]) -> list[tuple[_Cohort, tuple[str, ...] | None]]:
        """Agents who can step together, and with which relations; None: they are not due."""
        if self.batch == 1:
            (cohort,) = self._cohorts
            return [(cohort, tuple(self._named(tie) for tie in ties if tie.held[0]) if due[0] else None)]
        codes = self._codes(ties)
        table = np.column_stack([self._cohort_of, ~due, *codes.values()])
        keys, group_of = np.unique(table, axis=0, return_inverse=True)
        order = np.argsort(group_of.ravel(), kind="stable")
        bounds = np.searchsorted(group_of.ravel()[order], np.arange(len(keys) + 1))
        groups: list[tuple[_Cohort, tuple[str, ...] | None]] = []
        for k, (cohort_number, idle, *numbers) in enumerate(keys.tolist()):
            cohort = self._those(self._cohorts[cohort_number], order[bounds[k] : bounds[k + 1]])
            relations: list[str] = []
            for kind, columns in codes.items():
                relations += tuples_of(kind, numbers[: columns.shape[1]], self.members)
                numbers = numbers[columns.shape[1] :]
            groups.append((cohort, None if idle else tuple(relations)))
        return groups

    def _named(self, tie: Tie) -> str:
        """The relation tuple of the only agent."""
        names = []
        for role in tie.roles:
            index, place_of = role.index[0], self._place_of.get(role.class_name)
            names.append(self.members[role.class_name][index if place_of is None else place_of[0, index]])
        return canonical_tuple(tie.relation, names)

    # ------------------------------------------------------------------------------------------------- names

    def _own_name(self, variable: str, agent: int, place_of: Mapping[str, Indices]) -> str:
        """The name of a variable in an agent's own order of objects."""
        owner, dot, attribute = variable.partition(".")
        own = {
            o: self.members[c][place_of[c][agent, self.members[c].index(o)]]
            for o in (parse_tuple(owner)[1] if "(" in owner else (owner,))
            for c in (self.grounding.objects.get(o, ""),)
            if c in place_of
        }
        return variable if not own else (rename_tuple(owner, own) if "(" in owner else own[owner]) + dot + attribute

    # ------------------------------------------------------------------------------------------------- answers

    def view(self, view: View, variable: str) -> NDArray[np.float64]:
        """A number of the posterior of an object's variable.

        Returns
        -------
        (W,) float array
            NaN for agents that did not take part in the last step.
        """
        owner, _, attribute = variable.partition(".")
        class_name = self.grounding.objects.get(owner, "")
        if class_name not in self._answered_for:
            if self.batch == 1 and self.answers and not self._answered_for and variable in (alone := self.answers[0][1]):
                return np.asarray(view(alone[variable], alone.variables[variable]))
            out = np.full(self.batch, np.nan)
            for agents, posterior in self.answers:
                for own, inside in self._by_own_name(variable, agents).items():
                    if own in posterior:
                        out[agents[inside]] = view(posterior[own][inside], posterior.variables[own])
            return out
        return self.view_of(view, Role(class_name, np.full(self.batch, self.members[class_name].index(owner))), attribute)

    def views(self, questions: tuple[Question, ...], held: NDArray[np.int32]) -> NDArray[np.float64] | None:
        """All numbers that are asked of the only agent at once; None where each has to be asked for itself.

        Parameters
        ----------
        questions : tuple of Question
        held : (1, n) int32 array
            Numbers of the objects that the agent means, -1 for nobody.

        Returns
        -------
        (1, len(questions)) float array
        """
        if self._gone is None or not self.answers or self.answers[0][1] is not self._gone[1]:
            return None
        way, posterior = self._gone
        result = posterior.result
        if not isinstance(result, FactoredResult) or result.alone is None or result.replaced:
            return None
        program, flat = result.alone
        key = program, way, held.tobytes(), questions
        asked = self._asked.fetch(
            key,
            lambda: find(questions, held[0].tolist(), self.members, way.place_of, result.info.variables, result.slice_step, program),
        )
        if asked is None:
            return None
        out = np.empty((1, len(questions)))
        for where, read in asked:
            out[0, where] = read(flat)
        return out

    def _by_own_name(self, variable: str, agents: Indices) -> dict[str, Any]:
        """The names that a variable has in the own orders of agents, and who of them has each."""
        if "(" not in variable.partition(".")[0] or not self._answered_for:
            return {variable: slice(None)}
        names: dict[str, list[int]] = {}
        for k, agent in enumerate(agents.tolist()):
            names.setdefault(self._own_name(variable, agent, self._answered_for), []).append(k)
        return {own: np.array(inside) for own, inside in names.items()}

    def view_of(self, view: View, whom: Role, attribute: str) -> NDArray[np.float64]:
        """As `view`, of the object that each agent means; NaN for those who mean nobody."""
        out = np.full(self.batch, np.nan)
        names = self.members[whom.class_name]
        place_of = self._answered_for.get(whom.class_name)
        where = whom.index if place_of is None else place_of[np.arange(self.batch), np.maximum(whom.index, 0)]
        if self.batch == 1 and self.answers and whom.index[0] >= 0:
            ((_, posterior),) = self.answers
            variable = f"{names[where[0]]}.{attribute}"
            return np.asarray(view(posterior[variable], posterior.variables[variable]))
        for agents, posterior in self.answers:
            meant = np.where(whom.index[agents] < 0, -1, where[agents])
            for place in np.unique(meant[meant >= 0]):
                inside = meant == place
                variable = f"{names[place]}.{attribute}"
                out[agents[inside]] = view(posterior[variable][inside], posterior.variables[variable])
        return out

    def marginal(self, variable: str, agent: int = 0) -> Any:
        """The posterior of a variable in an agent's last step, (card,); of a real number a `NormalMixture` of one agent.

        States of a variable of the model's own that name objects, of a mixture's selector, name them in the agent's own order.

        Raises
        ------
        ModelError
            If the agent took no part in the last step, or there is no such variable.
        """
        own = self._own_name(variable, agent, self._answered_for)
        for agents, posterior in self.answers:
            at = np.flatnonzero(agents == agent)
            if len(at):
                if own not in posterior:
                    hint = did_you_mean(variable, self.variables)
                    raise ModelError(f"no variable {variable!r} in the last slice of agent {agent}.{hint}")
                found = posterior[own]
                return np.asarray(found[at[0]]) if isinstance(found, np.ndarray) else found[at[:1]]
        raise ModelError(f"agent {agent} took no part in the last step")

    def alone(self, agent: int) -> Filter:
        """A filter of its own for an agent, from where the agent stands, to look ahead with; objects have their own names."""
        cohort = self._cohorts[self._cohort_of[agent]]
        state = self._those(cohort, np.array([agent])).state
        names = {
            self.members[c][place]: self.members[c][index]
            for c, order in self.object_in.items()
            for place, index in enumerate(order[agent])
            if place != index
        }
        return Filter.of(self.settings, self._renamings.of(state, names) if names else state)
