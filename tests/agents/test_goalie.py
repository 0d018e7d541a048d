"""The goalie (demonstration 2): its skills alone, its beliefs and relations, its baselines, and what they save."""

import numpy as np
import pytest
from cprm_baselines.goalie_memory import MemoryGoalie
from cprm_baselines.goalie_raw import RawGoalie
from cprm_baselines.scripted import ScriptedController

from cprm_gym.agents.goalie import GOALIE_NET, GoalieAgent, ReckoningGoalie, goalie_cprm, make_controller
from cprm_gym.agents.passer import PasserAgent
from cprm_gym.agents.skills.catch_ball import CATCH_BALL
from cprm_gym.agents.skills.clear import CLEAR, PATIENCE
from cprm_gym.agents.skills.reposition import REPOSITION
from cprm_gym.agents.skills.watch_ball import LOOKS, WATCH_BALL
from cprm_gym.architecture.analysis.modules.contracts import check_contract
from cprm_gym.architecture.cprm import CPRMRunner
from cprm_gym.architecture.petri import Executor, Input, PetriNet, Place
from cprm_gym.architecture.prm.inference.engines.projection import ProjectionEngine
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import BodyFeature
from cprm_gym.envs.players.senses import Senses
from cprm_gym.envs.tasks.base import Status
from cprm_gym.envs.tasks.goalie import Goalie
from cprm_gym.simulator.state import CommandKind, PlayMode


def alone(module):
    """The module with its parameters as inputs of the same names, begun."""
    parameters = module.ports.parameters
    places = tuple(Input(name, observes=name) for name in parameters)
    net = PetriNet("alone", places=places, modules={"m": module}, fuse={f"m.{name}": name for name in parameters})
    executor = Executor(net)
    executor.write("m.begin", 1)
    return executor


BODY = {"body.speed": 0.0, "body.stamina": 8000.0, "body.neck_deg": 0.0, "body.view_width": 2.0, "body.fresh": 1.0, "ball.seen": 1.0,
        "game.stopped": 0.0}  # fmt: skip
SHOT = {"ball_distance": 9.0, "ball_direction": 70.0, "next_distance": 7.0, "way_distance": 1.5, "way_direction": -10.0, "coming": 1.0,
        "behind": 0.0, "flank": 60.0}  # fmt: skip


def step(executor, **quantities):
    names = executor.input_names
    known = {**BODY, **quantities}
    return executor.step({name: known[name] for name in names}).of(0)


def holds(executor, *places):
    return all(executor.read(f"m.{place}")[0] == 1 for place in places)


@pytest.mark.parametrize("module", [WATCH_BALL, CATCH_BALL, REPOSITION, CLEAR], ids=lambda m: m.name)
def test_every_skill_of_the_goalie_keeps_its_contract(module):
    report = check_contract(module)
    assert report.holds, str(report)


def test_a_shot_is_met_by_strafing_near_and_turning_first_when_far():
    executor = alone(CATCH_BALL)
    assert step(executor, **SHOT)["dash"]["direction"] == -10.0
    command = step(executor, **{**SHOT, "way_distance": 4.0, "way_direction": 90.0})
    assert command["turn"]["moment"] == pytest.approx(90.0)
    assert step(executor, **{**SHOT, "way_distance": 0.0}) == {}


def test_the_one_catch_comes_when_the_ball_is_in_the_hands_reach():
    executor = alone(CATCH_BALL)
    step(executor, **SHOT)
    # in reach, but deeper in it a cycle later: wait
    assert "catch" not in step(executor, **{**SHOT, "ball_distance": 1.19, "next_distance": 0.3})
    command = step(executor, **{**SHOT, "ball_distance": 0.5, "next_distance": 0.8, "ball_direction": -33.0})
    assert command == {"catch": {"direction": -33.0}}
    assert step(executor, **{**SHOT, "game.stopped": 1.0}) == {}
    assert holds(executor, "caught")


def test_a_ball_in_the_hands_reach_is_caught_wherever_it_lies_from_the_body():
    for direction in (-170.0, -120.0, 0.0, 130.0):
        executor = alone(CATCH_BALL)
        command = step(executor, **{**SHOT, "ball_distance": 0.6, "ball_direction": direction})
        assert command == {"catch": {"direction": direction}}


