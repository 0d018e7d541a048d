"""The server's messages as text: see, sense_body, hear, fullstate, for protocol versions 3 to 19.

The texts are made from the same draws as the arrays of `cprm_gym.simulator.senses`, so both tell the same. Formats are those of
specification/protocol.md 5; numbers are printed as C's ``%g`` prints them.
`cprm_gym.simulator.protocol.message_parser` reads the texts back.
"""

from __future__ import annotations

import math
import re
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...errors import CommandError, ParameterError
from ..kernels import audio, body, geometry, landmark_sight, rounding, senses
from ..landmarks import GOALS, LANDMARK_NAMES, LINE_NAMES
from ..player_types import TypeColumn
from ..senses import new_landmarks, new_see
from ..state import BALL, PLAYERS, Announcement, Count, PlayerBit, PlayMode
from ..trainer import announcement_text

if TYPE_CHECKING:
    from ..simulator import Simulator

NEWEST_PROTOCOL, OLDEST_PROTOCOL = 19, 3
_R2D = 180.0 / math.pi
_WIDTHS = ("", "narrow", "normal", "wide")
_QUALITIES = ("high", "high", "low")
_CARDS = ("none", "yellow", "red")
_WORDS = ("ball", "close_ball", "flag", "close_flag", "goal", "close_goal", "player", "close_player", "line")
_SHORT = dict(zip(_WORDS, "bBfFgGpPl"))
_LONG = dict(zip(_WORDS, ("ball", "Ball", "flag", "Flag", "goal", "Goal", "player", "Player", "line")))


def real(value: float) -> str:
    """A real as the server prints it: six significant digits, no trailing zeros, ``-0`` for negative zero."""
    return f"{value:g}"


def whole(radians: float) -> str:
    """An angle that is a whole number of degrees."""
    return str(round(radians * _R2D))


class _Reader:
    """One player of one world, and what his client's protocol shows him."""

    def __init__(self, sim: Simulator, world: int, player: int, protocol: int | None) -> None:
        if isinstance(player, bool) or not isinstance(player, (int, np.integer)) or not 1 <= player <= PLAYERS:
            raise CommandError(f"`player` takes an object number from 1 to {PLAYERS}, got {player!r}")
        if not -sim.worlds <= world < sim.worlds:
            raise CommandError(f"`world` takes a number from 0 to {sim.worlds - 1}, got {world!r}")
        self.sim, self.world = sim, world
        self.w = sim.world[world]
        self.p = sim.packed[0]
        self.i = int(player) - 1
        own = int(self.w["protocol"][self.i]) or NEWEST_PROTOCOL
        self.protocol = own if protocol is None else int(protocol)
        if not OLDEST_PROTOCOL <= self.protocol <= NEWEST_PROTOCOL:
            raise ParameterError(f"`protocol` takes a version from {OLDEST_PROTOCOL} to {NEWEST_PROTOCOL}, got {protocol!r}")
        self.words = _SHORT if self.protocol >= 6 else _LONG

    @property
    def time(self) -> int:
        return int(self.w["time"])

    def limit(self, name: str, old: float) -> float:
        """A distance limit of the player's type, or the fixed one of protocols before 18."""
        return float(self.p["types"][self.w["type"][self.i], TypeColumn[name]]) if self.protocol >= senses.FOCUS_PROTOCOL else old

    def team_name(self, j: int) -> str:
        """Name of the team of player `j` (0..21), as this player is told it."""
        left = j < 11
        fixed = self.sim.parameters.fixed_teamname_l if left else self.sim.parameters.fixed_teamname_r
        name = fixed if fixed and left != (self.i < 11) else self.sim.team_names[0 if left else 1]
        return f'"{name}"' if self.protocol >= 6 else name

    def player_name(self, j: int, level: int, marks: int) -> str:
        if level == senses.FELT:
            return self.words["player" if marks & senses.IN_VIEW else "close_player"]
        name = f"{self.words['player']} {self.team_name(j)}"
        if level == senses.NAME_SEEN:
            marked = self.w["goalie"][j] == 1 or (self.w["goalie"][j] and (j < 11) == (self.i < 11))
            name += f" {j % 11 + 1}" + (" goalie" if marked and self.protocol >= 6 else "")
        return name

    def landmark_name(self, j: int, level: int) -> str:
        kind = "goal" if j in GOALS else "flag"
        return self.words[f"close_{kind}"] if level == senses.FELT else self.words[kind] + LANDMARK_NAMES[j][1:]


