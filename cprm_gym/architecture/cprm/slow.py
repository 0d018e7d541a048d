"""Inference that comes rarely and late (dissertation §2.3.3): what is told in each cycle waits until an inference takes it in at its time,
and what that found is rolled on from then to now.

An inference begins every `t_b` cycles, or where it is demanded, and takes in all slices up to its beginning, one by one with the model's
own transition: so the transition over a period is the one-cycle model's, evidence between inferences counts at its time, and what was given
then, such as an own kick, is not lost. Its result comes `latency` cycles later. The belief of now is that result, carried on by slices in
which nothing is observed and everything is given that was done.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...errors import ParameterError
from ..prm.inference.evidence import StateRows
from ..prm.inference.filter_bank import FilterBank
from ..prm.inference.links import Link
from ..prm.model.formulas import Formula
from .separate import Perceived, SeparateBeliefs
from .value import CPRM

Beliefs = TypeVar("Beliefs", FilterBank, SeparateBeliefs)
Record = TypeVar("Record")
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Timing:
    """When inferences begin and when their results come.

    Parameters
    ----------
    t_b : int
        Cycles from the beginning of one inference to that of the next, a multiple of the model's slice (`CPRM.period`).
    latency : int
        Cycles until its result comes.
    demand : str
        Expression over percepts and places, read as the cycle before left them: where it is true an inference begins as well, in a cycle
        in which a slice does. A transition demands one by a token in a place.
    """

    t_b: int
    latency: int = 0
    demand: str = ""

    @classmethod
    def of(cls, cprm: CPRM, t_b: int | None = None, latency: int = 0, demand: str = "") -> Timing:
        """The timing of a CPRM; `t_b` is its period if not given.

        Raises
        ------
        ParameterError
            For numbers that make no sense, and for a CPRM that infers nothing.
        ModelError
            For a demand that is no expression.
        """
        given = t_b is not None or latency != 0 or bool(demand)
        t_b = cprm.period if t_b is None else t_b
        for name, value, least in (("t_b", t_b, 1), ("latency", latency, 0)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ParameterError(f"cprm {cprm.name!r}: {name}: {value!r} given, a whole number of cycles of at least {least} is needed")
        if t_b % cprm.period:
            raise ParameterError(f"cprm {cprm.name!r}: t_b: {t_b} given, a multiple of the model's slice, {cprm.period} cycles, is needed")
        if given and cprm.model is None:
            raise ParameterError(f"cprm {cprm.name!r}: t_b, latency and demand are of inference, and it has no model")
        if demand:
            Formula(demand)
        return cls(t_b, latency, demand)

    def at_once(self, period: int) -> bool:
        """Whether each slice is inferred when it ends, which needs nothing of what is here."""
        return self.t_b == period and self.latency == 0 and not self.demand


class SlowBeliefs(Generic[Beliefs, Record]):
    """Two beliefs of each of W agents: up to the last inference whose result has come, and carried on to now.

    Parameters
    ----------
    inferred, now : Beliefs
        Alike, and at their beginning.
    timing : Timing
    period : int
        Cycles of a slice.
    batch : int
        W.
    advance : callable
        ``advance(beliefs, record, due, blind)`` lets the agents that are due go on by one slice with what was recorded in its cycle; where
        `blind`, with what is given alone.
    take : callable
        ``take(now, inferred, agents)`` gives agents of the first the beliefs of the second.
    """

    def __init__(
        self,
        inferred: Beliefs,
        now: Beliefs,
        timing: Timing,
        period: int,
        batch: int,
        advance: Callable[[Beliefs, Record, Mask, bool], None],
        take: Callable[[Beliefs, Beliefs, Mask], None],
    ) -> None:
        self.inferred: Beliefs = inferred
        self.now: Beliefs = now
        self.timing, self.period = timing, period
        self._advance: Callable[[Beliefs, Record, Mask, bool], None] = advance
        self._take: Callable[[Beliefs, Beliefs, Mask], None] = take
        self._cycle = np.zeros(batch, np.int64)
        self._done, self._told = np.full(batch, -1), np.full(batch, -1)  # the last slice of each belief
        self._records: list[Record] = []
        self._begins: list[Mask] = []

    def reset(self, mask: Mask) -> None:
        """Let agents begin anew, and their belief of now; the other one is reset by who has made it."""
        self.now.reset(mask)
        self._cycle[mask] = 0
        self._done[mask] = self._told[mask] = -1
        for begun in self._begins:
            begun[mask] = False

    def step(self, record: Record, demanded: Mask, read: Callable[[Beliefs, Mask], None]) -> None:
        """One cycle of all agents.

        Parameters
        ----------
        record : Record
            What is told in this cycle.
        demanded : (W,) bool array
        read : callable
            ``read(beliefs, agents)``: the answers of the last step are of now, for these agents.
        """
        t_b, latency = self.timing.t_b, self.timing.latency
        self._records.insert(0, record)
        del self._records[t_b + latency + 1 :]
        self._begins.insert(0, (self._cycle % self.period == 0) & ((self._cycle % t_b == 0) | demanded))
        come = self._begins.pop() if len(self._begins) > latency else np.zeros(len(demanded), bool)
        if come.any():
            last = np.where(come, (self._cycle - latency) // self.period, -1)
            self._go_on(self.inferred, self._done, last, blind=False)
            self._take(self.now, self.inferred, come)
            self._told[come] = self._done[come]
        present = self._cycle // self.period
        if (fresh := come & (self._told == present)).any():
            read(self.inferred, fresh)
        self._go_on(self.now, self._told, present, blind=True, read=read)
        self._cycle += 1

    def _go_on(
        self, beliefs: Beliefs, reached: NDArray[np.int64], last: NDArray[np.int64], blind: bool,
        read: Callable[[Beliefs, Mask], None] | None = None,
    ) -> None:  # fmt: skip
        """Step from the slice that each agent has reached to its last one, the oldest cycle first."""
        for lag in range(len(self._records) - 1, -1, -1):
            then = self._cycle - lag
            number = then // self.period
            due = (then >= 0) & (then % self.period == 0) & (number > reached) & (number <= last)
            if due.any():
                self._advance(beliefs, self._records[lag], due, blind)
                reached[due] = number[due]
                if read is not None and (ended := due & (number == last)).any():
                    read(beliefs, ended)


Banked = tuple[Mapping[str, Any], tuple[Link, ...]]
"""What a bank is told in a cycle: readings and relations."""


def slow_banks(inferred: FilterBank, now: FilterBank, timing: Timing, period: int) -> SlowBeliefs[FilterBank, Banked]:
    """Of two banks of the same agents."""
    given = frozenset(inferred.grounding.ground((), first=True).given)

    def advance(bank: FilterBank, record: Banked, due: Mask, blind: bool) -> None:
        told, links = record
        bank.step(_given(told, given) if blind else told, links, due)

    return SlowBeliefs(inferred, now, timing, period, inferred.batch, advance, FilterBank.take)


def _given(told: Mapping[str, Any], given: frozenset[str]) -> Mapping[str, Any]:
    """What is given of what is told."""
    if isinstance(told, StateRows):
        rows = [k for k, name in enumerate(told.names) if name in given]
        return StateRows(tuple(told.names[k] for k in rows), told.states[rows])
    return {name: value for name, value in told.items() if name in given}


def slow_separately(
    beliefs: SeparateBeliefs, timing: Timing, tell: Callable[[SeparateBeliefs, Perceived, Mask, bool], None]
) -> SlowBeliefs[SeparateBeliefs, Perceived]:
    """Of agents whose beliefs are kept one by one."""
    count = len(beliefs.filters)
    return SlowBeliefs(beliefs, beliefs.alike(), timing, beliefs.cprm.period, count, tell, SeparateBeliefs.take)
