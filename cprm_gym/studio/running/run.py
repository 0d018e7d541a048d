"""One world that is played cycle by cycle, and can be taken back."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...agents.play import agent_in
from ...architecture.prm import Grounding
from ...architecture.prm.inference.engines.exact import ExactEngine
from ...envs.controller import Action, Controller, check_action
from ...envs.core import SoccerCore, select_agents
from ...envs.tasks import Status, Task
from ...errors import CprmError, ParameterError
from ...wrappers.disturbances import DISTURBANCES, Disturber
from .changes import Change, Hands
from .memory import Remembered, can_keep, keep, put, runner_of
from .setup import Setup

TROUBLE = "TROUBLE"
"""Status of a run in which a player could not decide."""
KEPT = 400
"""Cycles back to which a run goes at once; further back it is played anew from the start."""


class Moment(NamedTuple):
    """All that decides how a run goes on, before the players decide."""

    world: dict[str, np.ndarray]
    players: list[Remembered]
    disturber: tuple[np.ndarray, ...] | None
    ended: tuple[str, bool] | None


def make_players(setup: Setup, task: Task) -> list[Controller]:
    """The players of a setup's agents, who keep what fires, play with changed nets, and share what inference compiles.

    Raises
    ------
    ParameterError
        When nobody plays with a net or model that was changed.
    """
    players: list[Controller] = [setup.player(task, name) for name in select_agents(task.controlled, task.left, task.right)]
    shared: dict[Any, dict[str, Any]] = {}
    used: set[str] = set()
    for player in filter(None, map(agent_in, players)):
        player.options["trace"] = True
        net = setup.nets.get(player.cprm.net.name)
        if net is not None:
            used.add(player.cprm.net.name)
            player.cprm = replace(player.cprm, net=net)
        model = None if player.cprm.model is None else setup.models.get(player.cprm.model.name)
        if model is not None:
            used.add(model.name)
            player.cprm = replace(player.cprm, model=model)
        cprm = player.cprm
        plain = cprm.model is not None and not cprm.separate and not cprm.references
        if plain and cprm.model is not None and not {"engine", "grounding", "deep"} & set(player.options):
            key = (id(cprm.model), tuple(cprm.objects.items()))
            if key not in shared:
                shared[key] = {"engine": ExactEngine(), "grounding": Grounding(cprm.model, cprm.objects)}
            player.options |= shared[key]
    for kind, given in (("net", setup.nets), ("model", setup.models)):
        if unused := set(given) - used:
            raise ParameterError(f"nobody in {setup.task} plays with a {kind} called {', '.join(sorted(unused))}")
    return players


def needs_of(players: Iterable[Controller]) -> tuple[str, ...]:
    """Parts of the observation that players read, but the memory."""
    return tuple(dict.fromkeys(part for player in players for part in getattr(player, "needs", ()) if part != "memory"))


class Run:
    """A world and its players.

    Parameters
    ----------
    setup : Setup

    Attributes
    ----------
    cycle : int
        Of the episode; the players have decided in it.
    agents : tuple of str
    players : list of Controller
    status : str
        Name of `Status`.
    success : bool
    over : bool
        Nothing comes after this cycle.
    struck : int
        Cycle in which the disturbance came, -1 before.
    trouble : str
        Why a player could not decide in this cycle; the run is over then.
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        task = self.task = setup.made()
        if setup.controller:
            self.players: list[Controller] = make_players(setup, task)
            self.core = SoccerCore(task, 1, seed=setup.seed, first_world=setup.world, include=("memory", *needs_of(self.players)))
        else:
            others = task.others
            sides = (others, others) if isinstance(others, str) else tuple(others)
            self.players = []
            sides = tuple("medium" if side == "hold" else side for side in sides)
            self.core = SoccerCore(task, 1, seed=setup.seed, first_world=setup.world, controlled=(), others=sides)
        self.agents = self.core.agents
        for agent, player in zip(self.agents, self.players):
            connect = getattr(player, "connect", None)
            if connect is not None:
                connect(self.core, agent)
        self.disturber = None if setup.disturbance is None else Disturber(self.core, DISTURBANCES[setup.disturbance], setup.seed)
        self.hands = Hands(self.core, self.players)
        self._moments: OrderedDict[int, Moment] = OrderedDict()
        self.begin()

    def about(self) -> dict[str, Any]:
        """What does not change from cycle to cycle, for a page."""
        return {
            **self.setup.said(),
            "agents": list(self.agents),
            "counts": list(self.core.counts),
            "region": list(self.task.region),
            "max_cycles": int(self.task.max_cycles),
            "goal_width": float(self.core.parameters.goal_width),
            "keepable": self.keepable,
            "recorded": None,
        }

    # ------------------------------------------------------------------ the course

    def begin(self) -> None:
        """The first cycle."""
        self.core.reset(self.setup.seed)
        self.status, self.success, self.over, self.struck = Status.IN_GAME.name, False, False, -1
        for i, player in enumerate(self.players):
            player.reset(self._seen(i), self.setup.seed)
        if self.disturber is not None:
            self.disturber.reset()
        self._moments.clear()
        self._decide()

    def _seen(self, i: int) -> dict[str, np.ndarray]:
        return {key: value[:, i] for key, value in self.core.observation.items()}

    @property
    def cycle(self) -> int:
        """Of the episode."""
        return int(self.core.cycle[0])

    def _decide(self, remember: bool = True) -> None:
        """The players look and decide."""
        if remember:
            self._remember()
        self.actions: list[Action] = []
        """What each player has decided."""
        self.trouble = ""
        if self.over:
            return
        try:
            self.actions = [self._act(i) for i in range(len(self.players))]
        except CprmError as error:  # of a net that goes on without end, say: the run stands here, and can be asked
            self.actions, self.trouble, self.over, self.status = [], str(error), True, TROUBLE

    def _act(self, i: int) -> Action:
        """One of them."""
        player = self.players[i]
        runner = runner_of(player)
        if runner is not None and runner.executor.trace is not None:
            runner.executor.trace.clear()
        with self.hands.over(i):
            return check_action(self.agents[i], player.act(self._seen(i)), 1)

    def advance(self) -> None:
        """Carry out what was decided, and let the players decide anew.

        Raises
        ------
        CprmError
            When the episode is over.
        """
        if self.over:
            why = f": {self.trouble}" if self.trouble else ""
            raise CprmError(f"{self.setup.task}: the episode is over in cycle {self.cycle}{why}; go back, or begin anew")
        if self.disturber is not None:
            self.disturber()
            self.struck = int(self.disturber.struck[0])
        self.hands.touch()
        action = {key: np.stack([a[key] for a in self.actions], axis=1) for key in self.actions[0]} if self.actions else None
        step = self.core.step(action)
        self.over = bool(step.terminated[0] or step.truncated[0])
        if self.over:
            self.status, self.success = Status(int(step.status[0])).name, bool(step.success[0].any())
        self._decide()

    # ------------------------------------------------------------------ back

    @property
    def keepable(self) -> bool:
        """Whether moments are kept; else going back means to play from the start."""
        return all(can_keep(player) for player in self.players)

    def _remember(self) -> None:
        if not self.keepable:
            return
        disturber = self.disturber
        self._moments[self.cycle] = Moment(
            self.core.save_state(),
            [keep(player) for player in self.players],
            None if disturber is None else (disturber.struck.copy(), disturber._now.copy(), disturber._cycle.copy()),
            (self.status, self.success) if self.over else None,
        )
        while len(self._moments) > KEPT:
            self._moments.popitem(last=False)

    def moment(self, cycle: int) -> Moment | None:
        """What was before the players decided in a cycle, if it is kept."""
        return self._moments.get(cycle)

    def go_to(self, cycle: int, told: Callable[[int], object] = lambda cycle: None) -> None:
        """Stand in another cycle: an earlier one, as it was, or a later one, as it will be.

        Parameters
        ----------
        cycle : int
        told : callable
            Of every cycle that is played on the way.

        Raises
        ------
        ParameterError
            For a cycle before the first.
        """
        if isinstance(cycle, bool) or not isinstance(cycle, int) or cycle < 0:
            raise ParameterError(f"cycle: a whole number from 0 is needed, got {cycle!r}")
        if cycle < self.cycle:
            moment = self._moments.get(cycle)
            self.hands.rewind(cycle)
            if moment is None:
                self.begin()
            else:
                self._put(moment)
        while self.cycle < cycle and not self.over:
            self.advance()
            told(self.cycle)

    def _put(self, moment: Moment, forget: bool = True) -> None:
        self.core.load_state(moment.world)
        for player, kept in zip(self.players, moment.players):
            put(player, kept)
        if self.disturber is not None and moment.disturber is not None:
            struck, now, cycle = moment.disturber
            self.disturber.struck, self.disturber._now, self.disturber._cycle = struck.copy(), now.copy(), cycle.copy()
            self.struck = int(struck[0])
        self.over = moment.ended is not None
        self.status, self.success = moment.ended or (Status.IN_GAME.name, False)
        for later in [c for c in self._moments if c > self.cycle and forget]:
            del self._moments[later]
        self._decide(remember=forget)

    @contextmanager
    def standing_in(self, cycle: int) -> Iterator[None]:
        """Stand in an earlier cycle for a while, to ask.

        Raises
        ------
        CprmError
            When it is not kept.
        """
        now = self.cycle
        if cycle == now:
            yield
            return
        there, back = self._moments.get(cycle), self._moments.get(now)
        if there is None or back is None:
            raise CprmError(f"cycle {cycle} is not kept, and cannot be asked; go back to it first")
        self._put(there, forget=False)
        try:
            yield
        finally:
            self._put(back, forget=False)

    def visit(self, cycles: Iterable[int]) -> Iterator[int]:
        """Stand in one cycle after the other, of those that are kept, and then again where it stood."""
        now, moved = self.cycle, False
        back = self._moments.get(now)
        try:
            for cycle in cycles:
                there = self._moments.get(cycle)
                if cycle != self.cycle:
                    if there is None or back is None:
                        continue
                    self._put(there, forget=False)
                    moved = True
                yield cycle
        finally:
            if moved and back is not None:
                self._put(back, forget=False)

    def without(self, i: int, lost: Iterable[Collection[str]], read: Callable[[], Any]) -> list[Any]:
        """What a player's belief would be in this cycle, had his model not been told some readings.

        Parameters
        ----------
        i : int
            Which player.
        lost : iterable of collections of str
            For each answer, the variables whose readings are kept from the model.
        read : callable
            What is asked, after the player has decided.

        Raises
        ------
        CprmError
            When this cycle is not kept, or the player is of another kind.
        """
        player, moment = self.players[i], self._moments.get(self.cycle)
        runner = runner_of(player)
        if moment is None or runner is None or self.over:
            raise CprmError(f"{self.agents[i]}: what would be without a reading can be told of players with nets and models of ours alone")
        found = []
        try:
            for names in lost:
                put(player, moment.players[i])
                with self.hands.over(i):
                    runner.withheld |= frozenset(names)
                    player.act(self._seen(i))
                    runner.withheld = frozenset()
                found.append(read())
        finally:
            put(player, moment.players[i])
            self._act(i)
        return found

    # ------------------------------------------------------------------ by hand

    def change(self, change: Change) -> None:
        """Change something by hand, from this cycle on (`changes.Hands`)."""
        self.hands.take(change)
