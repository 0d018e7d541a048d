"""What a page is shown of a cycle: the world for everybody, and of the chosen players all that went on in them.

Numbers are in metres, degrees and the server's frame, cut to what can be seen, so that a frame of 22 players stays a few kilobytes.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from ...agents.demos import _object_number, believed_ball, held
from ...agents.play import agent_in
from ...architecture.cprm import CPRMRunner
from ...architecture.petri import ObjectPlace
from ...architecture.petri.execution.compiled_net import PlaceKind
from ...envs.actions import PARAMETER_SCALES
from ...envs.rendering import CONE
from ...simulator.state import CommandKind, PlayMode
from .memory import runner_of
from .run import Run

MOST_SHOWN = 24
"""Beliefs of a player that are shown unless others are asked for."""
MOST_FIRED = 300
"""Firings of a cycle that are shown; a net that goes on without end has ten thousand."""
FLAT = 0.9
"""Share of the likeliest cell from which on the last one shown says that all are about as likely."""
ARGUMENTS = (0, 2, 1, 2, 2, 1, 2, 4)
"""Of each `CommandKind`, how many there are."""
POINTS = 40
"""Points that show where a player believes the ball to be."""
Message = dict[str, Any]


def number(value: float, digits: int = 3) -> float | None:
    """A number that JSON can say; None for one that is not finite."""
    return round(float(value), digits) if math.isfinite(value) else None


def world_of(world: np.void, counts: tuple[int, int]) -> Message:
    """Ball and players.

    Parameters
    ----------
    world : record of WORLD
    counts : (int, int)
        Players of the sides.

    Returns
    -------
    dict
        ``ball`` x, y, vx, vy; ``players`` rows of object number, x, y, direction of the body and of the face, half the view cone
        (degrees), stamina.
    """
    x, y = world["pos"][0]
    vx, vy = world["vel"][0]
    players = []
    for i in (*range(counts[0]), *range(11, 11 + counts[1])):
        if not world["enabled"][i]:
            continue
        body, face = float(world["body"][i]), float(world["body"][i] + world["neck"][i])
        half = CONE.get(int(world["view_width"][i]), CONE[2]) / 2
        px, py = world["pos"][i + 1]
        angles = (round(math.degrees(a)) for a in (body, face, half))
        players.append([i + 1, number(px, 2), number(py, 2), *angles, round(float(world["stamina"][i]))])
    return {
        "time": int(world["time"]),
        "mode": PlayMode(int(world["mode"])).name,
        "score": [int(s) for s in world["score"]],
        "ball": [number(x, 2), number(y, 2), number(vx, 3), number(vy, 3)],
        "players": players,
    }


def frame(run: Run, shown: Collection[str], asked: Mapping[str, Collection[str]]) -> Message:
    """A cycle of a run.

    Parameters
    ----------
    run : Run
    shown : collection of str
        Agents that are shown in full.
    asked : mapping of str to collection of str
        Agent -> variables whose distributions are shown; by default those that its net reads.
    """
    core = run.core
    message: Message = {
        "cycle": run.cycle,
        "status": run.status,
        "success": run.success,
        "over": run.over,
        "trouble": run.trouble,
        "struck": run.struck,
        "world": world_of(core.sim.world[0], core.counts),
        "commands": {name: command(run, i) for i, name in enumerate(run.agents)} if run.actions else {},
        "changes": [c.said() for c in run.hands.log if c.cycle == run.cycle],
        "agents": {},
    }
    for i, name in enumerate(run.agents):
        if name in shown:
            message["agents"][name] = inside(run, i, asked.get(name))
    return message


def command(run: Run, i: int) -> str:
    """What an agent's body does: ``dash(80, 0)``."""
    action = run.actions[i]
    kind = CommandKind(int(action["type"][0]))
    if kind == CommandKind.NONE:
        return ""
    given = np.asarray(action["params"][0], float) * PARAMETER_SCALES[kind]
    return f"{kind.name.lower()}({', '.join(f'{v:.4g}' for v in given[: ARGUMENTS[kind]] + 0.0)})"


