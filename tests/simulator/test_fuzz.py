"""Any commands, however wild: no crash, no number that is not finite, no other world touched."""

from __future__ import annotations

import numpy as np
import pytest
from simulator_worlds import same

from cprm_gym.simulator.parameters import Rules
from cprm_gym.simulator.simulator import Simulator, no_commands
from cprm_gym.simulator.state import COMMAND, WORLD, PlayMode

WILD = np.array([0.0, -0.0, 1.0, -1.0, 50.0, 100.0, -100.0, 180.0, 1e3, 1e18, -1e300, 1e308, 5e-324, np.nan, np.inf, -np.inf])
REALS = [name for name in WORLD.names if WORLD[name].base.kind == "f"]
FIELDS = COMMAND.names
CODES = {"kind": 8, "view_width": 4, "view_quality": 3, "attention_side": 4, "attention_unum": 12, "say_length": 12, "say": 256}


def wild_commands(worlds, rng, valid):
    """Random commands: each number wild or ordinary, each code any byte unless `valid`."""
    commands = no_commands(worlds, 22)
    for name in FIELDS:
        field = commands[name]
        if field.dtype.kind == "f":
            ordinary = rng.uniform(-200, 200, field.shape)
            field[...] = np.where(rng.random(field.shape) < 0.25, rng.choice(WILD, field.shape), ordinary)
        elif valid:
            field[...] = rng.integers(0, CODES[name], field.shape)
        else:
            field[...] = rng.integers(0, 256, field.shape).astype(np.uint8).view(field.dtype)
    return commands


def check(simulator):
    """Everything finite, every code in its range."""
    world = simulator.world
    for name in REALS:
        assert np.isfinite(world[name]).all(), name
    assert np.abs(world["pos"]).max() < 1e7
    assert np.isin(world["mode"], list(PlayMode)).all()
    assert ((world["view_width"] >= 1) & (world["view_width"] <= 3)).all()
    assert (world["attention"] <= 22).all()
    assert (world["ball_catcher"] <= 22).all()
    assert ((world["stamina"] >= 0) & (world["stamina"] <= 8000)).all()
    assert (np.abs(world["body"]) <= np.pi + 1e-9).all()
    assert (np.abs(world["neck"]) <= np.pi / 2 + 1e-9).all()


def fuzz(cycles, seed, rules, worlds=20):
    """`cycles` cycles of wild commands, spread over `worlds` worlds; the last world is left in peace and must stay so."""
    simulator, peaceful = Simulator(worlds, seed=seed, rules=rules), Simulator(worlds, seed=seed, rules=rules)
    for one in (simulator, peaceful):
        one.trainer.start()
    rng = np.random.default_rng(seed)
    silence = no_commands(worlds, 22)
    for cycle in range(cycles // worlds):
        commands = wild_commands(worlds, rng, valid=cycle % 3 != 0)
        commands[-1] = silence[-1]
        simulator.step(commands)
        peaceful.step(silence)
        if cycle % 20 == 0:
            check(simulator)
        if cycle % 50 == 0:
            for array in (*simulator.see(), *simulator.hear(), *simulator.landmarks(), simulator.sense_body()):
                assert np.isfinite(array).all()
        if cycle % 500 == 250:  # live worlds, from anywhere
            simulator.world["pos"][:-1] = rng.uniform(-60, 60, (worlds - 1, 23, 2))
            simulator.world["mode"][:-1] = rng.integers(1, 52, worlds - 1)
    check(simulator)
    assert same(simulator.world[-1], peaceful.world[-1])


@pytest.mark.parametrize("rules", [Rules.ALL, Rules.NONE])
def test_wild_commands_for_twenty_thousand_cycles(rules):
    fuzz(20_000, 1, rules)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_wild_commands_for_a_million_cycles(seed):
    fuzz(100_000, 100 + seed, Rules.NONE if seed % 4 == 3 else Rules.ALL, worlds=50)
