"""The state of a learner as arrays, so that a training goes on where it was, without pickled objects."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FormatError
from ..files import write_atomically

_REPLAYED = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")


def save_checkpoint(model: Any, folder: Path, told: dict[str, Any]) -> None:
    """Write ``learner.safetensors``, ``learner.json`` and, of a learner with a memory of transitions, ``replay.npz``.

    Parameters
    ----------
    model : BaseAlgorithm
    folder : Path
    told : dict
        Further things to know when it goes on, for JSON.
    """
    import safetensors.torch

    tensors: dict[str, Any] = {}
    for name, value in _parameters(model).items():
        for key, tensor in _tensors(name, value):
            tensors[key] = tensor.detach().contiguous().clone()
    buffer = getattr(model, "replay_buffer", None)
    if buffer is not None:
        filled = buffer.buffer_size if buffer.full else buffer.pos
        arrays = {name: getattr(buffer, name)[:filled] for name in _REPLAYED if getattr(buffer, name, None) is not None}
        hidden = folder / ".replay.incomplete.npz"
        np.savez(hidden, pos=np.array([buffer.pos, buffer.full]), **arrays)
        hidden.replace(folder / "replay.npz")
    write_atomically(folder / "learner.safetensors", safetensors.torch.save(tensors))
    state = {"steps": int(model.num_timesteps), "updates": int(model._n_updates), **told}
    write_atomically(folder / "learner.json", json.dumps(state, indent=1) + "\n")


def load_checkpoint(model: Any, folder: Path) -> dict[str, Any]:
    """Put a new learner, made in the same way, into the state of a checkpoint; what was noted with it.

    Raises
    ------
    FormatError
        When the files are no checkpoint of such a learner.
    """
    import safetensors.torch
    import torch

    try:
        told: dict[str, Any] = json.loads((folder / "learner.json").read_text("utf-8"))
        tensors = safetensors.torch.load((folder / "learner.safetensors").read_bytes())
        with torch.no_grad():
            for name, value in _parameters(model).items():
                if "optimizer" in name:
                    _restore_optimizer(_attribute(model, name), name, tensors)
                elif isinstance(value, dict):
                    _attribute(model, name).load_state_dict({key: tensors[f"{name}/{key}"] for key in value})
                else:
                    value.copy_(tensors[name])
        model.num_timesteps, model._n_updates = int(told["steps"]), int(told["updates"])
        if getattr(model, "replay_buffer", None) is not None:
            _restore_replay(model.replay_buffer, folder / "replay.npz")
    except (KeyError, ValueError, RuntimeError, OSError, TypeError) as error:
        raise FormatError(f"{folder}: no checkpoint of this training: {error}") from None
    return told


def _parameters(model: Any) -> dict[str, Any]:
    """State dicts of networks and optimisers, and single tensors such as the logarithm of SAC's entropy coefficient."""
    _, single = model._get_torch_save_params()
    return {**model.get_parameters(), **{name: getattr(model, name) for name in single if getattr(model, name, None) is not None}}


def _tensors(name: str, value: Any) -> list[tuple[str, Any]]:
    """Key and tensor of everything that learning changes: weights, and the moments that an optimiser keeps."""
    if not isinstance(value, dict):
        return [(name, value)]
    if "state" in value and "param_groups" in value:
        return [(f"{name}/{k}/{key}", tensor) for k, moments in value["state"].items() for key, tensor in moments.items()]
    return [(f"{name}/{key}", tensor) for key, tensor in value.items()]


def _restore_optimizer(optimizer: Any, name: str, tensors: dict[str, Any]) -> None:
    state = optimizer.state_dict()
    state["state"] = {}
    for key, tensor in tensors.items():
        if key.startswith(f"{name}/"):
            k, moment = key[len(name) + 1 :].split("/")
            state["state"].setdefault(int(k), {})[moment] = tensor
    optimizer.load_state_dict(state)


def _restore_replay(buffer: Any, path: Path) -> None:
    with np.load(path, allow_pickle=False) as kept:
        buffer.pos, buffer.full = int(kept["pos"][0]), bool(kept["pos"][1])
        for name in _REPLAYED:
            if name in kept.files:
                getattr(buffer, name)[: len(kept[name])] = kept[name]


def _attribute(model: Any, name: str) -> Any:
    for part in name.split("."):
        model = getattr(model, part)
    return model
