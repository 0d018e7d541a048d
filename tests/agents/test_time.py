"""Inference that is slow, reflexes that are not, and a narrow view, in the agents."""

import numpy as np
import pytest

from cprm_gym.agents.body import DEFAULT
from cprm_gym.agents.goalie import GoalieAgent
from cprm_gym.agents.outfielder.agent import OutfieldAgent
from cprm_gym.agents.outfielder.model import outfield_model
from cprm_gym.agents.registry import make_controller
from cprm_gym.agents.skills.watch_ball import watch_ball
from cprm_gym.architecture.analysis.modules.contracts import check_contract
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError, UnknownName
from cprm_gym.simulator.state import ViewWidth

TASKS = {"GoToBall": {}, "Goalie": {}, "PassAndAdvance": {}, "Soccer5v5": {"controlled": "left_2", "others": "weak"}}


def play(name, cycles, worlds=2, seed=1, **options):
    """The views of the last cycle, and the controllers."""
    task = make_task(name, **TASKS.get(name, {}))
    core = SoccerCore(task, worlds, seed=seed, include=("memory",))
    agents = [make_controller(task, agent, model="bins", **options) for agent in core.agents]
    observation = core.reset(seed)
    for i, agent in enumerate(agents):
        agent.reset({key: value[:, i] for key, value in observation.items()}, seed)
    for _ in range(cycles):
        actions = [agent.act({key: value[:, i] for key, value in observation.items()}) for i, agent in enumerate(agents)]
        core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
    return observation, agents


@pytest.mark.parametrize("name", sorted(TASKS))
@pytest.mark.parametrize(("t_b", "latency"), [(1, 10), (4, 0), (10, 5)])
def test_every_agent_with_a_model_infers_as_rarely_and_late_as_it_is_told(name, t_b, latency):
    _, agents = play(name, 2 + t_b + latency, t_b=t_b, latency=latency)
    for agent in agents:
        runner = agent.controller
        assert (runner.timing.t_b, runner.timing.latency) == (t_b, latency)
        assert runner.slow is not None
        assert (runner.slow._done >= 0).all(), "a result has come"


def test_inferences_an_odd_number_of_cycles_apart_have_slices_of_one_cycle():
    assert OutfieldAgent(t_b=5).cprm.period == 1
    assert OutfieldAgent(t_b=4).cprm.period == OutfieldAgent().cprm.period == 2


def test_two_slices_of_a_cycle_let_the_ball_roll_as_one_of_two():
    def mean(period, attribute):
        model = outfield_model(DEFAULT, period)
        ball = next(c for c in model.classes if c.name == "Ball")
        return next(a for a in ball.attributes if a.name == attribute).cpd.mean

    decay = DEFAULT.ball_decay
    assert mean(1, "vx") == f"{decay:.4f} * prev.vx"
    assert mean(2, "vx") == f"{decay**2:.4f} * prev.vx"
    assert mean(1, "x") == "prev.x + 1.0000 * prev.vx"
    assert mean(2, "x") == f"prev.x + {1 + decay:.4f} * prev.vx"


def test_who_infers_nothing_takes_no_timing():
    with pytest.raises(ParameterError, match="no model: there is no option 'latency'"):
        make_controller(make_task("KickOffShot"), "left_1", latency=2)
    with pytest.raises(ParameterError, match="no option 't_b'"):
        make_controller(make_task("PassAndAdvance2v1"), "left_1", t_b=2)


def test_deep_inference_is_reached_from_agents():
    _, (agent, *_) = play("GoToBall", 3, deep="exact", every=2)
    assert agent.controller.separate is not None


# ---------------------------------------------------------------------- reflexes and looking


def seen_ball(agent, **changed):
    """Percepts of a cycle in which the ball is seen 20 m before the goal."""
    names = agent.controller.executor.input_names
    percepts = dict.fromkeys((*names, "ball.seen", "ball.placed", "ball.moving"), np.zeros(1))
    told = {f"o{k}.{name}": 0.0 for k in (1, 2) for name in ("seen", "faced", "x", "y", "facing")}
    values = {"self.x": -50.0, "ball.placed": 1.0, "ball.moving": 1.0, "ball.seen": 1.0, "body.fresh": 1.0, "ball.x": -30.0, "ball.y": 3.0,
              "ball.vx": -2.0, "ball.vy": 0.1, "body.view_width": 2.0, **told, **changed}  # fmt: skip
    return percepts | {name: np.full(1, value) for name, value in values.items()}


def agent_of(**options):
    agent = GoalieAgent(2, **options)
    agent.reset({"level": np.zeros((1, 23))}, 0)
    return agent


NOBODY = {"Opponent": {"danger": np.zeros(2), "ball_gap": np.full(2, 99.0)}}


@pytest.mark.parametrize(("reflexes", "acts"), [("eye", True), ("none", False)])
def test_a_reflex_acts_in_the_cycle_of_the_reading_and_belief_later(reflexes, acts):
    agent = agent_of(t_b=5, latency=5, reflexes=reflexes)
    agent.controller.step(seen_ball(agent), NOBODY)
    read = agent.controller.executor.read
    assert bool(read("ball_x")[0] == -30.0) is acts
    assert bool(read("ball_vx")[0] == -2.0) is acts
    blind = {"ball.placed": 0.0, "ball.moving": 0.0, "ball.seen": 0.0, "body.fresh": 0.0, "ball.x": 9.0}
    agent.controller.step(seen_ball(agent, **blind), NOBODY)
    assert read("ball_x")[0] != pytest.approx(-32.0, abs=3.0), "nothing is kept of a reading but what inference will make of it"
    for _ in range(4):
        agent.controller.step(seen_ball(agent, **blind), NOBODY)
    assert read("ball_x")[0] == pytest.approx(-30.0 - sum(2.0 * DEFAULT.ball_decay**k for k in range(5)), abs=0.6)


def test_the_view_is_narrow_while_the_ball_is_seen_and_normal_when_a_look_does_not_show_it():
    agent = agent_of(focus=True)
    runner = agent.controller
    commands = runner.step(seen_ball(agent), NOBODY)
    assert commands.of(0)["change_view"] == {"width": ViewWidth.NARROW}
    narrow = {"body.view_width": 1.0}
    assert "change_view" not in {n for n, f in runner.step(seen_ball(agent, **narrow), NOBODY).fired.items() if f[0]}
    lost = runner.step(seen_ball(agent, **narrow, **{"ball.seen": 0.0, "ball.placed": 0.0, "ball.moving": 0.0}), NOBODY)
    assert lost.of(0)["change_view"] == {"width": ViewWidth.NORMAL}


def test_eyes_that_narrow_keep_their_contract():
    assert check_contract(watch_ball(DEFAULT, True)).holds


def test_reflexes_that_there_are_not_are_refused():
    with pytest.raises(UnknownName, match="reflexes"):
        GoalieAgent(2, reflexes="knee")
    with pytest.raises(ParameterError, match="opponents who are watched"):
        GoalieAgent(0, reflexes="eye")
