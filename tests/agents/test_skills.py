"""Skills alone, judged by the world; contracts; what single decisions look like; simpler architectures as nets."""

import pkgutil

import numpy as np
import pytest
from cprm_baselines.fsm.go_to_ball import GoToBallMachine

from cprm_gym.agents import skills
from cprm_gym.agents.equivalents.go_to_ball import GO_TO_BALL_MACHINE, GO_TO_BALL_REGIONS
from cprm_gym.agents.percepts import ball_percepts, field_percepts
from cprm_gym.agents.play import SoccerAgent
from cprm_gym.agents.skills.advance import ADVANCE
from cprm_gym.agents.skills.kick import KICK
from cprm_gym.agents.skills.pass_ball import PASS_BALL, TURNS
from cprm_gym.agents.skills.receive import PATIENCE, RECEIVE
from cprm_gym.agents.worlds.trials import TRIALS
from cprm_gym.architecture.analysis.modules.contracts import check_contract
from cprm_gym.architecture.cprm import CPRM, CPRMRunner
from cprm_gym.architecture.equivalences import MachineRunner, RegionsRunner, Rule, StateMachine, machine_net, regions_cprm
from cprm_gym.architecture.petri import Command, Executor
from cprm_gym.benchmark.skills import measure
from cprm_gym.benchmark.statistics import wilson_interval
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import NetError

HERE = {"goal.distance": 20.0, "goal.direction_deg": 0.0, "mate.distance": 12.0, "mate.direction_deg": 0.0, "mate.age": 0.0,
        "body.fresh": 1.0, "ball.reckoned_distance": 0.7, "ball.reckoned_direction_deg": 0.0, "ball.age": 0.0, "ball.speed_ahead": 0.0,
        "ball.speed_aside": 0.0, "ball.approach": 0.0, "body.speed": 0.0, "body.stamina": 8000.0,
        "me.x": 0.0, "me.y": 0.0, "me.facing_deg": 0.0}  # fmt: skip


def run(net, *changes, **constants):
    """The executor after a run of a skill, and the commands of each cycle."""
    executor = Executor(net)
    executor.write("begin", 1)
    for name, value in constants.items():
        executor.write(name, value)
    return executor, [executor.step({name: {**HERE, **change}[name] for name in executor.input_names}).of() for change in changes]


@pytest.mark.parametrize("name", TRIALS)
def test_each_skill_alone_does_what_it_promises(name):
    good, _ = measure(name, episodes=60, seed=5)
    assert wilson_interval(good, 60).low > 0.75


def test_every_skill_is_tried_alone():
    shipped = {found.name for found in pkgutil.iter_modules(skills.__path__)} - {"parts", "constants"}
    assert set(TRIALS) == shipped


@pytest.mark.parametrize("name", TRIALS)
def test_the_contract_of_each_skill_holds(name):
    assert check_contract(TRIALS[name].skill).holds


def test_a_kick_makes_up_for_the_motion_of_the_ball():
    _, (still,) = run(KICK, {})
    _, (rolling,) = run(KICK, {"ball.speed_ahead": 0.5})
    _, (aside,) = run(KICK, {"ball.speed_aside": 0.5})
    speed = 1.0 + 0.06 * 19.3
    rate = 0.027 * (1 - 0.25 * (0.7 - 0.385) / 0.7)
    assert still["kick"]["power"] == pytest.approx(speed / rate)
    assert rolling["kick"]["power"] == pytest.approx((speed - 0.5) / rate)
    assert aside["kick"]["direction"] == pytest.approx(-np.degrees(np.arctan2(0.5, speed)))


def test_a_kick_at_a_ball_out_of_reach_fails_without_a_command():
    executor, commands = run(KICK, {"ball.reckoned_distance": 1.3})
    assert commands == [{}]
    assert executor.read("failed")[0] == 1


