"""Episodes as game logs that rcssmonitor and other viewers play."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
from pettingzoo.utils import BaseParallelWrapper

from ..errors import ParameterError
from ..simulator.gamelog.writer import GameLogWriter


class _Writer:
    """One file per episode: ``<folder>/<name>-<number>.rcg``; it appears when the episode is over."""

    def __init__(self, env: Any, folder: str | Path, name: str, every: int, packed: bool) -> None:
        core = getattr(env.unwrapped, "core", None)
        if core is None:
            raise ParameterError(f"GameLog: needs an environment of cprm_gym; got {env}")
        if every < 1:
            raise ParameterError(f"GameLog: every is {every!r}; allowed is 1 and more")
        self.core, self.every, self.name = core, every, name
        self.folder, self.suffix = Path(folder), ".rcg.gz" if packed else ".rcg"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ParameterError(f"GameLog: folder {str(folder)!r} cannot be made: {error.strerror or error}") from None
        self.paths: list[Path] = []
        self.episode = -1
        self.writer: GameLogWriter | None = None

    def begin(self) -> None:
        self.end()
        self.episode += 1
        if self.episode % self.every == 0:
            path = self.folder / f"{self.name}-{self.episode:04d}{self.suffix}"
            self.writer = GameLogWriter.for_simulator(path, self.core.sim, teams=self.core.sim.team_names)
            self.writer.record(self.core.sim)

    def cycle(self) -> None:
        if self.writer is not None:
            self.writer.record(self.core.sim)

    def end(self) -> None:
        if self.writer is not None:
            self.writer.close()
            self.paths.append(self.writer._file.path)
            self.writer = None


class GameLog(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Writes the episodes of a Gymnasium environment of ours as game logs, version 6.

    Parameters
    ----------
    env : gymnasium.Env
        `cprm_gym.envs.single.SoccerEnv`, wrapped or not. Under `MacroSteps`, so that every cycle is written.
    folder : path
        Made if it is not there.
    name : str
        Beginning of the files' names.
    every : int
        Write every so manieth episode.
    packed : bool
        Compress (``.rcg.gz``).

    Attributes
    ----------
    paths : list of Path
        The files that are complete.

    Raises
    ------
    ParameterError
        For another environment.
    """

    def __init__(
        self, env: gymnasium.Env[Any, Any], folder: str | Path, name: str = "episode", every: int = 1, packed: bool = False
    ) -> None:
        super().__init__(env)
        self._log = _Writer(env, folder, name, every, packed)

    @property
    def paths(self) -> list[Path]:
        """The files that are complete."""
        return self._log.paths

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """Finish the log of the episode before, start an episode and its log."""
        result = self.env.reset(**kwargs)
        self._log.begin()
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play one cycle and write it."""
        result = self.env.step(action)
        self._log.cycle()
        if result[2] or result[3]:
            self._log.end()
        return result

    def close(self) -> None:
        """Finish the log and close the environment."""
        self._log.end()
        super().close()


class ParallelGameLog(BaseParallelWrapper):  # type: ignore[misc]
    """`GameLog` for the parallel environment; the same parameters."""

    def __init__(self, env: Any, folder: str | Path, name: str = "episode", every: int = 1, packed: bool = False) -> None:
        super().__init__(env)
        self.log = _Writer(env, folder, name, every, packed)

    @property
    def paths(self) -> list[Path]:
        """The files that are complete."""
        return self.log.paths

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Finish the log of the episode before, start an episode and its log."""
        result = self.env.reset(seed=seed, options=options)
        self.log.begin()
        return result

    def step(self, actions: dict[str, Any]) -> Any:
        """Play one cycle and write it."""
        result = self.env.step(actions)
        self.log.cycle()
        if not self.env.agents:
            self.log.end()
        return result

    def close(self) -> None:
        """Finish the log and close the environment."""
        self.log.end()
        self.env.close()
