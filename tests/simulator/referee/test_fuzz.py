"""The referee keeps order whatever the players and the trainer do."""

from __future__ import annotations

import numpy as np
import pytest

from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import CommandKind, PlayMode
from cprm_gym.simulator.trainer import announcement_text

WORLDS = 40


def shuffle_commands(sim: Simulator, random: np.random.Generator) -> None:
    """Random body commands, kicks and tackles for the most part."""
    shape = sim.commands["kind"].shape
    sim.commands["kind"] = random.choice([*CommandKind, CommandKind.KICK, CommandKind.KICK], shape)
    for name in "abcd":
        sim.commands[name] = random.uniform(-100.0, 100.0, shape)


def intervene(sim: Simulator, random: np.random.Generator) -> None:
    """The trainer puts the ball among the players or out of the pitch, and changes modes, in some worlds."""
    some = random.random(WORLDS) < 0.1
    if some.any():
        count = int(some.sum())
        sim.trainer.place_ball(
            random.uniform(-60, 60, count), random.uniform(-40, 40, count), *random.uniform(-3, 3, (2, count)), worlds=some
        )
        near = random.integers(1, 23)
        x, y = sim.world["pos"][some, 0].T
        sim.trainer.place_player(int(near), x + 0.5, y, worlds=some)
    sim.trainer.change_mode(int(random.integers(1, 52)), worlds=int(random.integers(WORLDS)))


@pytest.mark.parametrize(
    "parameters",
    [
        {"half_time": 10, "extra_half_time": 3, "auto_mode": True, "kick_off_wait": 3, "illegal_defense_number": 4},
        {"half_time": 2, "nr_extra_halfs": 0, "pen_setup_wait": 3, "auto_mode": True, "kick_off_wait": 2, "red_card_probability": 0.5},
        {"proper_goal_kicks": True, "free_kick_faults": False, "pen_coach_moves_players": False, "half_time": 2, "nr_extra_halfs": 0},
        {"keepaway": True, "half_time": -1},
    ],
    ids=["match", "shoot-out", "old rules", "keepaway"],
)
def test_order_is_kept(parameters):
    random = np.random.default_rng(11)
    sim = Simulator(WORLDS, ServerParameters(**parameters), seed=3)
    modes, said = set(), set()
    for _ in range(300):
        shuffle_commands(sim, random)
        intervene(sim, random)
        sim.step()
        world = sim.world
        for name in ("pos", "vel", "acc", "body", "stamina"):
            assert np.isfinite(world[name]).all(), name
        modes.update(world["mode"].tolist())
        assert (world["ruling"] == 0).all()
        assert (world["stoppage"] >= 0).all()
        assert (world["announced"] <= 32).all()
        on = (world["enabled"] != 0) & np.isin(world["mode"], (PlayMode.play_on,))[:, None]
        assert (np.abs(world["pos"][:, 1:][on]) < (58.2, 39.7)).all()
        for k in np.flatnonzero(world["announced"])[:4]:
            said.update(announcement_text(*(int(n) for n in row)) for row in world["announcement"][k, : world["announced"][k]])
    assert len(modes) > 20
    assert "play_on" in said
