"""The skill go_to_ball and the seeker: contract, equal actions in batch and alone, blind cycles, being lost."""

import numpy as np
import pytest
from cprm_baselines.fsm.go_to_ball import GoToBallMachine, State
from cprm_baselines.random_policy import RandomPolicy

from cprm_gym.agents.catalogue import shipped_net, shipped_nets
from cprm_gym.agents.percepts import ball_percepts
from cprm_gym.agents.seeker import SEEKER, make_controller
from cprm_gym.agents.skills.go_to_ball import GO_TO_BALL
from cprm_gym.architecture.analysis.modules.contracts import check_contract
from cprm_gym.architecture.analysis.report import analyze
from cprm_gym.architecture.cprm import CPRMRunner
from cprm_gym.architecture.petri import Executor
from cprm_gym.envs.controller import Predict
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import UnknownName
from cprm_gym.simulator.state import CommandKind

HERE = {"ball.seen": 1.0, "body.fresh": 1.0, "body.speed": 0.0, "body.stamina": 8000.0, "ball.distance": 10.0, "ball.direction_deg": 0.0,
        "ball.distance_change": 0.0}  # fmt: skip
AWAY = {**HERE, "ball.seen": 0.0, "ball.distance": 0.0, "ball.direction_deg": 0.0}


@pytest.mark.parametrize("name", sorted(shipped_nets()))
def test_every_shipped_module_keeps_its_contract(name):
    net = shipped_net(name)
    if net.ports.begin:
        report = check_contract(net)
        assert report.holds, str(report)
    else:
        found = analyze(net)
        assert found.untimed.bounded.holds
        assert found.timed.never_stops.holds


def test_one_invariant_holds_in_every_marking_reached():
    executor = Executor(GO_TO_BALL, batch=50)
    draws = np.random.default_rng(1)
    executor.write("begin", 1)
    outcomes = ("at_ball", "lost_ball", "aborted")
    for t in range(200):
        executor.step(
            {"ball.seen": draws.integers(0, 2, 50), "body.fresh": draws.integers(0, 2, 50), "body.speed": draws.random(50),
             "body.stamina": 8000.0, "ball.distance": draws.uniform(0, 20, 50), "ball.direction_deg": draws.uniform(-180, 180, 50),
             "ball.distance_change": 0.0},
            beliefs={"believed_distance": 10.0, "believed_direction": draws.uniform(-180, 180, 50)},
        )  # fmt: skip
        active = executor.read("begin") + executor.read("ongoing") + sum(executor.read(o) for o in outcomes)
        assert (active == 1).all()
        assert (executor.read("ready") + executor.read("acted") == executor.read("ongoing")).all()
        if t % 20 == 19:
            for place in outcomes:
                done = executor.read(place) == 1
                executor.write(place, 0, done)
                executor.write("begin", 1, done)


def run(steps, beliefs=(10.0, 0.0)):
    executor = Executor(GO_TO_BALL)
    executor.write("begin", 1)
    out = []
    for percepts in steps:
        commands = executor.step(percepts, beliefs={"believed_distance": beliefs[0], "believed_direction": beliefs[1]})
        out.append(commands.of(0))
    return executor, out


def test_a_ball_ahead_is_run_to_and_a_ball_aside_is_faced_with_damping():
    _, (command,) = run([HERE])
    assert command["dash"]["direction"] == 0.0
    assert command["dash"]["power"] == 100.0
    _, (command,) = run([{**HERE, "ball.direction_deg": 50.0, "body.speed": 0.2}])
    assert command["turn"]["moment"] == pytest.approx(0.9 * 50.0 * 2.0)


def test_blind_cycles_are_bridged_by_the_belief():
    blind = {**AWAY, "body.fresh": 0.0}
    executor, commands = run([HERE, blind, HERE, blind])
    assert [list(c) for c in commands] == [["dash"]] * 4
    _, commands = run([HERE, blind], beliefs=(10.0, 70.0))
    assert [list(c) for c in commands] == [["dash"], []], "believed aside: neither run nor turn on a guess"
    assert executor.read("ongoing")[0] == 1


def test_two_looks_without_the_ball_lose_it_but_blind_cycles_do_not_count():
    blind = {**AWAY, "body.fresh": 0.0}
    executor, commands = run([AWAY, blind, AWAY, blind])
    assert [list(c) for c in commands] == [["turn"], [], ["turn"], []]
    assert executor.read("lost_ball")[0] == 1
    assert executor.read("missed")[0] == 0
    executor, _ = run([AWAY, blind, HERE, blind, AWAY, blind])
    assert executor.read("ongoing")[0] == 1


