"""Recordings of how often something happens: stretched catches, fouls and cards, who of several speakers is heard."""

from __future__ import annotations

import numpy as np

from ..state import BALL, CommandKind, PlayerBit, PlayMode
from .recording import Recording
from .report import Result
from .statistics import batch, same_counts, same_proportions


def catches(recording: Recording, result: Result) -> None:
    """Frequency of success of stretched catches."""
    pairs, copies = [], 400
    for record in recording.records:
        simulator = batch(recording, copies)
        world, commands = simulator.world, simulator.commands
        world["goalie"][:, 0], world["type"][:, 0] = 1, record["type"]
        world["pos"][:, 1] = -45.0, 0.0
        world["pos"][:, BALL] = -45.0 + record["dist"], record["lateral"]
        commands["kind"][:, 0], commands["a"][:, 0] = CommandKind.CATCH, 0.0
        simulator.step()
        caught = int(((world["bits_shown"][:, 0] & int(PlayerBit.CATCH_FAULT)) == 0).sum())
        pairs.append(((record["caught"], record["n"] - record["caught"]), (caught, copies - caught)))
        result.cycles += int(record["n"])
    same_proportions(result, "catch, success", pairs)


def fouls(recording: Recording, result: Result) -> None:
    """Frequency of detected fouls, cards and charged victims of successful and failed tackles."""
    pairs, copies = [], 1000
    for record in recording.records:
        words = str(record["key"])
        simulator = batch(recording, copies, (1, 12))
        world, commands = simulator.world, simulator.commands
        world["pos"][:, 2], world["pos"][:, 13], world["pos"][:, BALL] = (0.0, 10.0), (0.75, 10.0), (1.2, 10.0)
        world["dash_cycles"] = -1
        if "victim_dashed=True" in words:
            world["dash_cycles"][:, 12] = 0  # he dashed in the cycle before
        commands["kind"][:, 1], commands["a"][:, 1], commands["b"][:, 1] = CommandKind.TACKLE, 0.0, float("foul=on" in words)
        world["forced_tackle"][:, 1] = 1 if "tackle_success" in words else -1
        simulator.step()
        mine = {
            "foul_charge": int((world["mode"] == PlayMode.foul_charge_l).sum()),
            "yellow": int((world["card_count"][:, 1] > 0).sum()),
            "victim_charged_flag": int(((world["bits_shown"][:, 12] & int(PlayerBit.FOUL_CHARGED)) != 0).sum()),
        }
        result.cycles += int(record["n"])
        for name, count in mine.items():
            pairs.append(((record[name], record["n"] - record[name]), (count, copies - count)))
    same_proportions(result, "fouls, cards, charged victims", pairs)


_SPEAKERS = {"two": 1, "three": 2, "four": 3, "five": 4, "r1": 11, "r2": 12, "r3": 13}


def hearing(recording: Recording, result: Result) -> None:
    """Whose message is heard when several players speak."""
    pairs = []
    for record in recording.records:
        simulator = batch(recording, int(record["n"]), (0, *_SPEAKERS.values()))
        world, commands = simulator.world, simulator.commands
        for place, row in enumerate(_SPEAKERS.values()):
            world["pos"][:, row + 1] = 5.0 + 2.0 * place, 10.0
            commands["say"][:, row, 0], commands["say_length"][:, row] = ord("a") + place, 1
        words = (record["attention"] or "").strip("()").split()
        if words:
            world["attention"][:, 0] = int(words[2]) + (0 if words[1] == "our" else 11)
        simulator.step()
        result.cycles += int(record["n"])
        heard = world["heard"][:, 0]
        slots = np.maximum(heard.astype(int) - 1, 0)
        speaker = np.where(heard > 0, np.take_along_axis(world["audio_from"], slots, axis=1), 0)
        told = record["heard_full"]
        for team in (range(11), range(11, 22)):
            names = [name for name, row in _SPEAKERS.items() if row in team]
            own = [int((speaker == _SPEAKERS[name] + 1).sum()) for name in names]
            pairs.append(([int(told.get(name, 0)) for name in names], own))
            result.equal("hearing", 0, "l1", "messages heard in full", sum(int(told.get(name, 0)) for name in names), sum(own))
    same_counts(result, "hearing, choice among speakers", pairs)
