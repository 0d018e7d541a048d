"""What monitors are sent: parameters, one frame per step, messages; text versions 3 to 5 and JSON (specification/protocol.md 10)."""

from __future__ import annotations

import json

import numpy as np

from ...simulator.gamelog.binary_writer import binary_frame, binary_message, binary_parameters
from ...simulator.gamelog.frames import Frame
from ...simulator.gamelog.kernels import show
from ...simulator.gamelog.kernels.show import POSITION_STEP
from ...simulator.gamelog.writer import (
    frame_of,
    json_parameters,
    json_player,
    json_team,
    json_time,
    quantised,
    shown_players,
    text_player,
)
from ...simulator.simulator import Simulator

JSON = -1
_LINE = np.zeros(show.LONGEST_LINE, np.uint8)
VERSIONS = (JSON, 1, 2, 3, 4, 5)
"""Protocols of monitors."""


class FrameTexts:
    """Makes what monitors are sent of one match.

    Parameters
    ----------
    sim : Simulator
        Of one world.
    """

    def __init__(self, sim: Simulator) -> None:
        self._sim = sim
        self._parameters: dict[int, tuple[bytes, ...]] = {}

    def parameters(self, version: int) -> tuple[bytes, ...]:
        """Datagrams that a monitor gets when it connects."""
        if version not in self._parameters:
            self._parameters[version] = self._make_parameters(version)
        return self._parameters[version]

    def _make_parameters(self, version: int) -> tuple[bytes, ...]:
        sim = self._sim
        if version == 1:
            return ()
        if version == 2:
            return binary_parameters(sim.parameters, sim.player_parameters, sim.types)
        if version == JSON:
            texts = [
                f'{{"server_param":{json_parameters(sim.parameters, alphabetical=True)}}}',
                f'{{"player_param":{json_parameters(sim.player_parameters, alphabetical=True)}}}',
                *(f'{{"player_type":{{"id":{n},{json_parameters(kind)[1:]}}}' for n, kind in enumerate(sim.types)),
            ]
        else:
            texts = [sim.parameters.to_text(), sim.player_parameters.to_text(), *(kind.to_text(n) for n, kind in enumerate(sim.types))]
        return tuple(text.encode("latin-1", "replace") + b"\0" for text in texts)

    def frame(self) -> Frame:
        """The world as it is now."""
        return frame_of(self._sim.world[0], self._sim.parameters, self._sim.team_names)

    def datagram(self, frame: Frame, version: int) -> bytes:
        """`frame` as a monitor of `version` gets it."""
        if version in (1, 2):
            return binary_frame(frame, version)
        text = _json_frame(frame) if version == JSON else _text_frame(frame, version)
        return text.encode("latin-1", "replace") + b"\0"

    @staticmethod
    def message(text: str, board: int, version: int, time: int, stoppage: int) -> bytes:
        """A text for the message board."""
        if version in (1, 2):
            return binary_message(text, board, version)
        if version != JSON:
            made = f'(msg {time} {board} "{text}")'
        elif text.startswith("(team_graphic_"):
            made = _json_graphic(text)
        else:
            made = f'{{"msg":{{{json_time(time, stoppage)},"board":{board},"message":{_json_text(text)}}}}}'
        return made.encode("latin-1", "replace") + b"\0"


def _json_text(text: str) -> str:
    """A string of JSON in which only quotes and backslashes are escaped, as the server's are."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _json_graphic(text: str) -> str:
    """``(team_graphic_l (X Y "line" ...))`` as an object."""
    head, rest = text[14:].split(" (", 1)
    x, y, lines = rest.split(" ", 2)
    rows = lines.split('"')[1::2]
    return f'{{"team_graphic":{{"side":"{head}","x":{x},"y":{y},"xpm":[{",".join(_json_text(row) for row in rows)}]}}}}'


def _text_frame(frame: Frame, version: int) -> str:
    """``(show T (pm N) (tm ...) ((b) ...) ((l 1) ...) ...)``."""
    left, right = frame.left, frame.right
    state = f"(show {frame.time} (pm {int(frame.mode)})"
    teams = f"{left.name or 'null'} {right.name or 'null'} {left.score} {right.score}"
    if any((left.pen_score, left.pen_miss, right.pen_score, right.pen_miss)):
        teams += f" {left.pen_score} {left.pen_miss} {right.pen_score} {right.pen_miss}"
    length = show.write_show(frame.time, frame.ball, frame.players, version == 5, _LINE) if version > 3 else -1
    if length > 0:
        line = _LINE[: length - 1].tobytes().decode("latin-1")
        return f"{state} (tm {teams}){line[line.index(' ((b)') :]}"
    ball = " ".join(quantised(value, POSITION_STEP) for value in frame.ball)
    players = " ".join(text_player(row, version + 1) for row in shown_players(frame.players))
    return f"{state} (tm {teams}) ((b) {ball}) {players})"


def _json_frame(frame: Frame) -> str:
    """The same as an object."""
    ball = ",".join(f'"{name}":{quantised(value, POSITION_STEP)}' for name, value in zip(("x", "y", "vx", "vy"), frame.ball))
    players = ",".join(json_player(row, monitor=True) for row in shown_players(frame.players))
    teams = f'"l":{json_team(frame.left)},"r":{json_team(frame.right)}'
    return (
        f'{{"show":{{{json_time(frame.time, frame.stoppage)},"mode":{json.dumps(frame.mode.name)},"team":{{{teams}}},'
        f'"ball":{{{ball}}},"players":[{players}]}}}}'
    )