def test_low_stamina_slows_the_run():
    _, (command,) = run([{**HERE, "body.stamina": 2500.0}])
    assert command["dash"]["power"] == 55.0


def test_the_seeker_acts_alike_in_a_batch_and_alone():
    cores = [SoccerCore(make_task("GoToBall"), 40, seed=6), SoccerCore(make_task("GoToBall"), 1, seed=6, first_world=17)]
    agents = [make_controller(core.task, "left_1") for core in cores]
    observations = [{k: v[:, 0] for k, v in core.reset(6).items()} for core in cores]
    for agent, observation in zip(agents, observations):
        agent.reset(observation, 0)
    for _ in range(60):
        actions = [agent.act(observation) for agent, observation in zip(agents, observations)]
        for key in actions[0]:
            assert actions[0][key][17] == pytest.approx(actions[1][key][0], abs=1e-9)
        for core, action in zip(cores, actions):
            core.step({k: v[:, None] for k, v in action.items()})


def test_the_belief_follows_a_ball_that_leaves_the_view():
    controller = CPRMRunner(SEEKER)
    seen = {**HERE, "body.turned_deg": 0.0, "body.advanced": 0.0, "ball.direction_deg": 20.0}
    for _ in range(6):
        controller.step(seen)
    assert controller.executor.read("go.believed_direction")[0] == pytest.approx(20.0, abs=15.0)
    assert controller.executor.read("go.believed_distance")[0] == pytest.approx(10.0, abs=2.5)
    # he turns by 90 degrees to the left without looking: the ball is now to his right
    controller.step({**seen, "ball.seen": 0.0, "body.fresh": 0.0, "body.turned_deg": -90.0})
    assert controller.executor.read("go.believed_direction")[0] == pytest.approx(110.0, abs=25.0)


def test_controllers_serve_stable_baselines_predict():
    core = SoccerCore(make_task("GoToBall"), 3, seed=1)
    observation = {k: v[:, 0].copy() for k, v in core.reset(1).items()}
    player = Predict(make_controller(core.task, "left_1"))
    action, state = player.predict(observation)
    assert action["params"].shape == (3, 4)
    action, state = player.predict(observation, state, np.array([False, True, False]))
    one, _ = Predict(RandomPolicy()).predict({k: v[0] for k, v in observation.items()})
    assert one["params"].shape == (4,)


def test_random_actions_of_a_world_do_not_depend_on_the_number_of_worlds():
    few, many = RandomPolicy(), RandomPolicy()
    few.reset({"level": np.zeros((2, 23))}, 5)
    many.reset({"level": np.zeros((9, 23))}, 5)
    for _ in range(10):
        a, b = few.act({}), many.act({})
        assert all((a[k] == b[k][:2]).all() for k in a)
        assert np.abs(a["params"]).max() <= 1.0


def test_the_state_machine_looks_turns_and_runs():
    machine = GoToBallMachine()
    observation = {"level": np.zeros((3, 23)), "body": np.zeros((3, 24)), "ball": np.zeros((3, 4))}
    machine.reset(observation, 0)
    observation["body"][:, 0], observation["body"][:, 12] = 8000.0, 1.0
    observation["level"][1:, 0] = 3
    observation["ball"][1] = [10.0, np.radians(40.0), 0, 0]
    observation["ball"][2] = [10.0, np.radians(-5.0), 0, 0]
    action = machine.act(observation)
    assert machine.state.tolist() == [State.LOOK, State.TURN, State.RUN]
    assert action["type"].tolist() == [CommandKind.TURN, CommandKind.TURN, CommandKind.DASH]
    assert 180.0 * action["params"][1, 0] == pytest.approx(36.0)
    machine.reset(observation, 0, np.array([False, False, True]))
    assert machine.state.tolist() == [State.LOOK, State.TURN, State.LOOK]


def test_percepts_are_degrees_from_the_body():
    observation = {"level": np.zeros((1, 23)), "body": np.zeros((1, 24)), "ball": np.zeros((1, 4))}
    observation["level"][0, 0] = 3
    observation["body"][0, 5] = np.radians(30.0)
    observation["ball"][0] = [7.0, np.radians(170.0), -0.5, 0.1]
    found = ball_percepts(observation)
    assert found["ball.direction_deg"][0] == pytest.approx(-160.0)
    assert (found["ball.distance"][0], found["ball.distance_change"][0]) == (7.0, -0.5)


def test_an_unknown_net_is_refused():
    with pytest.raises(UnknownName, match=r"unknown net 'go_to_bal'. Did you mean 'go_to_ball'\?"):
        shipped_net("go_to_bal")
