"""No false evidence: a variable may be observed only where its reading was given.

An observation array holds a number for everything, also for what nobody told: 0 where a player was seen without his number, what was
seen long ago where memory carries it on. `GIVEN` says by which percept each reading tells that it was given; `check_given` refuses a
CPRM that would take it for evidence at other times. Every soccer agent is checked when it is made.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import product

import numpy as np

from ..architecture.cprm import CPRM
from ..architecture.prm.model.formulas import Formula
from ..errors import ModelError

GIVEN: Mapping[str, str] = {
    r"ball\.seen": "body.fresh",
    r"ball\.(distance|direction_deg|reckoned_\w+|speed_\w+|approach)": "ball.seen",
    r"ball\.(distance_change|direction_change_deg|rolling|swinging_deg|vx|vy)": "ball.moving",
    r"ball\.(x|y|bearing_deg)": "ball.placed",
    r"([omt]\d+)\.(x|y)": r"\1.seen",
    r"([omt]\d+)\.facing": r"\1.faced",
    r"me\.(x|y|facing_deg|eyes_deg|met|slid_deg)": "me.located",
}
"""Reading (a pattern) -> the percept that is 1 where it was given."""
_TRIED = (0.0, 1.0, 1000.0)
"""Values of whatever else a condition reads, by which it is tried."""


def giver(percept: str) -> str | None:
    """The percept that says whether a reading was given; None for what always is."""
    for pattern, flag in GIVEN.items():
        match = re.fullmatch(pattern, percept)
        if match:
            return match.expand(flag)
    return None


def check_given(cprm: CPRM) -> None:
    """Refuse observations of readings that may not have been given.

    Raises
    ------
    ModelError
        Naming the variable, the reading, and the condition that is missing.
    """
    for link in cprm.observations:
        for reading in Formula(link.value).names:
            flag = giver(reading)
            if flag is not None and not _asks(link.when, flag):
                condition = f"when {link.when!r}" if link.when else "always"
                raise ModelError(
                    f"cprm {cprm.name!r}: {link.variable!r} is observed {condition}, but its reading {reading!r} is given only where "
                    f"{flag!r} is 1; write when={flag!r}, or join it by `and`"
                )


def _asks(when: str, flag: str) -> bool:
    """Whether a condition never holds where `flag` is 0."""
    if when == flag:
        return True
    if not when or flag not in Formula(when).names:
        return False
    formula = Formula(when)
    others = [name for name in formula.names if name != flag]
    tried = np.array(list(product(_TRIED, repeat=len(others)))).reshape(len(_TRIED) ** len(others), len(others))
    values = {name: tried[:, k] for k, name in enumerate(others)} | {flag: np.zeros(len(tried))}
    return not (np.asarray(formula(values, len(tried))) >= 0.5).any()
