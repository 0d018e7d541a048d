"""Players: connecting, reconnecting and their commands (specification/protocol.md 3, 4)."""

from __future__ import annotations

import math
import re
from collections.abc import Hashable
from typing import TYPE_CHECKING, Any

from ...simulator.kernels.audio import QUEUE_PROTOCOL
from ...simulator.protocol.commands import PlayerCommand, command_record, parse_commands, side_of_team
from ...simulator.protocol.messages import hear_text, score_text
from ...simulator.setup import NEVER_SUBSTITUTED, home
from ...simulator.state import LEFT, PlayerBit, PlayMode
from ..clients import Player, Refused
from ..stadium import PLAYERS_PER_TEAM, Stadium
from ..texts.parameter_texts import parameter_texts
from ..texts.pictures import player_name

if TYPE_CHECKING:
    from collections.abc import Callable

OLDEST, NEWEST = 1, 19
LONGEST_TEAM_NAME = 15
_TEAM_NAME = re.compile(r"[+-_a-z]+")
_OPTION = re.compile(r"\s*\(\s*(?:version\s+(?P<version>[^\s()]+)|(?P<goalie>goalie))\s*\)")
_REAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_RECONNECT = re.compile(r"\(reconnect +([+-_a-z]+) +([+-]?\d+)\s*\)")


def read_version(word: str) -> int | None:
    """The whole part of a version number, None when the word is none."""
    if not _REAL.fullmatch(word):
        return None
    try:
        return int(float(word))
    except OverflowError:
        return None


# ---------------------------------------------------------------------------------------------- connecting


def connect(stadium: Stadium, address: Hashable, text: str) -> Player:
    """Answer ``(init TEAM [(version V)] [(goalie)])`` at the well-known port; the new player, or None when he is refused."""

    rest = text[len("(init ") :].lstrip(" ")
    name = _TEAM_NAME.match(rest)
    if name is None:
        raise Refused("illegal_teamname")
    if len(name[0]) > LONGEST_TEAM_NAME:
        raise Refused("illegal_teamname_or_too_long_teamname")
    options = _options(rest[name.end() :])
    if options is None:
        raise Refused("illegal_command_form")
    if isinstance(options, str):
        raise Refused(options)
    version, goalie = options
    server = stadium.settings.server
    if name[0] in (server.fixed_teamname_l, server.fixed_teamname_r):
        raise Refused("conflict_with_fixed_teamname")
    side = _side_for(stadium, name[0])
    if side is None:
        raise Refused("no_more_team")
    team = stadium.team_of(side)
    first = 0 if side == LEFT else PLAYERS_PER_TEAM
    has_goalie = bool((stadium.world["goalie"][first : first + PLAYERS_PER_TEAM] != 0).any())
    if team.joined >= PLAYERS_PER_TEAM or (goalie and has_goalie) or not OLDEST <= version <= NEWEST:
        raise Refused("no_more_player_or_goalie_or_illegal_client_version")
    row = first + team.joined
    team.joined += 1
    player = Player(address, version, row)
    team.players[row - first] = player
    _enter(stadium, player, goalie)
    stadium.send(player, f"(init {'l' if side == LEFT else 'r'} {player.unum} {stadium.mode.name})")
    tell_parameters(stadium, player)
    if version >= 18:
        synchronous_see(stadium, player)
    return player


def _options(text: str) -> tuple[int, bool] | str | None:
    """Version and goalie from what follows the team's name; None for a syntax error, or the name of another error."""
    version, goalie = 3, False
    at = 0
    if text[:1] not in ("(", ")", " ", "\t", ""):
        return "illegal_teamname"
    while True:
        found = _OPTION.match(text, at)
        if found is None:
            break
        at = found.end()
        if found["goalie"]:
            goalie = True
            continue
        read = read_version(found["version"])
        if read is None:
            return None
        version = read
    rest = text[at:].lstrip()
    if rest.startswith(")"):
        return version, goalie
    return "illegal_teamname_or_too_long_teamname" if rest[:1].isalnum() else None


def _side_for(stadium: Stadium, name: str) -> int | None:
    """Side of the team of that name, which takes the first free side if it is new."""
    side = stadium.side_named(name)
    if side is not None:
        return side
    for index, team in enumerate(stadium.teams):
        if not team.name:
            team.name = name
            names = [team.name for team in stadium.teams]
            stadium.sim.team_names = names[0], names[1]
            return LEFT if index == 0 else -LEFT
    return None


