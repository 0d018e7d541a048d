"""What an outfield player of a match perceives: `attacker_percepts`, where he goes without the ball, and whether he can tackle."""

from __future__ import annotations

import numpy as np

from ...envs.controller import Observation
from ...envs.observations import BodyFeature, SelfFeature
from ...envs.players.scripted import FORMATION
from ...simulator.pitch import HALF_LENGTH
from ...simulator.state import PlayMode
from ..attacker.kernels import Terms
from ..attacker.percepts import OPPONENTS, Motion, attacker_percepts
from ..body import Body
from ..outfielder.agent import KEEP_OFF
from ..percepts import Percepts
from .constants import MatchConstants
from .kernels import Places, places

AWAY = (-4 * HALF_LENGTH, 0.0)
"""Where the own goalie is thought to be, so that nobody passes to him: he may not take a pass with his hands."""


def place_terms(c: MatchConstants) -> Places:
    """What places are judged by."""
    return Places(
        shift=c.shift, sway=c.sway, ahead=c.forward, margin=c.margin, marks=c.marks, cover=c.cover, supporters=c.supporters,
        supports=c.supports, distance=KEEP_OFF, half_length=HALF_LENGTH, rest=c.rest, near=c.near,
    )  # fmt: skip


def match_percepts(
    observation: Observation, judged_by: Terms, terms: Places, motion: Motion, mates: int, goalie: int, body: Body, c: MatchConstants
) -> Percepts:
    """What an outfield player perceives.

    Parameters
    ----------
    observation : dict of (N, ...) arrays
        With the part ``memory``.
    judged_by, terms
        What shots, passes and ways, and places, are judged by.
    motion : Motion
        Of the opponents; follows them.
    mates : int
        How many there are.
    goalie : int
        Number of the own goalie; 0 if there is none.
    body : Body
    c : MatchConstants

    Returns
    -------
    dict of (N,) float64
        `attacker_percepts`, where ``support.x`` and ``support.y`` say where to go without the ball, whoever has it;
        ``their.time`` (cycles until the first opponent is at the ball), ``tackle.chance``, ``rival.gap`` (m from the ball to the nearest
        opponent).
    """
    memory, age = np.array(observation["memory"], np.float64), np.array(observation["memory_age"], np.float64)
    if goalie:
        memory[:, goalie, :2], age[:, goalie] = AWAY, 0.0
    percepts = attacker_percepts({**observation, "memory": memory, "memory_age": age}, judged_by, motion, mates, c.stale, c.focus)
    told, me = np.asarray(observation["body"]), np.asarray(observation["self"], np.float64)
    own = told[:, BodyFeature.UNUM].astype(np.int64)
    rows, others = np.arange(len(me))[:, None], np.arange(1, mates + 1)[None] + np.zeros_like(own)[:, None]
    others = others + (others >= own[:, None])
    rivals = slice(OPPONENTS, OPPONENTS + motion.opponents)
    modes = percepts["game.playing"] + 2.0 * percepts["game.ours"]
    modes = np.where((modes == 0) & _theirs(told), 3, modes).astype(np.int64)
    out = np.zeros((len(me), 4))
    state = np.ascontiguousarray(me[:, [SelfFeature.X, SelfFeature.Y, SelfFeature.VX, SelfFeature.VY, SelfFeature.BODY]])
    pairs = [np.stack([percepts[a], percepts[b]], axis=1) for a, b in (("me.time", "mate.time"), ("support.x", "support.y"))]
    places(
        np.ascontiguousarray(memory[:, 0]), state, memory[rows, others, :2], age[rows, others], np.ascontiguousarray(memory[:, rivals, :2]),
        np.ascontiguousarray(age[:, rivals]), pairs[0], np.array(percepts["line.x"]), FORMATION[own - 1], pairs[1], modes,
        percepts["body.stamina"] / body.server.stamina_max, terms, judged_by,
        body.server.tackle_dist, body.server.tackle_width, float(body.server.tackle_exponent), out,
    )  # fmt: skip
    percepts["support.x"], percepts["support.y"], percepts["their.time"], percepts["tackle.chance"] = out.T
    gap = np.hypot(memory[:, rivals, 0] - memory[:, :1, 0], memory[:, rivals, 1] - memory[:, :1, 1])
    percepts["rival.gap"] = np.where(age[:, rivals] <= 4.0, gap, 99.0).min(axis=1, initial=99.0)
    return percepts


_FIRST, _LAST = int(PlayMode.kick_off_l), int(PlayMode.goal_kick_r)


def _theirs(body: np.ndarray) -> np.ndarray:
    """(N,) bool: a set play of the opponents."""
    mode = body[:, BodyFeature.PLAY_MODE].astype(np.int64)
    set_play = ((mode >= _FIRST) & (mode <= _LAST)) | np.isin(mode, (PlayMode.indirect_free_kick_l, PlayMode.indirect_free_kick_r))
    return np.asarray(set_play & ((mode % 2 == 0) != (body[:, BodyFeature.SIDE] > 0)))
