"""A training: seeds one after the other or at a time, each measured on the way, kept at every measurement, taken up where it was left.

The folder of a training holds ``plan.json``, for each seed a folder ``seed_<k>`` with the state of the learner (`checkpoints`), the curve
(``curve.jsonl``) and the best policy so far, and, when all seeds are done, what random choices reach (``random.json``) and the report
(`report`). A training that goes on after an interruption begins new episodes and draws anew; everything that was learned, measured or
remembered stays.
"""

from __future__ import annotations

import json
import shlex
import signal
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import CprmError, FormatError, ParameterError
from ..files import write_atomically
from ..workers import results
from .configuration import ALGORITHMS, Configuration, from_table, read_configuration
from .policy import Description, Policy, load_policy, save_policy

if TYPE_CHECKING:
    from .measuring import Measured

FLOOR = "random.json"
Tell = Callable[[int, int, "float | None"], None]
"""Is told (seed, agent-steps so far, success or seconds when they were last measured)."""


@dataclass(frozen=True)
class Plan:
    """What is trained.

    Attributes
    ----------
    configuration : Configuration
    seeds : int
        How many.
    first : int
        The first of them.
    command : str
    """

    configuration: Configuration
    seeds: int = 5
    first: int = 0
    command: str = ""

    def __post_init__(self) -> None:
        """Refuse seeds that are none."""
        for name, value, least in (("seeds", self.seeds, 1), ("seed", self.first, 0)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ParameterError(f"{name}: {value!r} given; a whole number of at least {least} is needed")
        if self.first + self.seeds > 1_000_000_000:
            raise ParameterError(f"seed: {self.first} given; allowed are numbers below 1,000,000,000, which no measurement uses")

    @classmethod
    def of(cls, algorithm: str, task: str, file: Path | None = None, seeds: int = 5, first: int = 0, steps: int | None = None) -> Plan:
        """The plan of a command, with its configuration from a file or from those of the project."""
        configuration = read_configuration(task, algorithm, file)
        words = ["cprm-gym", "train", algorithm, "--task", task, "--seeds", str(seeds)]
        words += ["--seed", str(first)] if first else []
        words += ["--config", str(file)] if file else []
        if steps is not None:
            words += ["--steps", str(steps)]
            configuration = from_table(task, algorithm, {**configuration.as_json(), "steps": steps}, f"--steps {steps}")
        return cls(configuration, seeds, first, shlex.join(words))

    def write(self, folder: Path) -> None:
        """``plan.json``."""
        told = {"configuration": self.configuration.as_json(), "seeds": self.seeds, "first": self.first, "command": self.command}
        write_atomically(folder / "plan.json", json.dumps(told, indent=1) + "\n")

    @classmethod
    def read(cls, folder: Path) -> Plan:
        """The plan of a folder.

        Raises
        ------
        FormatError
            When there is none, or it is damaged.
        """
        place = folder / "plan.json"
        try:
            told = json.loads(place.read_text("utf-8"))
            given = told["configuration"]
            configuration = from_table(given["task"], given["algorithm"], given, str(place))
            return cls(configuration, told["seeds"], told["first"], str(told["command"]))
        except OSError as error:
            raise FormatError(f"{place}: cannot be read: {error.strerror}") from None
        except (ValueError, KeyError, TypeError) as error:
            raise FormatError(f"{place}: no plan of a training: {error}") from None


@dataclass(frozen=True)
class Point:
    """A measurement on the way."""

    steps: int
    drawn: float
    likeliest: float
    seconds: float
    """Processor time of the learning until here."""

    @property
    def worth(self) -> float:
        """By what the best policy is chosen: success or seconds, as the task counts, not return, which shaping may fool."""
        return 0.5 * (self.drawn + self.likeliest)


def check_installed() -> None:
    """Refuse to begin without what learning needs.

    Raises
    ------
    CprmError
        Saying how to install it.
    """
    for package in ("torch", "stable_baselines3", "sb3_contrib", "safetensors"):
        if find_spec(package) is None:
            raise CprmError(f"training needs {package}: pip install 'cprm-gym[rl]'")


def make_learner(configuration: Configuration, env: Any, seed: int, logs: Path | None = None) -> Any:
    """A new learner of stable-baselines3."""
    import sb3_contrib
    import stable_baselines3
    import torch
    from gymnasium import spaces

    kind = configuration.kind
    maker = getattr(stable_baselines3, kind.learner, None) or getattr(sb3_contrib, kind.learner)
    network = kind.policy
    if isinstance(env.observation_space, spaces.Dict):
        network = {"Mlp": "MultiInput", "MlpLstm": "MultiInputLstm"}[network]
    more: dict[str, Any] = dict(configuration.learner)
    if configuration.layers:
        more["policy_kwargs"] = {"net_arch": list(configuration.layers)}
    torch.set_num_threads(1)  # such small networks are slower with more
    return maker(f"{network}Policy", env, seed=seed, device="cpu", tensorboard_log=None if logs is None else str(logs), **more)


def policy_of(model: Any, plan: Plan, seed: int, curve: list[Point]) -> Policy:
    """The policy of a learner as it is now."""
    from gymnasium import spaces

    from .beliefs import COLUMNS
    from .export import arrays_of
    from .worlds import columns_of, names_of

    configuration, env = plan.configuration, model.get_env()
    kind, space = configuration.kind, env.action_space
    choices = space.nvec.tolist() if isinstance(space, spaces.MultiDiscrete) else [int(space.n if hasattr(space, "n") else space.shape[0])]
    columns = columns_of(env)
    fields_of_task = {k: v for k, v in configuration.environment.items() if k not in ("reward", "reward_gamma")}
    described = Description(
        algorithm=configuration.algorithm, task=configuration.task, mode=kind.mode, choices=tuple(choices), columns=columns,
        names=tuple(names_of(env)), activation="relu" if kind.learner == "SAC" else "tanh",
        belief="ball" if set(COLUMNS) & set(columns) else "", task_options=fields_of_task,
        command=plan.command, seed=seed, steps=int(model.num_timesteps),
        curve=tuple((p.steps, p.drawn, p.likeliest) for p in curve),
    )  # fmt: skip
    return Policy(described, arrays_of(model.policy.state_dict()))


def train_seed(plan: Plan, seed: int, folder: Path, tell: Tell | None = None) -> None:
    """Train one seed in its folder, from where it is.

    Raises
    ------
    KeyboardInterrupt
        After the state of the learner has been kept.
    FormatError
        When the folder holds something else.
    """
    import random

    import numpy as np
    import torch

    from .worlds import make_worlds

    configuration, own = plan.configuration, folder / f"seed_{seed}"
    own.mkdir(exist_ok=True)
    done = own / "done.json"
    if done.exists():
        return
    logs = folder / "tensorboard" / f"seed_{seed}" if _has_tensorboard() else None
    run = _Run(plan, seed, own, tell)
    steps, stages = 0, (*configuration.curriculum, None)
    model: Any = None
    for k, stage in enumerate(stages):
        steps = configuration.steps if stage is None else steps + stage.steps
        env = make_worlds(configuration, configuration.worlds, seed + 1000 * k, None if stage is None else stage.environment)
        if model is None:
            model = make_learner(configuration, env, seed, logs)
            if (own / "learner.json").exists():
                run.take_up(model)
                # other luck than that of the part that was played already
                draw = int(np.random.SeedSequence([seed, model.num_timesteps]).generate_state(1)[0])
                random.seed(draw)
                np.random.seed(draw)  # noqa: NPY002  (stable-baselines3 draws from it)
                torch.manual_seed(draw)
                env.seed(draw)
        else:
            model.set_env(env)
        if model.num_timesteps < steps:
            try:
                model.learn(steps - model.num_timesteps, callback=run.callback(), reset_num_timesteps=False, tb_log_name="learning")
            except KeyboardInterrupt:
                run.keep(model)
                raise
        env.close()
    run.measure(model)
    run.keep(model)
    run.finish(done)


def told_of(found: Measured) -> dict[str, list[Any]]:
    """What is kept of measured episodes."""
    return {"success": found.success.astype(int).tolist(), "cycles": found.cycles.tolist(), "reward": found.reward.tolist()}


def _has_tensorboard() -> bool:
    return find_spec("tensorboard") is not None


class _Run:
    """What happens beside the learning of one seed: measurements, kept states, news."""

    def __init__(self, plan: Plan, seed: int, folder: Path, tell: Tell | None) -> None:
        self.plan, self.seed, self.folder, self.tell = plan, seed, folder, tell
        self.curve: list[Point] = []
        self._seconds = 0.0
        self._every = max(1, plan.configuration.steps // plan.configuration.evaluations)

    def take_up(self, model: Any) -> None:
        """Put a learner into the state that was kept, and read the curve until there."""
        from .checkpoints import load_checkpoint

        told = load_checkpoint(model, self.folder)
        self.curve = [point for point in read_curve(self.folder) if point.steps <= model.num_timesteps]
        self._write_curve()
        self._seconds = float(told.get("seconds", 0.0))

    def callback(self) -> Any:
        """What stable-baselines3 calls while it learns."""
        import time

        from stable_baselines3.common.callbacks import BaseCallback

        run, begin = self, time.process_time() - self._seconds

        class Beside(BaseCallback):
            def _on_step(self) -> bool:
                return True

            def _on_training_end(self) -> None:
                run._seconds = time.process_time() - begin

            def _on_rollout_start(self) -> None:
                nonlocal begin
                run._seconds = time.process_time() - begin
                steps = self.model.num_timesteps
                last = run.curve[-1] if run.curve else None
                if steps and steps // run._every > (last.steps if last else 0) // run._every and steps < run.plan.configuration.steps:
                    pause = time.process_time()
                    last = run.measure(self.model)
                    run.keep(self.model)
                    begin += time.process_time() - pause
                if run.tell is not None:
                    run.tell(run.seed, steps, None if last is None else last.worth)

        return Beside()

    def measure(self, model: Any) -> Point:
        """Measure the policy as it is now; if it is the best so far, keep it."""
        from .measuring import measure
        from .worlds import UNSEEN

        steps = int(model.num_timesteps)
        if self.curve and self.curve[-1].steps == steps:
            return self.curve[-1]
        policy = policy_of(model, self.plan, self.seed, self.curve)
        c = self.plan.configuration
        drawn, likeliest = (float(measure(policy, c, way, UNSEEN + 1).figures(c.metric).mean()) for way in (True, False))
        point = Point(steps, drawn, likeliest, round(self._seconds, 1))
        best = max((p.worth for p in self.curve), default=-1.0)
        self.curve.append(point)
        if point.worth >= best:
            save_policy(policy_of(model, self.plan, self.seed, self.curve), self.folder / "best")
        self._write_curve()
        if model.logger is not None and hasattr(model, "_logger"):
            model.logger.record("measured/drawn", point.drawn)
            model.logger.record("measured/likeliest", point.likeliest)
        if self.tell is not None:
            self.tell(self.seed, steps, point.worth)
        return point

    def keep(self, model: Any) -> None:
        """Write the state of the learner."""
        from .checkpoints import save_checkpoint

        save_checkpoint(model, self.folder, {"seconds": round(self._seconds, 1), "seed": self.seed})

    def _write_curve(self) -> None:
        lines = [json.dumps([p.steps, p.drawn, p.likeliest, p.seconds]) for p in self.curve]
        write_atomically(self.folder / "curve.jsonl", "".join(line + "\n" for line in lines))

    def finish(self, done: Path) -> None:
        """Measure the best policy in worlds that chose nothing, and note that the seed is done."""
        from dataclasses import replace

        from .measuring import measure
        from .worlds import UNSEEN

        best = load_policy(self.folder / "best")
        told: dict[str, Any] = {"seconds": round(self._seconds, 1)}
        for name, drawn in (("drawn", True), ("likeliest", False)):
            found = measure(best, self.plan.configuration, drawn, UNSEEN)
            told[name] = told_of(found)
        reached = {name: (sum(told[name]["success"]), len(told[name]["success"])) for name in ("drawn", "likeliest")}
        described = replace(best.description, success=reached, curve=tuple((p.steps, p.drawn, p.likeliest) for p in self.curve))
        save_policy(Policy(described, best.arrays), self.folder / "best")
        write_atomically(done, json.dumps(told) + "\n")


def read_curve(folder: Path) -> list[Point]:
    """The measurements of a seed, in order.

    Raises
    ------
    FormatError
        For a damaged line.
    """
    place = folder / "curve.jsonl"
    if not place.exists():
        return []
    points = []
    for number, line in enumerate(place.read_text("utf-8").splitlines(), 1):
        try:
            steps, drawn, likeliest, seconds = json.loads(line)
            points.append(Point(int(steps), float(drawn), float(likeliest), float(seconds)))
        except (ValueError, TypeError) as error:
            raise FormatError(f"{place}, line {number}: no measurement: {error}") from None
    return points


def _trained(plan: Plan, seed: int, folder: Path) -> int:
    """One seed by a process of its own, which keeps its state when it is asked to end."""

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, stop)
    train_seed(plan, seed, folder)
    return seed


def train(plan: Plan, folder: Path, tell: Tell | None = None, workers: int = 1, ray: str | None = None) -> None:
    """Train all seeds that are not done.

    Parameters
    ----------
    plan : Plan
    folder : Path
        Where they are trained; every machine of a Ray cluster has to see it.
    tell : callable, optional
        Told of every measurement, or, where other processes train, of every seed that is done.
    workers, ray : int, str, optional
        Processes that train a seed each, or address of a Ray cluster (`cprm_gym.workers.results`). A process that is killed costs time
        alone: its seed goes on from what was kept of it. What is learned does not depend on how many there are.

    Raises
    ------
    CprmError
        Without what learning needs, or when another process trains in the folder.
    """
    from filelock import FileLock, Timeout

    check_installed()
    lock = FileLock(folder / "training.lock", timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise CprmError(f"{folder}: another process is training there") from None
    try:
        seeds = range(plan.first, plan.first + plan.seeds)
        if workers == 1 and ray is None:
            for seed in seeds:
                train_seed(plan, seed, folder, tell)
        else:
            for seed in results(_trained, [(plan, seed, folder.absolute()) for seed in seeds], workers, ray):
                if tell is not None:
                    tell(seed, plan.configuration.steps, None)
        if not (folder / FLOOR).exists():
            from .measuring import measure_random
            from .worlds import UNSEEN

            write_atomically(folder / FLOOR, json.dumps(told_of(measure_random(plan.configuration, UNSEEN))) + "\n")
    finally:
        lock.release()


def known_algorithms() -> Mapping[str, str]:
    """Name and what it is, of every algorithm."""
    return {name: kind.says for name, kind in ALGORITHMS.items()}