def _told(name: str, distance: float, direction: float, *rest: str) -> str:
    """One object of a see message; a distance that is NaN is not told (low quality)."""
    return " ".join((f"(({name})", *(() if math.isnan(distance) else (real(distance),)), whole(direction), *rest)) + ")"


def _changes(row: Any) -> tuple[str, ...]:
    return () if math.isnan(row[2]) else (real(row[2]), real(row[3] * _R2D))


def _told_player(reader: _Reader, j: int, row: Any, level: int, marks: int) -> str:
    """One player of a see message."""
    rest: list[str] = []
    if not math.isnan(row[0]) and level >= senses.TEAM_SEEN:
        if level == senses.NAME_SEEN:
            rest += _changes(row)
            if reader.protocol >= 4:
                rest.append(whole(row[4]))
            if reader.protocol >= 5:
                rest.append(whole(row[5]))
        if marks & senses.POINTING and reader.protocol >= 8:
            rest.append(whole(row[6]))
        if marks & senses.TACKLING and reader.protocol >= 8:
            rest.append("t")
        elif marks & senses.KICKING and reader.protocol >= 13:
            rest.append("k")
    return _told(reader.player_name(j, level, marks), row[0], row[1], *rest)


class _Object(NamedTuple):
    """One object of a see message: its text at the level it is seen at, and the texts that other draws could have given."""

    text: str
    others: tuple[str, ...] = ()
    pointing: bool = False


def _landmarks(r: _Reader, message: int) -> list[_Object]:
    out = new_landmarks(1)
    landmark_sight.look_at_landmarks(r.w, r.p, r.i, r.protocol, message, out.landmarks[0], out.level[0])
    rows, levels = out.landmarks[0, r.i], out.level[0, r.i]
    far = r.limit("FLAG_CHG_FAR_LENGTH", 20.0)
    return [_still_or_moving(r.landmark_name(j, levels[j]), rows[j], levels[j], far) for j in _rows(levels)]


def _rows(levels: Any) -> list[int]:
    """Rows of what is seen or felt."""
    return [int(j) for j in np.flatnonzero(levels)]


def _still_or_moving(name: str, row: Any, level: int, far: float) -> _Object:
    """A landmark or the ball; its changes may be lost beyond `far`."""
    still = _told(name, row[0], row[1])
    if level != senses.TOLD_MOVING:
        return _Object(still)
    return _Object(_told(name, row[0], row[1], *_changes(row)), (still,) if row[0] > far or math.isnan(row[0]) else ())


def _ball_and_players(r: _Reader, message: int) -> list[_Object]:
    out = new_see(1)
    look_out = out.ball[0], out.players[0], out.players_level[0], out.players_flags[0]
    level = senses.look(r.w, r.p, r.i, r.protocol, message, *look_out)[0]
    ball, rows, levels, marks = (array[r.i] for array in look_out)
    seen = []
    if level != senses.UNSEEN:
        name = r.words["close_ball" if level == senses.FELT else "ball"]
        seen.append(_still_or_moving(name, ball, level, r.limit("BALL_VEL_FAR_LENGTH", 20.0)))
    number, team = r.limit("UNUM_FAR_LENGTH", 20.0), r.limit("TEAM_FAR_LENGTH", 40.0)
    for j in _rows(levels):
        row, mark = rows[j], int(marks[j])
        lesser = []
        if levels[j] == senses.NAME_SEEN and not row[0] <= number:
            lesser.append(senses.TEAM_SEEN)
        if levels[j] >= senses.TEAM_SEEN and not row[0] <= team:
            lesser.append(senses.FELT)
        others = tuple(_told_player(r, j, row, level, mark) for level in lesser)
        seen.append(_Object(_told_player(r, j, row, levels[j], mark), others, bool(mark & senses.POINTING)))
    return seen


def _lines(r: _Reader) -> list[_Object]:
    out = new_landmarks(1)
    landmark_sight.look_at_lines(r.w, r.p, r.i, r.protocol, out.lines[0], out.line[0])
    seen = zip(out.lines[0, r.i], out.line[0, r.i])
    return [_Object(_told(r.words["line"] + LINE_NAMES[line][1:], row[0], row[1])) for row, line in seen if line]