def test_a_pass_turns_at_most_twice_and_then_kicks():
    executor, commands = run(PASS_BALL, *[{"mate.direction_deg": 50.0}] * (TURNS + 1))
    assert [list(c) for c in commands] == [["turn"]] * TURNS + [["kick"]]
    assert executor.read("turns")[0] == 0, "the set arc has reset the counter"


def test_a_ball_that_drifts_away_or_does_not_move_off_fails_the_pass():
    executor, _ = run(PASS_BALL, {"mate.direction_deg": 50.0}, {"ball.reckoned_distance": 2.5})
    assert executor.read("failed")[0] == 1
    executor, _ = run(PASS_BALL, *[{}] * 12)
    assert executor.read("failed")[0] == 1
    executor, _ = run(PASS_BALL, {}, {"ball.reckoned_distance": 2.0, "ball.age": 0.0})
    assert executor.read("passed")[0] == 1


def test_a_rolling_ball_is_stopped_before_the_pass():
    _, (stop, wait, go) = run(PASS_BALL, {"ball.speed_ahead": 0.6}, {"body.fresh": 0.0, "ball.speed_ahead": 0.6}, {})
    assert stop["kick"]["direction"] == pytest.approx(180.0)
    assert not wait, "what he saw of its speed is no longer true"
    assert go["kick"]["direction"] == pytest.approx(0.0)


def test_a_player_waits_for_a_ball_that_comes_and_misses_one_that_does_not():
    comes = {"ball.reckoned_distance": 8.0, "ball.speed_ahead": -1.0, "ball.approach": 1.0}
    _, commands = run(RECEIVE, comes, comes)
    assert commands == [{}, {}]
    executor, _ = run(RECEIVE, *[{"ball.reckoned_distance": 8.0}] * (PATIENCE + 1))
    assert executor.read("missed")[0] == 1
    _, (turn,) = run(RECEIVE, {**comes, "ball.speed_aside": 0.6})
    assert turn["turn"]["moment"] > 20.0, "to where its way passes"


def test_an_aborted_advance_stands_still():
    executor, (first,) = run(ADVANCE, {}, place_x=10.0)
    assert list(first) == ["dash"]
    executor.write("abort", 1)
    assert executor.step({name: HERE[name] for name in executor.input_names}).of() == {}
    assert executor.read("aborted")[0] == 1
    assert executor.read("ongoing")[0] == 0


def test_percepts_place_ball_goal_and_mate_from_memory():
    observation = {"level": np.zeros((1, 23)), "body": np.zeros((1, 24)), "ball": np.zeros((1, 4)), "self": np.zeros((1, 8)),
                   "memory": np.zeros((1, 23, 4)), "memory_age": np.full((1, 23), 1000.0)}  # fmt: skip
    observation["body"][0, [13, 14, 16]] = 1, 2, 4  # left, number 2, kick_off_l
    observation["self"][0, :5] = 12.5, -10.0, 0, 0, np.radians(90.0)
    observation["memory"][0, 0] = 12.5, 0.0, 0.0, -1.0
    observation["memory"][0, 3] = 2.5, -10.0, 0, 0
    observation["memory_age"][0, [0, 2, 3]] = 2.0, 0.0, 5.0
    found = {key: value[0] for key, value in field_percepts(observation).items()}
    assert (found["ball.reckoned_distance"], found["ball.reckoned_direction_deg"], found["ball.age"]) == pytest.approx((10.0, 0.0, 2.0))
    assert (found["ball.speed_ahead"], found["ball.approach"]) == pytest.approx((-1.0, 1.0))
    assert (found["goal.distance"], found["goal.direction_deg"]) == pytest.approx((np.hypot(40, 10), np.degrees(np.arctan2(10, 40)) - 90))
    assert (found["mate.distance"], found["mate.direction_deg"], found["mate.age"]) == pytest.approx((10.0, 90.0, 5.0))
    assert (found["game.ours"], found["game.waiting"], found["game.playing"]) == (1.0, 0.0, 0.0)