def test_a_failed_catch_is_a_miss_and_a_ball_behind_is_past():
    executor = alone(CATCH_BALL)
    step(executor, **{**SHOT, "ball_distance": 0.5})
    step(executor, **SHOT)
    step(executor, **SHOT)
    assert holds(executor, "missed")
    executor = alone(CATCH_BALL)
    step(executor, **{**SHOT, "behind": 1.0})
    assert holds(executor, "past")
    executor = alone(CATCH_BALL)
    step(executor, **{**SHOT, "coming": 0.0})
    assert holds(executor, "over")


def test_a_ball_out_of_the_hands_reach_is_tackled_when_that_may_succeed():
    executor = alone(CATCH_BALL)
    assert step(executor, **{**SHOT, "ball_distance": 1.5, "ball_direction": 5.0}) == {"tackle": {"direction": 60.0, "foul": 0.0}}
    executor = alone(CATCH_BALL)
    assert "tackle" not in step(executor, **{**SHOT, "ball_distance": 1.5, "ball_direction": 100.0})


def test_reposition_runs_then_faces_then_settles():
    executor = alone(REPOSITION)
    assert "turn" in step(executor, post_distance=5.0, post_direction=120.0, side_turn=0.0)
    assert step(executor, post_distance=5.0, post_direction=5.0, side_turn=80.0)["dash"]["power"] == 100.0
    assert step(executor, post_distance=0.3, post_direction=5.0, side_turn=-50.0)["turn"]["moment"] == pytest.approx(-50.0)
    assert step(executor, post_distance=0.3, post_direction=5.0, side_turn=3.0) == {}
    assert holds(executor, "in_place")


def test_clear_kicks_a_ball_at_hand_and_gives_up_on_one_that_is_not():
    executor = alone(CLEAR)
    assert step(executor, ball_distance=0.7, flank=60.0) == {"kick": {"power": 100.0, "direction": 60.0}}
    step(executor, ball_distance=3.0, flank=60.0)
    assert holds(executor, "cleared")
    executor = alone(CLEAR)
    for _ in range(PATIENCE + 1):
        assert step(executor, ball_distance=3.0, flank=60.0) == {}
    assert holds(executor, "failed")


def test_the_eyes_follow_the_ball_warn_and_sweep_when_it_is_lost():
    executor = alone(WATCH_BALL)
    assert step(executor, ball_direction=30.0, coming=0.0) == {"look": {"direction": 30.0}}
    assert not holds(executor, "ball_coming")
    step(executor, ball_direction=30.0, coming=1.0)
    assert holds(executor, "ball_coming", "ongoing")
    step(executor, ball_direction=30.0, coming=0.0)
    assert not holds(executor, "ball_coming")
    for _ in range(LOOKS + 2):
        command = step(executor, ball_direction=30.0, coming=0.0, **{"ball.seen": 0.0, "body.neck_deg": 30.0})
    assert command == {"look": {"direction": -90.0}}
    executor.write("m.stop", 1)
    step(executor, ball_direction=30.0, coming=0.0)
    assert holds(executor, "stopped")
    assert not holds(executor, "ongoing")


@pytest.mark.parametrize(("width", "aside"), [(1.0, 60.0), (2.0, 90.0), (3.0, 90.0)], ids=["narrow", "normal", "wide"])
def test_a_first_look_without_the_ball_is_followed_by_one_to_each_side(width, aside):
    executor = alone(WATCH_BALL)
    unseen = {"ball.seen": 0.0, "body.view_width": width}
    assert step(executor, ball_direction=30.0, coming=0.0, **unseen) == {"look": {"direction": aside}}
    assert step(executor, ball_direction=30.0, coming=0.0, **unseen, **{"body.neck_deg": aside}) == {"look": {"direction": -aside}}
    seen = {"body.neck_deg": -aside, "body.view_width": width}
    assert step(executor, ball_direction=30.0, coming=0.0, **seen) == {"look": {"direction": 30.0}}
    assert step(executor, ball_direction=30.0, coming=0.0, **seen | unseen) == {"look": {"direction": 30.0}}, "he knows where it was"


