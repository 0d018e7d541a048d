"""Learned policies as values: arrays and a description, read from and written to files that hold nothing that could be executed.

A policy is two files: ``NAME.safetensors``, the arrays of its network (`cprm_gym.learning.networks`), and ``NAME.json``, what they are: the
columns that it takes in, what it chooses, how it was learned and what it reached. It runs in NumPy, in batches, without PyTorch.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import CprmError, FormatError, ParameterError
from ..files import read_bounded, write_atomically
from .networks import ACTIVATIONS, Network, choose

FORMAT = "cprm_gym policy"
VERSION = 1
LIMIT = 64_000_000
"""Bytes of the largest file of arrays that is read."""
MODES = ("discrete", "box", "macro", "option")
"""What a policy chooses: the actions of the views of these names, or an option (`cprm_gym.learning.options`)."""


@dataclass(frozen=True, kw_only=True)
class Description:
    """What a policy is.

    Attributes
    ----------
    algorithm, task : str
    mode : str
        One of `MODES`.
    choices : tuple of int
        Numbers of choices, one for each independent part of the action; of the view ``box`` the number of its entries.
    columns : tuple of str
        Names of the entries of the input, in their order: columns of the observation ``normalised``, after which those of a belief come.
    names : tuple of str
        For macros and options what each choice is.
    activation : str
    belief : str
        Name of the model whose posterior is part of the input; empty if there is none.
    task_options : mapping
        Fields of the task that differed in learning.
    command : str
        Line that trains it.
    seed, steps : int
        Seed and agent-steps of the learning.
    curve : tuple of (int, float, float)
        Agent-steps, and success on worlds that it did not learn from, drawing actions and taking the likeliest; seconds where they are
        what the task counts.
    success : mapping
        What was reached in the end: ``drawn`` and ``likeliest``, each successes and episodes.
    """

    algorithm: str
    task: str
    mode: str
    choices: tuple[int, ...]
    columns: tuple[str, ...]
    names: tuple[str, ...] = ()
    activation: str = "tanh"
    belief: str = ""
    task_options: Mapping[str, Any] = field(default_factory=dict)
    command: str = ""
    seed: int = 0
    steps: int = 0
    curve: tuple[tuple[int, float, float], ...] = ()
    success: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what does not add up."""
        if self.mode not in MODES:
            raise ParameterError(f"policy: mode: {self.mode!r} given; allowed are {', '.join(MODES)}")
        if self.activation not in ACTIVATIONS:
            raise ParameterError(f"policy: activation: {self.activation!r} given; allowed are {', '.join(ACTIVATIONS)}")
        if not self.choices or any(isinstance(n, bool) or not isinstance(n, int) or n < 1 for n in self.choices):
            raise ParameterError(f"policy: choices: {self.choices!r:.60} given; whole numbers of at least 1 are needed")
        if not self.columns or not all(isinstance(name, str) for name in self.columns):
            raise ParameterError("policy: columns: the names of the inputs are needed")
        if self.names and len(self.names) != self.choices[0]:
            raise ParameterError(f"policy: names: {len(self.names)} names for {self.choices[0]} choices")

    @property
    def outputs(self) -> int:
        """Numbers that the head of the network gives."""
        return sum(self.choices)


