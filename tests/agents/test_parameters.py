"""Agents in other worlds: with other parameters and types they act by those, and better than one who takes the defaults for granted."""

from dataclasses import replace

import numpy as np
import pytest
from cprm_baselines.fsm import make_controller as fsm
from cprm_baselines.fsm.go_to_ball import GoToBallMachine
from cprm_baselines.goalie_raw import make_controller as raw_goalie
from cprm_baselines.scripted import ScriptedController

from cprm_gym.agents.body import DEFAULT, Body
from cprm_gym.agents.catalogue import shipped_net
from cprm_gym.agents.goalie import GoalieAgent
from cprm_gym.agents.kernels.outfield import meeting
from cprm_gym.agents.models import ball_model, goalie_model, passer_model
from cprm_gym.agents.outfielder.agent import outfielder_cprm
from cprm_gym.agents.outfielder.model import outfield_model
from cprm_gym.agents.outfielder.percepts import terms
from cprm_gym.agents.passer import PasserAgent
from cprm_gym.agents.percepts import ball_percepts, field_percepts
from cprm_gym.agents.play import SoccerAgent, agent_in
from cprm_gym.agents.registry import make_controller
from cprm_gym.agents.seeker import seeker_cprm
from cprm_gym.agents.skills.catch_ball import catch_ball
from cprm_gym.agents.skills.kick import kick
from cprm_gym.agents.skills.orient import orient
from cprm_gym.agents.skills.watch_ball import watch_ball
from cprm_gym.agents.striker import striker_cprm
from cprm_gym.agents.worlds.trials import TRIALS
from cprm_gym.architecture.petri import Executor
from cprm_gym.benchmark.skills import measure
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import PlayerParameters, PlayerType, generate_types

WORLDS = {
    "a wide ring": {"kickable_margin": 1.5},
    "a narrow ring": {"kickable_margin": 0.35},
    "a sticky pitch": {"ball_decay": 0.88},
    "heavy bodies": {"inertia_moment": 20.0},
    "slow legs that glide": {"dash_power_rate": 0.003, "player_decay": 0.7},
    "strong feet": {"kick_power_rate": 0.054},
    "quick legs that stop": {"dash_power_rate": 0.0085, "player_decay": 0.15},
}
"""Name -> changed parameters."""


def parameters(world):
    return ServerParameters(**WORLDS[world])


# ------------------------------------------------------------------ skills, judged by the world


FAILED = [
    ("a wide ring", "kick"), ("a wide ring", "shoot"), ("a narrow ring", "go_to_ball"), ("a narrow ring", "slow"),
    ("a narrow ring", "approach"), ("a narrow ring", "receive"), ("a narrow ring", "dribble"), ("strong feet", "dribble"),
    ("slow legs that glide", "accelerate"), ("quick legs that stop", "accelerate"),
]  # fmt: skip
"""Where a player who takes the defaults for granted fails in at least a quarter of the trials."""


@pytest.mark.parametrize(("world", "skill"), FAILED)
def test_a_skill_that_fails_by_the_defaults_succeeds_by_the_parameters(world, skill):
    knowing, _ = measure(skill, 60, seed=5, parameters=parameters(world))
    defaults, _ = measure(skill, 60, seed=5, parameters=parameters(world), body=DEFAULT)
    assert knowing >= 57
    assert defaults <= 45


@pytest.mark.parametrize("world", WORLDS)
def test_every_skill_of_the_field_succeeds_in_every_world(world):
    for skill in ("orient", "go_to_ball", "advance", "approach", "kick", "shoot", "receive", "dribble", "cruise"):
        good, _ = measure(skill, 30, seed=7, parameters=parameters(world))
        assert good >= 24, skill


# ------------------------------------------------------------------ whole agents


def alone(task, body):
    """The agent of a task who takes himself to be `body`."""
    if task.name == "KickOffShot":
        return [SoccerAgent(striker_cprm(body), field_percepts, needs=("memory",), body=body)]
    if task.name == "GoToBall":
        return [SoccerAgent(seeker_cprm(body), ball_percepts, body=body)]
    if task.name == "Goalie":
        return [GoalieAgent(task.right, body=body)]
    return [PasserAgent(True, 1, body) for _ in range(2)]


