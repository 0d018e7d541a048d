"""The server without sockets and clocks: datagrams in, datagrams out.

`Server` takes every datagram at once and is told when time passes; what it wants to send waits in its outbox. A transport
(`cprm_gym.server.transport`) moves the datagrams and keeps the time, a test replays a recorded session instead.

One cycle of 100 ms (specification/simulator.md 1.2, 1.3)::

    step()         the world moves; sense_body, fullstate, hear, see, see_global go out
    look_again()   40 ms later: players who see asynchronously
    think()        in synchronous mode, 60 ms after the step: (think); then datagrams are received until `is_complete`
    look_late()    80 ms after the step: players who see asynchronously

With other periods (``sense_body_step``, ``send_step``, ``send_vi_step``) the same three send what is due until then; in real time
the transport sends each thing of `due` in its moment.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Hashable, Sequence

from ..simulator.protocol.messages import fullstate_rest, fullstate_text, hear_text
from ..simulator.state import LEFT, PlayMode, Seed
from .clients import LARGEST_DATAGRAM, Client, Coach, Monitor, Outgoing, Player, Port, Refused, Trainer
from .roles import monitors, players, trainers
from .roles.coaches import Coaches
from .settings import Settings
from .stadium import Stadium
from .texts.pictures import picture
from .timetable import LAST, Due, Task, Timetable

MOST_MISSED = 20
"""Windows in a row that may end without an answer of everybody; one more ends the match."""
OLDEST_SEEING = 3
"""Versions 1 and 2 get see messages in which there is nothing."""
MOST_REMEMBERED = 512
"""Addresses of clients that are kept before those of clients who have left are forgotten."""
AGAIN = 0.4
"""Part of a cycle in which `Server.step` sends what is due, and `Server.look_again` what is due then: of the usual looks the second."""
AT_ONCE = 1.0
"""Milliseconds within which what is due is due with the step."""
_THINK = b"(think)\0"
MOST_KEPT = 64
"""Words of others that wait for a player's next sense_body."""
ONLY_INIT = "(error only_init_allowed_on_init_port)"