class Policy:
    """A learned policy.

    Parameters
    ----------
    description : Description
    arrays : mapping of str to float32 array
        Of the network.

    Raises
    ------
    ParameterError
        When arrays and description do not fit each other.
    """

    def __init__(self, description: Description, arrays: Mapping[str, np.ndarray]) -> None:
        self.description = description
        self.arrays = {name: np.ascontiguousarray(values, np.float32) for name, values in arrays.items()}
        check_arrays(self.arrays, len(description.columns), description.outputs)
        self.network = Network(self.arrays, description.activation)

    def act(
        self,
        x: np.ndarray,
        mask: np.ndarray | None = None,
        uniform: np.ndarray | None = None,
        state: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Actions of the view, and the next state of a recurrent network.

        Parameters
        ----------
        x : (N, columns) array
        mask : (N, choices) bool array, optional
            What may be chosen, of macros and options.
        uniform : (N, parts) array, optional
            Numbers in [0, 1) that draw the action; without them the likeliest one is taken.
        state : (2, N, hidden) array, optional

        Returns
        -------
        (N,) or (N, parts) int array, or (N, entries) float array within -1 and 1 for ``box``
        """
        d = self.description
        if d.mode == "box":
            mean, deviation = self.network.gaussian(x)
            return np.tanh(mean if uniform is None else mean + deviation * _normal(uniform)), None
        logits, state = self.network(x, state)
        parts, at = [], 0
        for k, count in enumerate(d.choices):
            parts.append(choose(logits[:, at : at + count], mask, None if uniform is None else uniform[:, k]))
            at += count
        return (parts[0] if d.mode in ("macro", "option") else np.stack(parts, axis=1)), state

    @property
    def parts(self) -> int:
        """Random numbers that an action takes."""
        return self.description.choices[0] if self.description.mode == "box" else len(self.description.choices)


def _normal(uniform: np.ndarray) -> np.ndarray:
    """Standard normal numbers from numbers in [0, 1)."""
    from scipy.special import ndtri

    return np.asarray(ndtri(np.clip(uniform, 1e-12, 1.0 - 1e-12)))


def check_arrays(arrays: Mapping[str, np.ndarray], inputs: int, outputs: int) -> None:
    """Refuse arrays that make no network from `inputs` to `outputs` numbers.

    Raises
    ------
    ParameterError
        Naming the array.
    """
    size = inputs

    def layer(name: str, rows: int | None = None) -> int:
        weight, bias = (_array(arrays, f"{name}.{part}") for part in ("weight", "bias"))
        wanted = (weight.shape[0] if rows is None else rows, size)
        if weight.ndim != 2 or weight.shape != wanted or bias.shape != (weight.shape[0],):
            raise ParameterError(f"policy: {name}: shapes {weight.shape} and {bias.shape} given; needed are {wanted} and {wanted[:1]}")
        return int(weight.shape[0])

    known = {"head.weight", "head.bias"}
    if "lstm.input" in arrays:
        weight, hidden, bias = (_array(arrays, f"lstm.{part}") for part in ("input", "hidden", "bias"))
        width = weight.shape[0] // 4
        if weight.shape != (4 * width, size) or hidden.shape != (4 * width, width) or bias.shape != (4 * width,):
            raise ParameterError(f"policy: lstm: shapes {weight.shape}, {hidden.shape}, {bias.shape} do not fit {size} inputs")
        size = width
        known |= {"lstm.input", "lstm.hidden", "lstm.bias"}
    k = 0
    while f"layer_{k}.weight" in arrays:
        known |= {f"layer_{k}.weight", f"layer_{k}.bias"}
        size = layer(f"layer_{k}")
        k += 1
    layer("head", outputs)
    if "deviation.weight" in arrays:
        layer("deviation", outputs)
        known |= {"deviation.weight", "deviation.bias"}
    for name in arrays:
        if name not in known:
            raise ParameterError(f"policy: array {name!r} belongs to no network; known here are {', '.join(sorted(known))}")


def _array(arrays: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    if name not in arrays:
        raise ParameterError(f"policy: array {name!r} is missing")
    if not np.isfinite(arrays[name]).all():
        raise ParameterError(f"policy: array {name!r} holds what is no finite number")
    return arrays[name]


# ---------------------------------------------------------------------- files


def save_policy(policy: Policy, path: str | Path) -> tuple[Path, Path]:
    """Write ``PATH.safetensors`` and ``PATH.json``, each whole or not at all; `path` with or without an ending.

    Raises
    ------
    CprmError
        Without the package safetensors.
    """
    tensors, described = _places(path)
    content = _safetensors().save({name: policy.arrays[name] for name in sorted(policy.arrays)})
    told = {"format": FORMAT, "version": VERSION, **asdict(policy.description), "sha256": hashlib.sha256(content).hexdigest()}
    write_atomically(tensors, content)
    write_atomically(described, json.dumps(told, indent=1) + "\n")
    return tensors, described


def load_policy(path: str | Path) -> Policy:
    """Read a policy; nothing in its files is executed.

    Parameters
    ----------
    path : path
        Of either file, or of both without an ending.

    Raises
    ------
    FormatError
        For files that are no policy, do not belong together or are too large.
    CprmError
        For a model saved by stable-baselines3 (`cprm-gym train --convert` makes a policy of it), and without the package safetensors.
    """
    if Path(path).suffix == ".zip":
        raise CprmError(
            f"{path}: a model saved by stable-baselines3; loading one executes code that it holds. If you trust who made it: "
            f"cprm-gym train --convert {path}"
        )
    tensors, described = _places(path)
    try:
        told = json.loads(read_bounded(described, 4_000_000))
    except ValueError as error:
        raise FormatError(f"{described}: no JSON: {error}") from None
    if not isinstance(told, dict) or told.get("format") != FORMAT:
        raise FormatError(f"{described}: no description of a policy; 'format' is {FORMAT!r} there")
    if told.get("version") != VERSION:
        raise FormatError(f"{described}: version {told.get('version')!r} given; allowed is {VERSION}")
    content = read_bounded(tensors, LIMIT)
    if hashlib.sha256(content).hexdigest() != told.get("sha256"):
        raise FormatError(f"{tensors}: not the arrays that {described.name} describes (another sha256)")
    try:
        arrays = _safetensors().load(content)
        return Policy(_description(told), arrays)
    except (ParameterError, TypeError, ValueError, KeyError, AttributeError) as error:
        raise FormatError(f"{described}: {error}") from None
    except CprmError:
        raise
    except Exception as error:  # whatever the reader of safetensors finds wrong
        raise FormatError(f"{tensors}: no arrays in the form safetensors: {error}") from None


def _description(told: Mapping[str, Any]) -> Description:
    """The description in a JSON object.

    Raises
    ------
    ParameterError
        For keys that are missing, unknown or of another type.
    """
    known = {f.name: f for f in fields(Description)}
    for name in told:
        if name not in known and name not in ("format", "version", "sha256"):
            raise ParameterError(f"policy: unknown key {name!r}; known are {', '.join(known)}")
    given: dict[str, Any] = {}
    for name, entry in known.items():
        if name not in told:
            if name in ("algorithm", "task", "mode", "choices", "columns"):
                raise ParameterError(f"policy: key {name!r} is missing")
            continue
        value, kind = told[name], str(entry.type)
        wanted: type | tuple[type, ...] = str if kind == "str" else int if kind == "int" else list if "tuple" in kind[:5] else dict
        if not isinstance(value, wanted) or (wanted is int and isinstance(value, bool)):
            raise ParameterError(f"policy: {name}: {value!r:.60} given; a {wanted.__name__} is needed")  # type: ignore[union-attr]
        given[name] = tuple(tuple(v) if isinstance(v, list) else v for v in value) if isinstance(value, list) else value
    return Description(**given)


def _places(path: str | Path) -> tuple[Path, Path]:
    """Where arrays and description are."""
    bare = Path(path)
    if bare.suffix in (".safetensors", ".json"):
        bare = bare.with_suffix("")
    return bare.with_name(bare.name + ".safetensors"), bare.with_name(bare.name + ".json")


def _safetensors() -> Any:
    try:
        import safetensors.numpy
    except ImportError:
        raise CprmError("policies are files of safetensors: pip install 'cprm-gym[policies]'") from None
    return safetensors.numpy


SHIPPED = Path(__file__).parent / "policies"
"""Folder of the policies that come with the project: ``<Task>-<algorithm>``."""


def shipped() -> tuple[str, ...]:
    """Names of the policies that come with the project."""
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.json")))
