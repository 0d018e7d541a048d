"""One save told frame by frame: what happened, and what the goalie believed.

``python -m cprm_gym.benchmark.demonstrations.story docs/images/save_before_the_kick.svg`` looks for the first world in which the model
saves what its tracker alone concedes because it set out in the cycle of the kick, and draws it.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...agents.intention.situation import GOAL_X
from ...agents.intention.tier import Told
from ...agents.skills.constants import GoalieConstants
from ...envs.core import SoccerCore
from ...envs.players.senses import Senses
from ...envs.tasks import make_task
from ...errors import CprmError
from ...files import write_atomically
from ...simulator.parameters import ServerParameters
from ...simulator.state import Count
from ..arguments import at_least
from ..knowledge import SENSES
from .arms import ARMS
from .plan import DEMONSTRATIONS

SEED = 4002
"""Of the worlds that are looked through."""
MOVED, SEEN = 0.3, 2
"""Metres by which he has to be nearer to the shot's line than he is without intention, so many cycles after it, when a look can show it."""
SHOWN = (-3, -1, 0, 2, 4, 6)
"""Cycles that are drawn, counted from the kick: that of frame 0 is made from it."""
CYCLES = 45
"""Of a world that is looked through."""


class Played(NamedTuple):
    """T cycles of W worlds."""

    places: np.ndarray
    """(T, W, 4, 2) of ball, goalie and the two opponents, m."""
    known: np.ndarray
    """(T, W, 2) where he takes the ball to be."""
    told: np.ndarray
    """(T, W, 8) `Told`."""
    kicked: np.ndarray
    """(T, W) bool: an opponent kicks in the cycle that comes."""
    playing: np.ndarray
    """(T, W) bool."""
    saved: np.ndarray
    """(W,) bool."""


def played(arm: str, constants: GoalieConstants, senses: Senses, worlds: int, seed: int = SEED, play: str = "shooter") -> Played:
    """Worlds of shooters as an arm plays them."""
    task = make_task("Goalie", shots=0.0)
    core = SoccerCore(task, worlds, seed=seed, include=("memory",), senses=senses)
    core.reset(seed)
    goalie, sent = ARMS[arm].on(senses, constants, play)(task, core.agents[0]), None
    goalie.reset({key: value[:, 0] for key, value in core.observation.items()}, seed)
    saved, playing = np.zeros(worlds, bool), np.ones(worlds, bool)
    rows = []
    for _ in range(CYCLES):
        seen = {key: value[:, 0] for key, value in core.observation.items()}
        known = {**seen, **goalie.tier.know(seen, sent)}
        sent = {key: np.array(value) for key, value in goalie.controller.act(known).items()}
        kicks = core.sim.world["counts"][:, 11:13, Count.KICK].copy()
        places = core.sim.world["pos"][:, [0, 1, 12, 13]].copy()
        step = core.step({key: value[:, None] for key, value in sent.items()})
        kicked = (core.sim.world["counts"][:, 11:13, Count.KICK] > kicks).any(axis=1)
        rows.append(
            (places, known["memory"][:, 0, :2].copy(), known.get("intention", np.zeros((worlds, len(Told)))), kicked, playing.copy())
        )
        saved |= playing & step.success.any(axis=1)
        playing &= ~(step.terminated | step.truncated)
    places, beliefs, told, kicked, alive = (np.array(column) for column in zip(*rows))
    return Played(places, beliefs, told, kicked, alive, saved)


def found(model: Played, rival: Played) -> tuple[int, int]:
    """(world, cycle of the kick) of the first save of the model's that the rival concedes, and that began before the kick could be seen.

    Raises
    ------
    CprmError
        When there is none.
    """
    ball = model.places[:, :, 0]
    for world in np.flatnonzero(model.saved & ~rival.saved):
        alive = model.playing[:, world]
        kicks = np.flatnonzero(model.kicked[:, world] & alive)
        kicks = kicks[kicks + 6 < alive.sum()]
        if not len(kicks):
            continue
        kick = int(kicks[-1])
        way = ball[kick + 2, world] - ball[kick + 1, world]
        if kick < 4 or way[0] > -1.0 or model.told[kick, world, Told.CHANCE] < 0.6:
            continue
        line = ball[kick + 2, world, 1] + way[1] / way[0] * (GOAL_X - ball[kick + 2, world, 0])
        y, other = (side.places[kick + SEEN, world, 1, 1] for side in (model, rival))
        if abs(line - other) - abs(line - y) > MOVED:
            return int(world), kick
    raise CprmError("no such save in these worlds")


