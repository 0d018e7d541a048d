"""A net as one state machine sends what the net sends, and is as large as the product of what runs at once."""

from __future__ import annotations

import numpy as np
import pytest

from cprm_gym.architecture.petri import Command, Executor, Input, Math, ObjectPlace, PetriNet, Place, Transition
from cprm_gym.architecture.product_machine import NOWHERE, Outcome, ProductMachine, ProductRunner
from cprm_gym.benchmark.chapter5.facts import concurrency
from cprm_gym.errors import LivelockError, NetError

CYCLES, WORLDS = 120, 8


def _waiting(delay: int) -> PetriNet:
    """Counts, waits, and says by a quantity of its own tokens how far it is."""
    return PetriNet(
        "waiting",
        places=(
            Place("rest", capacity=1, tokens=1), Place("work", capacity=1), Place("done", capacity=1), Place("turns", capacity=3),
            Input("signal", observes="signal"), Input("level", observes="level"),
            Math("effort", "level + 10 * turns"), Math("busy", "work"), Math("high", "1 if effort > 12 else 0"),
        ),
        transitions=(
            Transition("start", ("rest",), ("work",), tests={"signal": 0.5}, sets={"turns": 0}),
            Transition("go_on", ("work",), ("work", "turns"), tests={"signal": 0.5}, delay=1, emits=Command("work", effort="effort")),
            Transition("tire", ("work",), ("done",), tests={"busy": 1, "high": 1}, delay=2, priority=1, emits=Command("stop")),
            Transition("give_up", ("work",), ("rest",), inhibitors={"signal": 0.5}, delay=delay, emits=Command("rest", left="turns")),
            Transition("again", ("done",), ("rest",), delay=delay),
        ),
    )  # fmt: skip


@pytest.mark.parametrize("net", [_waiting(1), _waiting(3), concurrency.net(1), concurrency.net(3)], ids=lambda net: net.name)
def test_the_machine_sends_what_the_net_sends(net):
    executor, runner = Executor(net, WORLDS), ProductRunner(ProductMachine(net), WORLDS)
    draws, sent = np.random.default_rng(4), 0
    for cycle in range(CYCLES):
        inputs = {name: draws.random(WORLDS) * (8.0 if name == "level" else 1.0) for name in executor.input_names}
        inputs = {name: np.rint(values) if name != "level" else values for name, values in inputs.items()}
        if cycle == CYCLES // 2:
            some = np.arange(WORLDS) % 2 == 0
            executor.reset(some), runner.reset(some)
        executor.step(inputs)
        runner.step(inputs)
        (fired, values), (other_fired, other_values) = executor.sent, runner.sent
        assert np.array_equal(fired, other_fired)
        for k, name in enumerate(executor.command_names):
            columns = list(executor.parameters(name).values())
            assert np.array_equal(values[fired[:, k]][:, columns], other_values[fired[:, k]][:, columns])
        sent += int(fired.sum())
    assert sent > CYCLES


def test_skills_that_share_nothing_multiply():
    found = [ProductMachine(concurrency.net(k)).explore() for k in (1, 2, 3)]
    assert all(e.complete and e.expanded == e.states and not e.endless for e in found)
    (one, two, three) = (e.states - 1 for e in found)  # the start, in which no clock runs, comes but once
    assert (two, three) == (one**2, one**3)


def test_what_a_budget_does_not_reach_is_not_claimed():
    machine = ProductMachine(concurrency.net(5))
    cut = machine.explore(states=20)
    assert not cut.complete
    assert cut.expanded < cut.states
    assert machine.explore().complete


def test_the_reached_state_is_a_marking_with_its_clocks():
    machine = ProductMachine(_waiting(3))
    runner = ProductRunner(machine)
    runner.step({"signal": 1.0, "level": 0.0})
    tokens, clocks = machine.states[runner.state[0]]
    assert tokens == (0, 1, 0, 0)
    assert clocks == (0, -1, -1, -1)


def test_a_net_that_goes_round_in_an_instant_leads_nowhere():
    net = PetriNet(
        "to and fro",
        places=(Place("a", tokens=1), Place("b"), Input("go")),
        transitions=(Transition("there", ("a",), ("b",), tests={"go": 1}), Transition("back", ("b",), ("a",))),
    )
    machine = ProductMachine(net)
    explored = machine.explore()
    assert (explored.states, explored.rules, explored.endless) == (1, 1, 1)
    runner = ProductRunner(machine)
    runner.step({"go": 0.0})
    with pytest.raises(LivelockError, match="to and fro"):
        runner.step({"go": 1.0})
    assert Outcome(NOWHERE, ()).state == NOWHERE


def test_what_is_not_given_is_named():
    with pytest.raises(NetError, match="'signal' is not given"):
        ProductRunner(ProductMachine(_waiting(1))).step({"signl": 1.0, "level": 0.0})


@pytest.mark.parametrize(
    "net",
    [
        PetriNet("objects", places=(ObjectPlace("who", "Player"),), transitions=()),
        PetriNet("servers", places=(Place("a", capacity=2),), transitions=(Transition("t", ("a",), (), delay=2, servers=2),)),
        PetriNet("aged", places=(Place("a"),), transitions=(Transition("t", ("a",), (), delay=2, memory="age"),)),
    ],
    ids=lambda net: net.name,
)
def test_a_net_with_more_than_tokens_and_clocks_is_refused(net):
    with pytest.raises(NetError, match=f"'{net.name}'"):
        ProductMachine(net)