PERCEPTS = {**BODY, "self.x": -50.0, "self.y": 0.0, "self.body_deg": 80.0, "self.vx": 0.0, "self.vy": 0.0, "ball.moving": 1.0,
            "ball.placed": 1.0, "ball.x": -30.0, "ball.y": 2.0, "ball.vx": 0.0, "ball.vy": 0.0, "ball.distance": 20.1, "ball.age": 0.0,
            **{f"o{k}.{name}": value for k in (1, 2, 3)
               for name, value in (("seen", 1.0), ("faced", 1.0), ("x", -30.0 + 5 * k), ("y", 2.0), ("facing", 0.0))}}  # fmt: skip
NOBODY_NEAR = {"Opponent": {"danger": np.array([0.3, 0.2, 0.1]), "ball_gap": np.array([2.0, 4.0, 9.0])}}
FIRST_HAS_IT = {"Opponent": {"danger": np.array([0.6, 0.2, 0.1]), "ball_gap": np.array([0.6, 4.0, 9.0])}}


def test_relations_are_active_while_the_object_places_hold_objects():
    controller = CPRMRunner(goalie_cprm(opponents=3))
    assert controller.relations(0) == ()
    controller.step(PERCEPTS, NOBODY_NEAR)
    assert controller.relations(0) == ("attendedOpponent(o1)", "attendedOpponent(o2)")
    controller.step(PERCEPTS, FIRST_HAS_IT)
    assert "possessesOpponent(o1,ball)" in controller.relations(0)
    gone = {"Opponent": {"danger": np.zeros(3), "ball_gap": np.full(3, 99.0)}}
    controller.step(PERCEPTS, gone)
    assert controller.relations(0) == ()


def test_a_possession_makes_a_shot_expected_before_it_is_seen():
    expected = []
    for candidates in (NOBODY_NEAR, FIRST_HAS_IT):
        controller = CPRMRunner(goalie_cprm(opponents=3))
        for _ in range(4):
            controller.step(PERCEPTS, candidates)
        controller.step({**PERCEPTS, "body.fresh": 0.0, "ball.seen": 0.0, "ball.placed": 0.0, "ball.moving": 0.0}, candidates)
        expected.append(controller.executor.read("ball_vx")[0])
    assert expected[0] == pytest.approx(0.0, abs=0.1)
    assert expected[1] < -0.15


def test_beliefs_carry_the_ball_through_blind_cycles():
    controller = CPRMRunner(goalie_cprm(opponents=0))
    x, v = -25.0, -2.0
    for cycle in range(8):
        blind = cycle % 2
        seen = {**PERCEPTS, "ball.x": x, "ball.vx": v, "ball.vy": 0.1, "ball.seen": 1.0 - blind, "ball.moving": 1.0 - blind,
                "ball.placed": 1.0 - blind}  # fmt: skip
        controller.step({**seen, **({"ball.x": 0.0, "ball.vx": 0.0} if blind else {})})
        assert controller.executor.read("ball_x")[0] == pytest.approx(x, abs=0.8)
        assert controller.executor.read("ball_vx")[0] == pytest.approx(v, abs=0.2)
        x, v = x + v, 0.94 * v
    assert controller.executor.read("eyes.ball_coming")[0] == 1
    assert controller.executor.read("save.ongoing")[0] == 1


def play(agent, worlds, seed=3, first=0):
    core = SoccerCore(Goalie(max_cycles=50), worlds, seed=seed, first_world=first, include=agent.needs)
    observation = {key: value[:, 0] for key, value in core.reset(seed).items()}
    agent.reset(observation, 0)
    running, clean, first_actions = np.ones(worlds, bool), np.ones(worlds, bool), []
    while running.any():
        action = agent.act(observation)
        if len(first_actions) < 12:
            first_actions.append({key: np.array(value) for key, value in action.items()})
        done = core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
        clean &= ~(running & (done.status == Status.GOAL))
        running &= ~(done.terminated | done.truncated)
    return clean, first_actions


def test_the_goalie_saves_more_than_the_scripted_keeper():
    saved = play(GoalieAgent(2), 120)[0].mean()
    assert saved > play(ScriptedController(Goalie(), "left_1"), 120)[0].mean() + 0.1
    assert saved > 0.75


def test_the_same_net_on_the_memory_is_no_worse_than_with_the_model():
    """The fair rival: what docs/performance.md says of the model's worth."""
    memory = play(MemoryGoalie(2), 240)[0]
    believing = play(GoalieAgent(2), 240)[0]
    assert memory.mean() > believing.mean() - 0.02
    assert memory.mean() > play(RawGoalie(2), 240)[0].mean() + 0.03


