"""The cycle that looks at changes only does what the one did that looked at everything, to the last bit, on random nets."""

import numpy as np
import pytest
from petri_random_nets import OBJECTS, pick, random_net, random_world
from scanning_cycle import ScanningExecutor

from cprm_gym.architecture.petri import Executor, PetriNet, Place, Transition, compile_net
from cprm_gym.errors import CprmError

GROUPS = (("turn", "kick"),)
COPIES, CYCLES = 3, 12


def outcome(executor, act):
    """The class of the error that a call raises, None for none."""
    try:
        act(executor)
    except CprmError as error:
        return type(error), str(error)
    return None


def disturbed(rng, net, snapshots):
    """Something that is done to a running executor from outside."""
    what = pick(rng, ["nothing", "nothing", "nothing", "write", "reset", "restore", "fire"])
    copy = int(rng.integers(COPIES))
    if what == "write":
        place = pick(rng, [p for p in net.net.places if isinstance(p, Place)])
        return lambda e: e.write(place.name, int(rng.bit_generator.seed_seq.entropy) % (place.capacity + 1), which=[copy])
    if what == "reset":
        return lambda e: e.reset(np.arange(COPIES) == copy)
    if what == "restore" and snapshots:
        kept = pick(rng, snapshots)
        return lambda e: e.restore(kept)
    if what == "fire":
        name = pick(rng, net.transition_names)
        return lambda e: e.fire(name, copy) if name in e.enabled(copy) else None
    return lambda e: None


def same(a, b):
    """Whether two arrays are the same bit by bit."""
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def compare(seed: int) -> int:
    """Run one random net both ways, with interference from outside; returns the number of firings."""
    rng = np.random.default_rng(seed)
    net = compile_net(random_net(rng))
    options = {"objects": OBJECTS, "exclusive": GROUPS, "seed": seed, "trace": bool(seed % 2)}
    mine, scanning = Executor(net, COPIES, **options), ScanningExecutor(net, COPIES, **options)
    read = {"present", *mine.attributes["Opponent"]}
    snapshots, world = [], None
    for cycle in range(CYCLES):
        where = f"seed {seed}, cycle {cycle}"
        act = disturbed(rng, net, snapshots)
        assert outcome(mine, act) == outcome(scanning, act), where
        if world is None or rng.random() < 0.6:  # else everything is as it was
            worlds = [random_world(rng) for _ in range(COPIES)]
            inputs = np.array([[w[0][name] for name in mine.input_names] for w in worlds])
            beliefs = np.array([[w[1][name] for name in mine.belief_names] for w in worlds])
            world = inputs, beliefs, {"Opponent": {key: np.array([w[2]["Opponent"][key] for w in worlds]) for key in read}}
        inputs, beliefs, objects = world
        step = lambda e: e.step(inputs, beliefs=beliefs, objects=objects)  # noqa: B023, E731
        assert outcome(mine, step) == outcome(scanning, step), where
        for name, a, b in zip(mine.snapshot()._fields, mine.snapshot(), scanning.snapshot()):
            assert same(a, b), f"{where}: {name}"
        for name, a, b in zip(mine._out._fields, mine._out, scanning._out):
            assert same(a, b), f"{where}: {name}"
        assert mine.conflicts == scanning.conflicts, where
        if mine.trace is not None:
            assert mine.trace.text() == scanning.trace.text(), where
        snapshots.append(mine.snapshot())
    return len(mine.trace.firings()) if mine.trace is not None else 0


@pytest.mark.parametrize("block", range(3))
def test_the_executor_and_the_scanning_one_are_the_same_bit_by_bit(block):
    firings = sum(compare(seed) for seed in range(block * 40, block * 40 + 40))
    assert firings > 200


@pytest.mark.slow
@pytest.mark.parametrize("block", range(100))
def test_they_are_the_same_on_ten_thousand_random_nets(block):
    firings = sum(compare(seed) for seed in range(200_000 + block * 100, 200_000 + block * 100 + 100))
    assert firings > 800


@pytest.mark.parametrize("count", [31, 32, 33, 1023, 1024, 1025, 2100])
def test_whichever_of_many_transitions_is_enabled_fires(count):
    """Words and tops of the sets have edges at 32 and 1024."""
    places = (*(Place(f"p{i}", capacity=1) for i in range(count)), *(Place(f"q{i}", capacity=1) for i in range(count)))
    now = tuple(Transition(f"now{i}", (f"p{i}",), (f"q{i}",)) for i in range(count))
    later = tuple(Transition(f"later{i}", (f"q{i}",), delay=1) for i in range(count))
    executor = Executor(PetriNet("wide", places, (*now, *later)), batch=2)
    for i in {i for i in (0, 30, 31, 32, count // 2, count - 2, count - 1) if i < count}:
        executor.write(f"p{i}", 1, which=[1])
        executor.step()
        assert executor.marking[1].nonzero()[0].tolist() == [count + i]
        executor.step()
        assert not executor.marking.any()