def _enter(stadium: Stadium, player: Player, goalie: bool) -> None:
    """The body of a player who connects for the first time."""
    w, i = stadium.world, player.row
    w["enabled"][i] = 1
    w["bits"][i] = PlayerBit.STAND | (PlayerBit.GOALIE if goalie else 0)
    w["goalie"][i] = int(goalie)
    w["protocol"][i] = max(player.version, 3)
    w["pos"][i + 1], w["body"][i] = home(i), 0.0 if player.side == LEFT else math.pi
    team = i // PLAYERS_PER_TEAM
    w["on_field"][team, NEVER_SUBSTITUTED] += 1
    w["used_types"][team, NEVER_SUBSTITUTED] += 1


def tell_parameters(stadium: Stadium, player: Player) -> None:
    """What a player is told after he connected: parameters, then who is of another type."""
    settings = stadium.settings
    for text in parameter_texts(settings.server, settings.player, settings.types, player.version):
        stadium.send(player, text)
    tell_types(stadium, player, player.side)


def tell_types(stadium: Stadium, client: Any, side: int) -> None:
    """change_player_type for every player of another than the default type."""
    if client.version < 7:
        return
    for row, kind in enumerate(stadium.world["type"].tolist()):
        if kind:
            own = (row < PLAYERS_PER_TEAM) == (side == LEFT)
            unum = row % PLAYERS_PER_TEAM + 1
            stadium.send(client, f"(change_player_type {unum} {kind})" if own else f"(change_player_type {unum})")


def reconnect(stadium: Stadium, address: Hashable, text: str) -> Player:
    """Answer ``(reconnect TEAM U)`` at the well-known port."""

    if stadium.mode == PlayMode.play_on:
        raise Refused("cannot_reconnect_while_playon")
    found = _RECONNECT.match(text)
    if found is None:
        raise Refused("illegal_command_form", "no_such_team_or_player")
    side, unum = stadium.side_named(found[1]), int(found[2]) if len(found[2]) < 9 else 0
    if side is None or not 1 <= unum <= stadium.team_of(side).joined:
        raise Refused("no_such_team_or_player")
    team, w = stadium.team_of(side), stadium.world
    row = unum - 1 + (0 if side == LEFT else PLAYERS_PER_TEAM)
    if int(w["bits"][row]) & PlayerBit.RED_CARD:
        raise Refused("red_carded_player")
    before = team.players[unum - 1]
    if before is not None:
        before.connected = False
    player = Player(address, int(w["protocol"][row]), row)
    if before is not None:
        player.clang, player.done, player.copies = before.clang, before.done, before.copies + 1
    team.players[unum - 1] = player
    w["enabled"][row] = 1
    w["bits"][row] |= PlayerBit.STAND | (PlayerBit.GOALIE if w["goalie"][row] else 0)
    copies, player.copies = player.copies, 1
    stadium.send(player, f"(reconnect {'l' if side == LEFT else 'r'} {stadium.mode.name})")
    tell_parameters(stadium, player)
    player.copies = copies
    return player


# ---------------------------------------------------------------------------------------------- commands


def receive(stadium: Stadium, player: Player, text: str, begun: bool = False) -> None:
    """Execute a datagram of a player: its commands in order, up to the first mistake.

    Parameters
    ----------
    stadium : Stadium
    player : Player
    text : str
    begun : bool
        It is the rest of a datagram, whose beginning has been executed.
    """
    parsed = parse_commands(text)
    for command in parsed.commands:
        execute(stadium, player, command)
        if not player.connected:
            return
    if parsed.error is not None or not (parsed.commands or begun):
        stadium.send(player, "(error illegal_command_form)")


def execute(stadium: Stadium, player: Player, command: PlayerCommand) -> None:
    """Execute one command."""
    special = _SPECIAL.get(command.name)
    if special is not None:
        special(stadium, player, *command.args)
        return
    if command.name == "move":
        _warn_of_move(stadium, player, command.args[0])
    elif command.name == "attentionto" and not _may_attend(stadium, player, *command.args):
        return
    record = command_record(command, player.side, stadium.sim.team_names)
    if record is None:
        return
    stadium.sim.command_phase(0, player.row + 1, record)
    stadium.world_changed()


