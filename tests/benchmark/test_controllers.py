"""The methods of analysis on controllers without a net: what they say is held against episodes, what cannot be said is named."""

import numpy as np
import pytest
from cprm_baselines.behavior_tree import make_controller as tree
from cprm_baselines.fsm import make_controller as fsm
from cprm_baselines.fsm.go_to_ball import GoToBallMachine
from cprm_baselines.scripted import make_controller as scripted

from cprm_gym.agents.registry import make_controller as cprm
from cprm_gym.architecture.analysis.sampling.intervals import clopper_pearson
from cprm_gym.benchmark.behaviours.controllers import OUTCOMES, closed_loop, memory_of, to_markdown, try_methods
from cprm_gym.benchmark.behaviours.controllers import _play as play
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task

MADE = {"cprm": cprm, "fsm": fsm, "behavior_tree": tree, "scripted": scripted}


@pytest.fixture(scope="module")
def tried():
    return {name: try_methods(name, episodes=150, make=make, seed=2, proofs=3.0) for name, make in MADE.items()}


def test_the_closed_loop_chain_says_what_episodes_say(tried):
    for name, t in tried.items():
        assert sum(t.counts.values()) == 150
        assert clopper_pearson(t.counts["success"], 150, 0.99).holds(min(t.chance, 1.0)), name
        assert t.counts["success"] > 140


def test_memory_is_found_where_it_can_be_seen(tried):
    assert {name: t.remembers for name, t in tried.items()} == {
        "cprm": "marking", "fsm": "state, unseen", "behavior_tree": "", "scripted": "",
    }  # fmt: skip
    machine = GoToBallMachine()
    machine.state, machine.unseen = np.array([0, 2]), np.array([1, 0])
    assert memory_of(machine, 2) == ("state, unseen", [(0, 1), (2, 0)])
    assert memory_of(machine, 3) == ("", [()] * 3)


def test_what_holds_for_every_environment_is_said_of_nets_alone(tried):
    method = "every environment: deadlocks, reachability"
    can = {name: next(f for f in t.found if f.method == method).can for name, t in tried.items()}
    assert can == {"cprm": True, "fsm": False, "behavior_tree": False, "scripted": False}
    table = to_markdown(list(tried.values()))
    assert table.count("\n") == 2 + len(tried["cprm"].found)
    assert "| no: there is no net to explore |" in table


def test_a_machine_that_turns_the_wrong_way_is_caught_by_its_chain():
    class Wrong(GoToBallMachine):
        damping = -0.9

    t = try_methods("wrong", episodes=150, make=lambda task, agent: Wrong(), seed=2)
    assert t.chance < 0.7
    assert t.counts["success"] < 120
    assert t.counts["out of time"] > 20


def test_the_chain_counts_every_step_once():
    played = play(fsm, make_task("GoToBall"), 30, 5)
    chain, counts, outcomes, start = closed_loop(played)
    steps = sum(len(path) for path in played.paths)
    assert sum(n for row in counts for n in row.values()) >= steps - 30
    assert sum(start.values()) == pytest.approx(1.0)
    assert set(played.outcomes) <= set(OUTCOMES)
    assert chain.name(outcomes["success"][0]) == "success"


def test_the_memory_of_a_structure_is_seen_in_its_parts():
    machine = fsm(make_task("Goalie"), "left_1")
    core = SoccerCore(make_task("Goalie"), 2, seed=1, include=("memory",))
    machine.reset({key: value[:, 0] for key, value in core.reset(1).items()}, 1)
    machine.structure.at[:] = 0, 2
    names, values = memory_of(machine, 2)
    assert names.startswith("structure._opened, structure.at")
    assert [value[1] for value in values] == [0, 2]
