"""A simulator that knows what a player is told, and nothing else."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import CprmError, FormatError, ParameterError
from ..simulator.parameters import ServerParameters
from ..simulator.player_types import PlayerParameters, PlayerType
from ..simulator.senses import BodyColumn, Hear, Landmarks, See, new_body, new_hear, new_landmarks, new_see
from ..simulator.simulator import Simulator
from ..simulator.state import PlayerBit, PlayMode
from .percepts import read_body, read_hear, read_referee, read_see

SLOTS = 44
"""Messages of others that are kept of one cycle."""
_INIT = re.compile(r"\((init|reconnect) ([lr])(?: (\d+))? ([a-z_]+)\)")
_CHANGED = re.compile(r"\(change_player_type (\d+) (\d+)\)")
_REFEREE = re.compile(r"\(hear (\d+) referee (.+)\)")
_LARGEST_SET = 22


class PerceivedSimulator(Simulator):
    """Answers ``see``, ``sense_body``, ``hear`` and ``landmarks`` with what messages told.

    Parameters
    ----------
    parameters : ServerParameters
        As the server told them.
    types : tuple of PlayerType
    left, right : int
        Players of the task, for its counts.
    """

    told = True

    def __init__(self, parameters: ServerParameters, types: tuple[PlayerType, ...], left: int = 11, right: int = 11) -> None:
        super().__init__(1, parameters, PlayerParameters(), types, left=left, right=right, goalies=(0, 0))
        self.told_see, self.told_body = new_see(1), new_body(1)
        self.told_hear, self.told_landmarks = new_hear(1, SLOTS), new_landmarks(1)

    def see(self, out: See | None = None, worlds: Any = None) -> See:
        """What was seen in this cycle; there is one world, whatever `worlds` says."""
        return _copied(self.told_see, out)

    def sense_body(self, out: npt.NDArray[Any] | None = None, worlds: Any = None) -> npt.NDArray[Any]:
        """What was felt last."""
        if out is None:
            return self.told_body
        out[...] = self.told_body
        return out

    def hear(self, out: Hear | None = None, worlds: Any = None) -> Hear:
        """What was heard in this cycle."""
        if out is None:
            return self.told_hear
        slots = out.sender.shape[2]
        for name in ("sender", "level", "unum", "direction", "length", "text"):
            getattr(out, name)[...] = getattr(self.told_hear, name)[:, :, :slots]
        out.heard[...] = self.told_hear.heard
        return out

    def landmarks(self, out: Landmarks | None = None, worlds: Any = None) -> Landmarks:
        """Landmarks and lines as they were seen."""
        return _copied(self.told_landmarks, out)


def _copied(source: Any, out: Any) -> Any:
    if out is None:
        return source
    for into, array in zip(out, source):
        into[...] = array
    return out


class ServerTold:
    """Parameters as they arrive after a connection, and what a server that says no more means by default."""

    def __init__(self) -> None:
        self.server: ServerParameters | None = None
        self.types: dict[int, PlayerType] = {}

    def tell(self, text: str) -> bool:
        """Take over a message with parameters; False for another one.

        Raises
        ------
        FormatError
            When it cannot be read.
        """
        try:
            if text.startswith("(server_param"):
                self.server = ServerParameters.from_text(text)
            elif text.startswith("(player_type"):
                number, kind = PlayerType.from_text(text)
                if 0 <= number < _LARGEST_SET:
                    self.types[number] = kind
            else:
                return text.startswith("(player_param")
        except ParameterError as error:
            raise FormatError(f"the server's parameters: {error}") from None
        return True

    @property
    def parameters(self) -> ServerParameters:
        """What the server told, or the defaults."""
        return self.server or ServerParameters()

    @property
    def player_types(self) -> tuple[PlayerType, ...]:
        """All types in order."""
        default = PlayerType.default(self.parameters)
        return tuple(self.types.get(number, default) for number in range(min(max(self.types, default=0) + 1, 18)))


class PlayerEar:
    """Sorts the messages of one player into a `PerceivedSimulator`.

    Parameters
    ----------
    sim : PerceivedSimulator
    row : int
        Of the player, 0..21.
    team : str
        Name of his team.

    Attributes
    ----------
    time : int
        Of the last sense_body; -1 before the first.
    goalie : bool
    felt, saw : bool
        There was a sense_body, a see, since `begin_cycle`.
    thought : int
        ``(think)`` messages that were not answered yet.
    lost, stale, damaged : int
        Cycles of which no sense_body came; messages that were older than what was known; messages that could not be read.
    """

    def __init__(self, sim: PerceivedSimulator, row: int, team: str) -> None:
        self.sim, self.row, self.team = sim, row, team
        self.time = -1
        self.goalie = False
        self._seen = -1
        self.felt = self.saw = self._stood = False
        self.thought = 0
        self.lost = self.stale = self.damaged = 0
        self._heard: list[str] = []
        self.answers: list[str] = []
        """Errors and warnings, the latest of them."""
        sim.world["enabled"][0, row] = 1

    def connected(self, text: str, goalie: bool) -> None:
        """The answer to init or reconnect."""
        found = _INIT.fullmatch(text)
        if found is None:
            raise CprmError(f"the server answered {text[:60]!r}; (init SIDE NUMBER MODE) was expected")
        w, row = self.sim.world, self.row
        self.goalie = goalie
        w["goalie"][0, row] = int(goalie)
        w["bits"][0, row] = PlayerBit.STAND
        if found[4] in PlayMode.__members__:
            w["mode"] = PlayMode[found[4]]

    def tell(self, text: str) -> None:
        """Take in one message. What cannot be read is counted and passed over."""
        try:
            self._tell(text)
        except (ValueError, KeyError, IndexError, OverflowError):
            self.damaged += 1

    def _tell(self, text: str) -> None:
        if text.startswith("(see "):
            self._see(text)
        elif text.startswith("(sense_body "):
            self._body(text)
        elif text == "(think)":
            self.thought += 1
        elif text.startswith("(hear "):
            self._hear(text)
        elif text.startswith("(change_player_type "):
            found = _CHANGED.fullmatch(text)
            kind = int(found[2]) if found else 0
            if found and int(found[1]) == self.row % 11 + 1 and kind < len(self.sim.types):
                self.sim.world["type"][0, self.row] = kind
        elif text.startswith(("(error ", "(warning ")):
            self.answers = [*self.answers[-9:], text]

    def _see(self, text: str) -> None:
        time = int(text[5:-1].split(" ", 1)[0])
        if time < self.time or time < self._seen:
            self.stale += 1
            return
        read_see(text, self.row, self.team, self.sim.told_see, self.sim.told_landmarks)
        self.saw, self._seen = True, time

    def _body(self, text: str) -> None:
        time = int(text[12:].split(" ", 1)[0])
        standing = self._is_stopped()  # in the last of such cycles the referee has already said how it goes on
        if time < self.time or (time == self.time > 0 and self.felt and not (standing or self._stood)):
            self.stale += 1
            return
        self._stood = standing
        self._begin_cycle(time)
        time, card = read_body(text, self.sim.told_body[0, self.row])
        w, row = self.sim.world, self.row
        body = self.sim.told_body[0, row]
        w["time"], w["card_count"][0, row] = time, card
        w["counts"][0, row] = body[BodyColumn.COUNT_KICK : BodyColumn.COUNT_ATTENTION + 1].astype(np.int32)
        self.time, self.felt = time, True

    def _is_stopped(self) -> bool:
        """The clock stands: messages of several cycles carry one time."""
        mode = PlayMode(int(self.sim.world["mode"][0])).name
        standing = ("goal_l", "goal_r", "offside", "foul", "back_pass", "free_kick_fault", "catch_fault", "illegal_defense")
        return mode in ("before_kick_off", "time_over") or mode.startswith(standing[2:]) or mode in standing[:2]

    def _begin_cycle(self, time: int) -> None:
        """Old sights and sounds go; what already came of this cycle stays."""
        if time > self.time + 1 and self.time >= 0:
            self.lost += time - self.time - 1
        sim, row = self.sim, self.row
        if not (self.saw and self._seen == time and not self.felt):
            sim.told_see.fresh[0, row], self.saw = False, False
        for array in (sim.told_hear.sender, sim.told_hear.level, sim.told_hear.unum, sim.told_hear.direction, sim.told_hear.length):
            array[0, row] = 0
        sim.told_hear.text[0, row], sim.told_hear.heard[0, row] = 0, 0

    def _hear(self, text: str) -> None:
        referee = _REFEREE.fullmatch(text)
        if referee is not None:
            read_referee(referee[2], self.sim.world[0])
        else:
            read_hear(text, self.row, self.sim.told_hear)

    def consumed(self) -> None:
        """What was perceived has been looked at: another look in the same cycle finds nothing fresh."""
        self.felt = self.saw = False
        self.sim.told_see.fresh[0, self.row] = False
