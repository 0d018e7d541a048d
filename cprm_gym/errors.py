"""The errors of cprm_gym. Every message says where, what is wrong, what was given and what is allowed."""

from __future__ import annotations

import difflib
import itertools
from collections.abc import Iterable


class CprmError(Exception):
    """Base of every error that cprm_gym raises on purpose."""


class NetError(CprmError, ValueError):
    """A Petri net, module or transition is not well defined."""


class NotEnabled(CprmError, RuntimeError):
    """A transition was asked to fire in a marking that does not enable it."""


class LivelockError(CprmError, RuntimeError):
    """Immediate transitions of a net went on firing without end within one cycle."""


class ExpressionError(CprmError, ValueError):
    """An expression is not in the language, or has no finite value."""


class ModelError(CprmError, ValueError):
    """A probabilistic relational model is not well defined."""


class EvidenceError(CprmError, ValueError):
    """An observation is not a value of its variable."""


class ImpossibleEvidence(CprmError, RuntimeError):
    """The evidence has probability zero under the model.

    Attributes
    ----------
    step : int or None
        Number of the slice.
    conflict : tuple of str
        Variables whose readings contradict the belief; leaving out any of them would make the rest possible.
    agents : tuple of int
        Whose readings are impossible, in a batch.
    """

    def __init__(self, message: str, step: int | None = None, conflict: tuple[str, ...] = (), agents: tuple[int, ...] = ()) -> None:
        super().__init__(message)
        self.step, self.conflict, self.agents = step, conflict, agents


class CostError(CprmError, RuntimeError):
    """An inference would take more memory or time than is allowed; nothing was run."""


class CommandError(CprmError, ValueError):
    """A player, trainer or coach command is malformed."""


class ParameterError(CprmError, ValueError):
    """A parameter is unknown, of the wrong type or out of range."""


class FormatError(CprmError, ValueError):
    """A file or message (log, PNML, JSON, BIF ...) is damaged or is none; the text names the file and the place."""


class FormatWarning(UserWarning):
    """A file was read, and something in it ignored that may mean something to another program."""


class UnknownName(CprmError, ValueError):
    """A name was given that does not exist; the message lists those that do."""


class CacheError(CprmError, RuntimeError):
    """The folder that ``CPRM_GYM_CACHE`` names for compiled kernels cannot be used safely, or not at all."""


class ControllerError(CprmError, RuntimeError):
    """A controller broke its interface."""


LONGEST_NAME, MOST_NAMES = 100, 2000
"""Longer names get no suggestion, and of more names the first are looked at: comparing takes time with the square of their length."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`` Did you mean 'idle'?``, or ```` when nothing known is close.

    Parameters
    ----------
    name : str
        What was given.
    known : iterable of str
        What is allowed.
    """
    given = str(name)
    if len(given) > LONGEST_NAME:
        return ""
    options = [k for k in map(str, itertools.islice(known, MOST_NAMES)) if len(k) <= LONGEST_NAME]
    near = difflib.get_close_matches(given, options, n=1, cutoff=0.6)
    return f" Did you mean {near[0]!r}?" if near else ""


def unknown_name(kind: str, name: str, known: Iterable[str]) -> UnknownName:
    """An `UnknownName` that lists what is allowed and suggests the nearest.

    Parameters
    ----------
    kind : str
        What is being named ("task", "controller", ...).
    name : str
        What was given.
    known : iterable of str
        What is allowed.
    """
    options = sorted(known)
    return UnknownName(f"unknown {kind} {name!r}.{did_you_mean(name, options)} Known: {', '.join(options) or 'none'}.")
