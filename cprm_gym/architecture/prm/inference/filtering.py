"""Filtering with the state as a value: `advance` takes a state, readings and relations, and gives a new state and the posterior.

Nothing here is changed in place: a state may be kept, carried on in two ways, cut into agents or joined again. `Filter` remembers one
state, `FilterBank` one for each form of belief among its agents; looking ahead and Jeffrey's rule carry a state on and forget it.

    settings = FilterSettings(grounding, make_engine("exact"))
    state = begin(settings, batch=1000)
    state, posterior = advance(settings, state, readings, relations)

The relations in force are fixed before a slice is predicted. They may be any function of what happened before (a Petri net
decides them): they are context and contribute nothing to the likelihood. The answer is that of the unrolled, non-homogeneous net.
Readings that have a probability below some 1e-300 in one component of one step count as impossible; give CPDs a floor, as
integrated ones have.

References
----------
Dissertation sections 2.3.3 and 2.3.4; Murphy, Dynamic Bayesian Networks, 2002.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ....errors import EvidenceError, ModelError
from ..grounding.slices import STATIC, Grounds, GroundSlice, GroundVariable
from ..model.domains import Index, Interval
from . import smoothing
from .compiled.slice_info import NeedsVariable, SliceInfo
from .continuous.number_evidence import Numbers, nothing
from .engines.conflicts import impossible_evidence, softened
from .engines.engine import Engine, StepResult
from .evidence import UNOBSERVED, Readings, StateRows, jeffrey_likelihood, read_hard, read_soft, split_numbers
from .posterior import Posterior

POLICIES = ("raise", "drop", "soften", "restart")


class Past(NamedTuple):
    """What is remembered of a step: the belief before it, the slice, the readings, who began anew and the relations."""

    before: Any
    info: SliceInfo
    readings: Readings
    fresh: np.ndarray
    relations: Any


class FilterState(NamedTuple):
    """All that a filter knows; a value.

    Attributes
    ----------
    belief : engine's own kind
        After the last slice.
    step : int
        Number of slices so far.
    log_likelihood : (W,) float array
        ln P(readings since the agent began).
    fresh : (W,) bool array
        Agents who begin anew with the next slice.
    impossible : (W,) int array
        How often an agent's readings were impossible.
    history : tuple of Past
        The last slices, at least one.
    relations : grounding's own kind
        What held in the last slice.
    exact : bool
        No step has approximated anything.
    info : SliceInfo or None
        The last slice.
    late : frozenset of str
        Static variables that only the second slice told of.
    """

    belief: Any
    step: int
    log_likelihood: np.ndarray
    fresh: np.ndarray
    impossible: np.ndarray
    history: tuple[Past, ...] = ()
    relations: Any = ()
    exact: bool = True
    info: SliceInfo | None = None
    late: frozenset[str] = frozenset()

    @property
    def batch(self) -> int:
        """Number of agents."""
        return len(self.log_likelihood)


@dataclass(frozen=True, eq=False)
class FilterSettings:
    """What does not change while a belief is carried on.

    Attributes
    ----------
    grounding : Grounds
    engine : Engine
    on_impossible : {"raise", "drop", "soften", "restart"}
    eps : float
        For "soften".
    window : int
        How many past slices are remembered.
    static : frozenset of str
        Static variables that the grounding does not name.
    """

    grounding: Grounds
    engine: Engine
    on_impossible: str = "raise"
    eps: float = 1e-6
    window: int = 0
    static: frozenset[str] = frozenset()


# ----------------------------------------------------------------------------------------------------- states


def begin(settings: FilterSettings, batch: int) -> FilterState:
    """The state before the first slice."""
    zeros = np.zeros(batch)
    return FilterState(settings.engine.start(batch), 0, zeros, np.zeros(batch, bool), np.zeros(batch, np.int64))


def begin_anew(state: FilterState, agents: np.ndarray) -> FilterState:
    """The state in which some agents, a (W,) bool array, begin anew with the next slice."""
    fresh = state.fresh | agents if state.step else np.zeros(state.batch, bool)
    return state._replace(log_likelihood=np.where(agents, 0.0, state.log_likelihood), fresh=fresh)


def select(settings: FilterSettings, state: FilterState, agents: np.ndarray) -> FilterState:
    """The state of some of the agents, (n,) indices. All history is forgotten but the first slice, which may have to be made again."""
    engine = settings.engine
    history = tuple(
        Past(engine.select(p.before, agents), p.info, p.readings.rows(agents), p.fresh[agents], p.relations)
        for p in (state.history if state.step == 1 else ())
    )
    return state._replace(
        belief=engine.select(state.belief, agents),
        log_likelihood=state.log_likelihood[agents],
        fresh=state.fresh[agents],
        impossible=state.impossible[agents],
        history=history,
    )


def join(settings: FilterSettings, states: list[FilterState]) -> FilterState:
    """One state for the agents of several whose beliefs have the same form."""
    return states[0]._replace(
        belief=settings.engine.join([s.belief for s in states]),
        step=max(s.step for s in states),
        log_likelihood=np.concatenate([s.log_likelihood for s in states]),
        fresh=np.concatenate([s.fresh for s in states]),
        impossible=np.concatenate([s.impossible for s in states]),
        history=(),
        exact=all(s.exact for s in states),
    )


# ----------------------------------------------------------------------------------------------------- slices


def slice_info(settings: FilterSettings, state: FilterState, ground: GroundSlice) -> SliceInfo:
    """The next slice as engines see it."""
    names, before = settings.static | state.late, state.info
    if before is not None and not names and not before.static_variables:
        return indexed(settings, ground, {})
    if before is None:
        names = names | {p for cpd in ground.cpds for p, lag in cpd.parents if lag == STATIC}
    static = {n: ground.variables[n] for n in sorted(names & ground.variables.keys())}
    for name, variable in before.static_variables.items() if before is not None else ():
        assert before is not None
        gone = bool(variable.object_name) and variable.object_name in before.slice.owners and variable.object_name not in ground.owners
        if name not in ground.variables and not gone:
            static[name] = variable
    return indexed(settings, ground, static)


def indexed(settings: FilterSettings, ground: GroundSlice, static: dict[str, GroundVariable]) -> SliceInfo:
    """A slice with these static variables as engines see it."""

    def make() -> SliceInfo:
        info = SliceInfo(ground, static, settings.engine.store, settings.grounding.defaults(ground), settings.grounding.quantities(ground))
        settings.engine.learn(info)
        return info

    return settings.engine.store.infos.fetch((ground, frozenset(static)), make)


def next_slice(settings: FilterSettings, state: FilterState, relations: Any = (), objects: Iterable[str] | None = None) -> SliceInfo:
    """The slice that follows with these relations."""
    situation = settings.grounding.situation(relations, objects, state.relations if state.step else None)
    return slice_info(settings, state, settings.grounding.ground(situation, first=state.step == 0))


def _first_slice(settings: FilterSettings, state: FilterState, relations: Any) -> SliceInfo:
    """The first slice, for agents that begin anew."""
    ground = settings.grounding.ground(relations, first=True)
    names = settings.static | state.late
    return indexed(settings, ground, {n: ground.variables[n] for n in sorted(names & ground.variables.keys())})


# ----------------------------------------------------------------------------------------------------- readings


def read(info: SliceInfo, batch: int, evidence: Mapping[str, Any] | np.ndarray | None, soft: Mapping[str, Any] | None) -> Readings:
    """Readings of a slice from what a user tells; what is given and left out takes its default.

    Raises
    ------
    EvidenceError
    """
    numbers: dict[str, Numbers] = {}
    if info.continuous or _has_interval(evidence):
        evidence, numbers, likelihoods = split_numbers(info.variables, evidence, batch)
        soft = {**likelihoods, **(soft or {})}
    hard = read_hard(info.variables, info.names, info.cards, info.row, evidence, batch)
    for name, default in info.quantities.items():
        numbers[name] = numbers.get(name, nothing(batch)).filled(default)
    if numbers:
        hard[[info.row[name] for name in numbers]] = -np.isnan(np.array([read.low for read in numbers.values()])).astype(np.int64)
    if len(info.given_rows):
        fill_in(info, hard)
    if not soft:
        return Readings(hard, {}, numbers)
    for name in soft:
        if name in info.slice.given:
            raise EvidenceError(f"soft evidence for {name!r}: it is given, not inferred")
        variable = info.variables.get(name)
        if variable is not None and variable.quantity is not None:
            raise EvidenceError(
                f"soft evidence for {name!r}: a real number has no states; read it with a `Noise` of its own, or an Interval"
            )
    return Readings(hard, read_soft(info.variables, soft, batch), numbers)


def _has_interval(evidence: Any) -> bool:
    return isinstance(evidence, Mapping) and not isinstance(evidence, StateRows) and any(isinstance(v, Interval) for v in evidence.values())


def fill_in(info: SliceInfo, hard: np.ndarray) -> None:
    """Put the defaults of what is given where nothing is told, in place."""
    rows = info.given_rows
    told = hard[rows]
    missing = told < 0
    if missing.any():
        told = np.where(missing, info.defaults[:, None], told)
        bad = (told < 0).any(axis=1)
        if bad.any():
            names = ", ".join(repr(info.names[r]) for r in rows[bad])
            raise EvidenceError(f"{names} must be given for every agent in every slice: it has no default")
        hard[rows] = told


def as_in_last_step(state: FilterState, info: SliceInfo) -> Readings:
    """The variables of a slice that are observed, if the same are as in the last step; the values do not matter."""
    hard = np.full((len(info.names), state.batch), UNOBSERVED, np.int64)
    hard[info.given] = 0
    if state.history:
        last = state.history[-1]
        for name, row in info.row.items():
            if name in last.info.row:
                hard[row] = np.minimum(last.readings.hard[last.info.row[name]], info.cards[row] - 1)
    return Readings(hard, {})


# ----------------------------------------------------------------------------------------------------- one slice


def advance(
    settings: FilterSettings, state: FilterState, readings: Readings, relations: Any, info: SliceInfo | None = None
) -> tuple[FilterState, Posterior]:
    """Go on by one slice.

    Parameters
    ----------
    settings : FilterSettings
    state : FilterState
        Stays as it is.
    readings : Readings
        Rows in the order of `next_slice`.
    relations : grounding's own kind
        What holds in the slice, as ``grounding.situation`` gives it.
    info : SliceInfo, optional
        The slice that these make, if it is known already.

    Returns
    -------
    state : FilterState
    posterior : Posterior

    Raises
    ------
    ImpossibleEvidence
        The readings have probability zero and the policy is "raise".
    CostError
        A component is too large for exact inference.
    """
    if info is None:
        info = slice_info(settings, state, settings.grounding.ground(relations, first=state.step == 0))
    state, info, readings, result = _carry_on(settings, state, info, readings)
    if state.fresh.any():
        result = _with_beginners(settings, state, result, readings, state.fresh, relations)
    fresh, impossible = state.fresh, result.impossible
    if impossible.any():
        result, fresh = _in_spite(settings, state, info, result, relations)
    past = Past(state.belief, info, result.readings, fresh, relations)
    after = FilterState(
        result.belief,
        state.step + 1,
        state.log_likelihood + result.increment,
        np.zeros(state.batch, bool),
        state.impossible + impossible,
        (*state.history[1 - settings.window :], past) if settings.window > 1 else (past,),
        relations,
        state.exact and result.exact,
        info,
        state.late,
    )
    return after, Posterior(result, state.step, after.log_likelihood, after.exact, impossible, relations)


def _carry_on(
    settings: FilterSettings, state: FilterState, info: SliceInfo, readings: Readings
) -> tuple[FilterState, SliceInfo, Readings, StepResult]:
    """One step of the engine. If it needs a variable that was summed out, the last step is made again with it kept."""
    for _ in range(1 + 2 * len(info.names)):
        try:
            return state, info, readings, settings.engine.advance(state.belief, info, readings)
        except NeedsVariable as need:
            state = made_again(settings, state, need)
            info = slice_info(settings, state, info.slice)
            readings = readings.extended(len(info.names))
    raise ModelError("the belief cannot be kept in a form that the next slice needs")


def made_again(settings: FilterSettings, state: FilterState, need: NeedsVariable) -> FilterState:
    """The state after the last step made again with a variable kept."""
    if not state.history:
        raise ModelError(f"{need.name!r} of the previous slice is needed, but there is none") from None
    past = state.history[-1]
    info = past.info
    if need.static:
        if state.step != 1:
            raise ModelError(f"static variable {need.name!r} is used for the first time in slice {state.step}; name it in `static`")
        info = indexed(settings, info.slice, {**info.static_variables, need.name: info.variables[need.name]})
        state = state._replace(late=state.late | {need.name}, info=info)
    else:
        settings.engine.note(need.kind)
    result = settings.engine.advance(past.before, info, past.readings)
    if past.fresh.any():
        result = _with_beginners(settings, state, result, past.readings, past.fresh, past.relations)
    return state._replace(belief=result.belief, history=(*state.history[:-1], past._replace(info=info)))


def _with_beginners(
    settings: FilterSettings,
    state: FilterState,
    result: StepResult,
    readings: Readings,
    agents: np.ndarray,
    relations: Any,
    forgive: bool = False,
) -> StepResult:
    """The result with the answer of a first slice for some agents."""
    first = _first_slice(settings, state, relations)
    chosen = np.flatnonzero(agents)
    known = np.array([result.info.row.get(name, -1) for name in first.names], np.int64)
    hard = np.where(known[:, None] >= 0, readings.hard[known][:, chosen], UNOBSERVED)
    if len(first.given_rows):
        fill_in(first, hard)
    lost = [n for n, row in result.info.row.items() if n not in first.row and (readings.hard[row, chosen] >= 0).any()]
    if lost:
        raise ModelError(f"some agents begin anew while others go on, and observe {lost[0]!r}, which a first slice does not have")
    soft = {n: s[chosen] for n, s in readings.soft.items() if n in first.row}
    part = Readings(hard, soft, {n: r.rows(chosen) for n, r in readings.numbers.items() if n in first.row})
    return settings.engine.replace_agents(result, first, part, chosen, forgive)


# ----------------------------------------------------------------------------------------------------- impossible readings


def _in_spite(
    settings: FilterSettings, state: FilterState, info: SliceInfo, result: StepResult, relations: Any
) -> tuple[StepResult, np.ndarray]:
    """The policy for readings of probability zero: the result in spite of them, and who began anew."""
    engine, readings, fresh = settings.engine, result.readings, state.fresh
    agents = np.flatnonzero(result.impossible)
    if settings.on_impossible == "raise":
        raise impossible_evidence(engine.conflict(state.belief, result, int(agents[0])), info, readings, agents, state.step)
    if settings.on_impossible == "restart":
        fresh = fresh | result.impossible
        again = _with_beginners(settings, state, result, readings, result.impossible, relations) if not result.sampled else result
    else:
        again = result
    eps = settings.eps if settings.on_impossible == "soften" else None
    for _ in range(1 + len(info.names)):
        bad = np.flatnonzero(again.impossible)
        if not len(bad) or again.sampled:
            break
        conflicts = {int(a): engine.conflict(state.belief, again, int(a)) for a in bad}
        if not all(conflicts.values()):
            break
        readings = softened(info, readings, conflicts, eps)
        again = engine.advance(state.belief, info, readings)
        if fresh.any() and not again.sampled:
            again = _with_beginners(settings, state, again, readings, fresh, relations)
    if again.sampled:
        again = engine.advance(state.belief, info, readings, forgive=np.flatnonzero(again.impossible))
        return (_with_beginners(settings, state, again, readings, fresh, relations, forgive=True) if fresh.any() else again), fresh
    if again.impossible.any():
        raise impossible_evidence(engine.conflict(state.belief, result, int(agents[0])), info, result.readings, agents, state.step)
    return again, fresh


# ----------------------------------------------------------------------------------------------------- looking ahead


def look_ahead(
    settings: FilterSettings,
    state: FilterState,
    steps: int,
    relations: Any = None,
    given: Mapping[str, Any] | None = None,
    soft: Mapping[str, Any] | None = None,
) -> Posterior:
    """The belief some slices ahead, without further readings.

    Parameters
    ----------
    settings : FilterSettings
    state : FilterState
    steps : int
        At least 1.
    relations : relations, optional
        In force on the way; by default those of the last slice.
    given : dict, optional
        What is given on the way. What is left out takes its default, or without one the value of the last slice.
    soft : dict, optional
        Likelihood vectors in the last of the slices.
    """
    grounding = settings.grounding
    posterior = None
    for left in reversed(range(steps)):
        situation = grounding.next(state.relations if state.step else None, relations)
        info = slice_info(settings, state, grounding.ground(situation, first=state.step == 0))
        told = dict(given or {})
        last = state.history[-1] if state.history else None
        for row, default in zip(info.given_rows, info.defaults):
            name = info.names[row]
            if default >= 0 or name in told or name in info.quantities or last is None or name not in last.info.row:
                continue
            if name in last.readings.numbers:
                told[name] = last.readings.numbers[name].low
            else:
                told[name] = Index(last.readings.hard[last.info.row[name]])
        state, posterior = advance(settings, state, read(info, state.batch, told, soft if left == 0 else None), situation)
    assert posterior is not None
    return posterior


def jeffrey(
    settings: FilterSettings, state: FilterState, targets: Mapping[str, Any], relations: Any = None, given: Mapping[str, Any] | None = None
) -> dict[str, np.ndarray]:
    """Likelihood vectors for the next slice that turn the predicted marginals into the given ones, one variable after the other."""
    found: dict[str, np.ndarray] = {}
    for name, target in targets.items():
        ahead = look_ahead(settings, state, 1, relations, given, found)
        if name in ahead.variables and ahead.variables[name].quantity is not None:
            raise EvidenceError(f"jeffrey: {name!r} is a real number and has no states")
        found[name] = jeffrey_likelihood(name, ahead[name], target)
    return found


def window_of(state: FilterState) -> list[smoothing.Slice]:
    """The slices remembered since the last one in which only some agents began anew."""
    slices: list[smoothing.Slice] = []
    for past in state.history:
        if past.fresh.any():
            slices.clear()
        else:
            slices.append(smoothing.Slice(past.before, past.info, past.readings))
    return slices