def drawn(model: Played, rival: Played, world: int, kick: int) -> str:
    """The frames as SVG: ball, goalie and holder, the expected line with its chance, and in outline the goalie without intention."""
    wide, high, scale = 30.0, 24.0, 9.0
    half = ServerParameters().goal_width / 2
    panels = []
    for k, shift in enumerate(SHOWN):
        t = kick + shift
        left, top = (k % 3) * (wide + 2) * scale, (k // 3) * (high + 4) * scale

        def at(place: np.ndarray, left: float = left, top: float = top) -> str:
            return f"{left + (place[0] - GOAL_X + 1.5) * scale:.1f} {top + (high / 2 - place[1]) * scale:.1f}"

        def dot(place: np.ndarray, radius: float, style: str, at=at) -> str:  # type: ignore[no-untyped-def]
            x, y = at(place).split()
            return f'<circle cx="{x}" cy="{y}" r="{radius}" {style}/>'

        def inside(place: np.ndarray) -> bool:
            return bool(place[0] < GOAL_X - 2.0 + wide and abs(place[1]) < high / 2)

        ball, goalie, *others = model.places[t, world]
        told, known = model.told[t, world], model.known[t, world]
        other = rival.places[t, world, 1]
        chance = float(told[Told.CHANCE])
        parts = [
            f'<rect x="{left:.1f}" y="{top:.1f}" width="{wide * scale:.1f}" height="{high * scale:.1f}" fill="#f3f7f0" stroke="#9ab"/>',
            f'<path d="M {at(np.array([GOAL_X, half]))} L {at(np.array([GOAL_X, -half]))}" stroke="#222" stroke-width="4"/>',
            f'<path d="M {at(known)} L {at(np.array([GOAL_X, told[Told.LINE]]))}" stroke="#c33" stroke-width="2" stroke-dasharray="5 4" '
            f'opacity="{chance:.2f}"/>',
            dot(other, 5, 'fill="none" stroke="#369" stroke-dasharray="2 2"'),
            dot(goalie, 6, 'fill="#369"'),
            *(dot(place, 6, 'fill="#c80"') for place in others if inside(place)),
            dot(known, 5, 'fill="none" stroke="#c33" stroke-width="1.5"'),
            dot(ball, 3.5, 'fill="#111"'),
            f'<text x="{left + 6:.1f}" y="{top + high * scale + 15:.1f}">{shift:+d}: chance {chance:.2f}, '
            f"line {told[Told.LINE]:+.1f} m</text>"
            if chance > 0.02
            else f'<text x="{left + 6:.1f}" y="{top + high * scale + 15:.1f}">{shift:+d}: no shot expected</text>',
        ]
        panels += [part for part in parts if chance > 0.02 or 'dasharray="5 4"' not in part]
    size = f'width="{3 * (wide + 2) * scale:.0f}" height="{2 * (high + 4) * scale:.0f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="13">\n' + "\n".join(panels) + "\n</svg>\n"


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description="Draw a save that began before the kick.")
    parser.add_argument("output", type=Path)
    parser.add_argument("--demonstration", default="E", choices=list(DEMONSTRATIONS))
    parser.add_argument("--worlds", type=at_least(1), default=1000)
    options = parser.parse_args()
    one = DEMONSTRATIONS[options.demonstration]
    senses = SENSES[one.senses]
    model, rival = (played(arm, one.numbers(arm), senses, options.worlds) for arm in ("model", "tracker"))
    world, kick = found(model, rival)
    write_atomically(options.output, drawn(model, rival, world, kick))
    print(f"world {world} of seed {SEED}, kick in cycle {kick}")
    for shift in range(-4, 7):
        told, places = model.told[kick + shift, world], model.places[kick + shift, world]
        y, other = places[1, 1], rival.places[kick + shift, world, 1, 1]
        believed = (
            f"chance {told[Told.CHANCE]:.2f}, within 5 {told[Told.WITHIN_5]:.2f}, side {told[Told.SIDE]:.2f}, line {told[Told.LINE]:+.1f} m"
        )
        print(f"{shift:+d}: {believed}; goalie at y {y:+.2f} m, without intention {other:+.2f} m")


if __name__ == "__main__":
    main()
