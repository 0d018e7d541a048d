"""Who plays, by name: a registered controller, the net of a task on a tier of knowledge, without its recovery parts, watched, slow."""

from __future__ import annotations

import functools
from collections.abc import Callable
from functools import partial

from ...agents.body import Body
from ...agents.equivalents.contained import make_contained
from ...agents.goalie import GoalieAgent
from ...agents.hiker.internal import make_controller as internal
from ...agents.knowledge import TIERS, Informed, informed
from ...agents.knowledge.players import PLAYERS
from ...agents.registry import BINS, ON_BELIEF, TIER
from ...agents.registry import make_controller as cprm
from ...agents.skills.constants import GoalieConstants
from ...envs.controller import Controller
from ...envs.others.registry import controller_entries, load_controller
from ...envs.tasks import Task, make_task
from ...errors import ControllerError, UnknownName
from ..recovery import RIVALS, Watchdog
from .conditions import Condition
from .slow import Slow

Maker = Callable[[Task, str], Controller]

WATCHED, ON = " watched", " on "
NET = "net"
"""The task's own Petri net with its numbers, which takes its knowledge from a tier."""
INTERNAL = "belief_region + internal variables"
"""Belief regions over a model that holds the agent's own intention as a variable, too (dissertation §5.3.2)."""
UNTUNED = "net by hand"
"""The same net with the numbers that were set by hand before anything was tuned."""
BARE = "cprm without recovery"
"""The primary sequence alone."""
TRACKING = f"{NET}{ON}tracker"
"""The same net on Kalman filters: the rival of who plays on a belief."""
CONTAINED = {what + end: (what, bool(end)) for what in ("state machine", "belief regions") for end in ("", " as a net")}
"""What the architecture contains (`agents.equivalents.contained`), run as such and as a net."""
BELIEVING, BLIND = "cprm, reflexes", "cprm, no reflexes"
"""The goalie with his relational model under a condition's period and latency, what is late rolled on to now; with inputs that act in the
cycle in which the ball is seen, or by what he believes alone. Both narrow their view to the ball, and have the numbers of the memory."""
LATE, REFLEXES = ", all late", ", reflexes"


def _net(task: Task, agent: str) -> Controller:
    if task.name in PLAYERS:
        player = PLAYERS[task.name]
        return player.make(task, agent, player.numbers("memory"))
    return cprm(task, agent, model=BINS)


def _untuned(task: Task, agent: str) -> Controller:
    player = PLAYERS.get(task.name)
    if player is None or player.constants is None:
        raise UnknownName(f"{UNTUNED}: nothing is tuned in task {task.name!r}")
    return player.make(task, agent, player.constants())


def _believing(how: Condition, reflexes: str, task: Task, agent: str) -> Controller:
    if task.name != "Goalie":
        raise UnknownName(f"{BELIEVING}: task {task.name!r}; it plays Goalie")
    return GoalieAgent(
        task.right, body=Body.of(task), constants=GoalieConstants.tuned("memory"), reflexes=reflexes, focus=True,
        t_b=how.period, latency=how.latency,
    )  # fmt: skip


def _bare(task: Task, agent: str) -> Controller:
    if task.name not in RIVALS:
        raise UnknownName(f"{BARE}: task {task.name!r} has none; allowed are {', '.join(RIVALS)}")
    without = RIVALS[task.name]["without"]
    return informed(without, TIER)(task, agent) if task.name in ON_BELIEF else without(task, agent)


def _contained(name: str, task: Task, agent: str) -> Controller:
    return make_contained(*CONTAINED[name], task)


OWN: dict[str, Maker] = {
    NET: _net, UNTUNED: _untuned, BARE: _bare, INTERNAL: internal, **{name: partial(_contained, name) for name in CONTAINED},
}  # fmt: skip
"""Players of the suite beside the registered controllers."""


