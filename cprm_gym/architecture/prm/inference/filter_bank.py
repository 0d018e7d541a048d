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

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import ModelError, did_you_mean
from ..grounding.grounding import Grounding, Situation
from ..model.schema import canonical_tuple, parse_tuple
from .compiled.steps import Layout, Node, Piece, Recent
from .engines.exact import FactoredBelief
from .evidence import UNOBSERVED, StateRows, read_hard
from .filter import Filter
from .posterior import Past, Result, Snapshot
from .views import View

__all__ = ["FilterBank", "Link", "Role"]

Indices = NDArray[np.integer[Any]]
Pairs = tuple[tuple[str, str], ...]


@dataclass(frozen=True, eq=False)
class Role:
    """Whom each agent means: ``index[k]`` numbers the objects of the class in their order; -1 is nobody."""

    class_name: str
    index: Indices


@dataclass(frozen=True, eq=False)
class Link:
    """A relation that holds for those agents who mean somebody in all of its roles; a fixed object is given by its name."""

    relation: str
    roles: tuple[str | Role, ...]


@dataclass(frozen=True)
class _Cohort:
    """Agents whose beliefs have the same form, and the state of a filter for them, in their order."""

    agents: Indices
    state: Snapshot


class _Tie(NamedTuple):
    """A link as numbers: the objects that agents mean in each role, and for which agents it holds, (W,)."""

    relation: str
    roles: tuple[Role, ...]
    held: NDArray[np.bool_]


class _Renaming(NamedTuple):
    """The layout of a renamed belief, and where its readings and, for each array, its objects stood before (None: as they are)."""

    layout: Layout
    rows: Indices
    objects: tuple[Indices | None, ...]


