"""One player on a server: messages become the observation arrays of the environments, actions become commands."""

from __future__ import annotations

import re
import time
from dataclasses import dataclass, replace

import numpy as np

from ..client.connection import Connection
from ..client.perceived import PerceivedSimulator, PlayerEar, ServerTold
from ..envs.controller import Controller, ControllerFactory, check_action
from ..envs.core import SoccerCore
from ..envs.play import rehearse
from ..envs.tasks import Task
from ..errors import CprmError
from ..simulator.protocol.commands import command_text
from ..simulator.simulator import Simulator
from ..simulator.state import PlayMode

PROTOCOL = 19
_NUMBER = re.compile(r"\(init ([lr]) (\d{1,2}) [a-z_]+\)")
SILENCE = 3.0
"""Seconds without a datagram after which a player tries to connect again."""
PLACED = (PlayMode.before_kick_off, PlayMode.goal_l, PlayMode.goal_r)
"""Modes in which players may be put into formation."""


def played_from(task: Task, part: str, side: str) -> Task:
    """The task as a team plays it from a side of the pitch: mirrored where it is not the side that is its part.

    Parameters
    ----------
    task : Task
    part : str
        ``left`` or ``right``: the side of the task that the team plays.
    side : str
        ``l`` or ``r``: the side of the pitch that the server gave it.
    """
    if part[0] == side:
        return task
    return replace(task, left=task.right, right=task.left, left_goalie=task.right_goalie, right_goalie=task.left_goalie)


class PerceivedCore(SoccerCore):
    """The engine of an environment whose simulator knows what one player is told.

    Parameters
    ----------
    task : Task
    agent : str
        Who he is: ``left_3``.
    sim : PerceivedSimulator
    needs : tuple of str
        Parts of the observation that his controller reads.
    """

    def __init__(self, task: Task, agent: str, sim: PerceivedSimulator, needs: tuple[str, ...] = ()) -> None:
        self._perceived = sim
        super().__init__(task, 1, controlled=agent, others="hold", include=needs)

    def simulator(self, task: Task, worlds: int, seed: int, first_world: int, threads: int) -> Simulator:
        """The one that was given."""
        return self._perceived


@dataclass
class Tally:
    """What a player did and missed."""

    decisions: int = 0
    """Cycles in which he decided."""
    missed: int = 0
    """Cycles that began while he was still busy with an earlier one."""
    blind: int = 0
    """Decisions in real time that did not wait any longer for a see message."""
    reconnections: int = 0
    longest: float = 0.0
    """Seconds of the longest decision."""


