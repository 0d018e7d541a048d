"""How a policy is trained: files that people write and change, checked when they are read.

A configuration is a TOML file with a table for each algorithm::

    [ppo]
    steps = 300_000
    worlds = 4

    [ppo.environment]           # options of the environment, fields of the task
    reward = "to_ball_progress"

    [ppo.learner]               # arguments of the learner; what is not named is as stable-baselines3 has it
    learning_rate = 3e-4

    [[ppo.curriculum]]          # easier worlds first, for as many of the steps
    steps = 50_000
    environment = { far = 12.0 }

Those of the project lie in `FOLDER`: for a task (``HFO1v0.toml``) or for all whose names begin so (``HFO.toml``); others are trained as
``default.toml`` says.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import CprmError, FormatError, ParameterError, did_you_mean, unknown_name
from ..files import read_bounded

FOLDER = Path(__file__).parent / "configurations"
FACES = ("batch", "gymnasium")
"""``batch``: all worlds in one engine (`cprm_gym.wrappers.sb3.SoccerVecEnv`); ``gymnasium``: one of `gymnasium.make` for each."""


@dataclass(frozen=True)
class Algorithm:
    """A way of learning.

    Attributes
    ----------
    says : str
    learner : str
        Class of stable-baselines3 or sb3-contrib.
    policy : str
        Kind of network: ``Mlp`` or ``MlpLstm``.
    mode : str
        Action view, or ``option``.
    shared : bool
        All agents that the task lets act learn one policy; otherwise the first of them learns.
    """

    says: str
    learner: str = "PPO"
    policy: str = "Mlp"
    mode: str = "discrete"
    shared: bool = False


ALGORITHMS: Mapping[str, Algorithm] = {
    "ppo": Algorithm("proximal policy optimisation, low-level actions"),
    "recurrent_ppo": Algorithm("PPO with an LSTM", "RecurrentPPO", "MlpLstm"),
    "sac": Algorithm("soft actor-critic, continuous low-level actions", "SAC", mode="box"),
    "maskable_ppo": Algorithm("PPO over macros, of which some cannot be chosen", "MaskablePPO", mode="macro", shared=True),
    "belief_ppo": Algorithm("PPO that also sees the posterior of a model of the ball"),
    "shared_ppo": Algorithm("PPO, one policy for all agents that act", shared=True),
    "options": Algorithm("PPO over skills of the architecture as options", "MaskablePPO", mode="option"),
}
"""By name."""

_PPO = ("PPO", "RecurrentPPO", "MaskablePPO")
LEARNER: Mapping[str, tuple[type, float, float, tuple[str, ...]]] = {
    "learning_rate": (float, 1e-7, 1.0, (*_PPO, "SAC")),
    "gamma": (float, 0.0, 1.0, (*_PPO, "SAC")),
    "batch_size": (int, 2, 10**6, (*_PPO, "SAC")),
    "n_steps": (int, 2, 10**6, _PPO),
    "n_epochs": (int, 1, 1000, _PPO),
    "gae_lambda": (float, 0.0, 1.0, _PPO),
    "clip_range": (float, 1e-4, 10.0, _PPO),
    "ent_coef": (float, 0.0, 10.0, (*_PPO, "SAC")),
    "vf_coef": (float, 0.0, 10.0, _PPO),
    "max_grad_norm": (float, 1e-4, 1e6, _PPO),
    "buffer_size": (int, 1, 10**8, ("SAC",)),
    "learning_starts": (int, 0, 10**8, ("SAC",)),
    "train_freq": (int, 1, 10**6, ("SAC",)),
    "gradient_steps": (int, 1, 10**6, ("SAC",)),
    "tau": (float, 1e-6, 1.0, ("SAC",)),
}
"""Arguments of the learners that a configuration may give: type, extent, and whose they are."""
FIXED = (
    "task",
    "action_mode",
    "observation",
    "flatten",
    "include",
    "render_mode",
    "controlled",
    "agent",
    "debug_info",
    "backend",
    "senses",
)
"""Options of an environment that an algorithm decides itself."""


@dataclass(frozen=True)
class Stage:
    """A part of the learning in easier worlds."""

    steps: int
    environment: Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Configuration:
    """How one policy is trained.

    Attributes
    ----------
    task, algorithm : str
    steps : int
        Agent-steps learned from, those of the curriculum included.
    worlds : int
        Environments side by side.
    face : str
        One of `FACES`.
    layers : tuple of int
        Widths of the hidden layers; as the learner has them if empty.
    episodes : int
        Episodes of each measurement, drawing and taking the likeliest.
    evaluations : int
        Measurements along the way.
    longest : int
        Cycles for which an option lasts unless it ends earlier.
    environment, learner : mapping
    curriculum : tuple of Stage
    """

    task: str
    algorithm: str
    steps: int = 300_000
    worlds: int = 8
    face: str = "batch"
    layers: tuple[int, ...] = ()
    episodes: int = 200
    evaluations: int = 10
    longest: int = 5
    environment: Mapping[str, Any] = field(default_factory=dict)
    learner: Mapping[str, Any] = field(default_factory=dict)
    curriculum: tuple[Stage, ...] = ()

    @property
    def metric(self) -> str:
        """What counts in the task: ``success``, or ``duration`` in seconds."""
        from ..envs.tasks import make_task

        return make_task(self.task).metric

    @property
    def kind(self) -> Algorithm:
        """The algorithm."""
        return ALGORITHMS[self.algorithm]

    def as_json(self) -> dict[str, Any]:
        """All of it, as `from_table` takes it beside task and algorithm."""
        told = asdict(self)
        return told | {"layers": list(self.layers), "curriculum": [asdict(stage) for stage in self.curriculum]}


_WHOLE = {"steps": 1, "worlds": 1, "episodes": 1, "evaluations": 1, "longest": 1}


def from_table(task: str, algorithm: str, table: Any, where: str) -> Configuration:
    """The configuration in a table.

    Parameters
    ----------
    task, algorithm : str
    table : mapping
    where : str
        What an error calls it: ``file.toml [ppo]``.

    Raises
    ------
    ParameterError
        Naming the key, what was given and what is allowed.
    UnknownName
        For a task or an algorithm that does not exist.
    """
    from ..envs.tasks import TASKS

    if task not in TASKS:
        raise unknown_name("task", task, TASKS)
    if algorithm not in ALGORITHMS:
        raise unknown_name("algorithm", algorithm, ALGORITHMS)
    if not isinstance(table, Mapping):
        raise ParameterError(f"{where}: {table!r:.60} given; a table is needed")
    known = [f.name for f in fields(Configuration) if f.name not in ("task", "algorithm")]
    given: dict[str, Any] = {}
    for key, value in table.items():
        if key in ("task", "algorithm"):
            continue
        if key not in known:
            raise ParameterError(f"{where}: unknown key {key!r}.{did_you_mean(str(key), known)} Allowed: {', '.join(known)}.")
        given[key] = value
    for key, least in _WHOLE.items():
        if key in given:
            _whole(where, key, given[key], least)
    if given.get("face", FACES[0]) not in FACES:
        raise ParameterError(f"{where}: face: {given['face']!r} given; allowed are {', '.join(FACES)}")
    kind = ALGORITHMS[algorithm]
    if given.get("face") == "gymnasium" and (kind.shared or kind.mode == "option" or algorithm == "belief_ppo"):
        raise ParameterError(f"{where}: face: 'gymnasium' has one agent, and no beliefs or options; allowed here is 'batch'")
    if "layers" in given:
        layers = given["layers"]
        if not isinstance(layers, (list, tuple)) or not all(_is_whole(n) and 1 <= n <= 4096 for n in layers):
            raise ParameterError(f"{where}: layers: {layers!r:.60} given; a list of whole numbers from 1 to 4096 is needed")
        given["layers"] = tuple(layers)
    given["environment"] = _environment(where, given.get("environment", {}))
    given["learner"] = _learner(where, kind.learner, given.get("learner", {}))
    given["curriculum"] = _stages(where, given.get("curriculum", ()))
    made = Configuration(task=task, algorithm=algorithm, **given)
    if sum(stage.steps for stage in made.curriculum) >= made.steps:
        raise ParameterError(f"{where}: curriculum: its stages take all {made.steps} steps; the task itself needs some")
    _try(where, made)
    return made


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _whole(where: str, key: str, value: Any, least: int) -> None:
    if not _is_whole(value) or value < least:
        raise ParameterError(f"{where}: {key}: {value!r:.60} given; a whole number of at least {least} is needed")


def _environment(where: str, table: Any) -> dict[str, Any]:
    if not isinstance(table, Mapping):
        raise ParameterError(f"{where}: environment: {table!r:.60} given; a table is needed")
    for key in table:
        if key in FIXED:
            raise ParameterError(f"{where}: environment: {key!r} is decided by the algorithm; give others, reward or fields of the task")
    return dict(table)


def _learner(where: str, learner: str, table: Any) -> dict[str, Any]:
    if not isinstance(table, Mapping):
        raise ParameterError(f"{where}: learner: {table!r:.60} given; a table is needed")
    known = [name for name, (*_, whose) in LEARNER.items() if learner in whose]
    for key, value in table.items():
        if key not in known:
            hint = did_you_mean(str(key), known)
            raise ParameterError(f"{where}: learner: {learner} takes no {key!r}.{hint} Allowed: {', '.join(known)}.")
        kind, low, high, _ = LEARNER[key]
        if isinstance(value, bool) or not isinstance(value, (int, float) if kind is float else int) or not low <= value <= high:
            what = "whole numbers" if kind is int else "numbers"
            raise ParameterError(f"{where}: learner: {key}: {value!r:.60} given; allowed are {what} from {low:g} to {high:g}")
    return dict(table)


def _stages(where: str, given: Any) -> tuple[Stage, ...]:
    if not isinstance(given, (list, tuple)):
        raise ParameterError(f"{where}: curriculum: {given!r:.60} given; a list of tables with steps and environment is needed")
    stages = []
    for k, table in enumerate(given):
        here = f"{where}: curriculum {k + 1}"
        if not isinstance(table, Mapping) or set(table) != {"steps", "environment"}:
            raise ParameterError(f"{here}: {table!r:.60} given; a table of steps and environment is needed")
        _whole(here, "steps", table["steps"], 1)
        stages.append(Stage(table["steps"], _environment(here, table["environment"])))
    return tuple(stages)


def _try(where: str, configuration: Configuration) -> None:
    """Refuse options that no environment of the task has."""
    from ..envs.options import EnvOptions
    from ..envs.rewards import Reward

    for more in ({}, *(stage.environment for stage in configuration.curriculum)):
        try:
            options = EnvOptions.of({"task": configuration.task, **configuration.environment, **more})
            played = options.played()
            Reward(options.reward, options.reward_gamma, played.terms, played.shaping)
        except CprmError as error:
            raise ParameterError(f"{where}: environment: {error}") from None


def read_configuration(task: str, algorithm: str, file: Path | None = None) -> Configuration:
    """The configuration of a task and an algorithm from a file, or else from those of the project.

    Raises
    ------
    FormatError
        For a file that cannot be read or is no TOML.
    ParameterError, UnknownName
        As for `from_table`; for a file that has no table of the algorithm.
    """
    if file is not None:
        tables = read_toml(file)
        for name in tables:
            if name not in ALGORITHMS:
                raise ParameterError(f"{file}: unknown table {name!r}.{did_you_mean(name, ALGORITHMS)} Allowed: {', '.join(ALGORITHMS)}.")
        if algorithm not in tables:
            raise ParameterError(f"{file}: no table [{algorithm}]; it has {', '.join(tables) or 'none'}")
        return from_table(task, algorithm, tables[algorithm], f"{file} [{algorithm}]")
    for name in (*_families(task), "default"):
        place = FOLDER / f"{name}.toml"
        tables = read_toml(place) if place.is_file() else {}
        if algorithm in tables:
            return from_table(task, algorithm, tables[algorithm], f"{place.name} [{algorithm}]")
    return from_table(task, algorithm, {}, f"[{algorithm}]")


def _families(task: str) -> list[str]:
    """Names of files that begin the task's, the longest first: `HFO1v1`, `HFO`."""
    found = [place.stem for place in FOLDER.glob("*.toml") if task.startswith(place.stem)]
    return sorted(found, key=len, reverse=True)


def read_toml(file: Path) -> dict[str, Any]:
    """The tables of a TOML file.

    Raises
    ------
    FormatError
        When it cannot be read, or is none.
    """
    # Python 3.10 has no reader of TOML
    tomllib: Any = import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")
    content = read_bounded(file, 1_000_000)
    try:
        tables: dict[str, Any] = tomllib.loads(content.decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise FormatError(f"{file}: no TOML: {error}") from None
    return tables
