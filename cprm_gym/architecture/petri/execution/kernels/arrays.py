"""The arrays that the kernels of execution work on, and what they answer."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .bit_sets import width_of

OK, LIVELOCK, UNDEFINED, CLOCKS, FULL = 0, 1, 2, 3, 4  # what a phase answers; FULL: no room left in the trace
OFF = -1  # a clock that is not running; -2 - c: an age clock paused at c
AGE = 1  # Memory.AGE
CONFLICTS, EVENTS, DETAIL, START, LOOPED = 0, 1, 2, 3, 4  # places in Scratch.counts
LOOP = 512  # firings kept of a livelock


class State(NamedTuple):
    """What a copy remembers from cycle to cycle; W copies."""

    row: np.ndarray  # (W, S) marking of the P places, then attributes of held objects, then of the candidate looked at
    held: np.ndarray  # (W, O) int32 index of the object in each object place, -1 for none
    clock: np.ndarray  # (W, K) int32
    random: np.ndarray  # (W,) uint64 state of the copy's random stream
    cycle: np.ndarray  # (W,) int64 cycles run
    data: np.ndarray  # (W, N) attributes of all objects


class Cache(NamedTuple):
    """What follows from a state, kept so that a cycle works out again only what depends on a slot that is another than it was.

    Whoever writes to a state need not tell: the slots are compared, bit by bit.
    """

    now: np.ndarray  # (W, S) int64 the bits of State.row, the same memory
    known: np.ndarray  # (W, S) int64 the bits with which the rest was worked out
    valid: np.ndarray  # (W,) bool whether it was
    enabled: np.ndarray  # (W, T) uint8
    ready: np.ndarray  # (W, .) sets of the enabled immediate transitions, by their rank


class Output(NamedTuple):
    """What a cycle sends out."""

    fired: np.ndarray  # (W, commands) bool
    source: np.ndarray  # (W, commands) int32 transition that emitted it
    value: np.ndarray  # (W, parameters)
    winner: np.ndarray  # (W, groups) int32 command that goes out, -1 for none
    overruled: np.ndarray  # (W, T) bool emitted a command that gave way to another of its group


class Scratch(NamedTuple):
    """Working memory and findings."""

    stack: np.ndarray  # of expressions
    score: np.ndarray  # (objects,)
    conflict: np.ndarray  # (n, 3) int64 transition fired, transition it disabled, how often
    counts: np.ndarray  # conflicts found; events in the trace; detail of an error; whether clocks may start; firings in the loop
    loop: np.ndarray  # (LOOP,) int32 firings of a livelock
    event: np.ndarray  # (E, 4) int64 copy, cycle, transition, timed; no rows: no trace
    event_enabled: np.ndarray  # (E, T) uint8 what was enabled
    stale: np.ndarray  # set, without tops, of math places to evaluate, empty between phases
    unsure: np.ndarray  # the same of transitions whose conditions are to be looked at, empty between phases
    due: np.ndarray  # set of the timed transitions that are due, by their rank


def new_cache(row: np.ndarray, transitions: int, timed: int) -> Cache:
    """A cache in which nothing is worked out yet.

    Parameters
    ----------
    row : (W, S) float64
        `State.row`.
    transitions, timed : int
        T, and how many of them are timed.
    """
    copies, now = len(row), row.view(np.int64)
    return Cache(
        now=now,
        known=np.zeros_like(now),
        valid=np.zeros(copies, np.bool_),
        enabled=np.zeros((copies, transitions), np.uint8),
        ready=np.zeros((copies, width_of(transitions - timed)), np.int64),
    )
