"""The compiled executor and the plain-Python interpreter do the same, step by step, on random nets with every feature."""

import numpy as np
import pytest
from petri_random_nets import OBJECTS, random_net, random_world
from reference_interpreter import Reference

from cprm_gym.architecture.petri import Executor, compile_net
from cprm_gym.errors import ExpressionError, LivelockError

GROUPS = (("turn", "kick"),)
COPIES, CYCLES = 2, 14


def clocks(executor: Executor, copy: int) -> dict[str, tuple[list[int], list[int]]]:
    """Transition -> running clocks, paused clocks."""
    found = {}
    snapshot = executor.snapshot()
    for t, name in enumerate(executor.net.transition_names):
        if executor.net.delay[t] > 0:
            spans = executor._program.transitions[t]
            values = snapshot.clock[copy, spans["clock"] : spans["clock_end"]].tolist()
            found[name] = (sorted(c for c in values if c >= 0), sorted(-2 - c for c in values if c < -1))
    return found


def flat(commands: dict[str, dict[str, float]]) -> dict[tuple[str, str], float]:
    """Commands and their parameters in one level."""
    return {(name, key): value for name, values in commands.items() for key, value in {"": 1.0, **values}.items()}


def compare(seed: int) -> int:
    """Run one random net in both; returns the number of firings."""
    rng = np.random.default_rng(seed)
    net = random_net(rng)
    compiled = compile_net(net)
    executor = Executor(compiled, COPIES, objects=OBJECTS, exclusive=GROUPS, seed=seed, trace=True)
    read = {"present", *executor.attributes["Opponent"]}
    references = [Reference(net, OBJECTS, seed, copy) for copy in range(COPIES)]
    total = 0
    for cycle in range(CYCLES):
        worlds = [random_world(rng) for _ in range(COPIES)]
        inputs = np.array([[world[0][name] for name in executor.input_names] for world in worlds])
        beliefs = np.array([[world[1][name] for name in executor.belief_names] for world in worlds])
        objects = {"Opponent": {key: np.array([w[2]["Opponent"][key] for w in worlds]) for key in read}}
        expected, failure = [], None
        for reference, world in zip(references, worlds):
            reference.groups = GROUPS
            try:
                expected.append(reference.step(*world))
            except (LivelockError, ExpressionError) as error:
                failure = failure or type(error)
        if failure:
            with pytest.raises(failure):
                executor.step(inputs, beliefs=beliefs, objects=objects)
            return total
        commands = executor.step(inputs, beliefs=beliefs, objects=objects)
        for copy, (fired, sent, overruled) in enumerate(expected):
            where = f"seed {seed}, cycle {cycle}, copy {copy}"
            got = [f.transition for f in executor.trace.firings(copy) if f.cycle == cycle]
            assert got == fired, where
            marking = dict(zip(compiled.place_names, executor.marking[copy].tolist()))
            assert marking == pytest.approx(references[copy].marking, rel=1e-12, abs=1e-12), where
            assert {name: int(executor.holds(name)[copy]) for name in executor.object_names} == references[copy].held, where
            for name, (running, paused) in clocks(executor, copy).items():
                assert running == sorted(references[copy].running[name]), f"{where}, clocks of {name}"
                assert paused == sorted(references[copy].paused[name]), f"{where}, paused clocks of {name}"
            assert flat(commands.of(copy)) == pytest.approx(flat(sent), rel=1e-12), where
            assert {compiled.transition_names[t] for t in np.flatnonzero(commands.overruled[copy])} == overruled, where
            total += len(fired)
    return total


@pytest.mark.parametrize("block", range(10))
def test_compiled_and_reference_interpreter_agree_on_random_nets(block):
    firings = sum(compare(seed) for seed in range(block * 30, block * 30 + 30))
    assert firings > 200


@pytest.mark.slow
@pytest.mark.parametrize("block", range(100))
def test_compiled_and_reference_interpreter_agree_on_ten_thousand_random_nets(block):
    firings = sum(compare(seed) for seed in range(100_000 + block * 100, 100_000 + block * 100 + 100))
    assert firings > 800