class FilterBank:
    """Filters of W agents, each with its own relations.

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
        engine: Any = "exact",
        *,
        on_impossible: str = "raise",
        seed: Any = None,
        alike: bool = False,
    ) -> None:
        self.grounding = grounding
        self.batch = batch
        self._pilot = Filter(grounding, batch, engine, on_impossible=on_impossible, seed=seed)
        base = grounding.ground((), first=True)
        self.variables = base.variables
        """Of a slice without relations."""
        self._names = tuple(base.variables)
        self._row = {name: i for i, name in enumerate(self._names)}
        self._cards = np.array([v.card for v in base.variables.values()], np.int64)
        self._given = set(base.given)
        self.members: dict[str, tuple[str, ...]] = {}
        """Class -> its objects, without those of its subclasses."""
        for name, class_name in grounding.objects.items():
            self.members[class_name] = (*self.members.get(class_name, ()), name)
        self._factored = isinstance(self._pilot.belief, FactoredBelief) and not hasattr(self._pilot.engine, "snapshot")
        self._alike = alike
        if self._factored and not alike:
            self._pilot.foresee(*self._examples())
        self._renamings: Recent[tuple[Layout, Pairs], _Renaming] = Recent(1024)
        self._likenesses: dict[str, bool] = {}
        self._told: Recent[tuple[tuple[str, ...], int], list[str]] = Recent(16)
        self._rows_in: Recent[tuple[str, ...], Indices] = Recent(256)
        self._rows_of: dict[str, Indices] = {}
        self.object_in: dict[str, Indices] = {}
        """Class -> (W, n): the object in each place of an agent's own order, for classes whose objects are alike."""
        self._place_of: dict[str, Indices] = {}
        self.impossible_count = np.zeros(batch, np.int64)
        """How often an agent's readings were impossible."""
        self.log_likelihood = np.zeros(batch)
        """ln P(readings since the agent began)."""
        self.answers: list[tuple[Indices, Result]] = []
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
        if not self._factored:
            self._reset_samples(chosen)
            return
        kept = [self._those(c, c.agents[~chosen[c.agents]]) for c in self._cohorts if not chosen[c.agents].all()]
        if chosen.any():
            kept.append(self._beginners(np.flatnonzero(chosen)))
        self._settle(kept)

    def _reset_samples(self, chosen: NDArray[np.bool_]) -> None:
        """As `reset`, for a belief that cannot be divided among agents: one cohort of all, or one for each."""
        if not self._cohorts:
            cohorts = [self._beginners(np.arange(self.batch))] if self._alike else []
            for k in range(0 if self._alike else self.batch):
                self._pilot.engine.branch()
                cohorts.append(self._beginners(np.array([k])))
            self._settle(cohorts)
            return
        renewed = []
        for cohort in self._cohorts:
            mask = chosen[cohort.agents]
            if mask.any():
                self._pilot.restore(cohort.state)
                self._pilot.reset(mask)
                cohort = replace(cohort, state=self._pilot.snapshot())
            renewed.append(cohort)
        self._settle(renewed)

    def _beginners(self, agents: Indices) -> _Cohort:
        """A cohort that has made no step."""
        pilot = self._pilot
        pilot.batch = len(agents)
        pilot.impossible_count = np.zeros(len(agents), np.int64)
        pilot.reset()
        return _Cohort(agents, pilot.snapshot())

    def _those(self, cohort: _Cohort, agents: Indices) -> _Cohort:
        """Some agents of a cohort; all of them stay in its order."""
        if len(agents) == len(cohort.agents):
            return cohort
        return _Cohort(agents, select(cohort.state, self._position[agents]))

    def _settle(self, cohorts: Sequence[_Cohort]) -> None:
        """Join cohorts of one form, and note who is in which."""
        by_form: dict[Any, list[_Cohort]] = {}
        for cohort in cohorts:
            by_form.setdefault(self._form(cohort.state), []).append(cohort)
        self._cohorts = [
            same[0] if len(same) == 1 else _Cohort(np.concatenate([c.agents for c in same]), joined([c.state for c in same]))
            for same in by_form.values()
        ]
        self._cohort_of = np.empty(self.batch, np.int64)
        self._position = np.empty(self.batch, np.int64)
        for k, cohort in enumerate(self._cohorts):
            self._cohort_of[cohort.agents] = k
            self._position[cohort.agents] = np.arange(len(cohort.agents))

    def _form(self, state: Snapshot) -> Any:
        """What two beliefs must share to be one; nothing does for beliefs that are not factors."""
        if not self._factored:
            return id(state)
        relations = state.relations.relations if isinstance(state.relations, Situation) else ()
        return state.belief.layout, relations, state.step == 0, tuple(state.static), state.owners

    # ------------------------------------------------------------------------------------------------- steps

    def step(self, evidence: Mapping[str, Any], links: Sequence[Link] = (), due: NDArray[np.bool_] | None = None) -> None:
        """Go on by one slice.

        Parameters
        ----------
        evidence : dict of name to observation
            Of variables, and of what is given, as for `Filter.step`, for all W agents.
        links : sequence of Link
            Which relations hold for whom in this slice.
        due : (W,) bool array, optional
            The agents that make a step; default all.

        Raises
        ------
        EvidenceError, ImpossibleEvidence, CostError
            As `Filter.step`; every belief is as it was.
        """
        due = np.ones(self.batch, bool) if due is None else due
        hard = read_hard(self.variables, self._names, self._cards, self._row, evidence, self.batch)
        told = [name for name in self._names if name in evidence]
        ties = [self._tie(link, due) for link in links]
        self._turn(self._engaged(ties, told), due)
        hard = self._renumbered(hard)
        told = self._told.fetch((tuple(told), len(self.object_in)), lambda: self._told_of_any(told))
        after: list[_Cohort] = []
        answers: list[tuple[Indices, Result]] = []
        for cohort, relations in self._groups(ties, due):
            if relations is None:
                after.append(cohort)
                continue
            self._pilot.restore(cohort.state)
            readings = self._readings(hard[:, cohort.agents], told, relations)
            answers.append((cohort.agents, self._pilot.step(readings, relations=relations)))
            after.append(_Cohort(cohort.agents, self._pilot.snapshot()))
        for agents, result in answers:
            self.log_likelihood[agents] += result.increment
            self.impossible_count[agents] += result.impossible
        self.answers, self._answered_for = answers, dict(self._place_of)
        self._settle(after)

    def _tie(self, link: Link, due: NDArray[np.bool_]) -> _Tie:
        """A link with a role for every object, and for whom it holds."""
        roles = []
        for role in link.roles:
            if isinstance(role, str):
                class_name = self.grounding.objects.get(role)
                if class_name is None:
                    raise ModelError(f"a link names the unknown object {role!r}.{did_you_mean(role, self.grounding.objects)}")
                role = Role(class_name, np.full(self.batch, self.members[class_name].index(role)))
            roles.append(role)
        return _Tie(link.relation, tuple(roles), due & np.logical_and.reduce([role.index >= 0 for role in roles]))

    def _engaged(self, ties: Sequence[_Tie], told: Sequence[str]) -> dict[str, NDArray[np.bool_]]:
        """For each class of several objects that are alike: (W, n), which of them stand in relations."""
        engaged: dict[str, NDArray[np.bool_]] = {}
        for tie in ties:
            for role in tie.roles:
                if self._are_alike(role.class_name, told):
                    marks = engaged.setdefault(role.class_name, np.zeros((self.batch, len(self.members[role.class_name])), bool))
                    marks[tie.held, role.index[tie.held]] = True
        return engaged

    def _turn(self, engaged: Mapping[str, NDArray[np.bool_]], due: NDArray[np.bool_]) -> None:
        """Let every agent's own order begin with the objects in its relations, and rename beliefs accordingly.

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
                came_from = _fronted(marks[k][order[k]].tolist())
                order[k] = order[k][came_from]
                renamed.setdefault(k, {}).update({names[old]: names[new] for new, old in enumerate(came_from) if new != old})
            self._place_of[class_name] = np.argsort(order, axis=1)
        if not renamed:
            return
        parts: dict[Any, list[int]] = {}
        for k in range(self.batch):
            parts.setdefault((self._cohort_of[k], tuple(renamed.get(k, {}).items())), []).append(k)
        cohorts = []
        for (number, pairs), members in parts.items():
            part = self._those(self._cohorts[number], np.array(members))
            cohorts.append(replace(part, state=self._with_names(part.state, dict(pairs))) if pairs else part)
        self._settle(cohorts)

    def _codes(self, ties: Sequence[_Tie]) -> dict[tuple[str, ...], NDArray[np.int64]]:
        """For each kind of tie the tuples that hold for an agent, as sorted numbers (W, k) that `_tuples` reads; -1 fills up."""
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
        return {kind: _sets(np.stack(columns, axis=1)) for kind, columns in kinds.items()}

    def _are_alike(self, class_name: str, told: Sequence[str]) -> bool:
        """Whether the several objects of a class differ in their names only: nothing refers to them, givens are told of all or none."""
        known = self._likenesses.get(class_name)
        if known is None:
            model, members = self.grounding.model, {*self.members[class_name]}
            given: dict[str, set[str]] = {}
            for owner, _, attribute in (name.partition(".") for name in told if name in self._given):
                given.setdefault(attribute, set()).add(owner)
            known = self._likenesses[class_name] = (
                self._factored
                and len(members) > 1
                and not any(c.references for c in model.classes)
                and not self.grounding.static
                and all(not owners & members or owners >= members for owners in given.values())
            )
        return known

    def _readings(self, hard: NDArray[np.int64], told: Sequence[str], relations: tuple[str, ...]) -> StateRows | NDArray[np.int64]:
        """Readings as the next slice wants them: an array in its own order, or by name where what is given may take its default."""
        if not self._given <= set(told):
            return StateRows(tuple(told), hard[[self._row[name] for name in told]])
        names = self._pilot.variables(relations)
        rows = self._rows_in.fetch(names, lambda: np.array([names.index(name) for name in self._names]))
        out = np.full((len(names), hard.shape[1]), UNOBSERVED, np.int64)
        out[rows] = hard
        return out

    def _told_of_any(self, told: Sequence[str]) -> list[str]:
        """What is told of an object may be told of any in the agents' own orders."""
        names = dict.fromkeys(told)
        for name in told:
            owner, _, attribute = name.partition(".")
            class_name = self.grounding.objects.get(owner, "")
            if class_name in self.object_in:
                names.update(dict.fromkeys(f"{o}.{attribute}" for o in self.members[class_name]))
        return list(names)

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

    def _groups(self, ties: Sequence[_Tie], due: NDArray[np.bool_]) -> list[tuple[_Cohort, tuple[str, ...] | None]]:
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
                relations += self._tuples(kind, numbers[: columns.shape[1]])
                numbers = numbers[columns.shape[1] :]
            groups.append((cohort, None if idle else tuple(relations)))
        return groups

    def _named(self, tie: _Tie) -> str:
        """The relation tuple of the only agent."""
        names = []
        for role in tie.roles:
            index, place_of = role.index[0], self._place_of.get(role.class_name)
            names.append(self.members[role.class_name][index if place_of is None else place_of[0, index]])
        return canonical_tuple(tie.relation, names)

    def _tuples(self, kind: tuple[str, ...], numbers: Sequence[int]) -> list[str]:
        """Relation tuples from their numbers (`_codes`)."""
        relation, *classes = kind
        found = []
        for number in numbers:
            if number < 0:
                continue
            names = []
            for class_name in reversed(classes):
                number, index = divmod(number, len(self.members[class_name]))
                names.append(self.members[class_name][index])
            found.append(canonical_tuple(relation, reversed(names)))
        return found

    # ------------------------------------------------------------------------------------------------- names

    def _with_names(self, state: Snapshot, names: Mapping[str, str]) -> Snapshot:
        """A belief in which objects have other names."""
        if state.step == 0:
            return state
        situation = state.relations
        relations = tuple(sorted(_rename_tuple(r, names) for r in situation.relations))
        key = state.belief.layout, tuple(sorted(names.items()))
        layout, rows, objects = self._renamings.fetch(key, lambda: self._new_layout(state.belief.layout, relations, names))
        batch = state.belief.hard.shape[1]
        messages = tuple(
            m if at is None else m.reshape(len(at), batch, m.shape[1])[at].reshape(m.shape) for m, at in zip(state.belief.messages, objects)
        )
        belief = FactoredBelief(layout, messages, state.belief.hard[rows])
        return replace(state, belief=belief, relations=self.grounding.situation(relations), history=())

    def _new_layout(self, old: Layout, relations: tuple[str, ...], names: Mapping[str, str]) -> _Renaming:
        """A layout for other names; like objects stand in the order of their new names."""
        info = self._pilot.slice_info(self.grounding.ground(relations))
        assert old.info is not None
        name_of = {v.name: _rename_variable(v.name, v.object_name, names) for v in old.info.variables.values()}
        strange = set(name_of.values()) ^ set(info.names)
        if strange:
            raise ModelError(f"a belief cannot be renamed: {', '.join(sorted(strange)[:3])}")
        back = {new: old_name for old_name, new in name_of.items()}
        rows = np.array([old.info.row[back[name]] for name in info.names])
        moved = [
            Piece(p.group, p.instance, tuple(f._replace(scope=tuple((name_of[name], time) for name, time in f.scope)) for f in p.factors))
            for p in old.pieces
        ]
        first: dict[tuple[int, int], Node] = {}
        for p in moved:
            node = min(v for f in p.factors for v in f.scope)
            first[p.group, p.instance] = min(node, first.get((p.group, p.instance), node))
        objects: list[Indices | None] = []
        place: dict[tuple[int, int], int] = {}
        for group, count in enumerate(old.counts):
            order = sorted(range(count), key=lambda b: first.get((group, b), ("", b)))
            place.update({(group, b): k for k, b in enumerate(order)})
            objects.append(None if order == list(range(count)) else np.array(order))
        pieces = sorted((p._replace(instance=place[p.group, p.instance]) for p in moved), key=lambda p: (p.group, p.instance))
        held = {name_of[name]: info.row[name_of[name]] for name in old.held}
        return _Renaming(self._pilot.engine.compiler.layout(tuple(pieces), old.widths, old.counts, held, info), rows, tuple(objects))

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
            out = np.full(self.batch, np.nan)
            for agents, result in self.answers:
                out[agents] = view(result[variable], result.variables[variable])
            return out
        return self.view_of(view, Role(class_name, np.full(self.batch, self.members[class_name].index(owner))), attribute)

    def view_of(self, view: View, whom: Role, attribute: str) -> NDArray[np.float64]:
        """As `view`, of the object that each agent means; NaN for those who mean nobody."""
        out = np.full(self.batch, np.nan)
        names = self.members[whom.class_name]
        place_of = self._answered_for.get(whom.class_name)
        where = whom.index if place_of is None else place_of[np.arange(self.batch), np.maximum(whom.index, 0)]
        if self.batch == 1 and self.answers and whom.index[0] >= 0:
            ((_, result),) = self.answers
            variable = f"{names[where[0]]}.{attribute}"
            return np.asarray(view(result[variable], result.variables[variable]))
        for agents, result in self.answers:
            meant = np.where(whom.index[agents] < 0, -1, where[agents])
            for place in np.unique(meant[meant >= 0]):
                inside = meant == place
                variable = f"{names[place]}.{attribute}"
                out[agents[inside]] = view(result[variable][inside], result.variables[variable])
        return out

    def marginal(self, variable: str, agent: int = 0) -> NDArray[np.float64]:
        """The posterior of a variable in an agent's last step, (card,).

        States of a variable of the model's own that name objects, of a mixture's selector, name them in the agent's own order.

        Raises
        ------
        ModelError
            If the agent took no part in the last step, or there is no such variable.
        """
        owner, _, attribute = variable.partition(".")
        class_name = self.grounding.objects.get(owner, "")
        if class_name in self._answered_for:
            place = self._answered_for[class_name][agent, self.members[class_name].index(owner)]
            own = f"{self.members[class_name][place]}.{attribute}"
        else:
            own = variable
        for agents, result in self.answers:
            at = np.flatnonzero(agents == agent)
            if len(at):
                if own not in result:
                    hint = did_you_mean(variable, self.variables)
                    raise ModelError(f"no variable {variable!r} in the last slice of agent {agent}.{hint}")
                return np.asarray(result[own][at[0]])
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
        one = copy.copy(self._pilot)
        one._history = self._pilot._history.copy()
        one.restore(self._with_names(state, names) if names else state)
        return one