def see_text(sim: Simulator, world: int, player: int, protocol: int | None = None, message: int = 0) -> str:
    """The see message that the player gets now.

    Parameters
    ----------
    sim : Simulator
    world : int
        Index of the world.
    player : int
        Object number 1 to 22.
    protocol : int, optional
        Version of the client, 3 to 19; the player's own (``sim.world["protocol"]``, 19 unless set) if not given. It decides names and
        rounding, and whether focus and types count (from 18 on).
    message : int
        Which message of the cycle, for the draws: 0 the first, 1 the second, 2 the one between commands and step. Bits 1, 2 and 4 of
        ``sim.world["saw"]`` tell which of them are due.

    Raises
    ------
    CommandError
        When there is no such world or player.
    ParameterError
        When there is no such protocol version.
    """
    r = _Reader(sim, world, player, protocol)
    seen = _landmarks(r, message) + _ball_and_players(r, message) + _lines(r)
    return f"(see {' '.join((str(r.time), *(item.text for item in seen)))})"


def see_mismatches(sim: Simulator, world: int, player: int, recorded: str, protocol: int | None = None) -> list[tuple[str, str]]:
    """What a recorded see message has that the player could not be told now: (recorded, possible) pairs of objects.

    Whether a number, a team or a change is lost at a distance where it may be lost, and the direction of a raised arm, are draws and
    may differ. Distances of the Gaussian model are draws too; such messages cannot be compared.

    Parameters
    ----------
    sim, world, player, protocol
        As for `see_text`.
    recorded : str
        The message.
    """
    r = _Reader(sim, world, player, protocol)
    possible = _landmarks(r, -1) + _ball_and_players(r, -1) + _lines(r)
    objects = re.findall(r"\(\([^()]*\)[^()]*\)", recorded)
    wrong = [] if re.match(rf"\(see {r.time}\b", recorded) else [(recorded[:12], f"(see {r.time} ...")]
    for told, item in zip_longest(objects, possible):
        if told is None or item is None or not any(_agree(told, text, item.pointing) for text in (item.text, *item.others)):
            wrong.append((told or "nothing", " or ".join((item.text, *item.others)) if item else "nothing"))
    return wrong


def _agree(told: str, text: str, pointing: bool) -> bool:
    """Whether two objects are equal, up to the direction of the arm: the last number of seven, or of three."""
    mine, other = text.split(), told.split()
    if told == text or not pointing or mine[0].endswith(")"):
        return told == text
    arm = -2 if mine[-1] in ("t)", "k)") else -1
    return len(mine) == len(other) and mine[:arm] == other[:arm] and (arm == -1 or mine[-1] == other[-1])


def _arm(r: _Reader) -> str:
    i = r.i
    movable, expires, distance, degrees = body.arm_in(r.sim.world, r.sim.packed, r.world, i)
    count = r.w["counts"][i, Count.ARM]
    return f"(arm (movable {movable}) (expires {expires}) (target {real(distance)} {int(degrees)}) (count {count}))"


def _whole_arm(r: _Reader) -> str:
    """The same in a fullstate message: the distance as it is, the direction rounded."""
    w, i = r.w, r.i
    movable, expires, _, _ = body.arm_in(r.sim.world, r.sim.packed, r.world, i)
    x, y = w["arm_target"][i] - w["pos"][i + 1] if expires else (0.0, 0.0)
    target = f"{real(math.sqrt(x * x + y * y))} {int(rounding.rounded_degrees(_face_angle(w, i, x, y))) if expires else 0}"
    return f"(arm (movable {movable}) (expires {expires}) (target {target}) (count {w['counts'][i, Count.ARM]}))"


def _card(bits: int) -> str:
    return _CARDS[2 if bits & PlayerBit.RED_CARD else 1 if bits & PlayerBit.YELLOW_CARD else 0]


