"""Films of one episode behind the claims of ``docs/results.md``: ``python docs/chapter5_films.py [NAME ...]`` makes all of them, or those.

A film is of a pair: who the claim speaks for, and his rival, in the same world: the first of the suite's seed in which the one succeeds and
the other does not, or, where both are to act alike, in which both do.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

from cprm_gym.benchmark.chapter5.conditions import condition
from cprm_gym.benchmark.chapter5.films import FILMS, Pair
from cprm_gym.benchmark.chapter5.players import make_player
from cprm_gym.benchmark.chapter5.playing import play_cell
from cprm_gym.benchmark.chapter5.watching import Disturbing
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.plan import Block
from cprm_gym.envs.core import SoccerCore, Step
from cprm_gym.envs.play import Film

IMAGES = Path(__file__).parent / "images"
SEED, LOOKED_AT = 0, 60
"""Of the suite; worlds in which a pair is looked for."""
LONGEST, ENOUGH = 200, 150
"""Cycles of a film of who succeeds and of who does not, at most."""


class Camera:
    """Films the first episode, and lets happen to it what the condition says."""

    def __init__(self, path: Path, disturbing: Disturbing | None) -> None:
        self.path, self.disturbing = path, disturbing
        self.film: Film | None = None

    def begin(self, core: SoccerCore, slots: np.ndarray, episodes: np.ndarray) -> None:
        """The first picture."""
        if self.disturbing is not None:
            self.disturbing.begin(core, slots, episodes)
        self.film = Film(self.path, core)
        self.film.__enter__()
        self.film.add()

    def before(self, core: SoccerCore) -> None:
        """What goes wrong goes wrong."""
        if self.disturbing is not None:
            self.disturbing.before(core)

    def after(self, core: SoccerCore, step: Step, playing: np.ndarray) -> None:
        """A picture of every cycle."""
        assert self.film is not None
        if self.disturbing is not None:
            self.disturbing.after(core, step, playing)
        self.film.add()


def world_of(pair: Pair) -> int:
    """The first world in which the one succeeds and the other does not, or both do.

    Raises
    ------
    SystemExit
        When there is none among those that are looked at.
    """
    looked_at = [play_cell(Block(pair.task, f"{pair.condition}/{who[1]}", 0, LOOKED_AT, SEED)) for who in (pair.one, pair.other)]
    one, other = (np.array(played.success, dtype=bool) for played in looked_at)
    fitting = np.flatnonzero(one & (other == pair.alike))
    if not len(fitting):
        how = "does, too" if pair.alike else "does not"
        sys.exit(f"{pair.task}, {pair.condition}: in none of {LOOKED_AT} worlds {pair.one[1]} succeeds and {pair.other[1]} {how}")
    return int(fitting[0])


def film(path: Path, task: str, where: str, player: str, world: int, most: int = LONGEST) -> bool:
    """One film; whether it ends in success."""
    how = condition(where)
    happening = how.happening()
    camera = Camera(path, None if happening is None else Disturbing(happening, 1, SEED))
    error: tuple[Any, Any, Any] = (None, None, None)
    try:
        played = play_episodes(how.task(task), make_player(player, how), 1, SEED, world, how.senses, observer=camera, most=most)
        return bool(played.success[0])
    except BaseException:
        error = sys.exc_info()
        raise
    finally:
        if camera.film is not None:
            camera.film.__exit__(*error)


def main(names: list[str], folder: Path = IMAGES) -> None:
    """Make the films of these names, or all."""
    unknown = [name for name in names if name not in FILMS]
    if unknown:
        sys.exit(f"unknown film {unknown[0]!r}; there are {', '.join(FILMS)}")
    for name in names or FILMS:
        pair = FILMS[name]
        world = world_of(pair)
        first: dict[Path, bytes] = {}
        for (_, player, how), file, wins in zip((pair.one, pair.other), pair.files(name), (True, pair.alike)):
            path = folder / file
            won = film(path, pair.task, pair.condition, player, world, LONGEST if wins else ENOUGH)
            if won != wins:
                sys.exit(f"{path.name}: {player} alone in world {world} does not end as among {LOOKED_AT} worlds")
            if first.setdefault(path, path.read_bytes()) != path.read_bytes():
                sys.exit(f"{path.name}: the films of {pair.one[1]} and {pair.other[1]} are not the same")
            print(f"{path.name}: {player} on {pair.task}, {pair.condition}, world {world}: {how}")


if __name__ == "__main__":
    main(sys.argv[1:])