def played(name, world, body=None, count=40, **options):
    """(successes, mean cycles of an episode) of agents who know the world they play in, or take themselves to be `body`."""
    task = replace(make_task(name, **options), parameters=parameters(world))
    agents = alone(task, body or Body.of(task))
    core = SoccerCore(task, count, seed=3, include=("memory",))
    observation = core.reset(3)
    for i, agent in enumerate(agents):
        agent.reset({key: value[:, i] for key, value in observation.items()}, 0)
    running, good, cycles = np.ones(count, bool), np.zeros(count, bool), np.zeros(count)
    while running.any():
        actions = [agent.act({key: value[:, i] for key, value in observation.items()}) for i, agent in enumerate(agents)]
        step = core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
        over = running & (step.terminated | step.truncated)
        good |= over & np.asarray(step.success).reshape(count, -1).all(axis=1)
        cycles[over], running = core.cycle[over], running & ~over
    return int(good.sum()), float(cycles.mean())


@pytest.mark.parametrize("world", WORLDS)
def test_the_striker_scores_in_every_world(world):
    good, _ = played("KickOffShot", world)
    assert good >= 37


@pytest.mark.parametrize("world", ["a wide ring", "a narrow ring", "a sticky pitch", "strong feet"])
def test_the_striker_scores_sooner_than_one_who_takes_the_defaults_for_granted(world):
    _, knowing = played("KickOffShot", world)
    _, defaults = played("KickOffShot", world, DEFAULT)
    assert knowing < defaults - 5.0


def test_with_heavy_bodies_the_ball_is_reached_sooner_by_him_who_knows_it():
    (good, knowing), (_, defaults) = (played("GoToBall", "heavy bodies", body, 100) for body in (None, DEFAULT))
    assert good == 100
    assert knowing < defaults - 3.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("world", "sooner"), [("a wide ring", 5.0), ("a narrow ring", 15.0), ("a sticky pitch", 80.0), ("heavy bodies", 10.0)]
)
def test_the_pair_gets_through_in_other_worlds_and_sooner_than_one_who_takes_the_defaults_for_granted(world, sooner):
    (good, knowing), (_, defaults) = (played("PassAndAdvance", world, body, 48, max_cycles=600) for body in (None, DEFAULT))
    assert good >= 44
    assert knowing < defaults - sooner


@pytest.mark.parametrize("world", ["a wide ring", "a narrow ring", "a sticky pitch", "heavy bodies", "quick legs that stop"])
def test_the_goalie_saves_in_other_worlds(world):
    good, _ = played("Goalie", world, count=60)
    assert good >= 36


def test_agents_of_the_registry_and_the_baselines_know_the_parameters_of_their_task():
    changed = ServerParameters(inertia_moment=9.0, catch_ban_cycle=12)
    for name, agent in (("KickOffShot", "left_1"), ("Goalie", "left_1"), ("PassAndAdvance", "left_2"), ("GoToBall", "left_1"),
                        ("Soccer5v5", "left_1"), ("Soccer5v5", "left_3")):  # fmt: skip
        assert agent_in(make_controller(replace(make_task(name), parameters=changed), agent)).body == Body(changed), name
    assert raw_goalie(replace(make_task("Goalie"), parameters=changed), "left_1").body == Body(changed)
    assert fsm(replace(make_task("GoToBall"), parameters=changed), "left_1").inertia_moment == 9.0
    assert ScriptedController(replace(make_task("Goalie"), parameters=changed), "left_1").catch_ban == 12


# ------------------------------------------------------------------ single decisions


PERCEPTS = {"goal.distance": 20.0, "goal.direction_deg": 0.0, "ball.reckoned_distance": 0.7, "ball.reckoned_direction_deg": 40.0,
            "ball.age": 0.0, "ball.speed_ahead": 0.0, "ball.speed_aside": 0.0, "body.speed": 0.3, "game.stopped": 0.0, "ball.seen": 0.0,
            "body.fresh": 1.0, "body.neck_deg": 30.0, "body.view_width": 2.0}  # fmt: skip


def command(net, percepts=PERCEPTS, **parameters_given):
    """What a skill sends in its first cycle."""
    executor = Executor(net)
    executor.write("begin", 1)
    for name, value in parameters_given.items():
        executor.write(name, value)
    return executor.step({name: percepts[name] for name in executor.input_names}).of()


