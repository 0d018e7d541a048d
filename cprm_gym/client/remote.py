"""A simulator that plays on a server: the world is what the trainer sees, the senses are what the players are told.

`RemoteSimulator` stands where a `Simulator` of one world stands: its ``world`` is the trainer's picture of every cycle (places and
velocities with six digits, directions in whole degrees), and what a task changes in it (places, play mode, types) is sent to the server by
the trainer before the next cycle. What cannot be the same as in process:

* seeds: the server has its own luck; a seed decides only where a task puts things;
* states: they cannot be saved, or set to anything but places, velocities, directions, mode and types;
* the referee: the server's is on or off for all tasks, whatever a task's ``rules`` say;
* clocks and goals go on from episode to episode; here they are counted from the beginning of the episode.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterator
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from ..errors import CprmError
from ..simulator.protocol.commands import command_text
from ..simulator.senses import See
from ..simulator.state import PlayMode, Seed, Worlds
from .connection import Connection
from .perceived import PerceivedSimulator, PlayerEar, ServerTold
from .percepts import read_referee

TEAMS = ("CprmLeft", "CprmRight")
"""Names of the teams that play on a server."""
ANSWER = 30.0
"""Seconds for which the server is waited for."""
LOOKS = 4
"""Cycles at most until everybody has seen something after a reset."""
_REFEREE = re.compile(r"\(hear referee (\d+) (.+)\)")
_BALL = re.compile(r"\(\(b\) (\S+) (\S+) (\S+) ([^\s()]+)\)")
_PLAYER = re.compile(r'\(\(p "([^"]*)" (\d{1,2})(?: goalie)?\) (\S+) (\S+) (\S+) (\S+) (-?\d+) (-?\d+)')
_PLACE = re.compile(r"udp://(?P<host>[^/:]+|\[[^]]+\])(?::(?P<port>\d{1,5}))?(?:/(?P<trainer>\d{1,5}))?")
_PLACED = ("pos", "vel", "body", "type", "mode")
FARTHEST = 200.0


def server_place(backend: str) -> tuple[str, int, int]:
    """Host, port of the players and port of the trainer of ``udp://host:port`` or ``udp://host:port/trainer_port``.

    Raises
    ------
    CprmError
        When it has another form.
    """
    found = _PLACE.fullmatch(backend)
    port = int(found["port"] or 6000) if found else 0
    trainer = int(found["trainer"] or port + 1) if found else 0
    if found is None or not (0 < port < 65536 and 0 < trainer < 65536):
        raise CprmError(f"backend {backend!r}: a server is named as udp://host:port, or udp://host:port/trainer_port")
    return found["host"].strip("[]"), port, trainer


def check_trainer(backend: str, seconds: float = 10.0) -> None:
    """See whether a server answers that takes a trainer, before work is done for it; nobody connects.

    Raises
    ------
    CprmError
        When none answers within so many seconds, or it takes no trainer.
    """
    host, _, port = server_place(backend)
    connection = Connection(host, port)
    try:
        connection.ask("(init (version 0))", lambda text: "without_coach_mode" not in text, seconds)
    finally:
        connection.close()


class RemoteSimulator(PerceivedSimulator):
    """A match on a server, of whose trainer and players we are all.

    Parameters
    ----------
    backend : str
        ``udp://host:port``; the trainer's port is the next one if it is not given behind a slash.
    left, right : int
        Players of each side.
    goalies : (int, int)
        Uniform numbers of the goalies, 0 for none.

    Raises
    ------
    CprmError
        When the server does not answer, refuses somebody, or has no trainer mode.
    """

    def __init__(self, backend: str, left: int, right: int, goalies: tuple[int, int] = (0, 0)) -> None:
        self._place = backend
        host, port, trainer_port = server_place(backend)
        self._ready = False
        self._told = ServerTold()
        self._replies: list[str] = []
        self._picture, self._trainer_asked = "", False
        self._ears: list[tuple[Connection, PlayerEar]] = []
        self._trainer = Connection(host, trainer_port)
        try:
            self._take_office()
            self._wait(lambda: len(self._told.types) > 0, "its parameters")
            time.sleep(0.05)
            self._pump()
            super().__init__(self._told.parameters, self._told.player_types, left, right)
            self._offset = 0
            self._synchronous = self.parameters.synch_mode
            self.team_names = TEAMS
            self._order("(change_mode before_kick_off)")  # players of an earlier environment may come back now
            for row in (*range(left), *range(11, 11 + right)):
                self._join(host, port, row, row % 11 + 1 == goalies[row // 11])
            for word in ("eye", "ear"):
                self._order(f"({word} on)")
            if self._synchronous:
                self._gather()
        except BaseException:
            self.close()
            raise
        self._ready = True
        self._shadow = self._state()

    # ------------------------------------------------------------------------------------------ talking

    def _fail(self, what: str) -> NoReturn:
        raise CprmError(f"backend {self._place}: {what}")

    def _pump(self) -> None:
        """Take in everything that has come."""
        for text in self._trainer.receive():
            self._tell_trainer(text)
        for connection, ear in self._ears:
            for text in connection.receive():
                ear.tell(text)

    def _tell_trainer(self, text: str) -> None:
        referee = _REFEREE.fullmatch(text)
        if text.startswith("(see_global "):
            self._picture = text
        elif text == "(think)":
            self._trainer_asked = True
        elif referee is not None:
            if self._ready:
                read_referee(referee[2], self.world[0])
        elif text.startswith(("(ok ", "(error ", "(warning ")):
            self._replies = [*self._replies[-99:], text]
        else:
            self._told.tell(text)

    def _wait(self, done: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + ANSWER
        while not done():
            if time.monotonic() > end:
                self._fail(f"the server has not sent {what} for {ANSWER:g} s")
            self._pump()
            if not done():
                time.sleep(0.0002)

    def _order(self, text: str) -> None:
        """A trainer's command, and the server's consent."""
        self._replies.clear()
        self._trainer.send(text)
        self._wait(lambda: bool(self._replies), f"an answer to {text}")
        if not self._replies[0].startswith("(ok "):
            self._fail(f"the server answers {text}: {self._replies[0]}")

    def _take_office(self) -> None:
        """Become the trainer; a server notices only after a while that an earlier one has gone."""
        end = time.monotonic() + ANSWER
        while True:
            try:
                self._trainer.ask("(init (version 19))", lambda text: text == "(init ok)", ANSWER, self._tell_trainer)
                return
            except CprmError as error:
                if "already_have_offline_coach" not in str(error) or time.monotonic() > end:
                    raise
                time.sleep(0.2)

    def _join(self, host: str, port: int, row: int, goalie: bool) -> None:
        """One player connects, while those who are in keep the others from waiting."""
        connection, team = Connection(host, port), TEAMS[row // 11]
        ear = PlayerEar(self, row, team)
        self._ears.append((connection, ear))
        anew = f"(init {team} (version 19){' (goalie)' if goalie else ''})"
        first = f"(reconnect {team} {row % 11 + 1})"
        answer = ""
        end, again = time.monotonic() + ANSWER, 0.0
        while not answer:
            if time.monotonic() > end:
                self._fail(f"no answer to {first}")
            if time.monotonic() > again:
                connection.send(first, known=True)
                again = time.monotonic() + 2.0
            for text in connection.receive():
                if text.startswith(("(init ", "(reconnect ")):
                    answer = text
                elif text == "(error no_such_team_or_player)" and first != anew:
                    first, again = anew, 0.0
                elif text.startswith("(error ") and not answer and "only_init" not in text:
                    self._fail(f"the server refuses {first}: {text[7:-1]}; it must have nobody else's teams")
                else:
                    ear.tell(text)
            self._nod()
            time.sleep(0.001)
        side = "l" if row < 11 else "r"
        if not answer.startswith((f"(init {side} {row % 11 + 1} ", f"(reconnect {side} ")):
            self._fail(f"player {row % 11 + 1} of {team} became {answer}; the server must be a fresh one, without teams")
        ear.connected(answer, goalie)
        connection.send("(done)")

    def _nod(self) -> None:
        """Whoever is asked has nothing to say."""
        self._pump()
        for connection, ear in self._ears:
            if ear.thought:
                ear.thought = 0
                connection.send("(done)")
        if self._trainer_asked:
            self._trainer_asked = False
            self._trainer.send("(done)")

    def _gather(self) -> None:
        """Nod until everybody has been asked in one window, which is then left open."""
        end = time.monotonic() + ANSWER
        while time.monotonic() < end:
            quiet = time.monotonic() + 0.3
            while time.monotonic() < quiet:
                self._pump()
                if self._trainer_asked and all(ear.thought for _, ear in self._ears):
                    return
                time.sleep(0.001)
            self._nod()
        self._fail("the server does not ask everybody, (think)")

    # ------------------------------------------------------------------------------------------ a cycle

    def step(self, commands: npt.NDArray[Any] | None = None) -> None:
        """Send what was changed and everybody's commands; wait for the next cycle."""
        self._push()
        given = self.commands if commands is None else commands
        self._cycle([command_text(given[0, ear.row]) for _, ear in self._ears])
        self._take_picture()

    def advance(self) -> None:
        """A cycle without commands."""
        self._push()
        self._cycle([""] * len(self._ears))
        self._take_picture()

    def command_phase(self, world: int, player: int, command: Any) -> None:
        """Not for a server, which executes commands when it receives them."""
        self._fail("single commands cannot be executed within a cycle; use step")

    def _cycle(self, texts: list[str]) -> None:
        """One cycle of the server."""
        self._picture = ""
        for (connection, ear), text in zip(self._ears, texts):
            ear.thought = 0
            ear.consumed()
            if self._synchronous:
                text += "(done)"
            if text:
                connection.send(text)
        if self._synchronous:
            self._trainer_asked = False
            self._trainer.send("(done)")
            self._wait(lambda: self._trainer_asked and all(ear.thought for _, ear in self._ears), "(think)")
        else:
            self._wait(lambda: bool(self._picture) and all(ear.felt for _, ear in self._ears), "the next cycle")
            time.sleep(0.003)
            self._pump()

    def _take_picture(self) -> None:
        """The world as the trainer sees it."""
        w, text = self.world[0], self._picture
        ball = _BALL.search(text)
        if ball is not None:
            w["pos"][0], w["vel"][0] = _pair(ball[1], ball[2]), _pair(ball[3], ball[4])
        for name, unum, x, y, vx, vy, body, neck in _PLAYER.findall(text):
            if name in TEAMS and 1 <= int(unum) <= 11:
                row = int(unum) - 1 + 11 * TEAMS.index(name)
                w["pos"][row + 1], w["vel"][row + 1] = _pair(x, y), _pair(vx, vy)
                w["body"][row], w["neck"][row] = math.radians(int(body)), math.radians(int(neck))
        for _, ear in self._ears:
            w["stamina"][ear.row] = self.told_body[0, ear.row, 0]
        self._count_time()
        self._shadow = self._state()

    def _count_time(self) -> None:
        """The clock of the episode."""
        now = max((ear.time for _, ear in self._ears), default=0)
        self.world["time"] = max(0, now - self._offset)
        self.world["saw"] = 0

    # ------------------------------------------------------------------------------------------ resets

    def reset(self, seed: Seed | None = None, worlds: Worlds = None) -> None:
        """Forget the episode; the server learns where everything is when somebody looks, or with the next step."""
        goals = self.world["score"][0].copy() if self._ready else None
        super().reset(seed, worlds)
        if goals is not None:
            self.world["score"] = goals
            for _, ear in self._ears:
                self.world["goalie"][0, ear.row] = int(ear.goalie)

    def see(self, out: See | None = None, worlds: Any = None) -> See:
        """What is seen; at the beginning of an episode everybody looks first."""
        if self._ready and self.world["saw"].any():
            self._settle()
        return super().see(out, worlds)

    def _settle(self) -> None:
        """Put everything where the episode begins, rest everybody, and wait until all have seen it; then once more."""
        wanted, seen = self.world.copy(), set[int]()
        self._order("(recover)")
        # view and neck as in process, the neck by way of its limit
        at_ease = ("(change_view normal high)(attentionto off)(turn_neck -180)", f"(turn_neck {-self.parameters.minneckang:g})")
        for n in range(LOOKS + len(at_ease)):
            self._push(everything=True)
            self._cycle([at_ease[n] if n < len(at_ease) else ""] * len(self._ears))
            if n + 1 >= len(at_ease):
                seen |= {ear.row for _, ear in self._ears if ear.saw}
            if int(self.world["mode"][0]) == PlayMode.time_over and int(wanted["mode"][0]) != PlayMode.time_over:
                self._fail("the match on the server is over; start it with server::half_time=-1")
            score = self.world["score"].copy()
            self.world.view("u1")[...] = wanted.view("u1")
            self.world["score"] = score
            if len(seen) == len(self._ears):
                break
        self._push(everything=True)
        self._order("(recover)")
        for _, ear in self._ears:
            self.told_see.fresh[0, ear.row] = ear.row in seen
        self._offset = max((ear.time for _, ear in self._ears), default=0) - int(wanted["time"][0])
        self._count_time()
        self._shadow = self._state()

    def _state(self) -> dict[str, Any]:
        """What the trainer can change, as the server has it."""
        return {name: self.world[name][0].copy() for name in _PLACED}

    def _push(self, everything: bool = False) -> None:
        """Tell the server what was changed since the last cycle."""
        w, old = self.world[0], self._shadow
        for text in self._changes(w, old, everything):
            self._order(text)
        self._shadow = self._state()

    def _changes(self, w: Any, old: dict[str, Any], everything: bool) -> Iterator[str]:
        """The trainer's commands for what is different."""
        rows = [ear.row for _, ear in self._ears]
        for row in rows:
            if w["type"][row] != old["type"][row] and int(w["type"][row]) < len(self.types):
                yield f"(change_player_type {TEAMS[row // 11]} {row % 11 + 1} {w['type'][row]})"
        mode = PlayMode(int(w["mode"]))
        if (everything or mode != old["mode"]) and mode != PlayMode.null:
            yield f"(change_mode {mode.name})"
        for row in rows:
            same = (
                all(np.array_equal(w[name][row + 1], old[name][row + 1]) for name in ("pos", "vel")) and w["body"][row] == old["body"][row]
            )
            if everything or not same:
                numbers = _numbers((*w["pos"][row + 1], math.degrees(w["body"][row]), *w["vel"][row + 1]))
                yield f"(move (player {TEAMS[row // 11]} {row % 11 + 1}) {numbers})"
        if everything or not all(np.array_equal(w[name][0], old[name][0]) for name in ("pos", "vel")):
            yield f"(move (ball) {_numbers((*w['pos'][0], 0.0, *w['vel'][0]))})"

    def restore(self, snapshot: npt.NDArray[Any], worlds: Worlds = None) -> None:
        """Not for a server.

        Raises
        ------
        CprmError
            Always.
        """
        self._fail("a saved state cannot be set on a server; reset with start=... places ball and players")

    def close(self) -> None:
        """Everybody leaves.

        A trainer cannot say goodbye: his place is free when a server sends something to where he was, as it does to an open eye.
        """
        for connection, _ in self._ears:
            connection.send("(bye)")
            connection.close()
        self._trainer.send("(eye on)")
        self._trainer.close()


def _pair(x: str, y: str) -> tuple[float, float]:
    """Two numbers of the trainer's picture."""
    first, second = float(x), float(y)
    return (first, second) if math.isfinite(first) and math.isfinite(second) else (0.0, 0.0)


def _numbers(values: tuple[float, ...]) -> str:
    """Numbers as a command has them: without exponents."""
    return " ".join(f"{max(-FARTHEST, min(float(value), FARTHEST)) + 0.0:.9f}".rstrip("0").rstrip(".") for value in values)