def select(state: Snapshot, agents: Indices) -> Snapshot:
    """The state of a filter for some of its agents."""
    history = state.history if state.step == 1 else ()  # what a first slice kept may still have to be changed
    history = tuple(Past(_selected(p.before, agents), p.info, p.readings.rows(agents), p.fresh[agents], p.relations) for p in history)
    return replace(
        state,
        belief=_selected(state.belief, agents),
        log_likelihood=state.log_likelihood[agents],
        fresh=state.fresh[agents],
        history=history,
        impossible=state.impossible[agents],
    )


def _selected(belief: FactoredBelief, agents: Indices) -> FactoredBelief:
    batch, objects = belief.hard.shape[1], belief.layout.counts
    blocks = (m.reshape(n, batch, m.shape[1])[:, agents] for m, n in zip(belief.messages, objects))
    messages = tuple(b.reshape(b.shape[0] * b.shape[1], b.shape[2]) for b in blocks)
    return belief._replace(messages=messages, hard=belief.hard[:, agents])


def joined(states: Sequence[Snapshot]) -> Snapshot:
    """The state of one filter for the agents of several whose beliefs have the same form."""
    first = states[0]
    return replace(
        first,
        belief=_joined([s.belief for s in states]),
        step=max(s.step for s in states),
        log_likelihood=np.concatenate([s.log_likelihood for s in states]),
        fresh=np.concatenate([s.fresh for s in states]),
        history=(),
        impossible=np.concatenate([s.impossible for s in states]),
        exact=all(s.exact for s in states),
    )


