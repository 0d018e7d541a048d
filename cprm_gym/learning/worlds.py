"""Worlds to learn in, as stable-baselines3 takes them: with beliefs, with skills as options, or plain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces as gym_spaces
from stable_baselines3.common.vec_env import VecEnv

from ..envs.options import EnvOptions
from ..envs.registration import NAMESPACE, VERSION
from ..envs.single import ego_options
from ..envs.vectors.normalised import Normalised
from ..wrappers.sb3 import SoccerVecEnv
from .beliefs import COLUMNS, NEEDS, BallBelief
from .configuration import Configuration
from .options import OptionPlayer

UNSEEN = 2_000_000_000
"""Seed of the worlds in which the end of a training is measured; those along the way have the next one. Seeds of a training are smaller."""
LARGEST_SEED = 1_000_000_000


def make_worlds(configuration: Configuration, worlds: int, seed: int, easier: Mapping[str, Any] | None = None) -> VecEnv:
    """The worlds of a training.

    Parameters
    ----------
    configuration : Configuration
    worlds, seed : int
    easier : mapping, optional
        Options of a stage of the curriculum.
    """
    options = {**configuration.environment, **(easier or {})}
    if configuration.face == "gymnasium":
        from stable_baselines3.common.env_util import make_vec_env

        return make_vec_env(f"{NAMESPACE}/{configuration.task}-v{VERSION}", n_envs=worlds, seed=seed, env_kwargs=options)
    return measured_worlds(configuration, worlds, seed, options)


def measured_worlds(configuration: Configuration, worlds: int, seed: int, options: Mapping[str, Any] | None = None) -> SoccerVecEnv:
    """Worlds as vectors in one engine, for learning and for measuring."""
    kind = configuration.kind
    given = dict(configuration.environment if options is None else options)
    if not kind.shared:
        given["controlled"] = ego_options({"task": configuration.task, **given}).controlled
    if kind.mode == "option":
        return OptionVecEnv(configuration.task, worlds, seed, configuration.longest, **given)
    if configuration.algorithm == "belief_ppo":
        return BeliefVecEnv(configuration.task, worlds, seed, **given)
    return SoccerVecEnv(configuration.task, worlds, kind.mode, seed, flatten=True, **given)


def columns_of(env: VecEnv) -> tuple[str, ...]:
    """Names of the network's inputs, in their order."""
    if isinstance(env, (BeliefVecEnv, OptionVecEnv)):
        return env.columns
    if isinstance(env, SoccerVecEnv):
        return env.core.preset.names
    # a Dict of Gymnasium's, whose parts go into the network in the order of their names
    core = env.get_attr("core", 0)[0]
    names = np.array(core.preset.names)
    assert isinstance(env.observation_space, gym_spaces.Dict)
    columns = Normalised(core, core.task.task_features).columns
    where = columns.views(np.arange(len(names))[None])
    return tuple(str(name) for part in env.observation_space.spaces for name in names[where[part].ravel()])