def test_the_goalie_acts_alike_in_a_batch_and_alone():
    _, batch = play(make_controller(Goalie(), "left_1"), 6)
    _, single = play(make_controller(Goalie(), "left_1"), 1, first=4)
    for many, one in zip(batch[:8], single[:8], strict=True):
        for key in many:
            assert many[key][4] == pytest.approx(one[key][0], abs=1e-6)


def test_the_raw_goalie_keeps_its_last_readings():
    agent = RawGoalie(1)
    core = SoccerCore(Goalie(), 2, seed=1, include=agent.needs)
    observation = {key: value[:, 0].copy() for key, value in core.reset(1).items()}
    agent.reset(observation, 0)
    agent.act(observation)
    before = agent.last["raw.ball_x"].copy()
    assert (before != 0).all()
    observation["level"][:], observation["memory"][:] = 0.0, 0.0
    agent.act(observation)
    assert (agent.last["raw.ball_x"] == before).all()
    agent.reset(observation, 0, np.array([True, False]))
    assert agent.last["raw.ball_x"].tolist() == [0.0, before[1]]


def test_the_scripted_controller_plays_as_the_scripted_players_of_the_environment():
    """The keeper through the controller and an attacker inside, or the other way round: the same match.

    Observations are float32, so after some cycles a decision that stands on a threshold falls differently.
    """
    cores, agents = [], []
    for name in ("left_1", "right_2"):
        core = SoccerCore(Goalie(), 12, controlled=name, seed=2, include=("memory",))
        cores.append(core)
        agents.append(ScriptedController(Goalie(), name))
    observations = [{key: value[:, 0] for key, value in core.reset(2).items()} for core in cores]
    for agent, observation in zip(agents, observations, strict=True):
        agent.reset(observation, 0)
    for _ in range(6):
        for core, agent, observation in zip(cores, agents, observations, strict=True):
            core.step({key: np.asarray(value)[:, None] for key, value in agent.act(observation).items()})
        apart = np.abs(cores[0].sim.world["pos"][:, :14] - cores[1].sim.world["pos"][:, :14]).max(axis=2)
        assert apart.max() < 0.02


def test_the_goalies_net_holds_one_thing_to_do_at_a_time():
    busy = ("guard", "watching", "post.ongoing", "save.ongoing", "away.ongoing")
    agent = GoalieAgent(2)
    core = SoccerCore(Goalie(), 20, seed=8, include=agent.needs)
    observation = {key: value[:, 0] for key, value in core.reset(8).items()}
    agent.reset(observation, 0)
    ends = ("post.in_place", "save.over", "save.past", "save.missed", "save.caught", "save.aborted")
    for _ in range(30):
        action = agent.act(observation)
        read = agent.controller.executor.read
        assert (sum(read(place) for place in (*busy, *ends)) == 1).all()
        assert (read("eyes.ongoing") == 1).all()
        core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
    assert {place.name for place in GOALIE_NET.places if isinstance(place, Place)} == {"shut", "guard", "watching"}


def test_a_ball_that_slipped_from_his_hands_is_cleared_in_the_same_cycle():
    agent, senses = ReckoningGoalie(2), Senses(noise=0.5)
    core = SoccerCore(Goalie(), 100, seed=8, include=agent.needs, senses=senses)
    observation = {key: value[:, 0] for key, value in core.reset(8).items()}
    agent.reset(observation, 0)
    caught, running, slipped = np.zeros(100, bool), np.ones(100, bool), 0
    for _ in range(40):
        action = agent.act(observation)
        at_hand = (agent.controller.executor.read("at_hand") > 0) & (observation["body"][:, BodyFeature.PLAY_MODE] == PlayMode.play_on)
        missed = running & caught & at_hand
        slipped += missed.sum()
        assert (action["type"][missed] == CommandKind.KICK).all()
        caught = action["type"] == CommandKind.CATCH
        done = core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
        running &= ~(done.terminated | done.truncated)
    assert slipped >= 3


def test_goalie_and_passer_infer_with_the_engine_that_they_are_given():
    for agent in (GoalieAgent(2, engine="anytime"), PasserAgent(engine="anytime")):
        assert agent.options["engine"] == "anytime"
    assert isinstance(GoalieAgent(2).options["engine"], ProjectionEngine)