def _warn_of_move(stadium: Stadium, player: Player, x: float) -> None:
    """What a player is told of a move before it is carried out."""
    w, row, server = stadium.world, player.row, stadium.settings.server
    if w["busy"][row] or not w["enabled"][row]:
        return
    if stadium.mode == PlayMode.before_kick_off:
        size = stadium.settings.types[int(w["type"][row])].player_size
        if server.forbid_kick_off_offside and x >= -size:
            stadium.send(player, "(warning moving_to_opponent_field)")
    elif stadium.mode in (PlayMode.free_kick_l, PlayMode.free_kick_r) and int(w["ball_catcher"]) == row + 1:
        used_up = 0 <= server.goalie_max_moves <= int(w["moves_since_catch"][row])
        if used_up:
            stadium.send(player, "(error too_many_moves)")


def _may_attend(stadium: Stadium, player: Player, team: str, unum: int) -> bool:
    """Whether somebody of that number ever was in the team."""
    side = side_of_team(team, player.side, stadium.sim.team_names)
    return side is not None and 1 <= unum <= stadium.team_of(side).joined


def _say(stadium: Stadium, player: Player, message: str) -> None:
    w = stadium.world
    if not 0 < len(message) <= stadium.settings.server.say_msg_size:
        return
    record = command_record(PlayerCommand("say", (message,)))
    if record is None:
        return
    stadium.sim.command_phase(0, player.row + 1, record)
    stadium.player_says(player, message)
    k = int(w["audio_count"])
    for listener in stadium.players():
        if listener.version < QUEUE_PROTOCOL:
            n = int(w["heard_count"][listener.row])
            if listener is player:
                stadium.send(listener, f"(hear {stadium.time} self {_quoted(message, listener.version)})")
            elif n and int(w["heard"][listener.row, n - 1]) == k:
                stadium.send(listener, hear_text(stadium.sim, 0, listener.row + 1)[-1])


def _quoted(message: str, version: int) -> str:
    return f'"{message}"' if version >= 7 else message


def synchronous_see(stadium: Stadium, player: Player) -> None:
    """See once per cycle or seldomer, always in high quality."""
    w, i = stadium.world, player.row
    w["synchronous"][i], w["view_quality"][i] = 1, 1
    stadium.send(player, "(ok synch_see)")


def _gaussian_see(stadium: Stadium, player: Player) -> None:
    stadium.world["gaussian"][player.row] = 1
    stadium.send(player, "(ok gaussian_see)")


def _sense_body(stadium: Stadium, player: Player) -> None:
    stadium.send_raw(player, stadium.bulk.bodies([player.row])[0])


def _score(stadium: Stadium, player: Player) -> None:
    stadium.send(player, score_text(stadium.sim, 0, player.row + 1))


def _done(stadium: Stadium, player: Player) -> None:
    player.done = True


def _bye(stadium: Stadium, player: Player) -> None:
    stadium.disable(player)


def _ear(stadium: Stadium, player: Player, on: bool, team: str | None, mode: str | None) -> None:
    sides = (0, 1)
    if team is not None:
        side = side_of_team(team, player.side, stadium.sim.team_names)
        if side is None:
            stadium.send(player, f"(error no team with name {team.lstrip('=')})")
            return
        sides = (0,) if side == player.side else (1,)  # type: ignore[assignment]
    bits = {None: 3, "complete": 1, "partial": 2}[mode]
    for side in sides:
        ear = int(stadium.world["ear"][player.row, side])
        stadium.world["ear"][player.row, side] = ear | bits if on else ear & ~bits


def _clang(stadium: Stadium, player: Player, low: int, high: int) -> None:
    player.clang = low, high
    stadium.send(player, f"(ok clang (ver {low} {high}))")
    for coach in stadium.coaches():
        if coach.side == player.side:
            tell_language(stadium, coach, player)


def tell_language(stadium: Stadium, coach: Any, player: Player) -> None:
    """Tell a coach which versions of the coach's language a player understands."""
    if coach.version >= 8 and player.clang is not None:
        low, high = player.clang
        stadium.send(coach, f"(clang (ver {player_name(stadium.sim, coach, player.row)} {low} {high}))")


def _compression(stadium: Stadium, player: Player, level: int) -> None:
    if level <= 9:
        stadium.send(player, f"(ok compression {level})")
        player.compression = level


def _nothing(stadium: Stadium, player: Player, *_: float) -> None:
    """``long_kick`` is understood and does nothing."""


_SPECIAL: dict[str, Callable[..., None]] = {
    "say": _say,
    "synch_see": synchronous_see,
    "gaussian_see": _gaussian_see,
    "sense_body": _sense_body,
    "score": _score,
    "done": _done,
    "bye": _bye,
    "ear": _ear,
    "clang": _clang,
    "compression": _compression,
    "long_kick": _nothing,
}