def sense_body_text(sim: Simulator, world: int, player: int, protocol: int | None = None) -> str:
    """The sense_body message that the player gets after the last step; parameters and errors as in `see_text`."""
    r = _Reader(sim, world, player, protocol)
    w, i, v = r.w, r.i, r.protocol
    row = np.zeros(body.COLUMNS)
    body.sense_body(w, r.p, i, row)
    counts = w["counts"][i]
    parts = [
        f"(sense_body {r.time} (view_mode {_QUALITIES[w['view_quality'][i]]} {_WIDTHS[w['view_width'][i]]})",
        f"(stamina {real(row[body.STAMINA])} {real(row[body.EFFORT])}{' ' + real(row[body.CAPACITY]) if v >= 13 else ''})",
        f"(speed {real(row[body.SPEED])}{' ' + whole(row[body.SPEED_DIRECTION]) if v >= 6 else ''})",
    ]
    if v >= 5:
        parts.append(f"(head_angle {whole(row[body.HEAD_ANGLE])})")
    shown = ["kick", "dash", "turn", "say"]
    shown += ["turn_neck"] if v >= 5 else []
    shown += ["catch", "move", "change_view"] if v >= 7 else []
    shown += ["change_focus"] if v >= 18 else []
    parts += [f"({name} {counts[Count[name.upper()]]})" for name in shown]
    if v >= 8:
        target = int(w["attention"][i])
        told = "none" if not target else f"{'l' if target <= 11 else 'r'} {(target - 1) % 11 + 1}"
        parts.append(_arm(r))
        parts.append(f"(focus (target {told}) (count {counts[Count.ATTENTION]}))")
        parts.append(f"(tackle (expires {w['tackle_cycles'][i]}) (count {counts[Count.TACKLE]}))")
    if v >= 12:
        hit = [f"({name})" for name, k in (("ball", body.HIT_BALL), ("player", body.HIT_PLAYER), ("post", body.HIT_POST)) if row[k]]
        parts.append(f"(collision {' '.join(hit) or 'none'})")
    if v >= 14:
        parts.append(f"(foul (charged {w['foul_cycles'][i]}) (card {_card(int(w['bits'][i]))}))")
    if v >= 18:
        parts.append(f"(focus_point {real(row[body.FOCUS_DISTANCE])} {real(row[body.FOCUS_DIRECTION] * _R2D)})")
    return " ".join(parts) + ")"


def hear_text(sim: Simulator, world: int, player: int, protocol: int | None = None) -> list[str]:
    """The messages of players that the player heard of the last cycle; parameters and errors as in `see_text`.

    Clients of version 8 and later hear after the step, their own messages first. Older ones hear at once, while commands are executed, at
    the time before the step; they are not told who spoke, nor that somebody spoke whom they cannot understand.
    """
    r = _Reader(sim, world, player, protocol)
    w, i, v = r.w, r.i, r.protocol
    at_once = 0 < int(w["protocol"][i]) < audio.QUEUE_PROTOCOL
    time = int(w["audio_time"]) if at_once else r.time

    def content(k: int) -> str:
        text = bytes(w["audio_text"][k, : w["audio_length"][k]]).decode("ascii")
        return f'"{text}"' if v >= 7 else text

    heard = [(k, f"(hear {time} self {content(k)})") for k in range(w["audio_count"]) if w["audio_from"][k] == i + 1]
    for n, entry in enumerate(w["heard"][i, : w["heard_count"][i]]):
        k = abs(int(entry)) - 1
        speaker = int(w["audio_from"][k]) - 1
        own = (speaker < 11) == (i < 11)
        who = f"our {speaker % 11 + 1}" if own else "opp"
        if entry < 0:
            heard += [(k, f"(hear {time} {who})")] if v >= 8 else []
            continue
        rounded = v == audio.ROUNDED_PROTOCOL
        degrees = int(w["heard_from"][i, n] if at_once else audio.hear_degrees_in(sim.world, world, i, speaker, rounded))
        heard.append((k, f"(hear {time} {degrees} {who} {content(k)})" if v >= 8 else f"(hear {time} {degrees} {content(k)})"))
    return [text for _, text in (sorted(heard) if at_once else heard)]


def trainer_text(time: int, message: str, protocol: int = NEWEST_PROTOCOL) -> str:
    """What a player hears of the trainer's ``(say message)`` at `time`."""
    return f'(hear {time} coach "{message}")' if protocol >= 7 else f"(hear {time} referee {message})"


def _announcements(w: Any) -> list[tuple[int, tuple[int, int, int, int]]]:
    """(time, (kind and arguments)) of what was announced since the commands of the last step began."""
    return [
        (int(time), (int(row[0]), int(row[1]), int(row[2]), int(row[3])))
        for time, row in zip(w["announced_at"][: w["announced"]], w["announcement"])
    ]


_BROADCASTS = (Announcement.CHANGE_PLAYER_TYPE, Announcement.PROMOTE_GOALIE)


def referee_text(sim: Simulator, world: int) -> list[str]:
    """What every player heard of the referee during the last commands and step, in order: ``(hear T referee ...)``.

    Announcements made during the commands come first and carry the time before the step.
    """
    announced = _announcements(sim.world[world])
    return [f"(hear {time} referee {announcement_text(*said)})" for time, said in announced if said[0] not in _BROADCASTS]


