"""Kernels compiled ahead, several at once: for images, clusters, and machines where nobody shall wait for the first step.

What is compiled lies in the folder of `kernel_cache` and is loaded from there by every later process of the same version, Python, Numba
and kind of processor. Jobs of one stage share few kernels, so that processes that run them side by side do little work twice; later stages
load what earlier ones have compiled.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .errors import CacheError, CprmError, unknown_name
from .kernel_cache import VARIABLE, cache_root, remove_stale


def _step() -> None:
    """A step without a referee, and the trainer's powers that set up drills."""
    from .simulator.parameters import Rules
    from .simulator.simulator import Simulator

    simulator = Simulator(1, rules=Rules.NONE)
    simulator.trainer.place_ball(0.0, 0.0)
    simulator.trainer.place_player(1, 1.0, 0.0, 0.0)
    simulator.uniforms(None, 1)
    simulator.step()


def _senses() -> None:
    """What players see and feel."""
    from .simulator.simulator import Simulator

    simulator = Simulator(1)
    simulator.see()
    simulator.sense_body()


def _drills() -> None:
    """Environments of drills, with every kind of action but macros."""
    import gymnasium

    import cprm_gym  # noqa: F401

    for mode in ("discrete", "box", "hybrid"):
        env = gymnasium.make("cprm/GoToBall-v2", action_mode=mode)
        env.reset(seed=0)
        env.step(env.action_space.sample())
        env.close()


def _matches() -> None:
    """Matches under the rules."""
    from .simulator.simulator import Simulator

    simulator = Simulator(1)
    simulator.trainer.change_mode("play_on")
    simulator.step()


def _pitch() -> None:
    """Landmarks, lines and what is heard."""
    from .simulator.simulator import Simulator

    simulator = Simulator(1)
    simulator.landmarks()
    simulator.hear()


def _server() -> None:
    """What a server runs for players, officials and monitors, with a referee and without."""
    from .server.warming import load_kernels

    for refereed in (True, False):
        load_kernels(refereed)


def _players() -> None:
    """Scripted players, memories and macros, in drills without rules."""
    from .envs.core import SoccerCore
    from .envs.tasks import make_task

    for task, options in (("Keepaway3v2", {}), ("HFO2v2", {"others": ("medium", "strong")}), ("Goalie2v1", {})):
        core = SoccerCore(make_task(task), 1, action_mode="macro", include=("memory", "landmarks", "hear"), **options)  # type: ignore[arg-type]
        core.reset(0)
        core.step(core.action_mask.argmax(axis=-1))  # type: ignore[union-attr]


def _views() -> None:
    """The feature vectors."""
    from .envs.core import SoccerCore
    from .envs.tasks import make_task

    for view in ("normalised", "hfo_low", "hfo_high", "keepaway", "full"):
        SoccerCore(make_task("Keepaway3v2"), 1, observation=view).reset(0)


def _agents() -> None:
    """Nets and models of an agent that plays."""
    from .benchmark.plan import Plan
    from .benchmark.runner import run

    list(run(Plan(tasks=("GoToBall",), controllers=("cprm",), episodes=1)))


JOBS: dict[str, Callable[[], None]] = {
    "step": _step, "senses": _senses, "drills": _drills, "matches": _matches, "pitch": _pitch, "server": _server, "players": _players,
    "views": _views, "agents": _agents,
}  # fmt: skip
STAGES = (("step", "senses"), ("drills", "matches", "pitch"), ("server", "players", "views"), ("agents",))
PARTS = {
    "drills": ("step", "senses", "drills"),
    "matches": ("step", "senses", "drills", "matches", "pitch"),
    "server": ("step", "senses", "matches", "server"),
    "views": ("step", "senses", "drills", "pitch", "players", "views"),
    "all": tuple(JOBS),
}
"""What may be asked for, and the jobs that it takes."""


def compile_ahead(parts: Sequence[str], jobs: int, say: Callable[[str], None]) -> Path:
    """Fill the cache.

    Parameters
    ----------
    parts : sequence of str
        Of `PARTS`.
    jobs : int
        Processes at a time.
    say : callable
        Is given a line for every job that is done.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    CacheError
        When there is no folder that can be written.
    CprmError
        When a job fails, or `jobs` is below 1.
    UnknownName
        For another part.
    """
    wanted: set[str] = set()
    for part in parts:
        if part not in PARTS:
            raise unknown_name("part", part, PARTS)
        wanted.update(PARTS[part])
    if jobs < 1:
        raise CprmError(f"--jobs {jobs}: a whole number of at least 1 is needed")
    root = cache_root()
    if root is None or not os.access(root / "kernels", os.W_OK):
        raise CacheError(f"there is no folder of kernels that can be written; name one with {VARIABLE}")
    remove_stale(root)
    with ThreadPoolExecutor(jobs) as pool:
        for stage in STAGES:
            for name, seconds in pool.map(_in_a_process, [job for job in stage if job in wanted]):
                say(f"{name}: {JOBS[name].__doc__} {seconds:.0f} s".replace("\n", " "))
    return root


def _in_a_process(name: str) -> tuple[str, float]:
    """Run a job in a process of its own; its name and seconds."""
    begin = time.monotonic()
    done = subprocess.run([sys.executable, "-m", __name__, name], capture_output=True, text=True, env={**os.environ, "CPRM_GYM_QUIET": "1"})
    if done.returncode:
        raise CprmError(f"compiling {name} failed: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else done.returncode}")
    return name, time.monotonic() - begin


if __name__ == "__main__":
    JOBS[sys.argv[1]]()
