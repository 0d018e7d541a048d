"""A net, model or CPRM in an installed module: ``package.module:NAME``, opened only when the command line names it."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

from ...architecture.cprm import CPRM
from ...architecture.petri import PetriNet
from ...architecture.prm import Grounding, Model
from ...errors import FormatError, did_you_mean
from .document import Value

_NAMED = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*")


def is_named(text: str) -> bool:
    """Whether a text names something in a module, and is no file."""
    return bool(_NAMED.fullmatch(text)) and not Path(text).is_file()


def named_value(text: str) -> Value:
    """The value of that name; importing its module runs the module's code, the name itself is never called.

    Raises
    ------
    FormatError
        When there is none, or it is neither a net nor a model nor a CPRM.
    """
    module, _, name = text.partition(":")
    try:
        found = importlib.import_module(module)
    except ImportError as error:
        raise FormatError(f"no module {module!r}: {error}") from None
    if not hasattr(found, name):
        raise FormatError(f"module {module!r} has no {name!r}.{did_you_mean(name, dir(found))}")
    value = getattr(found, name)
    if not isinstance(value, PetriNet | Model | Grounding | CPRM):
        raise FormatError(f"{text} is neither a net nor a model nor a CPRM, it is a {type(value).__name__}")
    return value