def test_a_ball_that_hit_the_body_in_the_dark_is_slow():
    observation = {"level": np.zeros((1, 23)), "body": np.zeros((1, 24)), "ball": np.zeros((1, 4)), "self": np.zeros((1, 8)),
                   "memory": np.zeros((1, 23, 4)), "memory_age": np.zeros((1, 23))}  # fmt: skip
    observation["memory"][0, 0, 2], observation["memory_age"][0, 0], observation["body"][0, 14] = 1.0, 1.0, 1
    assert field_percepts(observation)["ball.speed_ahead"][0] == pytest.approx(1.0)
    observation["body"][0, 9] = 1.0
    assert field_percepts(observation)["ball.speed_ahead"][0] == pytest.approx(-0.1)


def test_the_state_machine_as_a_net_acts_like_the_hand_written_one():
    core = SoccerCore(make_task("GoToBall"), 40, seed=1)
    machine, net = GoToBallMachine(), SoccerAgent(CPRM("machine", machine_net(GO_TO_BALL_MACHINE)), ball_percepts)
    observation = {k: v[:, 0] for k, v in core.reset(1).items()}
    machine.reset(observation, 0)
    net.reset(observation, 0)
    kinds = set()
    for _ in range(80):
        expected, action = machine.act(observation), net.act(observation)
        for key in expected:
            assert np.array_equal(expected[key], action[key]), key
        kinds |= set(expected["type"].tolist())
        core.step({k: np.asarray(v)[:, None] for k, v in expected.items()})
    assert len(kinds) == 3, "turns, dashes and waits were compared"


def test_the_net_of_a_machine_has_one_token_and_one_arc_in_and_out():
    net = machine_net(GO_TO_BALL_MACHINE)
    assert all(len(t.inputs) == len(t.outputs) == 1 and set(t.inputs.values()) == set(t.outputs.values()) == {1} for t in net.transitions)
    executor, runner = Executor(net), MachineRunner(GO_TO_BALL_MACHINE)
    draws = np.random.default_rng(3)
    for _ in range(300):
        percepts = {"ball.seen": draws.integers(0, 2), "body.fresh": draws.integers(0, 2), "ball.direction_deg": draws.uniform(-30, 30),
                    "body.speed": draws.random(), "body.stamina": draws.uniform(0, 8000)}  # fmt: skip
        assert executor.step(percepts).of() == runner.step(percepts)
        marked = [s for s in GO_TO_BALL_MACHINE.states if executor.read(s)[0] + executor.read(f"{s}.entered")[0]]
        assert marked == [runner.state]


def test_a_machine_with_an_unknown_state_is_refused():
    with pytest.raises(NetError, match=r"machine 'm': unknown state 'runn'\. Did you mean 'run'"):
        StateMachine("m", ("run",), (Rule("run", "runn", emits=Command("dash", power=1)),))


def test_the_belief_region_policy_as_a_cprm_acts_alike():
    core = SoccerCore(make_task("GoToBall"), 1, seed=1)
    walker, controller, runner = GoToBallMachine(), CPRMRunner(regions_cprm(GO_TO_BALL_REGIONS)), RegionsRunner(GO_TO_BALL_REGIONS)
    observation = {k: v[:, 0] for k, v in core.reset(1).items()}
    walker.reset(observation, 0)
    seen = set()
    for _ in range(60):
        percepts = ball_percepts(observation)
        percepts["body.turned_deg"], percepts["body.advanced"] = np.zeros(1), percepts["body.speed"]
        expected = runner.step({k: float(v[0]) for k, v in percepts.items()})
        found = controller.step(percepts).of()
        assert found.keys() == expected.keys()
        for name in expected:
            assert found[name] == pytest.approx(expected[name], abs=1e-9)
        seen |= set(expected)
        core.step({k: np.asarray(v)[:, None] for k, v in walker.act(observation).items()})
    assert seen == {"turn", "dash"}
