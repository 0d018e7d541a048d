"""How well tiers of knowledge know the ball: error and log density of the truth, on the same recorded worlds.

A goalie on the tier ``memory`` plays; what he is told and sends is recorded (`tracking.record`), and each tier makes its own of it. The
worlds are not those of a study.

    python -m cprm_gym.benchmark.ball_error --worlds 200
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..agents.body import Body
from ..agents.knowledge.belief import BeliefTier
from ..agents.knowledge.tracker import Tracker
from ..envs.observations import MAX_AGE, SelfFeature
from ..envs.players.senses import Senses
from ..envs.tasks import make_task
from ..errors import unknown_name
from .arguments import at_least
from .knowledge import SENSES
from .tracking import record

TIERS: dict[str, Callable[[Senses, Body], Tracker] | None] = {"memory": None, "tracker": Tracker, "belief": BeliefTier}
"""Name -> maker; None for what is told as it is."""
NEAR = 3.0
"""m within which a player can soon play the ball."""
FAR = 3.0
"""The largest error that counts in a mean, m."""
LEAST_DENSITY = -20.0
"""The lowest log density that counts: whoever is sure of what is not so has lost the ball."""


class BallError(NamedTuple):
    """How well a tier knows the ball.

    Attributes
    ----------
    root_mean_square, capped : float
        Of the distance from where it is, m, and its mean where each is at most 3 m.
    near : float
        Mean of the error of where it is from *him* while it is within `NEAR`, each at most 3 m: he reaches out from where he is, not from
        where he believes to be.
    velocity : float
        Root mean square error, m / cycle.
    log_density : float
        Mean of the true place's, nats; of late news carried on to now; NaN where the tier tells none.
    worlds : (W,) array
        ``capped`` of each world, by which tiers are compared in pairs; NaN where the ball was never seen.
    """

    root_mean_square: float
    capped: float
    near: float
    velocity: float
    log_density: float
    worlds: np.ndarray

    def less(self, other: BallError) -> tuple[float, float, float]:
        """How much less the capped error is than another tier's in the same worlds, m: their mean, with its 95 % interval (normal)."""
        off = self.worlds - other.worlds
        off = off[np.isfinite(off)]
        mean, half = float(off.mean()), 1.96 * float(off.std(ddof=1)) / len(off) ** 0.5
        return mean, mean - half, mean + half


def ball_error(tier: str, senses: Senses, worlds: int, seed: int, task: str = "Goalie") -> BallError:
    """The error of one tier in recorded worlds.

    Parameters
    ----------
    tier : str
        Of `TIERS`.
    senses : Senses
    worlds, seed : int
    task : str
        With a player for tiers of knowledge.
    """
    told, sent, true, own, playing = record(task, worlds, seed, senses)
    make = TIERS[tier]
    made = None if make is None else make(senses, Body.of(make_task(task)))
    if made is not None:
        made.reset(told[0])
    places, speeds, nears, densities = [], [], [], []
    sums, counts = np.zeros(worlds), np.zeros(worlds)
    for k, now in enumerate(told):
        there = playing[k] & (np.asarray(now["memory_age"])[:, 0] < MAX_AGE)
        known = now if made is None else {**now, **made.know(now, sent[k - 1] if k else None)}
        ball = np.asarray(known["memory"])[:, 0]
        off = ball - true[k]
        places.append(np.hypot(off[there, 0], off[there, 1]))
        sums[there] += np.minimum(places[-1], FAR)
        counts += there
        speeds.append(np.hypot(off[there, 2], off[there, 3]))
        away = true[k][:, :2] - own[k]
        close = there & (np.hypot(away[:, 0], away[:, 1]) < NEAR)
        apart = ball[:, :2] - np.asarray(known["self"])[:, [SelfFeature.X, SelfFeature.Y]] - away
        nears.append(np.hypot(apart[close, 0], apart[close, 1]))
        if made is not None:
            told_of = made.spread().log_density if any(senses.delays) else made.log_density
            densities.append(np.maximum(told_of(true[k][:, :2])[there], LEAST_DENSITY))
    place, speed, near = (np.concatenate(errors) for errors in (places, speeds, nears))
    density = float(np.concatenate(densities).mean()) if densities else float("nan")
    capped, nearby = (float(np.minimum(errors, FAR).mean()) if len(errors) else float("nan") for errors in (place, near))
    each = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
    return BallError(float(np.sqrt((place**2).mean())), capped, nearby, float(np.sqrt((speed**2).mean())), density, each)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--worlds", type=at_least(2), default=200)
    parser.add_argument("--seed", type=at_least(0), default=777)
    parser.add_argument("--senses", default=",".join(SENSES))
    options = parser.parse_args()
    names = options.senses.split(",")
    for name in names:
        if name not in SENSES:
            parser.error(str(unknown_name("senses", name, SENSES)))
    head = ("senses", "tier", "rms error, m", "mean, each at most 3 m", "less tracker, paired 95 %", "from him, within 3 m",
            "rms velocity, m/cycle", "log density, nats")  # fmt: skip
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for name in names:
        senses = SENSES[name]
        all_found = {tier: ball_error(tier, senses, options.worlds, options.seed) for tier in TIERS}
        for tier, found in all_found.items():
            density = "" if np.isnan(found.log_density) else f"{found.log_density:.2f}"
            pairs = "" if tier == "tracker" else "{:+.3f} ({:+.3f}, {:+.3f})".format(*found.less(all_found["tracker"]))
            errors = f"{found.root_mean_square:.2f} | {found.capped:.3f} | {pairs} | {found.near:.3f} | {found.velocity:.2f}"
            print(f"| {name} | {tier} | {errors} | {density} |", flush=True)


if __name__ == "__main__":
    main()
