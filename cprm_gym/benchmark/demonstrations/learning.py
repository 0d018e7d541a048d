"""Learning what a holder of the ball is about to do, from logged play.

``python -m cprm_gym.benchmark.demonstrations.learning shooter`` plays own worlds by seed, grows the trees, counts the tables (or finds
them by expectation-maximisation where what a player has in mind is not logged) and tells how well they foresee shots of other worlds.
"""

from __future__ import annotations

import argparse
import itertools
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...agents.body import Body
from ...agents.intention.model import DUE, LINE, MODES, PACE, POSSESSES, RULES, TABLES, Intention, intention_model
from ...agents.intention.situation import FEATURES, GOAL_X, TOUCHES, VIEW, touch
from ...agents.intention.tier import IntentionTier, Told
from ...agents.intention.tree import Tree, grow
from ...agents.knowledge.players import PLAYERS
from ...agents.knowledge.tracker import Tracker
from ...architecture.prm.grounding.grounding import Grounding
from ...architecture.prm.inference.learning import Episode, Observed, count, em
from ...envs.core import SoccerCore
from ...envs.players.mixing import Mode
from ...envs.players.senses import Senses
from ...envs.tasks import make_task
from ...simulator.state import Count
from ..arguments import at_least
from ..knowledge import SENSES

PLAYS: dict[str, tuple[str, dict[str, Any]]] = {"shooter": ("Goalie", {"shots": 0.0}), "attackers": ("Goalie2v1", {})}
"""Kind of play -> task and its options."""
LEARNING_SEED = 700_000
"""Of the worlds that are learned from; the held-out ones have the next seed. No measurement meets them."""
WIDE, FAST = 2.0, 1.2
"""Metres beside the post within which a kick at the goal is a shot; its least speed, m / cycle."""
LEAVES = {"situations": 240, "views": 24, "drives": 24}
WORTH = 6.0
"""Rows that a leaf's share over all modes counts as much as, in the table of one mode."""
UNSEEN = 4
"""Cycles after a shot in which it may not have been seen yet: the model asks for a shot where there has been none."""
SENSES_LEARNED = ("default", "default", "wide", "lost .3", "lost .6", "asynchronous", "noise .5", "noise 1")
"""Senses of the suite ``knowledge`` in which the logged worlds are played, an equal share each."""
EPISODE = 12
"""Slices of a piece of play that the temporal links are learned from."""


@dataclass
class Log:
    """Cycles of logged play in which somebody held the ball; arrays over N cycles.

    Attributes
    ----------
    world, cycle : (N,) int
    numbers : (N, F) float
        `situation`.
    seen : (N, V + F) float
        `view` and `situation`.
    holder, touch, mode : (N,) int
        Who; index of `TOUCHES`, -1 in the first cycle; index of `MODES`, -1 where it is not logged.
    shot : (N,) bool
        In the cycle that comes.
    line, speed : (N,) float
        Of that shot: where it crosses the goal line, m, and m / cycle.
    """

    world: np.ndarray
    cycle: np.ndarray
    numbers: np.ndarray
    seen: np.ndarray
    holder: np.ndarray
    touch: np.ndarray
    mode: np.ndarray
    shot: np.ndarray
    line: np.ndarray
    speed: np.ndarray

    @property
    def due(self) -> np.ndarray:
        """(N,) index of `DUE`: cycles until the next shot of the same world."""
        found, following, world = np.full(len(self.world), len(DUE) - 1), 99, -1
        last = -1
        for k in np.lexsort((self.cycle, self.world))[::-1]:
            if self.world[k] != world:
                world, following = self.world[k], 99
            elif following < 99:
                following += int(last - self.cycle[k])
            if self.shot[k]:
                following = 1
            last = self.cycle[k]
            found[k] = min(following, len(DUE)) - 1
        return found


