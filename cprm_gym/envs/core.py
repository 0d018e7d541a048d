"""Many worlds of one task at once: the engine under every environment face.

`SoccerCore` owns a `Simulator`, turns actions into commands, senses into observation arrays and asks the `Task` what it means.
The Gymnasium, vector and PettingZoo faces only translate between it and their libraries.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces as gym_spaces

from ..errors import CommandError, CprmError, ParameterError, UnknownName, did_you_mean, unknown_name
from ..simulator.senses import See, new_body, new_hear, new_landmarks, new_see
from ..simulator.setup import stream_keys
from ..simulator.simulator import Simulator
from ..simulator.state import COMMAND, PLAYERS
from .actions import MACRO, NO_COMMAND, ActionView, action_view
from .kernels import pitch as pitch_kernels
from .kernels.starts import begin
from .observations import HEARD, MAX_AGE, observation_space
from .options import EnvOptions, several
from .others.controlled import ControlledPlayers
from .others.percepts import Sensed, tell
from .others.registry import OtherPlayer, other_player
from .pitch import Pitch
from .players.macros import Macros
from .players.memory import Memories, true_memory
from .players.mixing import NOBODY
from .players.scripted import ScriptedPlayers
from .players.senses import LateNews, Senses, SensesChange
from .presets import REMEMBERED, Preset, see_everything
from .rewards import Reward
from .tasks.base import Status, Task
from .vectors.normalised import Normalised

OUT_OF_TIME = int(Status.OUT_OF_TIME)
BLOCK = 16
"""Worlds that each thread observes at once: their records, percepts and observations together stay in the cache of a core."""


class Step(NamedTuple):
    """What one cycle gave, for every world and agent."""

    reward: np.ndarray
    """(W, A) float64."""
    terminated: np.ndarray
    """(W,) bool."""
    truncated: np.ndarray
    """(W,) bool: out of time and not terminated."""
    success: np.ndarray
    """(W, A) bool: the episode has ended as the agent wishes."""
    status: np.ndarray
    """(W,) int: `Status`."""
    terms: Mapping[str, np.ndarray]
    """Named parts of the reward, each (W, A)."""


def agent_names(left: int, right: int) -> tuple[str, ...]:
    """``left_1 ... left_n, right_1 ... right_m``."""
    return tuple(f"left_{i}" for i in range(1, left + 1)) + tuple(f"right_{i}" for i in range(1, right + 1))


def select_agents(controlled: str | Sequence[str], left: int, right: int) -> tuple[str, ...]:
    """The agents meant by a selection, in the order left_1 ... right_11.

    Parameters
    ----------
    controlled : str or sequence of str
        ``all``, ``left``, ``right``, agent names, or several of them (a sequence, or one string with commas).
    left, right : int
        Players of each side.

    Raises
    ------
    UnknownName
        When a part of the selection names nobody.
    """
    names = agent_names(left, right)
    if isinstance(controlled, str):
        controlled = [part.strip() for part in controlled.split(",")]
    chosen: set[str] = set()
    for part in several("agents", controlled):
        group = {"all": names, "left": names[:left], "right": names[left:]}.get(part, (part,) if part in names else None)
        if not group:
            allowed = ("all", "left", "right", *names)
            hint = "" if part in allowed else did_you_mean(str(part), allowed)
            raise UnknownName(f"agents: {part!r} names no player here.{hint} Allowed: {', '.join(allowed)}.")
        chosen.update(group)
    return tuple(n for n in names if n in chosen)


def batch_of_one(action: Any) -> Any:
    """The action of one agent as a batch of one world and one agent."""
    if isinstance(action, dict):
        return {key: _lift(value) for key, value in action.items()}
    return _lift(action)


def _lift(value: Any) -> Any:
    """`value` with two leading axes of length one; what is not a number is left for the view to refuse."""
    try:
        return np.asarray(value)[None, None]
    except (TypeError, ValueError):
        return value


def player_number(agent: str) -> int:
    """Object number 1..22 of the agent name (``left_3`` is 3, ``right_1`` is 12)."""
    match = re.fullmatch(r"(left|right)_(\d+)", agent)
    if match is None or not 1 <= int(match[2]) <= 11:
        raise UnknownName(f"agent {agent!r}: names are left_1 ... left_11 and right_1 ... right_11")
    return int(match[2]) + (0 if match[1] == "left" else 11)


def _copy(source: np.ndarray, into: np.ndarray) -> None:
    """All of an array; records as bytes, much faster than field by field."""
    if into.dtype.names is None:
        into[...] = source
    else:
        into.view("u1")[...] = np.ascontiguousarray(source).view("u1")


class SoccerCore(Pitch):
    """A batch of worlds that play one task.

    Parameters
    ----------
    task : str, Task or EnvOptions
        What is played, or all options at once.
    worlds : int
        How many worlds, W.
    seed : int
        Seed of all worlds; world k depends on (seed, first_world + k) alone.
    first_world : int
        Number of the first world: ``SoccerCore(task, 1, first_world=k)`` is world k of a batch, bit for bit.
    threads : int
        Threads that share the worlds; results do not depend on it.
    **options
        As for `EnvOptions`, but if they do not say otherwise, it is what controllers see and do, who learn nothing: the actions of the
        canonical view, ``hybrid``, the observations ``raw``, the percepts themselves, the reward ``sparse``. An empty
        `controlled`: everybody is scripted, `step(None)`.

    Attributes
    ----------
    options : EnvOptions
    senses : Senses
        Of the controlled agents.
    agents : tuple of str
        Controlled agents, A of them.
    output : dict of str to array, or array
        What the preset makes of `observation`; (W, A, ...) too. Both are overwritten by `reset` and `step`.
    term_keys : tuple of (str, str)
        Terms of the reward, and their names in the infos.
    see_changes : list of callable
        Each is given what everybody sees (`See`) in some worlds and their indices (n,), row k being world k of them, before anything is
        made of it, observations and memories alike, and may change it.

    One class because a task sees, as a `Pitch`, the very worlds that the engine plays, saves and branches.
    """

    def __init__(
        self, task: str | Task | EnvOptions, worlds: int = 1, *, seed: int = 0, first_world: int = 0, threads: int = 1, **options: Any
    ) -> None:
        if not isinstance(task, EnvOptions):
            task = EnvOptions.of({"task": task, "action_mode": "hybrid", "observation": "raw", "reward": "sparse", **options})
        elif options:
            raise ParameterError(f"SoccerCore: {', '.join(options)} given beside EnvOptions, which hold all options")
        self.options = task
        self.task = task = self.options.played()
        counts = (task.left, task.right)
        sim = self.simulator(task, worlds, seed, first_world, threads)
        controlled = task.controlled if self.options.controlled is None else self.options.controlled
        self.agents = select_agents(controlled, *counts)
        players = np.array([player_number(a) for a in self.agents], np.int64)
        super().__init__(sim, players, counts, task.region, int(task.max_cycles))
        self.include: tuple[str, ...] = tuple(self.options.include)
        mode = self.options.action_mode
        self.macros = Macros(sim, players, counts, task.region, task.full_state) if mode == MACRO else None
        self.view = ActionView(MACRO, gym_spaces.Discrete(len(self.macros.names))) if self.macros else action_view(mode)
        self.scripted, self.played = self._others(task.others if self.options.others is None else self.options.others, counts)
        self._normal = Normalised(self, task.task_features) if "normalised" in self.include else None
        vector = self._normal.columns.space(flatten=True) if self._normal else None
        space = observation_space(task.task_features, self.include, len(self.macros.names) if self.macros else 0, vector)  # type: ignore[arg-type]
        for name, part in space.items():
            self.observation[name] = np.zeros((worlds, len(self.agents), *(part.shape or ())), part.dtype)
        senses = Senses.of(self.options.senses)
        self.senses = senses
        self._senses = SensesChange(senses, sim, players)
        # the observations as they are made; told at once, unless news are late
        self._late = LateNews(senses, self.observation) if any(senses.delays) else None
        self._now = self._late.now if self._late else self.observation
        self._begun = False
        self._memories: Memories | None = None
        if {"memory", "normalised"} & {*self.include} or self.options.observation in REMEMBERED:
            active = np.isin(np.arange(1, PLAYERS + 1), players)
            self._memories = self.macros.memories if self.macros else Memories(sim, active, task.full_state)
            self._records = self._memories.records
        # percepts of a block of worlds: made, used and overwritten while they are in the cache
        self._block = min(worlds, BLOCK * threads)
        self._see, self._body = new_see(self._block), new_body(self._block)
        told = {*self.include, *(self.played.include if self.played else ())}
        self._hear = new_hear(self._block, HEARD) if "hear" in told else None
        self._marks = new_landmarks(self._block) if {"landmarks", "lines"} & told else None
        self.see_changes: list[Callable[[See, np.ndarray], None]] = []
        self._omniscient = self.options.observation == "full" and not (self.scripted or self.played or self.macros or self._memories)
        self._commands = sim.commands
        # a view of the simulator's own array, which stays the same one
        self._ball = sim.world["pos"][:, 0]
        self.reward = Reward(self.options.reward, self.options.reward_gamma, task.terms, task.shaping)
        self.reward.prepare(worlds, len(self.agents))
        self.term_keys = tuple((term, f"reward_{term}") for term in self.reward.terms)
        self.preset = Preset(self, self.options.observation, self.options.flatten, space, task.task_features)
        self.output: dict[str, np.ndarray] | np.ndarray = self.observation

    def simulator(self, task: Task, worlds: int, seed: int, first_world: int, threads: int) -> Simulator:
        """The simulator that plays; called once, when the engine is made."""
        goalies = (task.left_goalie if task.left_goalie <= task.left else 0, task.right_goalie if task.right_goalie <= task.right else 0)
        if self.options.backend:
            from ..client.remote import RemoteSimulator

            if worlds != 1:
                raise ParameterError(f"backend {self.options.backend!r}: a server plays 1 world, {worlds} were asked for")
            self._rehearse()
            return RemoteSimulator(self.options.backend, task.left, task.right, goalies)
        return Simulator(
            worlds,
            parameters=task.parameters,
            seed=seed,
            first_world=first_world,
            rules=task.rules,
            threads=threads,
            left=task.left,
            right=task.right,
            goalies=goalies,
        )

    def _rehearse(self) -> None:
        """Play a cycle in process, so that no server waits while kernels are loaded or compiled."""
        core = SoccerCore(replace(self.options, backend=""), 1)
        core.reset(0)
        if core.action_mask is not None:
            core.step(core.action_mask.argmax(axis=-1))
            return
        action, agents = batch_of_one(copy.deepcopy(core.view.space).sample()), len(core.agents)
        if isinstance(action, dict):
            core.step({key: np.repeat(value, agents, axis=1) for key, value in action.items()})
        else:
            core.step(np.repeat(action, agents, axis=1))

    def _others(
        self, others: OtherPlayer | Sequence[OtherPlayer], counts: tuple[int, int]
    ) -> tuple[ScriptedPlayers | None, ControlledPlayers | None]:
        """The scripted players, and those whom controllers play; None where there are none, or they do nothing."""
        sides = (others, others) if isinstance(others, str) or callable(others) else several("others", others)
        if len(sides) != 2:
            raise UnknownName(f"others: expected one player or one for each side, got {others!r}")
        found = [other_player(side) for side in sides]
        free = [player_number(a) for a in agent_names(*counts) if a not in self.agents]
        policies = {p: found[0] if p <= 11 else found[1] for p in free}
        scripted = {p: policy for p, policy in policies.items() if isinstance(policy, str)}
        played = {p: policy for p, policy in policies.items() if not isinstance(policy, str)}
        acting = any(name != "hold" for name in scripted.values())
        task = self.task
        return (
            ScriptedPlayers(self.sim, scripted, counts, task.region, task.full_state, task.mix) if acting else None,
            ControlledPlayers(self, task, played) if played else None,
        )

    @property
    def action_mask(self) -> np.ndarray | None:
        """(W, A, macros) bool: what can be done now, for the macro view; otherwise None."""
        return None if self.macros is None else self.macros.mask

    # ------------------------------------------------------------------ spaces

    def observation_space(self) -> gym_spaces.Space[Any]:
        """Space of one agent's observation."""
        return copy.deepcopy(self.preset.space)

    # ------------------------------------------------------------------ the cycle

    def reset(
        self,
        seed: int | Sequence[int | np.random.SeedSequence | None] | None = None,
        worlds: np.ndarray | None = None,
        *,
        start: Any = None,
        state: Mapping[str, np.ndarray] | None = None,
    ) -> dict[str, np.ndarray]:
        """Start new episodes.

        Parameters
        ----------
        seed : int or sequence of int or SeedSequence, optional
            Seeds all streams of the worlds anew; without it they go on. One number for each chosen world: each is then what a single
            world with that seed is; None in it lets a world go on. World k of a batch with a seed is that of
            ``SeedSequence(seed, spawn_key=(k,))``.
        worlds : (W,) bool or (n,) int array, optional
            Which worlds; all if not given.
        start : mapping, optional
            Where ball and players shall be instead (`Pitch.start_at`).
        state : mapping, optional
            Of `save_state`: the episodes go on from it.

        Returns
        -------
        dict of array
            The observations of all worlds.

        Raises
        ------
        ParameterError
            When `worlds`, `seed`, `start` or `state` is none.
        CprmError
            When the first reset leaves worlds out.
        """
        chosen = np.arange(self.worlds) if worlds is None else np.asarray(worlds)
        if chosen.dtype == bool and chosen.shape == (self.worlds,):
            chosen = np.flatnonzero(chosen)
        elif chosen.ndim != 1 or (chosen.size and chosen.dtype.kind not in "iu"):
            raise ParameterError(f"worlds: expected ({self.worlds},) bool or a list of indices, got {chosen.dtype} of shape {chosen.shape}")
        if not self._begun and len(np.unique(chosen)) < self.worlds:
            raise CprmError("reset of some worlds before the others have begun: the first reset takes all worlds")
        chosen = chosen.astype(np.int64, copy=False)
        if state is not None:
            if start is not None:
                raise ParameterError("reset: start and state given; one of them says where the episode begins")
            self.load_state(state, chosen)
            if seed is not None:
                self.sim.world["key"][chosen] = stream_keys(seed, chosen, self.sim.first_world)  # type: ignore[arg-type]
            return self.observation
        if len(chosen):
            self._seed(seed, chosen)
            self.task.setup(self, chosen)
            if start is not None:
                self.start_at(chosen, start)
            self._begin(chosen)
        self._begun = True
        return self._open(chosen)

    def _open(self, chosen: np.ndarray) -> dict[str, np.ndarray]:
        """The first observations of episodes that begin, for the agents and for who else decides by them."""
        observation = self.observe(fresh_start=chosen)
        if self.played is not None and len(chosen):
            self.played.begin(chosen)
        return observation

    def enter(self) -> dict[str, np.ndarray]:
        """Begin episodes where everything stands, without the task's start: for worlds that others keep (`cprm_gym.joining`)."""
        chosen = np.arange(self.worlds)
        self._begin(chosen)
        self._begun = True
        return self._open(chosen)

    def _begin(self, chosen: np.ndarray) -> None:
        """Forget everything of earlier episodes."""
        begin(
            self.sim.world, chosen, self.cycle, self.late, self.previous_ball, self.memory, self._score, self._now["age"], MAX_AGE,
            self._commands, NO_COMMAND, self.preset.kicks, self.preset.drawn,
        )  # fmt: skip
        self._senses.begin(chosen)
        self.reward.begin(self, chosen)
        if self.scripted is not None:
            self.scripted.reset(chosen)
        if self.played is not None:
            self.played.forget(chosen)
        if self.macros is not None:
            self.macros.reset(chosen)
        elif self._memories is not None:
            self._memories.forget(chosen)

    def _seed(self, seed: int | Sequence[int | np.random.SeedSequence | None] | None, chosen: np.ndarray) -> None:
        """Put the worlds into the state before an episode, with new streams where there is a seed."""
        if seed is None or isinstance(seed, (int, np.integer)):
            self.sim.reset(seed=seed, worlds=chosen)
            return
        if isinstance(seed, str) or not isinstance(seed, (Sequence, np.ndarray)) or len(seed) != len(chosen):
            raise ParameterError(f"seed: expected a whole number of at least 0, or {len(chosen)} of them, got {seed!r:.60}")
        given = [k for k, one in enumerate(seed) if one is not None]
        for k in given:
            one = seed[k]
            if isinstance(one, np.random.SeedSequence):
                continue
            if isinstance(one, bool) or not isinstance(one, (int, np.integer)) or one < 0:
                raise ParameterError(f"seed: entry {k} is {one!r}; expected a whole number of at least 0, or None")
        rest = np.delete(chosen, given)
        if len(rest):
            self.sim.reset(worlds=rest)
        if given:
            # each as world 0 of its own seed
            seeds = [one if isinstance(one, np.random.SeedSequence) else np.random.SeedSequence(int(one), spawn_key=(0,))  # type: ignore[arg-type]
                     for one in (seed[k] for k in given)]  # fmt: skip
            self.sim.reset(seed=seeds, worlds=chosen[given])

    def check(self, action: Any) -> None:
        """Refuse what is no action of one agent.

        Raises
        ------
        CommandError
            When the action does not fit the view; the message names the entry.
        """
        if self.macros is None:
            self.view.commands(batch_of_one(action), np.zeros((1, 1), COMMAND))
        elif not self.view.space.contains(action):
            names = self.macros.names
            raise CommandError(f"action 'macro': {action!r:.60} is none; allowed are 0 to {len(names) - 1}: {', '.join(names)}")

    def commanded(self, action: Any) -> np.ndarray:
        """(W, 22) commands that the actions mean, without playing them; `observe` then looks at what came of them."""
        if self.macros is not None:
            self.macros.act(self.task.decide(self.macros.names, self.macros.mask, action), self._commands)
        elif self.agents:
            self.view.commands(action, self._commands, self._rows)
        return self._commands

    def step(self, action: Any) -> Step:
        """Play one cycle in every world.

        Parameters
        ----------
        action : dict of array or array
            Actions of the view, leading shape (W, A).

        Raises
        ------
        CprmError
            Before the first `reset`.
        CommandError
            When the actions do not fit the view.
        """
        self.advance(action)
        late = self.late
        any_late = pitch_kernels.tally(self.sim.world, self.max_cycles, self.cycle, self._score, self._gained, late)
        outcome = self.task.outcome(self)
        if not self.reward.plain:
            outcome = self.reward.apply(self, outcome)
        self.observe()
        status, truncated = outcome.status, late.copy()
        if any_late:
            truncated &= ~outcome.terminated
            status = np.where(truncated, OUT_OF_TIME, status)
        return Step(outcome.reward, outcome.terminated, truncated, outcome.success, status, outcome.terms)

    def advance(self, action: Any) -> None:
        """The worlds go on by a cycle, and that is all of it: nothing is judged, nothing told (`step` does both).

        Raises
        ------
        CprmError, CommandError
            As for `step`.
        """
        if not self._begun:
            raise CprmError("step before reset: call reset() first")
        self.commanded(action)
        if self.scripted is not None:
            self.scripted.act(self._commands)
        if self.played is not None:
            self.played.act(self._commands)
        self.previous_ball[...] = self._ball
        self.sim.step(self._commands)

    def observe(self, fresh_start: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """Fill `observation` from the senses.

        Parameters
        ----------
        fresh_start : (n,) int array, optional
            Worlds that have just started: their eyes are open now, and nothing ages.
        """
        chosen = self.every if fresh_start is None else fresh_start
        if fresh_start is not None:
            pitch_kernels.open_eyes(self.sim.world, fresh_start)
        for first in range(0, len(chosen), self._block):
            self._perceive(chosen[first : first + self._block], fresh_start is not None)
        o = self._now
        if self.macros is not None:
            self.task.restrict(self.macros.names, self.macros.mask)
            if "action_mask" in o:
                o["action_mask"][...] = self.macros.mask
        if "task" in o:
            self.task.features(self, o["task"])
            if self._normal is not None:
                self._normal.add_task(o["task"], o["normalised"])
        if self.played is not None:
            self.played.look(self.max_cycles)
        if self._late is not None:
            self._late.tell(fresh_start, MAX_AGE)
        self.output = self.preset(self, chosen)
        return self.observation

    def _perceive(self, chosen: np.ndarray, begins: bool) -> None:
        """Senses, memories, observations and feature vectors of some worlds, (n,); `begins`: their episodes do."""
        # where everybody is told the truth and nobody remembers, nobody looks
        see = self._see if self._omniscient and not self.see_changes else self.sim.see(self._see, chosen)
        for change in self.see_changes:
            change(see, chosen)
        if self._senses.rereads:
            self._senses.reread(see, chosen, self.cycle)
        body = self.sim.sense_body(self._body, chosen)
        marks = None if self._marks is None else self.sim.landmarks(self._marks, chosen)
        heard = None if self._hear is None else self.sim.hear(self._hear, chosen)
        sensed = Sensed(chosen, see, body, marks, heard, begins)
        if self.scripted is not None:
            self.scripted.perceive(see, body, self._commands, chosen)
        if self.played is not None:
            self.played.perceive(sensed, self._commands)
        if self.macros is not None:
            self.macros.observe(see, body, self._commands, chosen)
        elif self._memories is not None:
            self._memories.update(see, body, self._commands, chosen)
        tell(self, sensed, None if self._memories is None else self._memories.records, self._now)
        if self.preset.name == "full":
            see_everything(self, chosen)
        if self._normal is not None:
            self._normal.write(self, chosen, self.remembered(), self._now["normalised"])
        self.preset.fill(self, chosen)

    def close(self) -> None:
        """Leave the server, if it is played on one."""
        leave = getattr(self.sim, "close", None)
        if leave is not None:
            leave()

    # ------------------------------------------------------------------ the truth, for oracles

    def truth(self, agent: str) -> dict[str, np.ndarray]:
        """``self``, ``memory`` and ``memory_age``, each (W, ...), as one of `agents` would have them if he knew everything."""
        if agent not in self.agents:
            raise unknown_name("agent", agent, self.agents)
        return true_memory(self.sim, player_number(agent))

    @property
    def mixes(self) -> bool:
        """Whether there are players of the policy ``mixing``, whose modes `intentions` tells."""
        return self.scripted is not None and self.scripted.mixing is not None

    def intentions(self) -> np.ndarray:
        """(W, 22) hidden `Mode` of every scripted player who mixes, -1 of all others; truth that no observation tells."""
        if self.scripted is None or self.scripted.mixing is None:
            return np.full((self.worlds, PLAYERS), NOBODY)
        return self.scripted.mixing.modes

    def branch(self, into: SoccerCore | None = None) -> SoccerCore:
        """Another engine in the same state, in which a future can be tried; `into`, an earlier one, is used again."""
        other = SoccerCore(self.options, self.worlds, first_world=self.sim.first_world) if into is None else into
        other.max_cycles = self.max_cycles
        other.load_state({"world": self.sim.world, "max_cycles": self._limit(), **self._state(), **self.reward.save_state()})
        return other

    # ------------------------------------------------------------------ saved states

    def save_state(self, world: int | None = None) -> dict[str, np.ndarray]:
        """Everything that decides how the episodes go on, as arrays with the worlds first: `load_state` takes it, ``np.savez`` keeps it.

        Parameters
        ----------
        world : int, optional
            Only this one; all if not given.

        Raises
        ------
        ParameterError
            When there is no such world.
        """
        if world is not None:
            if isinstance(world, bool) or not isinstance(world, (int, np.integer)) or not 0 <= world < self.worlds:
                raise ParameterError(f"save_state: no world {world!r} among {self.worlds}")
            rows = slice(world, world + 1)
            own = {name: values[rows].copy() for name, values in self._state().items()}
            reward = {name: values[rows] for name, values in self.reward.save_state().items()}
            return {"world": self.sim.world[rows].copy(), "max_cycles": self._limit()[rows], **own, **reward}
        own = {name: values.copy() for name, values in self._state().items()}
        return {"world": self.sim.snapshot(), "max_cycles": self._limit(), **own, **self.reward.save_state()}

    def _limit(self) -> np.ndarray:
        """(W,) cycles after which each episode is out of time."""
        return np.full(self.worlds, self.max_cycles, np.int64)

    def load_state(self, state: Mapping[str, np.ndarray], worlds: np.ndarray | None = None) -> None:
        """Go on from a state of `save_state`, of this or of another engine with the same options.

        Parameters
        ----------
        state : mapping
            Of as many worlds as here, or of one, from which then all go on.
        worlds : (n,) int array, optional
            Which worlds; all if not given.

        Raises
        ------
        ParameterError
            When it is the state of other options or another number of worlds.
        """
        chosen = np.arange(self.worlds) if worlds is None else np.asarray(worlds, np.int64)
        live = self._state()
        if not isinstance(state, Mapping) or not {"world", "max_cycles", *live} <= set(state):
            raise ParameterError("state: expected what save_state gives of an environment with the same options")
        count = len(state["world"])
        for name, values in live.items():
            if state[name].dtype != values.dtype or state[name].shape[1:] != values.shape[1:] or count not in (1, self.worlds):
                given, here = (f"{a.dtype} of shape {a.shape}" for a in (state[name], values))
                raise ParameterError(f"state: {name!r} is {given}, here {here}: the state of other options or another number of worlds")
        if np.any(np.asarray(state["max_cycles"]) != self.max_cycles):
            limit = int(np.asarray(state["max_cycles"]).flat[0])
            raise ParameterError(f"state: of an environment with max_cycles={limit}, here {self.max_cycles}")
        rows = chosen if count == self.worlds else np.zeros(len(chosen), np.int64)
        if worlds is None and count == self.worlds:
            self.sim.restore(state["world"])
            for name, values in live.items():
                _copy(state[name], values)
        else:
            self.sim.restore(state["world"][rows], chosen)
            for name, values in live.items():
                values[chosen] = state[name][rows]
        self.reward.load_state(state, chosen, rows)
        self._begun = True

    def _state(self) -> dict[str, np.ndarray]:
        """The engine's own arrays beside the simulator's worlds, by name."""
        arrays = {
            "cycle": self.cycle, "late": self.late, "counters": self.memory, "previous_ball": self.previous_ball, "score": self._score,
            "gained": self._gained, "commands": self._commands, "kicks": self.preset.kicks,
            "drawn": self.preset.drawn,
        }  # fmt: skip
        arrays |= {f"observation/{name}": values for name, values in self.observation.items()}
        if not self.preset.plain:
            arrays["output"] = self.preset.vector
        if self._late is not None:
            arrays |= self._late.state()
        if self.macros is not None:
            arrays |= {"macros": self.macros.memories.records, "mask": self.macros.mask, "macros/fresh": self.macros.fresh}
        elif self._memories is not None:
            arrays["memories"] = self._memories.records
        if self.scripted is not None and self.scripted.memories is not None:
            arrays |= {"scripted": self.scripted.memories.records, "scripted/fresh": self.scripted.fresh}
        if self.scripted is not None and self.scripted.mixing is not None:
            arrays["intents"] = self.scripted.mixing.intents
        if self.played is not None:
            arrays |= self.played.state()
        return arrays
