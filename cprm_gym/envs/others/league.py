"""A league: earlier selves of a learner, and others, as opponents. Each world draws one of them at the start of each episode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...errors import ParameterError, UnknownName, unknown_name
from ..controller import Action, Controller, ControllerFactory, Observation, check_action, no_action
from ..tasks.base import Task
from .luck import WorldLuck
from .registry import load_controller

_SALT = 1_000_003
_WON, _PLAYED = 0, 1


class League:
    """Opponents among whom each episode draws one; given as ``others``, it makes their controllers.

    A training callback adds the learner as it is now (`add`) and tells how episodes ended (`tell`): against whom it loses it then plays
    more often, in the proportion ``(1 - share won) ** power`` (prioritised fictitious self-play).

    Parameters
    ----------
    members : mapping of str to (str or ControllerFactory), or sequence of str
        Who is in it from the start: controllers by name, or what makes them.
    needs : tuple of str
        Parts of the observation that members who join later need.
    most : int
        Members beyond this number: the earliest who were added leave; those of the start stay.
    power : float
        0 draws all members alike.

    Attributes
    ----------
    results : dict of str to (2,) int array
        Episodes that the learner won against each member, and all of them.

    Raises
    ------
    UnknownName, ParameterError
        For members that there are not, or numbers out of their range.

    References
    ----------
    Vinyals et al., Grandmaster level in StarCraft II using multi-agent reinforcement learning, Nature 575, 2019.
    """

    def __init__(
        self, members: Mapping[str, str | ControllerFactory] | tuple[str, ...] | list[str] = (), needs: tuple[str, ...] = (),
        most: int = 20, power: float = 2.0,
    ) -> None:  # fmt: skip
        if isinstance(most, bool) or not isinstance(most, (int, np.integer)) or most < 1:
            raise ParameterError(f"league: most: {most!r} given; allowed are whole numbers of at least 1")
        if isinstance(power, bool) or not isinstance(power, (int, float)) or not 0 <= power <= 100:
            raise ParameterError(f"league: power: {power!r} given; allowed are numbers from 0 to 100")
        if isinstance(members, str):
            raise UnknownName(f"league: expected several members, got the name {members!r}; write ({members!r},)")
        self.needs, self.most, self.power = tuple(needs), int(most), float(power)
        self.results: dict[str, np.ndarray] = {}
        self._factories: dict[str, ControllerFactory] = {}
        self._added: list[str] = []
        given = dict(members) if isinstance(members, Mapping) else {name: name for name in members}
        for name, member in given.items():
            self._join(name, member)

    @property
    def members(self) -> tuple[str, ...]:
        """Names of those who are in it."""
        return tuple(self._factories)

    def add(self, name: str, member: str | ControllerFactory) -> None:
        """Take in a member, such as the learner as it is now."""
        self._join(name, member)
        self._added.append(name)
        while len(self._factories) > self.most and len(self._added) > 1:
            del self._factories[self._added.pop(0)]

    def _join(self, name: str, member: str | ControllerFactory) -> None:
        if name in self.results:
            raise ParameterError(f"league: there is or was a member {name!r} already")
        if not isinstance(member, str) and not callable(member):
            raise UnknownName(f"league: {name!r}: expected a controller's name or a factory, got {type(member).__name__} {member!r:.60}")
        self._factories[name] = load_controller(member) if isinstance(member, str) else member
        self.results[name] = np.zeros(2, np.int64)

    def tell(self, members: np.ndarray, won: np.ndarray) -> None:
        """Episodes have ended.

        Parameters
        ----------
        members : (n,) array of str
            Against whom (`LeaguePlayer.opponents`).
        won : (n,) bool array
            Whether the learner won.
        """
        for name, victory in zip(members, won):
            if name not in self.results:
                raise unknown_name("member of the league", str(name), self.results)
            self.results[name] += (bool(victory), 1)

    def chances(self) -> np.ndarray:
        """(members,) probabilities with which they are drawn; a draw counts before anybody has played."""
        told = np.array([self.results[name] for name in self._factories], np.float64)
        weights = (1.0 - (told[:, _WON] + 0.5) / (told[:, _PLAYED] + 1.0)) ** self.power
        return np.asarray(weights / weights.sum())

    def factory(self, name: str) -> ControllerFactory:
        """What makes the controllers of a member."""
        return self._factories[name]

    def __call__(self, task: Task, agent: str) -> LeaguePlayer:
        """The controller of one player."""
        if not self._factories:
            raise ParameterError("league: it has no members; add one before the first episode")
        return LeaguePlayer(self, task, agent)


class LeaguePlayer:
    """One player whom in each world a member of the league plays; the players of one world have the same member.

    Parameters
    ----------
    league : League
    task : Task
    agent : str

    Attributes
    ----------
    opponents : (N,) array of str
        Who plays in each world.
    """

    def __init__(self, league: League, task: Task, agent: str) -> None:
        self.league, self.task, self.agent = league, task, agent
        self._controllers: dict[str, Controller] = {name: league.factory(name)(task, agent) for name in league.members}
        every = (*league.needs, *(part for c in self._controllers.values() for part in getattr(c, "needs", ())))
        self.needs: tuple[str, ...] = tuple(dict.fromkeys(every))
        self.opponents: np.ndarray = np.zeros(0, object)
        self._luck = WorldLuck(1)
        self._begun: set[str] = set()

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes whose luck follows from one seed."""
        count = len(observation["level"])
        self.begin(observation, np.random.SeedSequence(seed).generate_state(count, np.uint32).astype(np.int64), worlds)

    def begin(self, observation: Observation, seeds: np.ndarray, worlds: np.ndarray | None = None) -> None:
        """Begin episodes: each world draws its member."""
        count = len(observation["level"])
        chosen = np.ones(count, bool) if worlds is None or len(self.opponents) != count else np.asarray(worlds, bool)
        if len(self.opponents) != count:
            self.opponents, self._begun = np.full(count, "", object), set()
        self._luck.begin(seeds, _SALT, None if worlds is None else chosen)
        drawn = np.searchsorted(np.cumsum(self.league.chances()), self._luck.draw()[:, 0], side="right")
        names = np.array(self.league.members, object)[np.minimum(drawn, len(self.league.members) - 1)]
        self.opponents[chosen] = names[chosen]
        for name in dict.fromkeys(names[chosen].tolist()):
            mine = chosen & (self.opponents == name)
            controller = self._controller(name)
            first = name not in self._begun
            self._begun.add(name)
            if hasattr(controller, "begin"):
                controller.begin(observation, seeds, None if first else mine)
            else:
                controller.reset(observation, int(seeds[mine][0]) % 2**31, None if first else mine)

    def act(self, observation: Observation) -> Action:
        """Actions: of each member in its worlds. A member who plays in one world looks at all of them."""
        count = len(self.opponents)
        action: dict[str, Any] = no_action(count)
        for name in dict.fromkeys(self.opponents.tolist()):
            mine = self.opponents == name
            theirs = check_action(name, self._controller(name).act(observation), count)
            for key, value in action.items():
                value[mine] = np.asarray(theirs[key])[mine]
        return action

    def _controller(self, name: str) -> Controller:
        """The member's controller of this player, made when it is first drawn."""
        if name not in self._controllers:
            made = self.league.factory(name)(self.task, self.agent)
            missing = [part for part in getattr(made, "needs", ()) if part not in self.needs]
            if missing:
                raise ParameterError(f"league: member {name!r} needs {', '.join(missing)}; make the league with needs={tuple(missing)!r}")
            self._controllers[name] = made
        return self._controllers[name]