def broadcast_text(sim: Simulator, world: int, player: int, protocol: int | None = None) -> list[str]:
    """What the player is told of changed players during the last commands and step (specification/protocol.md 5.2); see `see_text`.

    Opponents are not told the type; versions before 7 nothing, before 16 nothing of a promoted goalie.
    """
    r = _Reader(sim, world, player, protocol)
    told = []
    for _, (kind, side, unum, number) in _announcements(r.w):
        if kind == Announcement.CHANGE_PLAYER_TYPE and r.protocol >= 7:
            own = (side > 0) == (r.i < 11)
            told.append(f"(change_player_type {unum} {number})" if own else f"(change_player_type {unum})")
        elif kind == Announcement.PROMOTE_GOALIE and r.protocol >= 16:
            told.append(announcement_text(kind, side, unum))
    return told


def mode_text(w: Any) -> str:
    """Play mode as fullstate shows it: while a goalie holds the ball, ``goalie_catch_ball_l`` or ``_r``."""
    mode = PlayMode(int(w["mode"]))
    if w["ball_catcher"] and mode in (PlayMode.free_kick_l, PlayMode.free_kick_r):
        return "goalie_catch_ball_l" if mode == PlayMode.free_kick_l else "goalie_catch_ball_r"
    return "" if mode == PlayMode.null else mode.name


def _fullstate_player(r: _Reader, j: int) -> str:
    """One player of a fullstate message, versions 8 and later."""
    w, p, v = r.w, r.p, r.protocol
    goalie, kind = bool(w["goalie"][j]), int(w["type"][j])
    mark = (" g" if goalie else "") + f" {kind}" if v >= 14 else " g" if goalie else f" {kind}"
    numbers = [*w["pos"][j + 1], *w["vel"][j + 1], w["body"][j] * _R2D, w["neck"][j] * _R2D]
    parts = [f"((p {'l' if j < 11 else 'r'} {j % 11 + 1}{mark})", *map(real, numbers)]
    if w["arm_timer"][j] < p["point_to_duration"]:
        x, y = w["arm_target"][j] - w["pos"][j + 1]
        parts += [real(math.sqrt(x * x + y * y)), real(_face_angle(w, j, x, y))]
    if v >= 18:
        parts.append(f"(focus_point {real(w['focus_distance'][j])} {real(w['focus_direction'][j] * _R2D)})")
    energy = [w["stamina"][j], w["effort"][j], w["recovery"][j]] + ([w["capacity"][j]] if v >= 13 else [])
    parts.append(f"(stamina {' '.join(map(real, energy))})")
    if w["tackle_cycles"][j] > 0:
        parts += ["t"] if v >= 13 else []
    elif w["kick_cycles"][j] >= 0:
        parts += ["k"] if v >= 13 else []
    elif w["foul_cycles"][j] > 0:
        parts += ["f"] if v >= 14 else []
    card = _card(int(w["bits"][j]))
    if v >= 14 and card != "none":
        parts.append(card[0])
    return " ".join(parts) + ")"


def _face_angle(w: Any, j: int, x: float, y: float) -> float:
    return float(rounding.face_direction(x, y, w["body"][j], w["neck"][j]))


def _fullstate_head(r: _Reader) -> str:
    w, i = r.w, r.i
    return f"(fullstate {r.time} (pmode {mode_text(w)}) (vmode {_QUALITIES[w['view_quality'][i]]} {_WIDTHS[w['view_width'][i]]})"


def _old_fullstate(r: _Reader) -> str:
    """Versions 5 to 7: rounded (stamina cut), without counts, and with the goals of the right team in the place of the left one's."""

    def rounded(values: Any, step: float = 0.001) -> str:
        return " ".join(real(float(geometry.quantize(float(value), step))) for value in values)

    w = r.w
    parts = [
        _fullstate_head(r),
        f"(score {w['score'][1] if w['enabled'][:11].any() else 0} 0)",
        f"(ball {rounded((*w['pos'][BALL], *w['vel'][BALL]))})",
    ]
    for j in np.flatnonzero(w["enabled"]):
        numbers = rounded((*w["pos"][j + 1], *w["vel"][j + 1], w["body"][j] * _R2D, w["neck"][j] * _R2D))
        energy = f"{int(w['stamina'][j])} {rounded((w['effort'][j], w['recovery'][j]), 0.0001)}"
        parts.append(f"({'l' if j < 11 else 'r'}_{j % 11 + 1} {numbers} {energy})")
    return " ".join(parts) + ")"