def inside(run: Run, i: int, asked: Collection[str] | None = None) -> Message:
    """What went on in an agent: marking, firings, beliefs, readings, commands."""
    player = run.players[i]
    runner = runner_of(player)
    if runner is None or not runner._percepts:
        return {"kind": type(player).__name__}
    decision = runner.explain()
    fired, enabled = happened(runner)
    holds = {p: object_held(runner, p) for p in runner.executor.object_names}
    message: Message = {
        "kind": "cprm",
        "marking": {name: number(value) for name, value in decision.marking.items()},
        "holds": {p: o for p, o in holds.items() if o is not None},
        "clocks": clocks(runner),
        "fired": fired,
        "enabled": enabled,
        "commands": {name: {k: number(v, 1) for k, v in values.items()} for name, values in decision.commands.items()},
        "percepts": {name: number(value) for name, value in decision.percepts.items()},
        "evidence": {name: reading(runner, name, value) for name, value in decision.evidence.items()},
        "relations": list(decision.relations),
        "places": {name: number(value) for name, value in decision.beliefs.items()},
    }
    posterior = posterior_of(runner)
    if posterior is not None:
        names = [name for name in (read_variables(runner) if asked is None else asked) if name in variables(runner)]
        message["beliefs"] = {name: distribution(runner, name) for name in names[:MOST_SHOWN]}
    inner = agent_in(player)
    if inner is not None:
        side, own = float(run.core.sides[i]), int(run.core.players[i])
        if "memory" in run.core.observation:
            points = believed_ball(player, {key: value[:, i] for key, value in run.core.observation.items()})[-POINTS:]
            if len(points) == 1 or points[0, 2] < FLAT:  # of a flat belief, any few cells would be as good
                message["ball"] = [[number(x * side, 2), number(y * side, 2), number(w, 2)] for x, y, w in points.tolist()]
        message["spots"] = spots(runner, side, own)
        message["marks"] = {str(k): text for k, text in held(inner, own).items()}
    return message


def happened(runner: CPRMRunner) -> tuple[list[str], list[str]]:
    """What fired in this cycle, in order, also when the cycle failed; and what was enabled at some firing and did not fire."""
    trace = runner.executor.trace
    firings = [] if trace is None else trace.firings(0)[:MOST_FIRED]
    fired = [firing.transition for firing in firings]
    return fired, sorted({name for firing in firings for name in firing.enabled}.difference(fired))


def quantities(runner: CPRMRunner) -> frozenset[str]:
    """Places of a runner's net that hold numbers and no tokens: inputs, beliefs, math and continuous places."""
    compiled = runner.executor.net
    return frozenset(n for n, k in zip(compiled.place_names, compiled.kind) if k not in (PlaceKind.DISCRETE, PlaceKind.OBJECT))


def object_held(runner: CPRMRunner, place: str) -> str | None:
    """The object in an object place."""
    index = int(runner.executor.holds(place)[0])
    class_name = next(p.class_name for p in runner.executor.net.net.places if isinstance(p, ObjectPlace) and p.name == place)
    objects = [name for name, kind in runner.cprm.objects.items() if kind == class_name]
    return objects[index] if 0 <= index < len(objects) else None if index < 0 else f"{class_name} {index}"


def clocks(runner: CPRMRunner) -> dict[str, list[int]]:
    """Timed transitions whose clocks run: cycles counted, of the delay."""
    net, found = runner.executor.net, {}
    for t in np.flatnonzero(net.delay > 0).tolist():
        counted = int(runner.executor.clocks(net.transition_names[t])[0].max(initial=-1))
        if counted >= 0:
            found[net.transition_names[t]] = [counted, int(net.delay[t])]
    return found


# ------------------------------------------------------------------ beliefs


