"""How well tiers of knowledge know the own pose and the other players, on the same recorded worlds.

A goalie on the tier ``memory`` plays; what he is told and sends is recorded, and each tier makes its own of it: ``memory`` what the
environment reckons, ``tracker`` a Kalman filter for each player, ``belief`` the models of `cprm_gym.agents.knowledge.scene`. The worlds are
not those of a study.

    python -m cprm_gym.benchmark.scene.error --worlds 60
"""

from __future__ import annotations

import argparse
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from ...agents.body import Body
from ...agents.knowledge.belief import BeliefTier
from ...agents.knowledge.hands import normal_log_density
from ...agents.knowledge.players import PLAYERS, RIVAL
from ...agents.knowledge.tracker import Tracker
from ...envs.controller import Action, Controller, Observation, no_action
from ...envs.core import SoccerCore
from ...envs.observations import MAX_AGE, BodyFeature, SelfFeature
from ...envs.players.senses import Senses
from ...envs.tasks import TASKS, Task, make_task
from ...errors import unknown_name
from ...simulator.state import CommandKind
from ..arguments import at_least
from ..knowledge import SENSES

FAR = 3.0
"""The largest error of a player that counts, m."""
LOST = 1.0
"""m from where he is beyond which one who looks has lost himself."""
LEAST_DENSITY = -20.0
"""The lowest log density that counts."""
CYCLES = 40
TIERS: dict[str, type[Tracker] | None] = {"memory": None, "tracker": Tracker, "belief": BeliefTier}


class SceneRecord(NamedTuple):
    """What a player was told, did, and how it really was, cycle by cycle."""

    told: list[Observation]
    sent: list[Action]
    true: list[dict[str, np.ndarray]]
    """Of each cycle ``self``, ``memory``, ``memory_age``."""
    playing: list[np.ndarray]
    """(W,) bool of each cycle."""


class SceneError(NamedTuple):
    """How well a tier knows himself and the others.

    Attributes
    ----------
    place, face : float
        Root mean square errors of his own place (m) and of where he looks (degrees).
    lost : float
        Share of the cycles in which his place is wrong by more than `LOST`.
    others : float
        Root mean square error of the places of those who have been seen, each by his number, m.
    capped : float
        Mean of the same where each is at most `FAR`.
    anybody : float
        Mean error of the best matching of those believed in with those who are there, team by team and whatever their numbers; who is
        missing or not there counts `FAR`.
    density : float
        Mean log density of the others' true places, nats, by number; NaN where the tier tells none.
    worlds : (W,) array
        ``capped`` of each world, by which tiers are compared in pairs; NaN where nobody was seen.
    """

    place: float
    face: float
    lost: float
    others: float
    capped: float
    anybody: float
    density: float
    worlds: np.ndarray

    def less(self, other: SceneError) -> tuple[float, float, float]:
        """How much less the others' capped error is than another tier's in the same worlds, m, with its 95 % interval (normal)."""
        off = self.worlds - other.worlds
        off = off[np.isfinite(off)]
        half = 1.96 * float(off.std(ddof=1)) / np.sqrt(len(off))
        return float(off.mean()), float(off.mean()) - half, float(off.mean()) + half


class Wanderer:
    """One who dashes and turns at random, for matches in which nobody is registered: there is much to see."""

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin; all his luck is of the seed."""
        if worlds is None:
            self._random = np.random.default_rng(seed)

    def act(self, observation: Observation) -> Action:
        """A dash more often than a turn."""
        count = len(observation["level"])
        action = no_action(count)
        action["type"][:] = self._random.choice([CommandKind.DASH, CommandKind.TURN], count, p=[0.7, 0.3])
        action["params"][:, 0] = self._random.uniform(-0.3, 0.8, count)
        return action


def task_of(task: str) -> Task:
    """A task, with the options of its player if it has one."""
    return make_task(task, **PLAYERS[task].options) if task in PLAYERS else make_task(task)


def record_scene(task: str, worlds: int, seed: int, senses: Senses) -> SceneRecord:
    """What the task's player is told and sends on the tier `RIVAL`, or number 7 of a match who wanders, and the truth."""
    made, registered = task_of(task), task in PLAYERS
    options: dict[str, Any] = {} if registered else {"controlled": "left_7", "others": "strong"}
    core = SoccerCore(made, worlds, seed=seed, include=("memory", "landmarks", "lines"), senses=senses, **options)
    observation = core.reset(seed)
    make = PLAYERS[task].on(RIVAL, senses) if registered else lambda task, agent: Wanderer()
    controllers: list[Controller] = [make(made, agent) for agent in core.agents]
    for i, controller in enumerate(controllers):
        controller.reset({key: value[:, i] for key, value in observation.items()}, seed)
    found = SceneRecord([], [], [], [np.ones(worlds, bool)])
    for _ in range(min(CYCLES, made.max_cycles)):
        found.told.append({key: value[:, 0].copy() for key, value in core.observation.items()})
        found.true.append({key: value.copy() for key, value in core.truth(core.agents[0]).items()})
        seen = [{key: value[:, i] for key, value in core.observation.items()} for i in range(len(controllers))]
        actions = [controller.act(told) for controller, told in zip(controllers, seen)]
        found.sent.append({key: np.array(value) for key, value in actions[0].items()})
        step = core.step({key: np.stack([np.asarray(action[key]) for action in actions], axis=1) for key in actions[0]})
        found.playing.append(found.playing[-1] & ~(step.terminated | step.truncated))
    return found


