"""The referee favours nobody: a world turned by half a turn, with the teams exchanged, is judged the same way."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from referee_scenes import QUIET

from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.simulator import Simulator, no_commands
from cprm_gym.simulator.state import CommandKind, PlayMode

MODES = (
    [
        mode
        for mode in PlayMode
        if mode.name.rpartition("_")[0]
        in {
            "kick_off",
            "kick_in",
            "free_kick",
            "corner_kick",
            "goal_kick",
            "indirect_free_kick",
            "offside",
            "foul_charge",
            "back_pass",
            "free_kick_fault",
            "catch_fault",
            "illegal_defense",
            "goal",
        }
    ]
    + [PlayMode.play_on] * 20
    + [PlayMode.drop_ball]
)


def mirrored_mode(mode: int) -> int:
    name = PlayMode(mode).name
    stem, _, end = name.rpartition("_")
    return int(PlayMode[f"{stem}_{'r' if end == 'l' else 'l'}"]) if end in ("l", "r") else mode


def mirrored_row(row: int) -> int:
    return (row + 11) % 22


def populate(sim: Simulator, random: np.random.Generator) -> None:
    """Fill world 0 with players round a ball, world 1 with its mirror image."""
    here, there = sim.world[0], sim.world[1]
    ball = random.choice([random.uniform((-54.0, -35.0), (54.0, 35.0)), random.uniform((44.0, -12.0), (53.0, 12.0))])
    here["pos"][0] = ball
    here["vel"][0] = random.uniform(-2.0, 2.0, 2) * random.integers(0, 2)
    here["ball_prev"] = np.clip(ball - here["vel"][0], (-52.5, -34.0), (52.5, 34.0))
    near = random.random(22) < 0.4
    here["pos"][1:] = np.where(
        near[:, None], ball + random.normal(0.0, 1.0, (22, 2)), random.uniform((-55.0, -36.0), (55.0, 36.0), (22, 2))
    )
    here["vel"][1:] = random.normal(0.0, 0.2, (22, 2))
    here["body"] = here["body_staged"] = random.uniform(-3.0, 3.0, 22)
    for name in ("pos", "vel"):
        there[name][0] = -here[name][0]
        there[name][1:] = -np.roll(here[name][1:], 11, axis=0)
    there["ball_prev"] = -here["ball_prev"]
    there["body"] = there["body_staged"] = np.roll((here["body"] + 2 * math.pi) % (2 * math.pi) - math.pi, 11)


def random_command(random: np.random.Generator) -> Any:
    command = no_commands(1)[0]
    command["kind"] = random.choice([CommandKind.NONE, CommandKind.DASH, CommandKind.KICK, CommandKind.KICK, CommandKind.CATCH])
    command["a"], command["b"] = random.uniform(10.0, 100.0), random.uniform(-90.0, 90.0)
    if random.random() < 0.1:
        command["kind"], command["a"], command["b"] = CommandKind.TACKLE, 0.0, float(random.random() < 0.5)
    return command


def assert_mirrored(sim: Simulator) -> None:
    here, there = sim.world[0], sim.world[1]
    assert PlayMode(mirrored_mode(int(here["mode"]))) == PlayMode(int(there["mode"]))
    assert here["kick_off_side"] == -there["kick_off_side"]
    assert here["score"].tolist() == there["score"].tolist()[::-1]
    assert here["time"] == there["time"]
    assert here["stoppage"] == there["stoppage"]
    for name in ("pos", "vel"):
        np.testing.assert_allclose(here[name][0], -there[name][0], atol=1e-7)
        np.testing.assert_allclose(here[name][1:], -np.roll(there[name][1:], 11, axis=0), atol=1e-7)
    for name in ("enabled", "card_count", "bits", "foul_cycles", "offside_candidate"):
        assert here[name].tolist() == np.roll(there[name], 11).tolist(), name


def crowded_behind_the_halfway_line(world: Any) -> bool:
    """Two players who were put 0.3 m behind it touch each other, as far as they push each other apart."""
    x, y = world["pos"][1:].T
    return bool((np.diff(np.sort(y[np.abs(np.abs(x) - 0.3) < 1e-9])) < 0.7).any())


@settings(max_examples=150)
@given(seed=st.integers(0, 2**32 - 1), mode=st.sampled_from(MODES))
def test_mirrored_world_is_judged_mirrored(seed, mode):
    random = np.random.default_rng(seed)
    sim = Simulator(2, ServerParameters(**{**QUIET, "illegal_defense_number": 6}), seed=[1, 1])
    populate(sim, random)
    sim.world["kick_off_side"] = 1, -1
    sim.trainer.change_mode(mode, worlds=0)
    sim.trainer.change_mode(mirrored_mode(int(mode)), worlds=1)
    for _ in range(3):
        luck = random.choice([-1, 1], (3, 22))
        for world, shift in ((0, 0), (1, 11)):
            for name, outcomes in zip(("forced_tackle", "forced_foul", "forced_catch"), luck):
                sim.world[name][world] = np.roll(outcomes, shift)
        for row in random.permutation(22):
            command = random_command(random)
            sim.command_phase(0, int(row) + 1, command)
            sim.command_phase(1, mirrored_row(int(row)) + 1, command)
        sim.advance()
        # who is pushed to the limit of the pitch or put behind the halfway line may land on another, where chance decides
        assume((np.abs(sim.world["pos"][:, 1:]) < (57.2, 38.7)).all())
        assume(not crowded_behind_the_halfway_line(sim.world[0]))
        assert_mirrored(sim)
