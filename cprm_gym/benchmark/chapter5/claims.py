"""What chapter 5 of the dissertation claims, in one sentence each, and the experiment that measures it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from .pieces import FAILS, HOLDS, IN_PART, UNDECIDED, UNKNOWN


class Claim(NamedTuple):
    """A claim."""

    section: str
    says: str
    experiment: str
    built: bool = False
    """Whether it holds by how things are built, so that the experiment shows that they were built so."""


CLAIMS: dict[str, Claim] = {
    "fsm "
    "contained": Claim(
        "5.3.1", "A state machine is a Petri net in which one token is moved by transitions of one input and one output.",
        "explosion", built=True,
    ),
    "explosion": Claim(
        "5.3.1", "A state machine can describe concurrent activities only by the full product of their states.",
        "explosion", built=True,
    ),
    "layers": Claim("5.3.1", "Concurrent machines, as subsumption has them, are as small as the net but less analysable.", "explosion"),
    "no better analysed": Claim("5.3.1", "A state machine cannot be analysed significantly more effectively than a Petri net.", "analysis"),
    "inference": Claim(
        "5.3.1", "Without inference, readings are of little use for what cannot be seen now; a model of the world makes more of them.",
        "senses",
    ),
    "regions contained": Claim("5.3.2", "A map from regions of belief to actions can be written in the architecture exactly.", "memory",
                               built=True),
    "slow": Claim(
        "5.3.2", "Who has to infer before each action answers too late where inference is slow; reflexes answer at once.",
        "slow",
    ),
    "intention": Claim(
        "5.3.2", "A policy on beliefs without internal state cannot act differently in what is the same world: the hike.",
        "memory", built=True,
    ),
    "internal": Claim(
        "5.3.2", "With variables for the own intention it can, but has to infer even what it is about, which takes longer.",
        "memory",
    ),
    "code can": Claim("5.3.3", "There is no activity that the architecture can represent and concurrent code cannot.", "table"),
    "code "
    "opaque": Claim(
        "5.3.3", "Of code fewer things can be found out by analysis: no reachability, no deadlocks, no chain, no causes of errors.",
        "analysis",
    ),
    "performance": Claim(
        "5.3.3", "Performance on some tasks may be higher with other representations; it is not what tells them apart.",
        "table",
    ),
    "recovery": Claim("4, 5.2", "The recovery machinery brings the behaviours back from whatever interrupts them.", "disturbances"),
    "transfer": Claim("-", "What holds on the standard tasks holds in worlds for which nobody was tuned.", "transfer"),
    "cost": Claim("-", "A net is no longer to write than another structure that plays the same.", "making"),
    "learning": Claim("-", "Nobody has to write it: a learner does as well.", "making"),
}  # fmt: skip
"""Key -> claim; the last three are questions that a reader asks, not claims of the text."""


def tally(verdicts: Mapping[str, str]) -> str:
    """How many claims hold, in part, do not, and how many of the first by how things are built; of key -> verdict."""
    counts = [(verdict, sum(v == verdict for v in verdicts.values())) for verdict in (HOLDS, IN_PART, FAILS, UNDECIDED, UNKNOWN)]
    said = ", ".join(f"{verdict}: {count}" for verdict, count in counts if count)
    built = sum(CLAIMS[key].built for key, verdict in verdicts.items() if verdict == HOLDS)
    return f"{said[:1].upper()}{said[1:]}." + (f" {built} of those that hold do so by how things are built." if built else "")