class BeliefVecEnv(SoccerVecEnv):
    """Worlds whose observations are the vector ``normalised`` and the posterior of the model of the ball."""

    def __init__(self, task: str, worlds: int, seed: int, **options: Any) -> None:
        super().__init__(task, worlds, "discrete", seed, observation="raw", include=NEEDS, **options)
        self.belief = BallBelief(self.core.task, self.num_envs)
        assert isinstance(self.core.preset.space, gym_spaces.Dict)
        vector = self.core.preset.space["normalised"]
        assert isinstance(vector, gym_spaces.Box)
        self.columns = (*Normalised(self.core, self.core.task.task_features).columns.names, *COLUMNS)
        low, high = (np.append(bound, np.full(len(COLUMNS), value)) for bound, value in ((vector.low, 0.0), (vector.high, 1.0)))
        self.observation_space = gym_spaces.Box(low.astype(np.float32), high.astype(np.float32), dtype=np.float32)

    def reset(self) -> Any:
        """Start episodes in all worlds, which nothing is known of."""
        super().reset()
        self.belief.reset()
        self._take_in()
        return self._observation()

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Play one cycle; the last observation of an episode has the posterior of the cycle before."""
        _, rewards, dones, infos = super().step_wait()
        self.belief.reset(dones)
        self._take_in()
        return self._observation(), rewards, dones, infos

    def _take_in(self) -> None:
        self.belief.update({name: values.reshape(self.num_envs, *values.shape[2:]) for name, values in self.core.observation.items()})

    def _observation(self) -> Any:
        vector = self.core.observation["normalised"].reshape(self.num_envs, -1)
        return np.concatenate([vector, self.belief.posterior], axis=1)


class OptionVecEnv(SoccerVecEnv):
    """Worlds in which an action is an option, a skill of the architecture that goes on for some cycles (`OptionPlayer`)."""

    def __init__(self, task: str, worlds: int, seed: int, longest: int, **options: Any) -> None:
        super().__init__(task, worlds, "discrete", seed, observation="raw", include=NEEDS, **options)
        self._make_hybrid(options)
        self.longest = longest
        self.player = OptionPlayer(self.core.task, self.core.agents[0], worlds)
        self.columns = Normalised(self.core, self.core.task.task_features).columns.names
        assert isinstance(self.core.preset.space, gym_spaces.Dict)
        self.observation_space = self.core.preset.space["normalised"]
        self.action_space = gym_spaces.Discrete(len(self.player.names))
        self._started = np.ones(worlds, bool)

    def _make_hybrid(self, options: Mapping[str, Any]) -> None:
        """The engine takes the commands of the skills themselves."""
        from ..envs.core import SoccerCore

        given = {"task": self.core.task, "action_mode": "hybrid", "observation": "raw", "include": NEEDS}
        self.core = SoccerCore(EnvOptions.of({**options, **given}), self.worlds)

    def reset(self) -> Any:
        """Start episodes in all worlds."""
        super().reset()
        self.player.begin(self._seen(), 0)
        self._started[:] = True
        return self._observation()

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Play the cycles of one choice; a world that ends within them stands still until the others have played theirs."""
        chosen = np.asarray(self._actions).reshape(self.worlds)
        rewards, over = np.zeros(self.worlds), np.zeros(self.worlds, bool)
        infos: list[dict[str, Any]] = [{} for _ in range(self.worlds)]
        for _ in range(self.longest):
            action = self.player.act(self._seen(), chosen)
            step = self.core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
            running = ~over
            rewards += np.where(running, step.reward[:, 0], 0.0)
            self._lengths += running
            ended = running & (step.terminated | step.truncated)
            last = self._observation()
            for w in np.flatnonzero(ended):
                infos[w] = {
                    "terminal_observation": last[w],
                    "TimeLimit.truncated": bool(step.truncated[w]),
                    "is_success": bool(step.success[w, 0]),
                    "status": int(step.status[w]),
                }
            over |= ended
            if over.all():
                break
        self._returns += rewards
        for w in np.flatnonzero(over):
            infos[w]["episode"] = {"r": float(self._returns[w]), "l": int(self._lengths[w]), "t": 0.0}
        if over.any():
            self._returns[over], self._lengths[over] = 0.0, 0
            self.core.reset(None, over)
            self.player.begin(self._seen(), 0, over)
        return self._observation(), rewards.astype(np.float32), over, infos

    def action_masks(self) -> np.ndarray:
        """(worlds, options) bool: every option can be chosen at any time."""
        return np.ones((self.worlds, len(self.player.names)), bool)

    def has_attr(self, attr_name: str) -> bool:
        """Whether the environment has an attribute; the masks are always there."""
        return attr_name == "action_masks" or super().has_attr(attr_name)

    def _seen(self) -> dict[str, np.ndarray]:
        return {name: values[:, 0] for name, values in self.core.observation.items()}

    def _observation(self) -> Any:
        return self.core.observation["normalised"][:, 0].copy()


def names_of(env: VecEnv) -> Sequence[str]:
    """What each choice is, of macros and options; otherwise nothing."""
    if isinstance(env, OptionVecEnv):
        return env.player.names
    if isinstance(env, SoccerVecEnv) and env.core.macros is not None:
        return env.core.macros.names
    return ()