def test_the_moment_of_a_turn_makes_up_for_the_inertia_of_his_type():
    for inertia in (2.0, 5.0, 20.0):
        body = Body(kind=PlayerType(inertia_moment=inertia))
        sent = command(orient(body), {**PERCEPTS, "ball.reckoned_direction_deg": 20.0})
        assert sent["turn"]["moment"] == pytest.approx(20.0 * (1.0 + inertia * 0.3))
    assert command(orient(Body(ServerParameters(maxmoment=60.0))))["turn"]["moment"] == 60.0


def test_a_kick_gives_the_ball_the_speed_that_is_wanted_whatever_the_type():
    drawn = generate_types(ServerParameters(), PlayerParameters(kick_power_rate_delta_min=-0.01, kick_power_rate_delta_max=0.02), seed=4)
    for kind in drawn[:6]:
        body = Body(ServerParameters(ball_decay=0.9), kind)
        sent = command(kick(body), {**PERCEPTS, "ball.reckoned_direction_deg": 0.0, "goal.distance": 8.0}, arriving=0.2)
        gap = 0.7 - kind.player_size - body.server.ball_size
        rate = kind.kick_power_rate * (1.0 - 0.25 * gap / kind.kickable_margin)
        assert sent["kick"]["power"] * rate == pytest.approx(0.2 + 0.1 * 7.3, abs=1e-6)


@pytest.mark.parametrize(("changed", "catches"), [({}, False), ({"catchable_area_l": 2.5}, True)])
def test_the_goalie_catches_as_far_as_his_hands_reach(changed, catches):
    shot = {"ball_distance": 1.6, "ball_direction": 5.0, "next_distance": 1.9, "way_distance": 0.0, "coming": 1.0, "flank": 60.0}
    assert ("catch" in command(catch_ball(Body(ServerParameters(**changed))), **shot)) == catches
    stretched = Body(kind=PlayerType(catchable_area_l_stretch=1.5))
    assert "catch" in command(catch_ball(stretched), **shot)


def test_the_neck_sweeps_as_far_as_it_turns():
    executor = Executor(watch_ball(Body(ServerParameters(minneckang=-60.0))))
    executor.write("begin", 1)
    for _ in range(8):
        sent = executor.step({name: PERCEPTS[name] for name in executor.input_names}).of()
    assert sent == {"look": {"direction": -60.0}}


def test_a_rolling_ball_is_met_where_it_is_when_he_is_there_on_any_pitch():
    memory = np.zeros((1, 23, 4))
    memory[0, 0] = 10.0, 0.0, 1.0, 0.0
    for decay in (0.8, 0.94, 0.98):
        body = Body(ServerParameters(ball_decay=decay))
        time, x, _ = meeting(memory[0, 0], 0.0, 0.0, terms(body))
        assert x == pytest.approx(10.0 + (1.0 - decay**time) / (1.0 - decay), rel=0.03)


def test_models_move_the_ball_as_the_pitch_does_and_see_it_as_the_eye_does():
    slow = Body(ServerParameters(ball_decay=0.8, ball_speed_max=2.0, quantize_step=0.3, visible_distance=5.0))
    for model in (goalie_model, passer_model, outfield_model, ball_model):
        assert model(slow) != model()
    edges = {a.name: a.domain for a in goalie_model(slow).classes[0].attributes}["vx"].edges
    assert edges[-1] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("changed", "followed"),
    [
        ({"inertia_moment": 9.0}, "turn"),
        ({"max_dash_power": 80.0}, "dash"),
        ({"kick_power_rate": 0.05}, "kick"),
        ({"ball_decay": 0.9}, "kick"),
    ],
)
def test_every_skill_that_gives_a_command_follows_what_decides_its_effect(changed, followed):
    body = Body(ServerParameters(**changed))
    for name, trial in TRIALS.items():
        computed = [t for t in trial.skill.transitions if t.emits and t.emits.name == followed and _computed(t.emits)]
        if computed:
            assert trial.make(body) != trial.skill, name


def _computed(emitted):
    """Whether power or moment is a place of the net."""
    return isinstance(emitted.params.get("power", emitted.params.get("moment")), str) and emitted.params.get("moment") != "bearing"


def test_a_body_is_a_value_and_what_is_made_for_it_is_made_once():
    assert Body() == DEFAULT == Body.of(make_task("Goalie"))
    assert outfielder_cprm(Body()) is outfielder_cprm()
    assert shipped_net("kick") is kick()
    assert Body(ServerParameters(kickable_margin=1.0)).reach == pytest.approx(1.385)
    assert GoToBallMachine().inertia_moment == PlayerType().inertia_moment
