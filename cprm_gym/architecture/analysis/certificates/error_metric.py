"""Error-metric proofs as values: what must be shown, and whether it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ....errors import ModelError
from ...expressions import Expression
from ..budget import Budget
from ..logic.boxes import BoxVerdict, Claim, prove
from ..logic.implication import implies
from ..logic.z3_terms import has_z3


@dataclass(frozen=True)
class Action:
    """What the agent may do in a cycle, and what becomes of the state.

    Parameters
    ----------
    name : str
    updates : mapping of str to str
        State variable -> its next value, an expression of state and noise; the others stay. Saturation is part of it (``clip``).
    when : str
        When it may be chosen. Cases may overlap: what the agent sees is not what is.
    """

    name: str
    updates: Mapping[str, str]
    when: str = "1"


@dataclass(frozen=True)
class ErrorMetricProof:
    """A claim that a behaviour closes with its goal, with all that shows it.

    Parameters
    ----------
    state : mapping of str to (low, high)
        Range of each variable: the box outside of which nothing is claimed.
    noise : mapping of str to (low, high)
        What the world adds, anything within in every cycle.
    actions : tuple of Action
    goal : str
        True where the behaviour has arrived.
    initial : str
        True where it may begin.
    invariant : str
        True from the beginning to the goal.
    rank : str
        The error: it falls in every cycle.
    falls : (amount, ratio)
        The next rank is at most ``ratio * rank - amount``; one of them must make it fall by a uniform share or amount (a fall without
        either never ends, so the text's condition 2 is not enough).
    least : float
        The rank is never below.

    Raises
    ------
    ModelError
    """

    state: Mapping[str, tuple[float, float]]
    noise: Mapping[str, tuple[float, float]]
    actions: tuple[Action, ...]
    goal: str
    initial: str
    invariant: str
    rank: str
    falls: tuple[float, float] = (0.0, 1.0)
    least: float = 0.0

    def __post_init__(self) -> None:
        amount, ratio = self.falls
        if not self.actions:
            raise ModelError("proof: needs an action")
        if amount < 0 or not 0 < ratio <= 1 or (amount == 0 and ratio == 1):
            raise ModelError(f"proof: the rank falls by an amount from 0 or to a share up to 1, and by one of them; got {self.falls}")
        for action in self.actions:
            for name in action.updates:
                if name not in self.state:
                    raise ModelError(f"proof, action {action.name!r}: updates {name!r}, which is none of {', '.join(self.state)}")

    def obligations(self) -> list[Claim]:
        """All that must be shown: beginning, coverage, and for each action that the invariant stays and the rank falls."""
        amount, ratio = self.falls
        under_way = (self.invariant, f"not ({self.goal})")
        inside = " and ".join(f"{low!r} <= {{{name}}} <= {high!r}" for name, (low, high) in self.state.items())
        claims = [
            Claim("the start is within the invariant", (self.initial,), self.invariant),
            Claim("some action is always chosen", under_way, " or ".join(f"({a.when})" for a in self.actions)),
            Claim("the rank is bounded from below", under_way, f"({self.rank}) >= {self.least!r}"),
        ]
        for action in self.actions:
            after = {name: f"({action.updates.get(name, name)})" for name in self.state}
            arrived, rank = _then(self.goal, after), _then(self.rank, after)
            stays = f"({_then(self.invariant, after)}) and {inside.format(**after)}"
            given = (*under_way, action.when)
            falls = f"({rank}) <= {ratio!r} * ({self.rank}) - {amount!r}"
            claims.append(Claim(f"{action.name} keeps the invariant", given, f"({arrived}) or ({stays})"))
            claims.append(Claim(f"{action.name} lets the rank fall", given, f"({arrived}) or ({falls})"))
        return claims

    def check(self, *, budget: Budget | None = None) -> ProofReport:
        """Decide every obligation: by boxes, by z3 where it is installed and boxes alone take long.

        Parameters
        ----------
        budget : Budget, optional
            Its seconds for all, its states for each.
        """
        limits, _ = (budget or Budget(states=20_000)).start()
        ranges = {**self.state, **self.noise}
        return ProofReport(tuple(_decide(claim, ranges, limits) for claim in self.obligations()))


FEW = 500
"""Boxes that are tried before z3 is asked."""


def _decide(claim: Claim, ranges: Mapping[str, tuple[float, float]], limits: Budget) -> BoxVerdict:
    """A few boxes, then z3 where it is installed and knows the operations, then all boxes that the budget grants."""
    found = prove(claim, ranges, budget=replace(limits, states=min(FEW, limits.states)))
    if found.holds is not None or limits.states <= FEW:
        return found
    if has_z3():
        given = [f"({text})" for text in claim.assumptions] + [f"{low!r} <= {name} <= {high!r}" for name, (low, high) in ranges.items()]
        answer = implies(" and ".join(given), claim.conclusion)
        if answer.holds is not None:
            return BoxVerdict(claim.name, answer.holds, answer.method, answer.counterexample, found.boxes)
    return prove(claim, ranges, budget=limits)


def _then(text: str, after: Mapping[str, str]) -> str:
    """What a condition says of the next state."""
    return Expression(text).rename(lambda name: after.get(name, name)).text


@dataclass(frozen=True)
class ProofReport:
    """What became of each obligation.

    Attributes
    ----------
    obligations : tuple of BoxVerdict
    """

    obligations: tuple[BoxVerdict, ...] = field(default=())

    @property
    def proved(self) -> bool | None:
        """True if all are proved, False if one is refuted, None if some are undecided."""
        answers = {o.holds for o in self.obligations}
        return False if False in answers else None if None in answers else True

    def __str__(self) -> str:
        return "\n".join(map(str, self.obligations))
