"""TorchRL: worlds as the batch of one `EnvBase`, agents in the groups ``left`` and ``right``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from tensordict import TensorDict, TensorDictBase
from torchrl.data import Binary, Bounded, Categorical, Composite, MultiCategorical, Unbounded
from torchrl.envs import EnvBase

from ..envs.tasks import Task
from ..errors import UnknownName
from .worlds import AgentWorlds


class SoccerTorchEnv(EnvBase):  # type: ignore[misc]
    """A task for one or two groups of agents in many worlds.

    For each group, with the shape (worlds, agents): ``(group, "observation")`` (a vector, or a nested dict of parts),
    ``(group, "action")``, ``(group, "reward")``, ``(group, "action_mask")`` in the macro view, ``(group, "is_success")``; for each world
    ``state`` (for centralised critics), ``status``, ``done``, ``terminated`` and ``truncated``.

    Parameters
    ----------
    worlds : int
        Batch size.
    task : str or Task
    seed : int, optional
    device : torch.device or str, optional
    threads : int
        Threads that share the worlds.
    state : bool
        Whether ``state`` is told.
    **options
        As for `EnvOptions`, and fields of the task; the actions are ``discrete``, ``box`` or ``macro``.

    Raises
    ------
    UnknownName
        For the views ``hybrid`` and ``full``, and as `AgentWorlds`.
    """

    def __init__(
        self, worlds: int = 1, task: str | Task = "Soccer", *, seed: int | None = None, device: Any = "cpu", threads: int = 1,
        state: bool = True, **options: Any,
    ) -> None:  # fmt: skip
        if options.get("action_mode") in ("hybrid", "full"):
            raise UnknownName(f"action_mode {options['action_mode']!r}: allowed here are discrete, box and macro")
        self.worlds = AgentWorlds(worlds, task, threads=threads, **options)
        self.group_map = {group: list(agents) for group, agents in self.worlds.groups.items()}
        self._tells_state = state
        super().__init__(device=device, batch_size=[worlds])
        self._make_specs()
        self._seed = seed

    # ------------------------------------------------------------------ specs

    def _make_specs(self) -> None:
        count = self.worlds.worlds
        observed, acting, rewarded = {}, {}, {}
        for group, agents in self.group_map.items():
            shape = (count, len(agents))
            parts = {"observation": self._observation_spec(self.worlds.observation_space, shape)}
            if self.worlds.core.action_mask is not None:
                macros = self.worlds.core.action_mask.shape[2]
                parts["action_mask"] = Binary(macros, shape=(*shape, macros), dtype=torch.bool, device=self.device)
            parts["is_success"] = Binary(1, shape=(*shape, 1), dtype=torch.bool, device=self.device)
            observed[group] = Composite(parts, shape=shape, device=self.device)
            acting[group] = Composite({"action": self._action_spec(shape)}, shape=shape, device=self.device)
            reward = Unbounded(shape=(*shape, 1), dtype=torch.float32, device=self.device)
            rewarded[group] = Composite({"reward": reward}, shape=shape, device=self.device)
        extra: dict[str, Any] = {"status": Unbounded(shape=(count, 1), dtype=torch.int64, device=self.device)}
        if self._tells_state:
            size = self.worlds.state_space.shape[0]
            extra["state"] = Unbounded(shape=(count, size), dtype=torch.float32, device=self.device)
        self.observation_spec = Composite({**observed, **extra}, shape=(count,), device=self.device)
        self.action_spec = Composite(acting, shape=(count,), device=self.device)
        self.reward_spec = Composite(rewarded, shape=(count,), device=self.device)
        done = {key: Categorical(2, shape=(count, 1), dtype=torch.bool, device=self.device) for key in ("done", "terminated", "truncated")}
        self.done_spec = Composite(done, shape=(count,), device=self.device)

    def _observation_spec(self, space: spaces.Space[Any], shape: tuple[int, ...]) -> Any:
        if isinstance(space, spaces.Dict):
            parts = {name: self._observation_spec(part, shape) for name, part in space.spaces.items() if name != "action_mask"}
            if list(parts) == ["observations"]:  # a vector with its mask, which is told beside it
                return parts["observations"]
            return Composite(parts, shape=shape, device=self.device)
        assert space.shape is not None
        return Unbounded(shape=(*shape, *space.shape), dtype=torch.float32, device=self.device)

    def _action_spec(self, shape: tuple[int, ...]) -> Any:
        space = self.worlds.action_space
        if isinstance(space, spaces.Discrete):
            return Categorical(int(space.n), shape=shape, dtype=torch.int64, device=self.device)
        if isinstance(space, spaces.MultiDiscrete):
            return MultiCategorical(space.nvec.tolist(), shape=(*shape, len(space.nvec)), dtype=torch.int64, device=self.device)
        assert space.shape is not None
        return Bounded(-1.0, 1.0, shape=(*shape, *space.shape), dtype=torch.float32, device=self.device)

    # ------------------------------------------------------------------ the cycle

    def _reset(self, tensordict: TensorDictBase | None = None, **kwargs: Any) -> TensorDict:
        chosen = None if tensordict is None else tensordict.get("_reset", None)
        mask = None if chosen is None or chosen.all() else chosen.reshape(self.worlds.worlds).cpu().numpy()
        seed, self._seed = self._seed, None
        if mask is None or mask.any() or seed is not None:
            self.worlds.reset(seed, mask if seed is None else None)
        nothing = np.zeros((self.worlds.worlds, len(self.worlds.core.agents)), bool)
        told = self._told(nothing, np.zeros(self.worlds.worlds, np.int64))
        flags = {key: torch.zeros(self.worlds.worlds, 1, dtype=torch.bool) for key in ("done", "terminated", "truncated")}
        return self._tensordict({**told, **flags})

    def _step(self, tensordict: TensorDictBase) -> TensorDict:
        step = self.worlds.step({group: tensordict.get((group, "action")).cpu().numpy() for group in self.group_map})
        told = self._told(step.success, step.status)
        reward = step.reward.astype(np.float32)
        for group in self.group_map:
            told[group]["reward"] = torch.from_numpy(self.worlds.of(group, reward)[..., None])
        over = step.terminated | step.truncated
        flags = {"done": over, "terminated": step.terminated, "truncated": step.truncated}
        return self._tensordict({**told, **{key: torch.from_numpy(value.copy()[:, None]) for key, value in flags.items()}})

    def _set_seed(self, seed: int | None) -> None:
        self._seed = seed

    def _told(self, success: np.ndarray, status: np.ndarray) -> dict[str, Any]:
        """What the agents are told now, in tensors of their own."""
        told: dict[str, Any] = {"status": torch.from_numpy(status.astype(np.int64)[:, None])}
        if self._tells_state:
            told["state"] = torch.from_numpy(self.worlds.state())
        for group in self.group_map:
            seen = self.worlds.observation(group)
            if isinstance(seen, Mapping):
                parts = {name: _own(values) for name, values in seen.items() if name != "action_mask"}
                mine: dict[str, Any] = {"observation": parts.get("observations", parts)}
            else:
                mine = {"observation": _own(seen)}
            mask = self.worlds.mask(group)
            if mask is not None:
                mine["action_mask"] = _own(mask)
            mine["is_success"] = _own(self.worlds.of(group, success)[..., None])
            told[group] = mine
        return told

    def _tensordict(self, told: dict[str, Any]) -> TensorDict:
        count = self.worlds.worlds
        values = {}
        for key, value in told.items():
            if key in self.group_map:
                shape = [count, len(self.group_map[key])]
                parts = {k: TensorDict(v, shape) if isinstance(v, dict) else v for k, v in value.items()}
                value = TensorDict(parts, shape)
            values[key] = value
        made = TensorDict(values, [count])
        return made if self.device is None or self.device.type == "cpu" else made.to(self.device)

    def close(self, *arguments: Any, **kwargs: Any) -> None:
        """Leave the server, if it is played on one."""
        self.worlds.core.close()
        super().close(*arguments, **kwargs)


def _own(values: np.ndarray) -> torch.Tensor:
    """A tensor of its own."""
    return torch.from_numpy(np.array(values))