class _Watching(IntentionTier):
    """Notes what it sees instead of inferring from it."""

    def __init__(self, inner: Tracker, opponents: int) -> None:
        nothing = Tree((-1,), (0.0,), (-1,), (-1,))
        even = {"begin": (), "mode": (len(MODES),), "touch": (len(MODES),), "due": (len(MODES), 1), "line": (len(MODES), 1), "pace": (1,)}
        sizes = {"begin": len(MODES), "mode": len(MODES), "touch": len(TOUCHES), "due": len(DUE), "line": len(LINE), "pace": len(PACE)}
        tables = {name: np.full((*shape, sizes[name]), 1.0 / sizes[name]) for name, shape in even.items()}
        super().__init__(inner, Intention(nothing, nothing, nothing, tables), opponents)

    def _expect(self) -> np.ndarray:
        ball = self.inner.course()[0]
        count = len(ball)
        held = self.holding(ball[None], self.inner.late)
        numbers, seen = np.zeros((count, len(FEATURES))), np.zeros((count, len(VIEW) + len(FEATURES)))
        numbers[held.at[1]], seen[held.at[1]] = held.numbers, held.seen
        self.noted = (held.holder[0], numbers, seen, np.where(self._cycles > 0, touch(self._before, ball, self.inner.body), -1))
        self._before = ball.copy()
        return np.zeros((count, len(Told)))


def joined(logs: list[Log]) -> Log:
    """One log of several, whose worlds are numbered on."""
    first, columns = 0, []
    for log in logs:
        columns.append([log.world + first, *(getattr(log, entry.name) for entry in fields(Log)[1:])])
        first += int(log.world.max()) + 1 if len(log.world) else 0
    return Log(*(np.concatenate(column) for column in zip(*columns)))


def logged_in_all_senses(play: str, worlds: int, seed: int) -> Log:
    """`logged` in `SENSES_LEARNED`, the same number of worlds in each, of seeds that differ."""
    each = worlds // len(SENSES_LEARNED)
    return joined([logged(play, each, seed + 10 * k, SENSES[name]) for k, name in enumerate(SENSES_LEARNED)])


def logged(play: str, worlds: int, seed: int, senses: Senses | None = None, slots: int = 250) -> Log:
    """Play and note; the goalie knows what the tier ``tracker`` tells him.

    Parameters
    ----------
    play : str
        Of `PLAYS`.
    worlds, seed : int
    senses : Senses, optional
    slots : int
        Worlds played at once.
    """
    name, options = PLAYS[play]
    task, senses = make_task(name, **options), senses or Senses()
    opponents = task.right
    parts: list[list[np.ndarray]] = []
    for first in range(0, worlds, slots):
        count_here = min(slots, worlds - first)
        core = SoccerCore(task, count_here, seed=seed, first_world=first, include=("memory",), senses=senses)
        observation = core.reset(seed)
        controller = PLAYERS[name].on("tracker", senses)(task, core.agents[0])
        watching = _Watching(Tracker(senses, Body.of(task)), opponents)
        alone = {key: value[:, 0] for key, value in observation.items()}
        controller.reset(alone, seed)
        watching.reset(alone)
        playing, sent, since = np.ones(count_here, bool), None, np.full(count_here, UNSEEN + 1)
        for cycle in range(int(task.max_cycles)):
            alone = {key: value[:, 0] for key, value in core.observation.items()}
            watching.know(alone, sent)
            holder, numbers, seen, done = watching.noted
            modes = _modes(core)
            kicks = core.sim.world["counts"][:, 11 : 11 + opponents, Count.KICK].copy()
            sent = {key: np.array(value) for key, value in controller.act(alone).items()}
            step = core.step({key: value[:, None] for key, value in sent.items()})
            kicked = (core.sim.world["counts"][:, 11 : 11 + opponents, Count.KICK] > kicks).any(axis=1)
            line, speed, at_goal = _crossing(core)
            mode = modes[np.arange(count_here), np.maximum(holder, 0)]
            rows = playing & (holder >= 0) & (since > UNSEEN)
            if core.mixes:
                rows &= mode >= 0  # the first one is drawn in the first cycle
            since = np.where(kicked & at_goal, 0, since + 1)
            worlds_here, now = first + np.arange(count_here), np.full(count_here, cycle)
            values = (worlds_here, now, numbers, seen, holder, done, mode, kicked & at_goal, line, speed)
            parts.append([value[rows] for value in values])
            playing &= ~(step.terminated | step.truncated)
            if not playing.any():
                break
    return Log(*(np.concatenate(column) for column in zip(*parts)))


