"""What all parts of the server share: the match, who is connected, and what waits to be sent."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator

from ..simulator.gamelog.frames import Frame
from ..simulator.kernels.referee.events import automatic_kick_offs
from ..simulator.kernels.referee.modes import is_stopped
from ..simulator.kernels.senses import late_messages_of_all
from ..simulator.protocol.bulk import BulkCommands, BulkMessages
from ..simulator.setup import home
from ..simulator.simulator import Simulator
from ..simulator.state import LEFT, Announcement, PlayerBit, PlayMode, Seed
from ..simulator.trainer import announcement_text
from .clients import Client, Coach, Monitor, Outgoing, Player, Port, Trainer, deflated
from .settings import Settings
from .texts.frames import FrameTexts
from .texts.pictures import player_name

PLAYERS_PER_TEAM = 11
_KEPT_OUTSIDE = int(PlayerBit.DISCARD | PlayerBit.RED_CARD | PlayerBit.YELLOW_CARD)
_SEEN_IN_STEP = 3
"""Bits of ``saw`` that say nothing of looks between commands and step."""
_BROADCASTS = (Announcement.CHANGE_PLAYER_TYPE, Announcement.PROMOTE_GOALIE)


class Team:
    """One team: its name, its coach, and how many players it ever had.

    Attributes
    ----------
    players : list of Player or None
        By uniform number; whoever has left is None, his place is not given to another.
    joined : int
        Uniform numbers given so far.
    """

    def __init__(self) -> None:
        self.name = ""
        self.players: list[Player | None] = [None] * PLAYERS_PER_TEAM
        self.joined = 0
        self.coach: Coach | None = None
        self.coached = False
        """Somebody has been coach; nobody else can be it any more."""
        self.coach_name = ""


class Stadium:
    """The match and everybody who is connected.

    Parameters
    ----------
    settings : Settings
    seed : int or SeedSequence
        Decides every random number of the match.

    Attributes
    ----------
    sim : Simulator
        Of one world.
    outbox : list of Outgoing
        What is to be sent, in order; who sends it clears it.
    listeners : list of callable
        Called with every line of the text log: time, stoppage, text.
    """

    def __init__(self, settings: Settings, seed: Seed = 0) -> None:
        self.settings = settings
        self.sim = Simulator(1, settings.server, settings.player, settings.types, seed=seed, left=0, right=0, goalies=(0, 0))
        self.sim.packed["auto_mode"] = 0  # kicked off here, after monitors have been shown the step
        self.sim.team_names = ("", "")
        self.world = self.sim.world[0]
        self.teams = Team(), Team()
        self.trainer: Trainer | None = None
        self.monitors: list[Monitor] = []
        self.frames = FrameTexts(self.sim)
        self.bulk, self.intake = BulkMessages(self.sim), BulkCommands(self.sim)
        self.graphics: list[tuple[str, int, int, tuple[str, ...]]] = []
        self.outbox: list[Outgoing] = []
        self.listeners: list[Callable[[int, int, str], None]] = []
        self.messages: list[Callable[[int, int, str], None]] = []
        """Called with every text of the message board: time, stoppage, text."""
        self.viewers: list[Callable[[Frame], None]] = []
        """Called with the frame of every step."""
        self._stopped_before = 0
        """Stoppage at which things were announced in the last step before the clock went on."""
        self.late_board: list[str] = []
        """Texts for the message board that are shown after the next step."""
        self.world["synchronous"] = 0  # until a client asks for it
        self.world["body"] = 0.0  # until somebody connects

    # ------------------------------------------------------------------------------------------ who is there

    @property
    def time(self) -> int:
        """The clock that messages carry."""
        return int(self.world["time"])

    @property
    def stoppage(self) -> int:
        """Steps since the clock stopped."""
        return int(self.world["stoppage"])

    @property
    def mode(self) -> PlayMode:
        """The play mode."""
        return PlayMode(int(self.world["mode"]))

    def team_of(self, side: int) -> Team:
        """The team of a side, +1 or -1."""
        return self.teams[0 if side == LEFT else 1]

    def side_named(self, name: str) -> int | None:
        """Side of the team of that name."""
        for side, team in zip((LEFT, -LEFT), self.teams):
            if team.name and team.name == name:
                return side
        return None

    def players(self) -> list[Player]:
        """Connected players, left team first."""
        return [player for team in self.teams for player in team.players if player is not None and player.connected]

    def coaches(self) -> Iterator[Coach]:
        """Connected online coaches."""
        for team in self.teams:
            if team.coach is not None and team.coach.connected:
                yield team.coach

    def clients(self) -> Iterator[Client]:
        """Everybody who is connected."""
        yield from self.players()
        yield from self.coaches()
        if self.trainer is not None:
            yield self.trainer
        yield from self.monitors

    # ------------------------------------------------------------------------------------------ sending

    def send(self, client: Client, text: str) -> None:
        """Send a text to a client, from its own socket."""
        if client.connected:
            self.outbox += [Outgoing(client, client.address, client.packed(text))] * client.copies

    def refuse(self, port: Port, address: Hashable, text: str) -> None:
        """Answer from a well-known port."""
        self.outbox.append(Outgoing(port, address, text.encode("latin-1") + b"\0"))

    def board(self, text: str, board: int = 1, only: Monitor | None = None, clock: tuple[int, int] | None = None) -> None:
        """Show a text on the message board of all monitors, or of one, at a clock (time, stoppage) that is the present one if not given."""
        time, stoppage = clock or (self.time, self.stoppage)
        made: dict[int, bytes] = {}
        for monitor in self.monitors if only is None else (only,):
            kind = monitor.version if monitor.version < 3 else 3
            if kind not in made:
                made[kind] = self.frames.message(text, board, monitor.version, time, stoppage)
            self.send_raw(monitor, made[kind])
        if only is None:
            for listener in self.messages:
                listener(time, stoppage, text)

    def send_raw(self, client: Client, data: bytes) -> None:
        """Send bytes that are a datagram already, but for compression."""
        self.send_each((client,), (data,))

    def send_each(self, clients: Iterable[Client], datagrams: Iterable[bytes]) -> None:
        """Send each client a datagram, as `send_raw` does."""
        outbox = self.outbox
        for client, data in zip(clients, datagrams):
            if client.connected:
                sent = Outgoing(client, client.address, data if client.compression < 0 else deflated(data, client.compression))
                for _ in range(client.copies):
                    outbox.append(sent)

    def log(self, text: str, time: int | None = None, stoppage: int | None = None) -> None:
        """A line of the text log."""
        for listener in self.listeners:
            listener(self.time if time is None else time, self.stoppage if stoppage is None else stoppage, text)

    # ------------------------------------------------------------------------------------------ what the referee and others say

    def tell_announcements(self) -> None:
        """Send what the referee announced since the last call."""
        w = self.world
        count = int(w["announced"])
        if not count:
            return
        now, stoppage = self.time, self.stoppage
        said = w["announcement"][:count].tolist()
        times = w["announced_at"][:count].tolist()
        w["announced"], w["announced_done"] = 0, 0
        for (kind, a, b, c), time in zip(said, times):
            if kind in _BROADCASTS:
                self._tell_change(kind, a, b, c)
            else:
                self.referee_says(announcement_text(kind, a, b, c), time, stoppage if time == now else self._stopped_before)
            if kind == Announcement.RED_CARD:
                self._thrown_out(a, b)

    def referee_says(self, name: str, time: int | None = None, stoppage: int | None = None) -> None:
        """The referee's word, to everybody who hears, at a clock that may have gone on since."""
        time = self.time if time is None else time
        stoppage = self.stoppage if stoppage is None else stoppage
        self.log(f"(referee {name})", time, stoppage)
        heard = f"(hear {time} referee {name})"
        for player in self.players():
            self.send(player, heard)
        for coach in self.coaches():
            self.send(coach, heard)
        if self.trainer is not None and self.trainer.ear:
            self.send(self.trainer, f"(hear referee {time} {name})")
        if self.settings.server.send_comms:
            self.board(f"(referee {name})", clock=(time, stoppage))

    def _tell_change(self, kind: int, side: int, unum: int, number: int) -> None:
        """Tell everybody of an exchanged player or of a new goalie."""
        if kind == Announcement.CHANGE_PLAYER_TYPE:
            listeners: list[Player | Coach] = [*self.players(), *self.coaches()]
            for client in listeners:
                if client.version >= 7:
                    own = client.side == side
                    self.send(client, f"(change_player_type {unum} {number})" if own else f"(change_player_type {unum})")
        text = announcement_text(kind, side, unum, number)
        if kind == Announcement.PROMOTE_GOALIE:
            for listener in (*self.players(), *self.coaches()):
                if listener.version >= 16:
                    self.send(listener, text)
        self.board(text)

    def player_says(self, player: Player, message: str) -> None:
        """Trainer, coaches and monitors hear a player at once."""
        for official in (*self.coaches(), *((self.trainer,) if self.trainer is not None and self.trainer.ear else ())):
            name = player_name(self.sim, official, player.row)
            if official.version >= 7:
                self.send(official, f'(hear {self.time} {name} "{message}")')
            elif isinstance(official, Coach):
                self.send(official, f"(hear {self.time} {name} {message})")
            else:
                self.send(official, f"(hear {name} {self.time} {message})")
        if self.settings.server.send_comms:
            self.board(f"((player {self.sim.team_names[player.row // 11]} {player.unum}) {message})")

    # ------------------------------------------------------------------------------------------ leaving

    def disable(self, player: Player) -> None:
        """The player leaves: his body goes home, his connection is closed."""
        w, row = self.world, player.row
        if w["enabled"][row]:
            w["enabled"][row] = 0
            w["bits"][row] = int(w["bits"][row]) & _KEPT_OUTSIDE
            w["pos"][row + 1], w["vel"][row + 1], w["acc"][row + 1] = home(row), 0.0, 0.0
        self.close(player)

    def close(self, client: Client) -> None:
        """Forget a client; its socket is closed."""
        client.connected = False
        if isinstance(client, Monitor):
            if client in self.monitors:
                self.monitors.remove(client)
        elif client is self.trainer:
            self.trainer = None
        elif isinstance(client, Player):
            team = self.teams[client.row // 11]
            if team.players[client.row % 11] is client:
                team.players[client.row % 11] = None
        elif isinstance(client, Coach):
            team = self.team_of(client.side)
            if team.coach is client:
                team.coach = None

    def _thrown_out(self, side: int, unum: int) -> None:
        """The connection of a player who was sent off."""
        team = self.team_of(side)
        row = unum - 1 + (0 if side == LEFT else PLAYERS_PER_TEAM)
        self.world["bits"][row] = int(PlayerBit.RED_CARD)
        player = team.players[unum - 1]
        if player is not None:
            self.close(player)

    # ------------------------------------------------------------------------------------------ time

    def advance(self, counts_looks: bool = True) -> None:
        """One step of the match, and what the referee says of it.

        Parameters
        ----------
        counts_looks : bool
            Let the step count the looks of those who see asynchronously; otherwise `count_look` does.
        """
        mode, stoppage = int(self.world["mode"]), self.stoppage
        self._stopped_before = stoppage + 1 if is_stopped(mode) else stoppage
        apart = [] if counts_looks else (self.world["synchronous"] == 0).nonzero()[0]
        counted = self.world["see_counter"][apart]
        self.sim.advance()
        self.world["see_counter"][apart], self.world["saw"][apart] = counted, 0
        self.tell_announcements()

    def kick_off(self) -> None:
        """The kick-off procedure. At the first one types are given out, also to players who have been there and left."""
        w, gone = self.world, []
        if self.time == 0:
            there = w["enabled"].tolist()
            joined = [row for side, team in enumerate(self.teams) for row in range(11 * side, 11 * side + team.joined)]
            gone = [row for row in joined if not there[row] and not int(w["bits"][row]) & PlayerBit.RED_CARD]
        w["enabled"][gone] = 1
        self.sim.trainer.start()
        w["enabled"][gone] = 0
        for row in gone:
            w["pos"][row + 1], w["vel"][row + 1] = home(row), 0.0
        self.tell_announcements()

    def kick_off_if_due(self) -> None:
        """The countdown of the automatic mode."""
        if self.settings.server.auto_mode:
            automatic_kick_offs(self.sim.world, self.sim.packed, 2 * PLAYERS_PER_TEAM)
            self.tell_announcements()

    def count_late_see(self) -> None:
        """Count the sub-tick between commands and step."""
        late_messages_of_all(self.sim.world)

    def count_look(self) -> None:
        """Count a sub-tick of other periods than the usual ones."""
        self.world["saw"] &= _SEEN_IN_STEP
        late_messages_of_all(self.sim.world)

    def world_changed(self) -> None:
        """After anything that the rules may have reacted to."""
        if self.world["announced"]:
            self.tell_announcements()