def fullstate_rest(sim: Simulator, world: int, player: int, protocol: int | None = None) -> str:
    """What the fullstate messages of one cycle have in common for all players of a version (8 and later): ball and players."""
    r = _Reader(sim, world, player, protocol)
    ball = f"((b) {' '.join(map(real, (*r.w['pos'][BALL], *r.w['vel'][BALL])))})"
    return " ".join((ball, *(_fullstate_player(r, j) for j in range(PLAYERS) if r.w["enabled"][j])))


def fullstate_text(sim: Simulator, world: int, player: int, protocol: int | None = None, rest: str | None = None) -> str:
    """The fullstate message of the player (versions 5 and later); parameters and errors as in `see_text`.

    Parameters
    ----------
    sim, world, player, protocol
        As for `see_text`.
    rest : str, optional
        Of `fullstate_rest`, where it has been made already.

    Raises
    ------
    ParameterError
        When the version is below 5.
    """
    r = _Reader(sim, world, player, protocol)
    w, i, v = r.w, r.i, r.protocol
    if v < 5:
        raise ParameterError(f"fullstate is written for protocol versions 5 to {NEWEST_PROTOCOL}, got {v}")
    if v < 8:
        return _old_fullstate(r)
    counts = ["kick", "dash", "turn", "catch", "move", "turn_neck", "change_view", "say"] + (["change_focus"] if v >= 18 else [])
    score = w["score"] if i < 11 else w["score"][::-1]
    parts = [
        _fullstate_head(r),
        f"(count {' '.join(str(w['counts'][i, Count[name.upper()]]) for name in counts)})",
        _whole_arm(r),
        f"(score {score[0]} {score[1]})",
        fullstate_rest(sim, world, player, protocol) if rest is None else rest,
    ]
    return " ".join(parts) + ")"


def score_text(sim: Simulator, world: int, player: int) -> str:
    """The answer to the player's ``(score)``: the own team's goals first."""
    r = _Reader(sim, world, player, None)
    own, other = r.w["score"] if r.i < 11 else r.w["score"][::-1]
    return f"(score {r.time} {own} {other})"


def _global_player(sim: Simulator, w: Any, j: int, look: bool) -> str:
    """One player of a trainer's or coach's picture."""
    name = f'(p "{sim.team_names[0 if j < 11 else 1]}" {j % 11 + 1}{" goalie" if w["goalie"][j] else ""})'
    parts = [f"({name}", *map(real, (*w["pos"][j + 1], *w["vel"][j + 1]))]
    parts += [str(int(rounding.rounded_degrees(w["body"][j]))), str(int(rounding.rounded_degrees(w["neck"][j])))]
    pointing = w["arm_timer"][j] < sim.packed["point_to_duration"][0]
    if pointing:
        x, y = w["arm_target"][j] - w["pos"][j + 1]
        parts.append(str(int(rounding.rounded_degrees(math.atan2(y, x)))))
    if w["tackle_cycles"][j] > 0:
        parts.append("t")
    elif not look and w["kick_cycles"][j] >= 0:
        parts.append("k")
    elif not look and not pointing and w["foul_cycles"][j] > 0:
        parts.append("f")
    card = _card(int(w["bits"][j]))
    if not look and card != "none":
        parts.append(card[0])
    return " ".join(parts) + ")"


def global_text(sim: Simulator, world: int, look: bool = False) -> str:
    """The picture of the whole pitch that trainer and coaches get every cycle, without noise (specification/protocol.md 6).

    Parameters
    ----------
    sim : Simulator
    world : int
        Index of the world.
    look : bool
        The answer ``(ok look ...)`` to a question instead of ``(see_global ...)``; it marks nothing but tackles.
    """
    w = sim.world[world]
    head = f"(ok look {w['time']}" if look else f"(see_global {w['time']}"
    ball = " ".join(map(real, (*w["pos"][BALL], *w["vel"][BALL])))
    players = [_global_player(sim, w, j, look) for j in range(PLAYERS) if w["enabled"][j]]
    return " ".join((head, "((g r) 52.5 0)", "((g l) -52.5 0)", f"((b) {ball})", *players)) + ")"
