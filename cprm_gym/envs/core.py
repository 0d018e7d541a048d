"""Many worlds of one task at once: the engine under every environment face.

`SoccerCore` owns a `Simulator`, turns actions into commands, senses into observation arrays and asks the `Task` what it means.
The Gymnasium, vector and PettingZoo faces only translate between it and their libraries.
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces as gym_spaces

from ..errors import CommandError, CprmError, ParameterError, UnknownName, did_you_mean, unknown_name
from ..simulator.senses import BodyColumn, See, new_body, new_hear, new_see
from ..simulator.simulator import Simulator
from ..simulator.state import COMMAND, LEFT, PLAYERS, RIGHT, Stream
from .actions import MACRO, NO_COMMAND, ActionView, action_view
from .kernels import observations as kernels
from .kernels import pitch as pitch_kernels
from .observations import HEARD, INCLUDES, MAX_AGE, observation_space
from .players.macros import Macros
from .players.memory import Memories
from .players.scripted import POLICIES, ScriptedPlayers
from .presets import VECTORS, Preset, check_preset, see_everything
from .rewards import Reward, RewardOption
from .tasks.base import Task

_COLUMNS = np.array(
    [
        BodyColumn.STAMINA, BodyColumn.EFFORT, BodyColumn.CAPACITY, BodyColumn.SPEED, BodyColumn.SPEED_DIRECTION, BodyColumn.HEAD_ANGLE,
        BodyColumn.VIEW_WIDTH, BodyColumn.TACKLE_EXPIRES, BodyColumn.FOUL_CHARGED, BodyColumn.HIT_BALL, BodyColumn.HIT_PLAYER,
        BodyColumn.HIT_POST,
    ]
)  # fmt: skip
"""What the server tells of the body, in the order of the first entries of `BodyFeature`."""


POST_RADIUS = 0.06
"""Of the goal posts, m (specification/simulator.md 3.3)."""


class Step(NamedTuple):
    """What one cycle gave, for every world and agent."""

    reward: np.ndarray
    """(W, A) float64."""
    terminated: np.ndarray
    """(W,) bool."""
    truncated: np.ndarray
    """(W,) bool: out of time and not terminated."""
    success: np.ndarray
    """(W,) bool."""
    status: np.ndarray
    """(W,) int: index into ``task.statuses``."""
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
    for part in _several("agents", controlled):
        group = {"all": names, "left": names[:left], "right": names[left:]}.get(part, (part,) if part in names else None)
        if not group:
            allowed = ("all", "left", "right", *names)
            hint = "" if part in allowed else did_you_mean(str(part), allowed)
            raise UnknownName(f"agents: {part!r} names no player here.{hint} Allowed: {', '.join(allowed)}.")
        chosen.update(group)
    return tuple(n for n in names if n in chosen)


def _several(name: str, given: Any) -> tuple[Any, ...]:
    """The members of a sequence; an error that names the argument for what is none."""
    if not isinstance(given, Iterable):
        raise UnknownName(f"{name}: expected a string or a sequence of strings, got {type(given).__name__} {given!r:.60}")
    return tuple(given)


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


class SoccerCore:
    """A batch of worlds that play one task.

    Parameters
    ----------
    task : Task
        What is played.
    worlds : int
        How many worlds, W.
    controlled : str or sequence of str, optional
        Who acts; the task's default if not given. The others are scripted. An empty sequence: everybody is scripted, `step(None)`.
    view : str
        Action view: ``hybrid``, ``discrete``, ``box`` or ``macro``.
    others : str or (str, str), optional
        Policy of the players not controlled, or one for each side; the task's own if not given.
    include : str or sequence of str
        Further parts of the observation: ``memory``, ``landmarks``, ``hear`` (`observation_space`).
    observation : str
        Preset of what the agents get (`cprm_gym.envs.presets.PRESETS`).
    flatten : bool
        Give each agent one vector instead of a dict.
    reward : RewardOption
        Instead of, or added to, the task's own (`cprm_gym.envs.rewards`).
    reward_gamma : float
        Discount of the shaping terms.
    seed : int
        Seed of all worlds; world k depends on (seed, first_world + k) alone.
    first_world : int
        Number of the first world: ``SoccerCore(task, 1, first_world=k)`` is world k of a batch, bit for bit.
    threads : int
        Threads that share the worlds; results do not depend on it.

    Attributes
    ----------
    agents : tuple of str
        Controlled agents, A of them.
    sides : (A,) float array
        +1 for agents of the left team, -1 for the right one.
    memory : (W, 8) int array
        Counters that a task keeps between cycles; zero at the start of an episode.
    previous_ball : (W, 2) float array
        Where the ball was before the cycle just played.
    observation : dict of str to array
        Current observations, each (W, A, ...), float32; overwritten by `reset` and `step`.
    output : dict of str to array, or array
        What the preset makes of them; (W, A, ...) too.
    see_changes : list of callable
        Each is given what everybody sees (`See`) before anything is made of it, observations and memories alike, and may change it.
    """

    def __init__(
        self,
        task: Task,
        worlds: int = 1,
        *,
        controlled: str | Sequence[str] | None = None,
        view: str = "hybrid",
        others: str | Sequence[str] | None = None,
        include: str | Sequence[str] = (),
        observation: str = "raw",
        flatten: bool = False,
        reward: RewardOption = None,
        reward_gamma: float = 0.99,
        seed: int = 0,
        first_world: int = 0,
        threads: int = 1,
    ) -> None:
        self.task = task
        self.worlds = worlds
        self.include = (include,) if isinstance(include, str) else _several("include", include)
        for part in self.include:
            if part not in INCLUDES:
                raise unknown_name("part of an observation", part, INCLUDES)
        if check_preset(observation) == "memory" and "memory" not in self.include:
            self.include = ("memory", *self.include)
        if isinstance(task.max_cycles, bool) or not isinstance(task.max_cycles, (int, np.integer)) or task.max_cycles < 1:
            raise ParameterError(f"max_cycles: {task.max_cycles!r} given, a whole number of at least 1 is needed")
        self.sim = Simulator(
            worlds,
            parameters=task.parameters,
            seed=seed,
            first_world=first_world,
            rules=task.rules,
            threads=threads,
            left=task.left,
            right=task.right,
            goalies=(task.left_goalie if task.left_goalie <= task.left else 0, task.right_goalie if task.right_goalie <= task.right else 0),
        )
        self.agents = select_agents(task.controlled if controlled is None else controlled, task.left, task.right)
        self.players = np.array([player_number(a) for a in self.agents], np.int64)
        counts = (task.left, task.right)
        self.macros = Macros(self.sim, self.players, counts, task.region, task.full_state) if view == MACRO else None
        self.view = ActionView(MACRO, gym_spaces.Discrete(len(self.macros.names))) if self.macros else action_view(view)
        self.scripted = self._scripted_players(task.others if others is None else others, counts)
        self.cycle = np.zeros(worlds, np.int64)
        self.memory = np.zeros((worlds, 8), np.int64)
        self.previous_ball = np.zeros((worlds, 2))
        self._score = np.zeros((worlds, 2), np.int64)
        self.sides = np.where(self.players <= 11, 1.0, -1.0)
        self._gained = np.zeros((worlds, 2), np.int64)
        space = observation_space(task.task_features, self.include)
        shape = (worlds, len(self.agents))
        self.observation: dict[str, np.ndarray] = {
            name: np.zeros((*shape, *(part.shape or ())), np.float32) for name, part in space.items()
        }
        self._begun = False
        self._memories: Memories | None = None
        if "memory" in self.include or observation in VECTORS:
            active = np.isin(np.arange(1, PLAYERS + 1), self.players)
            self._memories = self.macros.memories if self.macros else Memories(self.sim, active, task.full_state)
        self._hear = new_hear(worlds, HEARD) if "hear" in self.include else None
        self._see, self._body = new_see(worlds), new_body(worlds)
        self.see_changes: list[Callable[[See], None]] = []
        self._commands = self.sim.commands
        self._rows = self.players - 1
        # a view of the simulator's own array, which stays the same one
        self._ball = self.sim.world["pos"][:, 0]
        self.reward = Reward(reward, reward_gamma)
        self.preset = Preset(self, observation, flatten, space)
        self.output: dict[str, np.ndarray] | np.ndarray = self.observation

    def _scripted_players(self, others: str | Sequence[str], counts: tuple[int, int]) -> ScriptedPlayers | None:
        """The scripted players, or None where every player is controlled or does nothing."""
        sides = (others, others) if isinstance(others, str) else _several("others", others)
        if len(sides) != 2:
            raise UnknownName(f"others: expected one policy or one for each side, got {others!r}")
        free = [player_number(a) for a in agent_names(*counts) if a not in self.agents]
        policies = {p: sides[0] if p <= 11 else sides[1] for p in free}
        for name in sides:
            if name not in POLICIES:
                raise unknown_name("scripted policy", str(name), POLICIES)
        if all(name == "hold" for name in policies.values()):
            return None
        return ScriptedPlayers(self.sim, policies, counts, self.task.region, self.task.full_state)

    @property
    def action_mask(self) -> np.ndarray | None:
        """(W, A, macros) bool: what can be done now, for the macro view; otherwise None."""
        return None if self.macros is None else self.macros.mask

    # ------------------------------------------------------------------ spaces

    def observation_space(self) -> gym_spaces.Space[Any]:
        """Space of one agent's observation."""
        return copy.deepcopy(self.preset.space)

    # ------------------------------------------------------------------ the cycle

    def reset(self, seed: int | None = None, worlds: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """Start new episodes.

        Parameters
        ----------
        seed : int, optional
            Seeds all streams of the worlds anew; without it they go on.
        worlds : (W,) bool or (n,) int array, optional
            Which worlds; all if not given.

        Returns
        -------
        dict of array
            The observations of all worlds.

        Raises
        ------
        ParameterError
            When `worlds` or `seed` is neither.
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
        if len(chosen):
            self.sim.reset(seed=seed, worlds=chosen)
            self.task.setup(self, chosen)
            self.cycle[chosen] = 0
            self.previous_ball[chosen] = self.sim.world["pos"][chosen, 0]
            self.memory[chosen] = 0
            self._score[chosen] = self.sim.world["score"][chosen]
            self.observation["age"][chosen] = MAX_AGE
            self._commands[chosen] = NO_COMMAND[0]
            self.reward.begin(self, chosen)
            self.preset.begin(self, chosen)
            if self.scripted is not None:
                self.scripted.reset(chosen)
            if self.macros is not None:
                self.macros.reset(chosen)
            elif self._memories is not None:
                self._memories.forget(chosen)
        self._begun = True
        return self.observe(fresh_start=chosen)

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
        if not self._begun:
            raise CprmError("step before reset: call reset() first")
        if self.macros is not None:
            self.macros.act(self.task.decide(self.macros.names, self.macros.mask, action), self._commands)
        elif self.agents:
            self.view.commands(action, self._commands, self._rows)
        if self.scripted is not None:
            self.scripted.act(self._see, self._body, self._commands)
        self.previous_ball[...] = self._ball
        self.sim.step(self._commands)
        late = np.empty(self.worlds, np.bool_)
        any_late = pitch_kernels.tally(self.sim.world, self.task.max_cycles, self.cycle, self._score, self._gained, late)
        outcome = self.task.outcome(self)
        if not self.reward.plain:
            outcome = self.reward.apply(self, outcome)
        self.observe()
        status = outcome.status
        if any_late:
            late &= ~outcome.terminated
            status = np.where(late, len(self.task.statuses) - 1, status)
        return Step(outcome.reward, outcome.terminated, late, outcome.success, status, outcome.terms)

    def observe(self, fresh_start: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """Fill `observation` from the senses.

        Parameters
        ----------
        fresh_start : (n,) int array, optional
            Worlds that have just started: their eyes are open now, and nothing ages.
        """
        if fresh_start is not None:
            pitch_kernels.open_eyes(self.sim.world, fresh_start)
        see = self.sim.see(self._see)
        for change in self.see_changes:
            change(see)
        body = self.sim.sense_body(self._body)
        o = self.observation
        kernels.pack(
            self.sim.world, self.players, _COLUMNS, see.fresh, see.ball, see.ball_level, see.players, see.players_level, body,
            fresh_start is None, MAX_AGE, o["body"], o["ball"], o["players"], o["level"], o["age"],
        )  # fmt: skip
        if self.macros is not None:
            self.macros.observe(see, body, self._commands, fresh_start)
            self.task.restrict(self.macros.names, self.macros.mask)
        elif self._memories is not None:
            self._memories.update(see, body, self._commands, fresh_start)
        if "memory" in o and self._memories is not None:
            kernels.pack_memory(self._memories.records, self.players, o["self"], o["memory"], o["memory_age"])
        if "landmarks" in o:
            marks = self.sim.landmarks()
            o["landmarks"][...] = marks.landmarks[:, self._rows]
            o["landmark_level"][...] = marks.level[:, self._rows]
        if "hear" in o:
            heard = self.sim.hear(self._hear)
            kernels.pack_hear(*heard[:6], self.players, o["hear"])
        if self.preset.name == "full":
            see_everything(self)
        if "task" in o:
            self.task.features(self, o["task"])
        self.output = self.preset(self)
        return o

    def remembered(self) -> np.ndarray:
        """(W, A) records of what the agents remember (`players.memory.MEMORY`).

        Raises
        ------
        UnknownName
            When nobody keeps a memory here.
        """
        if self._memories is None:
            raise UnknownName("no memory is kept here; ask for include=('memory',), a preset made from memory or the macro view")
        return np.asarray(self._memories.records[:, self._rows])

    # ------------------------------------------------------------------ what tasks use

    def draw(self, worlds: np.ndarray, count: int) -> np.ndarray:
        """`count` numbers in [0, 1) for each of the given worlds, (n, count), from their stream of resets."""
        return self.sim.uniforms(worlds, count, Stream.RESETS)

    def place_ball(self, worlds: np.ndarray, position: np.ndarray, velocity: np.ndarray | float = 0.0) -> None:
        """Put the ball of the given worlds at (n, 2) positions with (n, 2) velocities."""
        w = self.sim.world
        w["pos"][worlds, 0] = position
        w["vel"][worlds, 0] = velocity
        w["acc"][worlds, 0] = 0.0

    def place_player(self, worlds: np.ndarray, player: int, position: np.ndarray, body_deg: np.ndarray | float) -> None:
        """Put a player (object number) of the given worlds at rest at (n, 2) positions, looking in body direction (n,) degrees."""
        w = self.sim.world
        w["pos"][worlds, player] = position
        w["vel"][worlds, player] = 0.0
        w["acc"][worlds, player] = 0.0
        angle = np.deg2rad((np.asarray(body_deg) + 180.0) % 360.0 - 180.0)
        w["body"][worlds, player - 1] = angle
        w["body_staged"][worlds, player - 1] = angle
        w["neck"][worlds, player - 1] = 0.0
        w["neck_staged"][worlds, player - 1] = 0.0

    def crossed_goal_line(self, right: bool) -> np.ndarray:
        """(W,) bool: the ball went through the right (or left) goal in the cycle just played (specification/simulator.md 7.8)."""
        p = self.task.parameters
        line = 52.5 + p.ball_size
        now, before = self.sim.world["pos"][:, 0], self.previous_ball
        x, x0 = (now[:, 0], before[:, 0]) if right else (-now[:, 0], -before[:, 0])
        over = (x > line) & (x0 <= line)
        share = np.where(over, (line - x0) / np.where(over, x - x0, 1.0), 0.0)
        y = before[:, 1] + share * (now[:, 1] - before[:, 1])
        return over & (np.abs(y) <= p.goal_width / 2 + POST_RADIUS)

    def kickable(self, player: int) -> np.ndarray:
        """(W,) bool: the ball is within the player's reach (specification/simulator.md 3.6)."""
        out: np.ndarray = np.empty(self.worlds, np.bool_)
        pitch_kernels.kickable(self.sim.world, self.sim.packed, player, out)
        return out

    def goals_scored(self) -> np.ndarray:
        """(W, 2) goals of left and right in the cycle just played."""
        return self._gained

    def side(self, player: int) -> int:
        """+1 for left players, -1 for right ones."""
        return LEFT if player <= 11 else RIGHT

    def distance(self, first: int, second: int) -> np.ndarray:
        """(W,) distance between two objects, metres."""
        d = self.sim.world["pos"][:, first] - self.sim.world["pos"][:, second]
        return np.hypot(d[:, 0], d[:, 1])

    @property
    def time_left(self) -> np.ndarray:
        """(W,) cycles until the episode is truncated."""
        return self.task.max_cycles - self.cycle

    def heading(self, player: int) -> np.ndarray:
        """(W,) direction of the player's face, radians in [-pi, pi]."""
        w = self.sim.world
        face = w["body"][:, player - 1] + w["neck"][:, player - 1]
        return (face + math.pi) % (2 * math.pi) - math.pi
