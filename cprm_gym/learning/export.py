"""Policies from the learners of stable-baselines3: the arrays of the acting network, by name, and nothing else.

A model that stable-baselines3 saved (``.zip``) holds pickled objects, and loading one executes what is in them. `convert` reads only its
weights, as PyTorch reads weights alone, and does so in a process of its own.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import CprmError, FormatError
from .policy import Policy, load_policy, save_policy

_LARGEST = 256_000_000


def arrays_of(weights: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The acting network in the weights of a policy of PPO, RecurrentPPO, MaskablePPO or SAC, named as `networks` names them.

    Parameters
    ----------
    weights : mapping of str to tensor or array
        ``policy.state_dict()``.

    Raises
    ------
    FormatError
        For weights of another policy.
    """
    given = {
        name: np.array(value.detach().cpu().numpy() if hasattr(value, "detach") else value, np.float32) for name, value in weights.items()
    }
    body, head = ("actor.latent_pi", "actor.mu") if "actor.mu.weight" in given else ("mlp_extractor.policy_net", "action_net")
    if f"{head}.weight" not in given:
        raise FormatError("model: no policy of PPO, RecurrentPPO, MaskablePPO or SAC with layers and a head (an MlpPolicy)")
    arrays: dict[str, np.ndarray] = {}
    for name in given:
        if name.startswith(("features_extractor.", "pi_features_extractor.", "actor.features_extractor.")):
            raise FormatError(f"model: {name}: layers that take in pictures are not carried over")
    layers = sorted({int(name.split(".")[-2]) for name in given if name.startswith(body + ".")})
    for k, number in enumerate(layers):
        for part in ("weight", "bias"):
            arrays[f"layer_{k}.{part}"] = given[f"{body}.{number}.{part}"]
    for part in ("weight", "bias"):
        arrays[f"head.{part}"] = given[f"{head}.{part}"]
        if head == "actor.mu":
            arrays[f"deviation.{part}"] = given[f"actor.log_std.{part}"]
    if "lstm_actor.weight_ih_l0" in given:
        if "lstm_actor.weight_ih_l1" in given:
            raise FormatError("model: an LSTM of several layers; one is carried over")
        arrays["lstm.input"], arrays["lstm.hidden"] = given["lstm_actor.weight_ih_l0"], given["lstm_actor.weight_hh_l0"]
        arrays["lstm.bias"] = given["lstm_actor.bias_ih_l0"] + given["lstm_actor.bias_hh_l0"]
    return arrays


def convert(model: Path, like: Path, output: Path) -> tuple[Path, Path]:
    """A policy from a model saved by stable-baselines3.

    Parameters
    ----------
    model : Path
        The ``.zip``.
    like : Path
        A policy with the same inputs and actions, whose description it takes over.
    output : Path

    Returns
    -------
    (Path, Path)
        The files written.

    Raises
    ------
    CprmError
        When it cannot be converted; the message says why.
    """
    with tempfile.TemporaryDirectory() as folder:
        arrays = Path(folder) / "arrays.npz"
        done = subprocess.run([sys.executable, "-m", __name__, str(model), str(arrays)], capture_output=True, text=True)
        if done.returncode:
            lines = done.stderr.strip().splitlines()
            raise CprmError(f"{model}: cannot be converted: {lines[-1] if lines else f'the process ended with {done.returncode}'}")
        with np.load(arrays, allow_pickle=False) as kept:
            given = {name: kept[name] for name in kept.files}
    described = replace(
        load_policy(like).description, command=f"cprm-gym train --convert {model.name}", curve=(), success={}, seed=0, steps=0
    )
    return save_policy(Policy(described, given), output)


def _extract(model: Path, arrays: Path) -> None:
    """The weights alone, in this process, which does nothing else."""
    import torch

    with zipfile.ZipFile(model) as archive:
        if archive.getinfo("policy.pth").file_size > _LARGEST:
            raise FormatError(f"policy.pth: larger than the {_LARGEST:,} bytes that are read")
        with archive.open("policy.pth") as file:
            weights = torch.load(file, map_location="cpu", weights_only=True)
    np.savez(arrays, **arrays_of(weights))  # type: ignore[arg-type]


if __name__ == "__main__":
    try:
        _extract(Path(sys.argv[1]), Path(sys.argv[2]))
    except (KeyError, OSError, RuntimeError, ValueError, zipfile.BadZipFile, CprmError) as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        raise SystemExit(1) from None
    except Exception as error:  # whatever PyTorch finds in weights that are none
        print(str(error).splitlines()[0], file=sys.stderr)
        raise SystemExit(1) from None