def unmatched(known: np.ndarray, places: np.ndarray, there: np.ndarray, true: np.ndarray) -> float:
    """Mean error of a team's players by the best matching, each at most `FAR` (OSPA metric of order 1); NaN for nobody.

    Parameters
    ----------
    known, there : (11,) bool arrays
    places, true : (11, 2) arrays
    """
    most = max(int(known.sum()), int(there.sum()))
    if most == 0:
        return float("nan")
    gaps = np.minimum(np.hypot(*(places[known, None, k] - true[None, there, k] for k in (0, 1))), FAR)
    one, other = linear_sum_assignment(gaps)
    return float((gaps[one, other].sum() + FAR * (most - min(gaps.shape))) / most)


def scene_error(tier: str, record: SceneRecord, senses: Senses, task: str) -> SceneError:
    """The error of one tier in recorded worlds.

    Parameters
    ----------
    tier : str
        Of `TIERS`.
    record : SceneRecord
        Of `record_scene` with these senses.
    senses : Senses
    task : str
    """
    make = TIERS[tier]
    made = None if make is None else make(senses, Body.of(task_of(task)))
    if made is not None:
        made.reset(record.told[0])
    own, faces, others, matched, densities = [], [], [], [], []
    totals, counts = np.zeros(len(record.playing[0])), np.zeros(len(record.playing[0]))
    for k, told in enumerate(record.told):
        now = told if made is None else {**told, **made.know(told, record.sent[k - 1] if k else None)}
        true, playing, rows = record.true[k], record.playing[k], np.arange(len(record.playing[k]))
        me, places = np.asarray(now["self"], np.float64), np.asarray(now["memory"], np.float64)[:, 1:, :2]
        off = me - true["self"]
        own.append(np.hypot(off[playing, SelfFeature.X], off[playing, SelfFeature.Y]))
        faces.append(np.abs((off[playing, SelfFeature.FACE] + np.pi) % (2.0 * np.pi) - np.pi))
        there, known = true["memory_age"][:, 1:] == 0, np.asarray(now["memory_age"])[:, 1:] < MAX_AGE
        mine = np.asarray(told["body"])[:, BodyFeature.UNUM].astype(np.int64) - 1
        there[rows, mine] = known[rows, mine] = False
        seen = there & (np.asarray(told["memory_age"])[:, 1:] < MAX_AGE) & playing[:, None]
        real = true["memory"][:, 1:, :2]
        gaps = np.hypot(*(places[..., i] - real[..., i] for i in (0, 1)))
        others.append(gaps[seen])
        totals += (np.minimum(gaps, FAR) * seen).sum(axis=1)
        counts += seen.sum(axis=1)
        for world in np.flatnonzero(playing):
            for team in (slice(0, 11), slice(11, 22)):
                matched.append(unmatched(known[world, team], places[world, team], there[world, team], real[world, team]))
        past = record.true[max(k - senses.delays[1], 0)]["memory"][:, 1:, :2]
        if isinstance(made, BeliefTier):
            densities.append(np.maximum(made.others.log_density(past), LEAST_DENSITY)[seen])
        elif made is not None:
            densities.append(np.maximum(_tracked_density(made, past), LEAST_DENSITY)[seen])
    place, face, other = (np.concatenate(found) for found in (own, faces, others))
    return SceneError(
        float(np.sqrt((place**2).mean())), float(np.degrees(np.sqrt((face**2).mean()))), float((place > LOST).mean()),
        float(np.sqrt((other**2).mean())), float(np.minimum(other, FAR).mean()), float(np.nanmean(matched)),
        float(np.concatenate(densities).mean()) if densities else float("nan"),
        np.where(counts > 0, totals / np.maximum(counts, 1), np.nan),
    )  # fmt: skip


def _tracked_density(tracker: Tracker, place: np.ndarray) -> np.ndarray:
    """(N, 22) log density of places under the tracker's filters, which have one variance for both directions."""
    cov = tracker._spread[..., 0, None, None] * np.eye(2)
    return normal_log_density(place - tracker._others[..., :2], cov)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--worlds", type=at_least(1), default=60)
    parser.add_argument("--seed", type=at_least(0), default=777)
    parser.add_argument("--task", default="Goalie3v2", choices=sorted(TASKS))
    parser.add_argument("--senses", default=",".join(SENSES))
    options = parser.parse_args()
    names = options.senses.split(",")
    for name in names:
        if name not in SENSES:
            parser.error(str(unknown_name("senses", name, SENSES)))
    print(
        "| senses | tier | place, m | face, degrees | lost, % | others, m | at most 3 m | less tracker, paired 95 % | whoever they are, m |"
        " log density, nats |\n|---|---|---|---|---|---|---|---|---|---|"
    )
    for name in names:
        record = record_scene(options.task, options.worlds, options.seed, SENSES[name])
        found = {tier: scene_error(tier, record, SENSES[name], options.task) for tier in TIERS}
        for tier, e in found.items():
            pairs = "" if tier != "belief" else "{:+.3f} ({:+.3f}, {:+.3f})".format(*e.less(found["tracker"]))
            density = "" if np.isnan(e.density) else f"{e.density:.2f}"
            own = f"{e.place:.3f} | {e.face:.2f} | {100 * e.lost:.1f}"
            print(f"| {name} | {tier} | {own} | {e.others:.2f} | {e.capped:.3f} | {pairs} | {e.anybody:.3f} | {density} |", flush=True)


if __name__ == "__main__":
    main()
