"""No false evidence: a variable may be observed only where its reading was given.

An observation array holds a number for everything, also for what nobody told: 0 where a player was seen without his number, what was
seen long ago where memory carries it on. `GIVEN` says by which percept each reading tells that it was given, `ALWAYS` which ones always
are; `check_given` refuses a CPRM that would take a reading for evidence at other times, and one of which neither says anything. Every
soccer agent is checked when it is made.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from ..architecture.cprm import CPRM, Observe
from ..architecture.expressions.intervals import bound
from ..architecture.petri import compile_net
from ..architecture.prm.model.formulas import Formula
from ..errors import ModelError

GIVEN: Mapping[str, str] = {
    r"ball\.seen": "body.fresh",
    r"ball\.(distance|direction_deg|reckoned_\w+|speed_\w+|approach)": "ball.seen",
    r"ball\.(distance_change|direction_change_deg|rolling|swinging_deg|vx|vy)": "ball.moving",
    r"ball\.(x|y|bearing_deg)": "ball.placed",
    r"([omt]\d+)\.(x|y)": r"\1.seen",
    r"([omt]\d+)\.facing": r"\1.faced",
    r"me\.(x|y|vx|vy|facing_deg|eyes_deg|met|slid_deg)": "me.located",
    r"goal\.\w+": "me.located",
}
"""Reading (a pattern) -> the percept that is 1 where it was given."""
FLAGS = r"\w+\.(seen|moving|placed|faced|located|fresh)"
"""Percepts that say whether others were given."""
ALWAYS = (r"body\.\w+", r"game\.\w+", r"\w+\.age", FLAGS)
"""Readings that always are: what is felt and heard, how old what was seen is, and the flags."""
_FAR = 1e12
"""Beyond it nothing that a condition reads is looked for."""


def giver(percept: str, given: Mapping[str, str] = GIVEN) -> str | None:
    """The percept that says whether a reading was given; empty for what always is, None where nobody says anything of it."""
    for pattern, flag in given.items():
        match = re.fullmatch(pattern, percept)
        if match:
            return match.expand(flag)
    return "" if any(re.fullmatch(pattern, percept) for pattern in ALWAYS) else None


def check_given(cprm: CPRM, given: Mapping[str, str] | None = None) -> None:
    """Refuse observations of readings that may not have been given.

    Parameters
    ----------
    cprm : CPRM
    given : mapping of str to str, optional
        Of readings that `GIVEN` does not know (patterns), the percepts that are 1 where they were given; empty for what always is.

    Raises
    ------
    ModelError
        Naming the variable, the reading, and the condition that is missing.
    """
    known = {**(given or {}), **GIVEN}
    places = set(compile_net(cprm.net).place_names) if cprm.net is not None else set()
    for link in cprm.observations:
        for reading in readings(link):
            if reading in places:
                continue
            flag = giver(reading, known)
            where = f"cprm {cprm.name!r}: {link.variable!r} is observed {f'when {link.when!r}' if link.when else 'always'}"
            if flag is None:
                raise ModelError(
                    f"{where}, but nothing says when its reading {reading!r} is given: say by which percept, in `given` "
                    f"(given={{{reading!r}: 'name.seen'}}; '' for what always is)"
                )
            if flag and not _asks(link.when, flag):
                raise ModelError(
                    f"{where}, but its reading {reading!r} is given only where {flag!r} is 1; write when={flag!r}, or join it by `and`"
                )


def readings(link: Observe) -> tuple[str, ...]:
    """Names that an observation reads; of its condition those that are no flags."""
    told = [name for text in (link.value, *link.likelihood) if text for name in Formula(text).names]
    asked = [name for name in Formula(link.when).names if not re.fullmatch(FLAGS, name)] if link.when else []
    return tuple(dict.fromkeys((*told, *asked)))


def _asks(when: str, flag: str) -> bool:
    """Whether a condition never holds where `flag` is 0, whatever else it reads."""
    if when == flag:
        return True
    formula = Formula(when) if when else None
    if formula is None or flag not in formula.names:
        return False
    return bound(formula.node, {name: (0.0, 0.0) if name == flag else (-_FAR, _FAR) for name in formula.names}).high < 0.5