def posterior_of(runner: CPRMRunner) -> Any:
    """The posterior of the last slice; None without a model, or before the first."""
    if runner.bank is not None:
        return runner.bank.answers[0][1] if runner.bank.answers else None
    return None if runner.separate is None else runner.separate.answers[0]


def variables(runner: CPRMRunner) -> Mapping[str, Any]:
    """The variables of the last slice, by the names that the objects have for everybody."""
    posterior = posterior_of(runner)
    return {} if posterior is None else posterior.variables


def reading(runner: CPRMRunner, name: str, value: float | None) -> float | str | None:
    """What was observed of a variable, as its state's name or as a number; None for what was not."""
    known = variables(runner).get(name)
    if value is None or known is None or known.edges is not None or known.quantity is not None:
        return None if value is None else number(value)
    return str(known.states[int(value)])


def marginal(runner: CPRMRunner, name: str) -> Any:
    """The belief about a variable: (card,) probabilities, or a mixture of normals."""
    if runner.bank is not None:
        return runner.bank.marginal(name, 0)
    posterior = posterior_of(runner)
    found = posterior[name]
    return found[0] if isinstance(found, np.ndarray) else found


def read_variables(runner: CPRMRunner) -> list[str]:
    """Variables that belief places read now, object places replaced by whom they hold."""
    names: dict[str, None] = {}
    for place in runner.executor.belief_places:
        owner, dot, attribute = place.variable.partition(".")
        if owner in runner._class_at:
            there = object_held(runner, owner)
            if there is None:
                continue
            owner = there
        names[owner + dot + attribute] = None
    return list(names)


def distribution(runner: CPRMRunner, name: str) -> Message:
    """A belief to be drawn: probabilities, expectation and standard deviation where there are numbers."""
    found, variable = marginal(runner, name), variables(runner)[name]
    if variable.quantity is not None:
        mean, spread = moments(found, variable)
        return {"mean": number(mean), "spread": number(spread)}
    p = np.asarray(found)
    message: Message = {"p": [round(float(v), 3) for v in p]}
    if variable.edges is not None:
        mean, spread = moments(p, variable)
        message |= {"mean": number(mean), "spread": number(spread)}
    return message


def moments(found: Any, variable: Any) -> tuple[float, float]:
    """Expectation and standard deviation; of an angle its mean direction."""
    if variable.quantity is not None:
        return float(np.ravel(found.expectation())[0]), float(np.sqrt(np.ravel(found.variance())[0]))
    p = np.asarray(found, float)
    middle = 0.5 * (variable.edges[:-1] + variable.edges[1:])
    if variable.circular:
        period = variable.edges[-1] - variable.edges[0]
        z = np.sum(p * np.exp(2j * np.pi * middle / period))
        return float(np.angle(z) * period / (2 * np.pi)), float(np.sqrt(max(0.0, -2 * np.log(max(abs(z), 1e-9)))) * period / (2 * np.pi))
    mean = float(p @ middle)
    return mean, float(np.sqrt(max(0.0, p @ (middle - mean) ** 2)))


def spots(runner: CPRMRunner, side: float, own: int) -> list[list[Any]]:
    """Where a player believes objects to be: object number (0 the ball), x, y and the standard deviations, metres.

    Only objects of whom the model has the place and that relations or object places have in view; of others it believes what it did at
    the beginning.
    """
    known = variables(runner)
    named = " ".join(
        (*map(str, runner._tuples(runner._in_force, 0)), *(o or "" for o in (object_held(runner, p) for p in runner._class_at)))
    )
    found = []
    for name in runner.cprm.objects:
        x, y = f"{name}.x", f"{name}.y"
        if x not in known or y not in known or (name != "ball" and name not in named):
            continue
        (mx, sx), (my, sy) = (moments(marginal(runner, v), known[v]) for v in (x, y))
        whom = 0 if name == "ball" else _object_number(name, own)
        found.append([whom, number(mx * side, 2), number(my * side, 2), number(sx, 2), number(sy, 2)])
    return found