def _joined(beliefs: Sequence[FactoredBelief]) -> FactoredBelief:
    layout = beliefs[0].layout
    widths = [b.hard.shape[1] for b in beliefs]
    messages = []
    for g, columns in enumerate(layout.widths):
        blocks = [b.messages[g].reshape(layout.counts[g], w, columns) for b, w in zip(beliefs, widths)]
        messages.append(np.concatenate(blocks, axis=1).reshape(layout.counts[g] * sum(widths), columns))
    return FactoredBelief(layout, tuple(messages), np.concatenate([b.hard for b in beliefs], axis=1))


def _fronted(engaged: Sequence[bool]) -> list[int]:
    """An order of places that begins with the engaged ones: those in front stay, whom they drive out come next."""
    count = sum(engaged)
    late = [k for k in range(count, len(engaged)) if engaged[k]]
    front = [k if engaged[k] else late.pop(0) for k in range(count)]
    return [*front, *(k for k in range(len(engaged)) if not engaged[k])]


def _sets(codes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Each row as a set: sorted, repetitions replaced by -1."""
    codes = np.sort(codes, axis=1)
    again = codes[:, 1:] == codes[:, :-1]
    if again.any():
        codes[:, 1:][again] = -1
        codes.sort(axis=1)
    return codes


def _rename_tuple(text: str, names: Mapping[str, str]) -> str:
    relation, objects = parse_tuple(text)
    return canonical_tuple(relation, (names.get(o, o) for o in objects))


def _rename_variable(variable: str, owner: str, names: Mapping[str, str]) -> str:
    if not owner or not variable.startswith(owner):
        return variable
    return (_rename_tuple(owner, names) if "(" in owner else names.get(owner, owner)) + variable[len(owner) :]