class Server:
    """A match that programs can join, datagram by datagram.

    Parameters
    ----------
    settings : Settings, optional
    seed : int or SeedSequence
        Decides every random number of the match.

    Attributes
    ----------
    stadium : Stadium
        The match and everybody who is connected.
    over : str
        Why the match is over; empty while it goes on.
    timetable : Timetable
    due : list of Due
        What is to be sent before the next step.
    """

    def __init__(self, settings: Settings | None = None, seed: Seed = 0) -> None:
        self.settings = Settings() if settings is None else settings
        self.stadium = Stadium(self.settings, seed)
        self.over = ""
        self._coaches = Coaches(self.stadium)
        self._clients: dict[tuple[Port, Hashable], Client] = {}
        self._missed = 0
        self._leaving = self.settings.server.game_over_wait
        self.timetable = Timetable(self.settings.server)
        self.due: list[Due] = []
        self._heard = False

    # ------------------------------------------------------------------------------------------ datagrams

    def take_outbox(self) -> list[Outgoing]:
        """What is to be sent, in order; the outbox is empty afterwards."""
        outbox, self.stadium.outbox = self.stadium.outbox, []
        return outbox

    def receive(self, port: Port, address: Hashable, data: bytes) -> Client | None:
        """A datagram at a well-known port.

        Parameters
        ----------
        port : Port
        address : hashable
            Of the sender; it also names him in the answers.
        data : bytes

        Returns
        -------
        Client or None
            The client that this datagram made, if it did.
        """
        known = self._clients.get((port, address))
        if known is not None and not known.connected:
            del self._clients[port, address]
            known = None
        if known is not None:
            self._again(known, data[:LARGEST_DATAGRAM])
            return None
        text = data[:LARGEST_DATAGRAM].split(b"\0", 1)[0].decode("latin-1").rstrip("\n")
        try:
            client = self._newcomer(port, address, text)
        except Refused as refused:
            for error in refused.errors:
                self.stadium.refuse(port, address, f"(error {error})")
            return None
        if client is not None:
            self._clients[port, address] = client
            if len(self._clients) > MOST_REMEMBERED:
                self._clients = {place: one for place, one in self._clients.items() if one.connected}
        return client

    def _newcomer(self, port: Port, address: Hashable, text: str) -> Client | None:
        """Somebody who is not connected."""
        stadium = self.stadium
        if port == Port.TRAINER:
            return trainers.connect(stadium, address, text)
        if port == Port.COACH:
            return self._coaches.connect(address, text)
        if text.startswith("(init "):
            return players.connect(stadium, address, text)
        if text.startswith("(reconnect "):
            return players.reconnect(stadium, address, text)
        if text.startswith("(dispinit"):
            return monitors.connect(stadium, address, text)
        raise Refused("unknown_command")

    def _again(self, client: Client, data: bytes) -> None:
        """A connected client that sends to the well-known port."""
        if client.strict:
            self.stadium.send(client, ONLY_INIT)
        else:
            self.receive_from(client, data)

    def receive_from(self, client: Client, data: bytes) -> None:
        """A datagram at the socket of a connected client."""
        if not client.connected:
            return
        read = client.unpacked(data[:LARGEST_DATAGRAM])
        if read is None:
            return
        text, ended = read
        if not ended and client.strict and client.compression < 0:
            warning = "(warning message_not_null_terminated)"
            if isinstance(client, Monitor):
                self.stadium.board(warning, only=client)
            else:
                self.stadium.send(client, warning)
        if isinstance(client, Player):
            self._log(client, text)
            players.receive(self.stadium, client, text)
        elif isinstance(client, Coach):
            self._log(client, text)
            self._coaches.receive(client, text)
        elif isinstance(client, Trainer):
            self._log(client, text)
            trainers.receive(self.stadium, client, text)
        elif isinstance(client, Monitor):
            monitors.receive(self.stadium, client, text)

    def receive_many(self, datagrams: Sequence[tuple[Client, bytes]]) -> None:
        """Datagrams at the sockets of connected clients, in order; players' plain commands are executed in bulk."""
        plain: list[tuple[Player, bytes]] = []
        for client, data in datagrams:
            if type(client) is Player and client.compression < 0 and data[:1] == b"(" and data.find(b"\0") == len(data) - 1:
                plain.append((client, data[:-1]))
                continue
            self._execute(plain)
            plain.clear()
            self.receive_from(client, data)
        self._execute(plain)

    def _execute(self, plain: list[tuple[Player, bytes]]) -> None:
        """Players' datagrams; what is out of the ordinary in them is read by `players`."""
        stadium, at = self.stadium, 0
        while at < len(plain):
            players_, texts = zip(*plain[at:])
            read, done = stadium.intake.execute([player.row for player in players_], texts)
            for (player, text), size, finished in zip(plain[at:], read, done):
                if not player.connected:
                    continue
                player.done |= finished
                self._log(player, text.decode("latin-1"))
                if size < len(text):
                    stadium.world_changed()
                    players.receive(stadium, player, text[size:].decode("latin-1"), begun=size > 0)
            stadium.world_changed()
            at += len(read)

    def _log(self, client: Player | Coach | Trainer, text: str) -> None:
        """A line of the text log for a received datagram."""
        if not self.stadium.listeners:
            return
        if isinstance(client, Trainer):
            who = "Coach"
        else:
            name = self.stadium.team_of(client.side).name
            who = f"{name}_Coach" if isinstance(client, Coach) else f"{name}_{client.unum}"
        self.stadium.log(f"Recv {who}: {text}")

    def lose(self, client: Client) -> None:
        """The socket of a client failed: it is gone."""
        if isinstance(client, Player):
            self.stadium.disable(client)
        else:
            self.stadium.close(client)

    # ------------------------------------------------------------------------------------------ time

    def step(self, look: bool = True) -> None:
        """The end of a cycle: everything moves, then everybody is told.

        Parameters
        ----------
        look : bool
            Also send what is due until `look_again`; otherwise only what is due at once, and `due` is to be followed.
        """
        stadium = self.stadium
        for player in stadium.players():
            player.done = False
        if stadium.trainer is not None:
            stadium.trainer.done = False
        self._coaches.deliver()
        stadium.advance(counts_looks=self.timetable.usual)
        self._coaches.count_time()
        self._show_monitors()
        stadium.kick_off_if_due()
        self._count_down()
        self._heard = False
        self.due = self.timetable.after(int(stadium.world["steps"]))
        if all(due.task is not Task.BODIES for due in self.due):
            self._keep_heard()
        self._send_due(AGAIN * self.timetable.cycle if look else AT_ONCE)

    def look_again(self) -> None:
        """What is due before the window of the synchronous mode: the second look of those who see asynchronously."""
        parameters = self.settings.server
        self._send_due(min(parameters.synch_offset * parameters.slow_down_factor, self.timetable.cycle))

    def look_late(self) -> None:
        """What is due before the next step: the last look of those who see asynchronously."""
        self._send_due(math.inf)

    def _send_due(self, until: float) -> None:
        """Send what is due before so many ms after the step and was not sent yet."""
        while self.due and self.due[0].offset < until:
            self.send(self.due.pop(0))

    def send(self, due: Due) -> None:
        """Send what is due, to everybody whom it concerns."""
        if due.task is Task.BODIES:
            self._tell_bodies()
            self._tell_heard()
        elif due.task is Task.LOOK_IN_STEP:
            self._tell_seen(1, 0, True)
        elif due.task is Task.PICTURES:
            self._tell_pictures()
        elif not self.timetable.usual:
            self.stadium.count_look()
            self._tell_seen(4, due.number, False)
        elif due.number == LAST:
            self.stadium.count_late_see()
            self._tell_seen(4, due.number, False)
        else:
            self._tell_seen(1 + due.number, due.number, False)

    def think(self) -> None:
        """Open a window of the synchronous mode: ask everybody who is waited for."""
        self.stadium.send_each(self.awaited(), itertools.repeat(_THINK))

    def awaited(self) -> list[Client]:
        """Who is waited for in synchronous mode: players, and officials with an open eye."""
        stadium = self.stadium
        officials: list[Client] = [coach for coach in stadium.coaches() if coach.eye]
        if stadium.trainer is not None and stadium.trainer.eye:
            officials.append(stadium.trainer)
        return [*stadium.players(), *officials]

    @property
    def is_complete(self) -> bool:
        """Whether everybody who is waited for has sent ``(done)``."""
        return all(client.done for client in self.awaited())

    def close_window(self, complete: bool) -> None:
        """The window of the synchronous mode ends, because everybody is done or because time is up."""
        if complete or self.stadium.time == 0:
            self._missed = 0
            return
        self._missed += 1
        if self._missed > MOST_MISSED:
            self.over = "players do not answer"

    # ------------------------------------------------------------------------------------------ messages of a step

    def _show_monitors(self) -> None:
        stadium = self.stadium
        if stadium.monitors or stadium.viewers:
            frame = stadium.frames.frame()
            made: dict[int, bytes] = {}
            for monitor in stadium.monitors:
                version = monitor.version
                if version not in made:
                    made[version] = stadium.frames.datagram(frame, version)
                stadium.send_raw(monitor, made[version])
            for viewer in stadium.viewers:
                viewer(frame)
        for text in stadium.late_board:
            stadium.board(text)
        stadium.late_board.clear()

    def _tell_bodies(self) -> None:
        """sense_body, and fullstate for teams that get it."""
        stadium, server = self.stadium, self.settings.server
        enabled = stadium.world["enabled"].tolist()
        players = [player for player in stadium.players() if enabled[player.row]]
        rests: dict[int, str] = {}
        for player, data in zip(players, stadium.bulk.bodies([player.row for player in players])):
            stadium.send_raw(player, data)
            if (server.fullstate_l if player.side == LEFT else server.fullstate_r) and player.version >= 5:
                if player.version >= 8 and player.version not in rests:
                    rests[player.version] = fullstate_rest(stadium.sim, 0, player.row + 1)
                stadium.send(player, fullstate_text(stadium.sim, 0, player.row + 1, rest=rests.get(player.version)))

    def _tell_heard(self) -> None:
        """What waited for the end of the step: trainer's words, own words, those of others."""
        stadium = self.stadium
        said = bool(stadium.world["audio_count"]) and not self._heard
        self._heard = True
        for player in stadium.players():
            for text in player.pending:
                stadium.send(player, f"(hear {stadium.time} {text})")
            player.pending.clear()
            for text in player.kept:
                stadium.send(player, text)
            player.kept.clear()
            if said and player.version >= 8:
                for text in hear_text(stadium.sim, 0, player.row + 1):
                    stadium.send(player, text)

    def _keep_heard(self) -> None:
        """What is heard in a step after which nobody is told of his body waits for the next one."""
        if self.stadium.world["audio_count"]:
            for player in self.stadium.players():
                if player.version >= 8:
                    player.kept = [*player.kept, *hear_text(self.stadium.sim, 0, player.row + 1)][-MOST_KEPT:]

    def _tell_seen(self, bit: int, message: int, synchronous: bool | None) -> None:
        """See messages that are due: those of `bit` in ``saw``, of players who see synchronously, asynchronously or both (None)."""
        stadium = self.stadium
        saw, in_step = stadium.world["saw"].tolist(), stadium.world["synchronous"].tolist()
        players = [
            player
            for player in stadium.players()
            if saw[player.row] & bit and (synchronous is None or bool(in_step[player.row]) == synchronous)
        ]
        if players:
            nothing = f"(see {stadium.time})\0".encode()
            sights = stadium.bulk.sights([player.row for player in players], message)
            stadium.send_each(players, [sight if player.version >= OLDEST_SEEING else nothing for player, sight in zip(players, sights)])

    def _tell_pictures(self) -> None:
        """The picture of the whole pitch, for officials with an open eye."""
        stadium = self.stadium
        officials = [coach for coach in stadium.coaches() if coach.eye]
        for client in officials:
            stadium.send(client, picture(stadium.sim, client))
        if stadium.trainer is not None and stadium.trainer.eye:
            stadium.send(stadium.trainer, picture(stadium.sim, stadium.trainer))

    def _count_down(self) -> None:
        """In automatic mode the server ends some time after the match."""
        if not self.settings.server.auto_mode or self.stadium.mode != PlayMode.time_over:
            self._leaving = self.settings.server.game_over_wait
            return
        self._leaving -= 1
        if self._leaving <= 0:
            self.over = "the match is over"