class JoinedPlayer:
    """A controller that plays on a server.

    Parameters
    ----------
    host, port
        Of the server's players.
    team : str
        Name of the team.
    task : Task
        What the controller thinks it plays; its parameters become those that the server tells.
    factory : ControllerFactory
    goalie : bool
    seed : int
        Of the controller.
    part : str
        Which side of the task the team plays, ``left`` or ``right``, whatever side the server gives it.
    formation : (n, 2) array, optional
        Where the team's players stand before a kick-off, metres in the team's frame; they stay where they are if it is not given.
    wait : float
        In real time: seconds after a sense_body for which a see message is waited for.
    patience : float
        Seconds for which an answer to the init is waited for.
    rehearsed : bool
        A player with this task and controller has joined from this process before; the first one decides in process until everything is
        compiled, and only then asks to be let in.

    Raises
    ------
    CprmError
        When the server does not answer, or refuses.
    """

    def __init__(
        self,
        host: str,
        port: int,
        team: str,
        task: Task,
        factory: ControllerFactory,
        *,
        goalie: bool = False,
        seed: int = 0,
        part: str = "left",
        formation: np.ndarray | None = None,
        wait: float = 0.02,
        patience: float = 10.0,
        rehearsed: bool = False,
    ) -> None:
        self.connection = Connection(host, port)
        self.team, self.goalie, self.seed = team, goalie, seed
        self._task, self._part, self._factory, self._formation, self._wait = task, part, factory, formation, wait
        self.tally = Tally()
        self._tried = 0.0
        try:
            if not rehearsed:
                rehearse(task, factory, f"{part}_1")
            self.connect(patience)
        except BaseException:
            self.leave()
            raise

    # ------------------------------------------------------------------------------------------ connecting

    def connect(self, patience: float) -> None:
        """Join as a new player; everything known of an earlier match is forgotten."""
        told, early = ServerTold(), list[str]()

        def keep(text: str) -> None:
            if not told.tell(text):
                early.append(text)

        first = f"(init {self.team} (version {PROTOCOL}){' (goalie)' if self.goalie else ''})"
        answer = self.connection.ask(first, lambda text: _NUMBER.fullmatch(text) is not None, patience, keep)
        found = _NUMBER.fullmatch(answer)
        assert found is not None
        self.side, self.unum = found[1], int(found[2])
        self.agent = f"{'left' if self.side == 'l' else 'right'}_{self.unum}"
        self.row = self.unum - 1 + (0 if self.side == "l" else 11)
        self._hear_parameters(told, keep)
        self._begin(told, answer)
        for text in early:
            self.ear.tell(text)

    def _hear_parameters(self, told: ServerTold, keep: object) -> None:
        """Wait for the parameters, which come at once, and for what ends them."""
        end = time.monotonic() + 2.0
        while time.monotonic() < end:
            for text in self.connection.receive():
                if not told.tell(text):
                    keep(text)  # type: ignore[operator]
                    end = min(end, time.monotonic() + 0.02) if told.types else end
            time.sleep(0.002)

    def _begin(self, told: ServerTold, answer: str) -> None:
        """Everything of this match: what is perceived, the engine, the controller."""
        task = played_from(self._task, self._part, self.side)
        count = task.left if self.side == "l" else task.right
        if self.unum > count:
            raise CprmError(f"player {self.unum} of {self.team}: on the side that it plays the task {task.name} has {count}")
        task = replace(task, parameters=told.parameters)
        sim = PerceivedSimulator(told.parameters, told.player_types, task.left, task.right)
        self.ear = PlayerEar(sim, self.row, self.team)
        self.ear.connected(answer, self.goalie)
        self.controller: Controller = self._factory(task, self.agent)
        self.core = PerceivedCore(task, self.agent, sim, tuple(getattr(self.controller, "needs", ())))
        self._entered, self._cycles, self._felt_at = False, 0, 0.0
        self._mode = -1

    def reconnect(self) -> None:
        """After silence: ask to be let in again, as the same player or, on a new server, as a new one."""
        if time.monotonic() - self._tried < 1.0:
            return
        self._tried = time.monotonic()
        self.tally.reconnections += 1
        self.connection.send(f"(reconnect {self.team} {self.unum})", known=True)

    def _answered(self, text: str) -> None:
        """An answer to `reconnect`."""
        if "no_such_team_or_player" in text:
            self.connection.send("(bye)")
            self.connect(2.0)
        elif text.startswith("(reconnect "):
            self.ear.connected(text, self.goalie)

    # ------------------------------------------------------------------------------------------ a cycle

    def take(self) -> None:
        """Take in the messages that are there."""
        for text in self.connection.receive():
            if text.startswith(("(reconnect ", "(error no_such_team")):
                self._answered(text)
                return
            felt = self.ear.felt
            self.ear.tell(text)
            if text.startswith("(sense_body ") and self.ear.felt:
                self.tally.missed += felt
                self._felt_at = time.monotonic()

    @property
    def silent(self) -> bool:
        """Nothing has come for a while."""
        return time.monotonic() - self.connection.heard > SILENCE

    @property
    def due(self) -> float:
        """When he has to decide (`time.monotonic`); infinity while there is nothing to decide about."""
        if self.ear.thought:
            return 0.0
        if not self.ear.felt:
            return float("inf")
        if self.core.parameters.synch_mode:  # asked soon
            return float("inf")
        return 0.0 if self.ear.saw else self._felt_at + self._wait

    def act(self) -> None:
        """Decide and send."""
        begin = time.monotonic()
        asked = self.ear.thought > 0
        self.ear.thought = 0
        text = self.decide() if self.ear.felt else ""
        if asked:
            text += "(done)"
        if text:
            self.connection.send(text)
        self.tally.longest = max(self.tally.longest, time.monotonic() - begin)

    def decide(self) -> str:
        """The commands for what has been perceived, as text."""
        sim = self.core.sim
        self.tally.decisions += 1
        self.tally.blind += not self.ear.saw
        mode = int(sim.world["mode"][0])
        entered = mode != self._mode
        self._mode = mode
        place = self._placing() if entered and mode in PLACED else ""
        if mode in (PlayMode.before_kick_off, PlayMode.time_over) or place:
            self.ear.consumed()
            return place
        if not self._entered:
            observation = self.core.enter()
        else:
            observation = self.core.observe()
        own = {key: values[:, 0] for key, values in observation.items()}
        if not self._entered:
            self.controller.reset(own, self.seed)
            self._entered = True
        action = check_action(type(self.controller).__name__, self.controller.act(own), 1)
        commands = self.core.commanded({key: np.asarray(value)[:, None] for key, value in action.items()})
        self.ear.consumed()
        return command_text(commands[0, self.row])

    def _placing(self) -> str:
        """The move into formation."""
        if self._formation is None:
            return ""
        x, y = self._formation[self.unum - 1]
        return f"(move {x:g} {y:g})"

    def leave(self) -> None:
        """Say goodbye and close the connection."""
        self.connection.send("(bye)")
        self.connection.close()