def _modes(core: SoccerCore) -> np.ndarray:
    """(W, K) index of `MODES` of the opponents, -1 of who does not mix."""
    opponents = slice(11, 22)
    mode = core.intentions()[:, opponents]
    if not core.mixes or core.scripted is None or core.scripted.mixing is None:
        return mode
    side = core.scripted.mixing.intents["side"][:, opponents]
    plain = np.select([mode == Mode.DRIBBLE, mode == Mode.PASS, mode == Mode.FEINT, mode == Mode.SHOOT], [0, 3, 1, 4], -1)
    # sides are of the attackers' frame: their left is the goalie's right
    return np.where((mode == Mode.FEINT) & (side > 0), 2, np.where((mode == Mode.SHOOT) & (side != 0), np.where(side < 0, 6, 5), plain))


def _crossing(core: SoccerCore) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the ball crosses the goal line, how fast it was kicked, and whether that is a shot; (W,) each."""
    world, body = core.sim.world, Body.of(core.task)
    (x, y), (vx, vy) = world["pos"][:, 0].T, world["vel"][:, 0].T
    speed, towards = np.hypot(vx, vy), np.minimum(vx, -0.2)
    line = y + vy / towards * (GOAL_X - x)
    arrives = (x - GOAL_X) * speed / -towards < speed / body.roll + 1.0
    at_goal = (vx < -0.2) & (np.abs(line) < body.server.goal_width / 2 + WIDE) & arrives & (speed > FAST)
    return line, speed / body.ball_decay, at_goal


def learn(log: Log, hidden: bool, source: str, start: Intention | None = None, iterations: int = 12) -> Intention:
    """Trees and tables from logged play.

    Parameters
    ----------
    log : Log
    hidden : bool
        Whether what players have in mind is found by expectation-maximisation instead of counted.
    source : str
        How it came about.
    start : Intention, optional
        Where expectation-maximisation begins, for the tables of modes and touches.
    iterations : int
    """
    due, line = log.due, np.clip(np.searchsorted(np.array(LINE.edges), log.line, side="right") - 1, 0, len(LINE) - 1)
    speed = np.clip(np.searchsorted(np.array(PACE.edges), log.speed, side="right") - 1, 0, len(PACE) - 1)
    situations = grow(log.numbers, due, LEAVES["situations"])
    seen = log.seen[:, : len(VIEW)]
    views = grow(seen[log.shot], line[log.shot], LEAVES["views"], 30)
    drives = grow(log.seen[log.shot], speed[log.shot], LEAVES["drives"], 30)
    leaf, open_to = situations.leaf(log.numbers), views.leaf(seen)
    tables = _even(situations.leaves, views.leaves, drives.leaves, start)
    whole_due = _shares(leaf, due, situations.leaves, len(DUE))
    whole_line = _shares(open_to[log.shot], line[log.shot], views.leaves, len(LINE))
    pace = _shares(drives.leaf(log.seen[log.shot]), speed[log.shot], drives.leaves, len(PACE))
    if hidden:
        # each mode is a little different to begin with, so that they can part
        leans = np.linspace(-1.0, 1.0, len(MODES))[[0, 2, 2, 1, 6, 5, 5]]
        tilt = np.exp(np.outer(leans, np.linspace(0.5, -0.5, len(DUE))))
        tables["due"] = whole_due[None] * tilt[:, None]
        tables["line"] = np.repeat(whole_line[None], len(MODES), axis=0)
        tables = {name: table / table.sum(axis=-1, keepdims=True) for name, table in tables.items()}
    model = intention_model(situations.leaves, views.leaves, drives.leaves, tables)
    world = Grounding(model, {"ball": "Ball", "o1": "Opponent"})
    pieces = episodes(log, leaf, open_to, due, line, whole=not hidden)
    targets = ("o.mode", "b.touch", "o.due") if hidden else ("o.mode", "b.touch")
    keys = [("relation", POSSESSES, target) for target in targets]
    fit = em(world, pieces, iterations=iterations, only=keys, prior=0.02) if hidden else count(world, pieces, only=keys, prior=0.5)
    counts = dict(fit.counts)
    if not hidden:  # lines are those of shots alone
        shots = episodes(log, leaf, open_to, due, line, whole=True, only=log.shot)
        key = ("relation", POSSESSES, *RULES["line"])
        counts[key] = count(world, shots, only=[key[:3]]).counts[key]
    learnt = {name: _table(fit.model, *RULES[name]) for name in ("begin", "mode", "touch")}
    for name, whole in (("due", whole_due), ("line", whole_line)):
        counted = counts.get(("relation", POSSESSES, *RULES[name]), np.zeros((len(MODES), *whole.shape)))
        pseudo = counted + WORTH * whole[None]
        learnt[name] = pseudo / pseudo.sum(axis=-1, keepdims=True)
    return Intention(situations, views, drives, learnt | {"pace": pace}, source)


def _table(model: Any, target: str, part: str) -> np.ndarray:
    change = next(c for c in model.relations[0].changes if c.target == target)
    return np.asarray(getattr(change, part).values)


def _even(situations: int, views: int, drives: int, start: Intention | None) -> dict[str, np.ndarray]:
    shapes = {"begin": (len(MODES),), "mode": (len(MODES),) * 2, "touch": (len(MODES), len(TOUCHES)),
              "due": (len(MODES), situations, len(DUE)), "line": (len(MODES), views, len(LINE)), "pace": (drives, len(PACE))}  # fmt: skip
    tables = {name: np.full(shape, 1.0 / shape[-1]) for name, shape in shapes.items()}
    # what he has in mind lasts, to begin with
    tables["mode"] = 0.85 * np.eye(len(MODES)) + 0.15 * tables["mode"]
    if start is not None:
        tables |= {name: 0.95 * start.tables[name] + 0.05 / shapes[name][-1] for name in ("begin", "mode", "touch")}
    return tables


def _shares(leaf: np.ndarray, outcome: np.ndarray, leaves: int, states: int) -> np.ndarray:
    """(leaves, states) shares of the outcomes, each with half a row of all together."""
    table = np.zeros((leaves, states))
    np.add.at(table, (leaf, outcome), 1.0)
    table += table.sum(axis=0) / table.sum() + 1e-3
    return np.asarray(table / table.sum(axis=1, keepdims=True))


def episodes(
    log: Log,
    leaf: np.ndarray,
    open_to: np.ndarray,
    due: np.ndarray,
    line: np.ndarray,
    whole: bool = False,
    only: np.ndarray | None = None,
) -> list[Episode]:
    """Pieces of play of one length each, as data of the model: cycles that follow each other in which one man holds the ball.

    What is not known is missing; as a whole, a cycle without a shot has some line and the first one no touch, and modes are told. With
    `only` (N,) bool, each of these cycles is a piece of its own.
    """
    order = np.lexsort((log.cycle, log.world))
    order = order if only is None else order[only[order]]
    follows = (only is None) & (np.diff(log.world[order]) == 0) & (np.diff(log.cycle[order]) == 1) & (np.diff(log.holder[order]) == 0)
    begins = np.flatnonzero(np.concatenate([[True], ~follows]))
    ends = np.append(begins[1:], len(order))
    by_length: dict[int, list[np.ndarray]] = {}
    for begin, end in zip(begins, ends):
        for at in range(begin, end, EPISODE):
            piece = order[at : min(at + EPISODE, end)]
            by_length.setdefault(len(piece), []).append(piece)
    made = []
    for length, pieces in sorted(by_length.items()):
        rows = np.stack(pieces)  # (batch, length)
        steps = []
        for t in range(length):
            now = rows[:, t]
            evidence: dict[str, Any] = {
                "o1.situation": leaf[now], "o1.view": open_to[now], "o1.due": due[now],
                "o1.line": np.ma.masked_array(line[now], mask=~log.shot[now]), "ball.touch": np.ma.masked_less(log.touch[now], 0),
            }  # fmt: skip
            if whole:
                evidence = {name: np.ma.filled(values, 0) for name, values in evidence.items()} | {"o1.mode": log.mode[now]}
                evidence["o1.pace"] = np.zeros(len(now), np.int64)  # its table is made of shots alone
            steps.append(Observed(evidence, (f"{POSSESSES}(o1,ball)",)))
        made.append(Episode(tuple(steps), len(rows)))
    return made


def foreseen(intention: Intention, log: Log) -> dict[int, np.ndarray]:
    """Within 1, 3 and 5 cycles -> (N,) probabilities of a shot, each from what was seen up to then; in the order of the log."""
    from ...architecture.prm.inference.filter import Filter

    leaf, open_to = intention.situations.leaf(log.numbers), intention.views.leaf(log.seen[:, : len(VIEW)])
    nothing = np.zeros(len(log.world), np.int64)
    world = Grounding(intention.model(), {"ball": "Ball", "o1": "Opponent"})
    found = {cycles: np.full(len(log.world), np.nan) for cycles in (1, 3, 5)}
    rows = np.arange(len(log.world))
    for piece in episodes(replace(log, shot=rows >= 0), leaf, open_to, nothing, rows):
        tracked = Filter(world, piece.batch)
        for step in piece.steps:
            given = {name: step.evidence[name] for name in ("o1.situation", "o1.view", "ball.touch")}
            posterior = tracked.step(given, step.relations)
            for cycles, into in found.items():
                into[step.evidence["o1.line"]] = posterior["o1.due"][:, :cycles].sum(axis=1)
    return found


def log_loss(chance: np.ndarray, happened: np.ndarray) -> float:
    """Mean log-loss, nats; chances are kept off 0 and 1 by a thousandth."""
    chance = np.clip(chance, 1e-3, 1 - 1e-3)
    return float(-np.where(happened, np.log(chance), np.log(1 - chance)).mean())


def calibration(
    chance: np.ndarray, happened: np.ndarray, edges: tuple[float, ...] = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)
) -> list[tuple[float, float, int]]:
    """(mean chance, share that happened, how many) of chances between the edges."""
    rows = []
    for low, high in itertools.pairwise(edges):
        inside = (chance >= low) & ((chance < high) | (high == 1.0))
        if inside.any():
            rows.append((float(chance[inside].mean()), float(happened[inside].mean()), int(inside.sum())))
    return rows


def report(intention: Intention, log: Log) -> str:
    """Log-loss and calibration as text; of cycles with the holder within 2.5 m of the ball."""
    near = log.numbers[:, 0] < 2.5
    due, lines = log.due, []
    for cycles, chance in foreseen(intention, log).items():
        happened = due[near] < cycles
        base = log_loss(np.full(near.sum(), happened.mean()), happened)
        lines.append(
            f"within {cycles}: rate {happened.mean():.3f}, log-loss {log_loss(chance[near], happened):.3f}, of the rate alone {base:.3f}"
        )
        lines += [f"  {said:.2f} said, {came:.2f} came, of {many}" for said, came, many in calibration(chance[near], happened)]
    return "\n".join(lines)


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description="Learn what a holder of the ball is about to do, from own play.")
    parser.add_argument("play", choices=sorted(PLAYS))
    parser.add_argument("--worlds", type=at_least(1), default=8000)
    parser.add_argument("--held-out", type=at_least(1), default=1500)
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    log = logged_in_all_senses(options.play, options.worlds, LEARNING_SEED)
    other = logged(options.play, options.held_out, LEARNING_SEED + 5)
    hidden = bool((log.mode < 0).any())
    source = f"{'expectation-maximisation' if hidden else 'counts'} over {options.worlds} worlds, {options.play}"
    found = Intention.of(learn(log, hidden, source).to_json())
    print(report(found, other))
    place = options.output or TABLES / f"{options.play}.json"
    place.write_text(found.to_json(), encoding="utf-8")
    print(f"wrote {place}")


if __name__ == "__main__":
    main()