def make_player(name: str, how: Condition) -> Maker:
    """A factory of the player of that name.

    Parameters
    ----------
    name : str
        ``BASE``, ``BASE on TIER``, either with `LATE` or `REFLEXES` behind it, all with `WATCHED` behind it; the base is a registered
        controller or one of `OWN`.
    how : Condition
        Its senses are those for which a tier and its player's numbers are made, its period and latency those of slow players.

    Raises
    ------
    UnknownName
        For a controller or a tier that there is not.
    """
    if name.endswith(WATCHED):
        watched = make_player(name.removesuffix(WATCHED), how)
        return lambda task, agent: Watchdog(watched(task, agent))
    if name in (BELIEVING, BLIND):
        return partial(_believing, how, "eye" if name == BELIEVING else "none")
    for ending in (LATE, REFLEXES):
        if name.endswith(ending):
            base, tier = name.removesuffix(ending).rsplit(ON, 1)
            return partial(_slow, base, tier, how, ending == REFLEXES)
    if ON in name:
        base, tier = name.rsplit(ON, 1)
        return partial(_informed, base, tier, how)
    return OWN[name] if name in OWN else load_controller(name)


def _informed(base: str, tier: str, how: Condition, task: Task, agent: str) -> Controller:
    if base == NET and task.name in PLAYERS:
        return PLAYERS[task.name].on(tier, how.senses)(task, agent)
    return informed(make_player(base, how), tier, how.senses)(task, agent)


def _slow(base: str, tier: str, how: Condition, reflexes: bool, task: Task, agent: str) -> Controller:
    return Slow(informed(make_player(base, how), tier, how.senses)(task, agent), how.period, how.latency, reflexes)


@functools.cache
def plays(name: str, task: str) -> bool:
    """Whether a player says that he plays a task; one who fails in another way is said to, so that it is seen when he does."""
    made = make_task(task)
    try:
        make_player(name, Condition())(made, "left_1")
    except UnknownName:
        return False
    except (Exception, SystemExit):
        return name not in not_installed()
    return True


@functools.cache
def believes(task: str) -> bool:
    """Whether the CPRM of a task has a model, or plays on one; where it has none it is a net, and `NET` would be the same once more."""
    if not plays("cprm", task):
        return False
    agent = make_player("cprm", Condition())(make_task(task), "left_1")
    return isinstance(agent, Informed) or getattr(getattr(agent, "cprm", None), "model", None) is not None


@functools.cache
def not_installed() -> dict[str, str]:
    """Registered controllers for which a package is missing, and which."""
    found = {}
    for name in controller_entries():
        try:
            load_controller(name)
        except ControllerError as error:
            cause: BaseException | None = error
            while cause is not None and not isinstance(cause, ModuleNotFoundError):
                cause = cause.__cause__
            if isinstance(cause, ModuleNotFoundError):
                found[name] = str(cause.name)
        except SystemExit:
            continue
    return found


FIRST = ("cprm", "fsm", "subsumption", "behavior_tree", "code", "belief_region", "policy", "scripted", "random")
"""The order of tables; whatever else is registered follows."""


AGAIN = ("goalie_memory", "lesion")
"""Registered controllers that are the CPRM or its net once more, unless an option takes something from them."""
WEAKENED = ("random", "eased", "goalie_raw")
"""Those that are weak on purpose: shown as a floor, and not compared."""


def registered() -> tuple[str, ...]:
    """All registered controllers in the order of tables, each once."""
    names = [name for name in controller_entries() if name not in AGAIN]
    return tuple(n for n in FIRST if n in names) + tuple(n for n in names if n not in FIRST)


LEARNED = "policy"
"""The policy that was trained for a task and comes with the project."""
STRUCTURES = ("cprm", "fsm", "subsumption", "behavior_tree", "code", "belief_region")
"""Those that differ in structure."""
TIERS_SHOWN = tuple(t for t in TIERS if t not in ("bins", "foresight"))
"""Tiers of the curves: the bins are the goalie's alone, and foresight is beyond what a player could know."""
