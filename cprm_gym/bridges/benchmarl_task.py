"""BenchMARL: every task here as a `TaskClass`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from benchmarl.environments import TaskClass
from torchrl.data import Composite
from torchrl.envs import EnvBase

from ..envs.options import EnvOptions
from .torchrl_env import SoccerTorchEnv


class SoccerTask(TaskClass):  # type: ignore[misc]
    """A task for BenchMARL's experiments: discrete actions are macros with their masks, continuous ones the view ``box``.

    Parameters
    ----------
    name : str
        Of the task: ``HFO2v2``.
    config : mapping, optional
        Options of `SoccerTorchEnv`, all but the worlds, the seed and the device; ``flatten`` is true if it is not said.

    Raises
    ------
    UnknownName, ParameterError
        As for `EnvOptions`, at once.
    """

    def __init__(self, name: str, config: Mapping[str, Any] | None = None) -> None:
        given = {"flatten": True, **(config or {})}
        EnvOptions.of({"task": name, **{key: value for key, value in given.items() if key not in ("threads", "state")}}).played()
        super().__init__(name, given)

    def get_env_fun(self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any) -> Callable[[], EnvBase]:
        """What makes the environment of `num_envs` worlds."""
        mode = {"action_mode": "box" if continuous_actions else "macro"}
        options = {**mode, **self.config}
        return lambda: SoccerTorchEnv(num_envs, self.name, seed=seed, device=device, **options)

    def supports_continuous_actions(self) -> bool:
        """Yes, unless the options say otherwise."""
        return self.config.get("action_mode", "box") == "box"

    def supports_discrete_actions(self) -> bool:
        """Yes, unless the options say otherwise."""
        return self.config.get("action_mode", "macro") == "macro"

    def max_steps(self, env: EnvBase) -> int:
        """Cycles of an episode."""
        return int(_of(env).worlds.core.max_cycles)

    def has_render(self, env: EnvBase) -> bool:
        """Pictures are drawn by the other faces."""
        return False

    def group_map(self, env: EnvBase) -> dict[str, list[str]]:
        """Agents of the sides."""
        return dict(_of(env).group_map)

    def observation_spec(self, env: EnvBase) -> Composite:
        """What the agents are told."""
        return self._only(env, "observation")

    def action_mask_spec(self, env: EnvBase) -> Composite | None:
        """What can be done; None without macros."""
        return None if _of(env).worlds.core.action_mask is None else self._only(env, "action_mask")

    def _only(self, env: EnvBase, part: str) -> Composite:
        spec = env.full_observation_spec_unbatched.clone()
        groups = self.group_map(env)
        for key in list(spec.keys()):
            if key not in groups:
                del spec[key]
                continue
            for name in list(spec[key].keys()):
                if name != part:
                    del spec[(key, name)]
        return spec

    def info_spec(self, env: EnvBase) -> Composite | None:
        """None."""
        return None

    def state_spec(self, env: EnvBase) -> Composite | None:
        """The true state."""
        spec = env.full_observation_spec_unbatched.clone()
        if "state" not in set(spec.keys()):
            return None
        for key in list(spec.keys()):
            if key != "state":
                del spec[key]
        return spec

    def action_spec(self, env: EnvBase) -> Composite:
        """What the agents do."""
        return env.full_action_spec_unbatched

    @staticmethod
    def env_name() -> str:
        """``cprm_gym``."""
        return "cprm_gym"


def _of(env: EnvBase) -> SoccerTorchEnv:
    """The environment within its transforms."""
    while not isinstance(env, SoccerTorchEnv):
        env = env.base_env
    return env
