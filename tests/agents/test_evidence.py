"""No agent is told what was not given, and none acts on it: neither by its links, nor in play, on any tier of knowledge."""

from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.agents.given import check_given, giver
from cprm_gym.agents.goalie import GoalieAgent, goalie_cprm
from cprm_gym.agents.knowledge import ORACLES, TIERS
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.registry import AGENTS, make_controller
from cprm_gym.agents.seeker import SEEKER
from cprm_gym.architecture.cprm import Observe
from cprm_gym.architecture.prm.model.formulas import Formula
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import SelfFeature
from cprm_gym.envs.players.senses import Senses
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ModelError, ParameterError
from cprm_gym.simulator.senses import PlayerLevel

PLAYED = [("GoToBall", "left_1"), ("Goalie", "left_1"), ("PassAndAdvance", "left_2"), ("Soccer5v5", "left_1"), ("Soccer5v5", "right_3")]
WORLDS, CYCLES = 4, 40


def without_numbers(see, worlds):
    """Half of the players are seen without their numbers, whatever the distance."""
    hidden = (np.arange(see.players_level.shape[-1]) % 2 == 1) & (see.players_level == PlayerLevel.NUMBER)
    see.players_level[hidden] = PlayerLevel.TEAM
    see.players[hidden, 2:6] = 0.0


def scrambled(observation, motion_told, draws):
    """The observation with noise wherever nothing was given: below the level that tells it, out of memory, in an unknown frame."""
    noise = {key: draws.uniform(-3.0, 3.0, value.shape) for key, value in observation.items()}
    out = {key: np.array(value, np.float64) for key, value in observation.items()}
    ball, player = (observation["level"][:, part, None] for part in (slice(0, 1), slice(1, None)))
    columns = np.arange(out["players"].shape[-1])
    given = {"ball": (ball[:, 0] >= 3) | ((ball[:, 0] > 0) & (columns[:4] < 2))}
    given["players"] = (player >= 3) | ((player > 0) & ((columns < 2) | (columns == 6)))
    if "memory" in observation:
        located = observation["self"][:, SelfFeature.LOCATED] > 0
        known = np.repeat((observation["memory_age"] < 1000.0)[..., None], out["memory"].shape[-1], axis=-1)
        known[:, 0, 2:] &= motion_told[:, None]
        given["memory"] = known & located[:, None, None]
        given["self"] = located[:, None] | (np.arange(out["self"].shape[-1]) >= SelfFeature.LOCATED)
    for key, there in given.items():
        out[key] = np.where(there, out[key], noise[key])
    return out


def evidence(agent, observation):
    """What the model would be told: variable -> readings, NaN where it is told nothing."""
    percepts, read = agent.perceive(observation), agent.controller.executor.read
    places = agent.controller.places
    told = {}
    for link in agent.cprm.observations:
        value, when = (
            f({n: read(n) if n in places else percepts[n] for n in f.names}, WORLDS)
            for f in (Formula(link.value), Formula(link.when or "1"))
        )
        told[link.variable] = np.where(np.asarray(when) >= 0.5, value, np.nan)
    return told


def with_model(task, name):
    """The agent with the model of his own, where he has one."""
    return make_controller(task, name, model="bins")


@pytest.mark.parametrize(("task", "name"), PLAYED)
def test_no_agent_is_told_what_was_not_given(task, name):
    task, draws = make_task(task), np.random.default_rng(1)
    agent = with_model(task, name)
    core = SoccerCore(task, WORLDS, controlled=name, others="medium", seed=5, include=agent.needs)
    core.see_changes.append(without_numbers)
    observation = {key: value[:, 0] for key, value in core.reset(5).items()}
    agent.reset(observation, 0)
    told, motion_told = set(), np.zeros(WORLDS, bool)
    for _ in range(CYCLES):
        motion_told = np.where(observation["level"][:, 0] > 0, observation["level"][:, 0] >= 3, motion_told)
        unlocated = {key: np.array(value) for key, value in observation.items()}
        if "self" in unlocated:
            unlocated["self"][:, SelfFeature.LOCATED] = 0.0
        for view in (observation, unlocated):
            as_it_is, with_noise = evidence(agent, view), evidence(agent, scrambled(view, motion_told, draws))
            for variable, values in as_it_is.items():
                np.testing.assert_allclose(with_noise[variable], values, rtol=1e-6, atol=1e-6, err_msg=variable)
            told |= {variable for variable, values in as_it_is.items() if np.isfinite(values).any()}
        action = agent.act(observation)
        core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
    assert told, "something was told at all"


def test_every_agent_with_a_model_is_played_here():
    played = {with_model(make_task(task), name).cprm.name for task, name in PLAYED}
    agents = {with_model(make_task(task), name) for task in AGENTS for name in ("left_1", "left_2")}
    assert {agent.cprm.name for agent in agents if agent.cprm.model is not None} <= played


def acts_alike(make, task, name, senses=None, cycles=CYCLES):
    """Whether an agent does the same when noise stands wherever nothing was given; the other players are scripted."""
    agents, draws = [make(task, name) for _ in range(2)], np.random.default_rng(2)
    reckoned = np.ones(WORLDS, bool)  # memory makes a motion of two looks without any told
    core = SoccerCore(task, WORLDS, controlled=name, seed=5, include=agents[0].needs, senses=senses or Senses())
    core.see_changes.append(without_numbers)
    observation = {key: value[:, 0] for key, value in core.reset(5).items()}
    for cycle in range(cycles):
        views = observation, scrambled(observation, reckoned, draws)
        if cycle == 0:
            for agent, view in zip(agents, views):
                agent.reset(view, 0)
        actions = [agent.act(view) for agent, view in zip(agents, views)]
        if any(not np.allclose(actions[0][key], actions[1][key], atol=1e-5) for key in actions[0]):
            return False
        core.step({key: np.asarray(value)[:, None] for key, value in actions[0].items()})
    return True


@pytest.mark.parametrize("task", sorted({*AGENTS} - {"Soccer", "Soccer11v11"}))
def test_no_agent_acts_on_what_was_not_given(task):
    """With a model or without one."""
    assert acts_alike(make_controller, make_task(task), "left_1")


@pytest.mark.parametrize("tier", [name for name in TIERS if name not in ORACLES])
def test_no_tier_tells_what_was_not_given(tier):
    for task, player in PLAYERS.items():
        if tier in player.tiers:
            for senses in (Senses(lost=0.5), Senses(noise=0.5, motion=False, late=1)):
                assert acts_alike(player.on(tier, senses), make_task(task, **player.options), "left_1", senses, cycles=25), (task, senses)


class Gullible:
    """Turns to where the ball is said to be, whether he was told or not."""

    needs = ("memory",)

    def reset(self, observation, seed, worlds=None):
        pass

    def act(self, observation):
        action = no_action(WORLDS)
        action["type"][:], action["params"][:, 0] = 2, np.clip(observation["ball"][:, 1] / np.pi, -1.0, 1.0)
        return action


def test_who_acts_on_what_was_not_given_is_caught():
    assert not acts_alike(lambda task, name: Gullible(), make_task("Goalie"), "left_1")


def test_an_opponent_without_a_number_who_faces_the_goal_is_not_told_as_facing_away():
    task = make_task("Goalie")
    agent = with_model(task, "left_1")
    core = SoccerCore(task, 1, seed=3, include=agent.needs)
    core.reset(3)
    core.place_player(1, -50.0, 0.0, 0.0)
    core.place_player(12, -38.0, 2.0, np.pi)
    told = []
    for change in (None, without_numbers):
        core.see_changes[:] = [change] if change else []
        observation = {key: value[:, 0] for key, value in core.observe(np.array([0])).items()}
        percepts = agent.percepts(observation)
        told.append([float(percepts[f"o1.{part}"][0]) for part in ("seen", "faced", "facing")])
    assert told[0] == [1.0, 1.0, 0.0]
    assert told[1][:2] in ([1.0, 0.0], [0.0, 0.0])


@pytest.mark.parametrize(
    ("link", "flag"),
    [
        (Observe("o1.seen_facing", "o1.facing", when="o1.seen"), "o1.faced"),
        (Observe("ball.seen_vx", "ball.vx", when="ball.placed"), "ball.moving"),
        (Observe("ball.seen_x", "ball.x"), "ball.placed"),
        (Observe("ball.seen_x", "2 * ball.x - 1", when="ball.placed >= 0"), "ball.placed"),
        (Observe("ball.seen_x", "ball.x", when="ball.placed or (ball_distance > 5 and ball_distance < 6)"), "ball.placed"),
        (Observe("o1.seen_facing", likelihood=("1", "0.5", "o1.facing")), "o1.faced"),
        (Observe("ball.seen_x", "1", when="ball.x > 3"), "ball.placed"),
    ],
)
def test_a_link_that_tells_a_reading_at_other_times_is_refused(link, flag):
    with pytest.raises(ModelError, match=f"is given only where '{flag}' is 1"):
        check_given(replace(goalie_cprm(2), observations=(link,)))


def test_a_reading_of_which_nothing_is_said_is_refused_until_something_is():
    cprm = replace(goalie_cprm(2), observations=(Observe("ball.seen_x", "smell.x", when="smell.sensed"),))
    with pytest.raises(ModelError, match=r"nothing says when its reading 'smell\.x' is given"):
        check_given(cprm)
    check_given(cprm, {r"smell\.(x|sensed)": "smell.sensed"})
    with pytest.raises(ModelError, match=r"only where 'smell\.sensed' is 1"):
        check_given(replace(cprm, observations=(Observe("ball.seen_x", "smell.x"),)), {r"smell\.x": "smell.sensed"})
    check_given(replace(cprm, observations=(Observe("ball.seen_x", "smell.x"),)), {r"smell\.x": ""})


def test_a_condition_may_ask_for_more():
    check_given(replace(goalie_cprm(2), observations=(Observe("ball.seen_x", "ball.x", when="ball.placed >= 1 and ball_distance > 4"),)))
    check_given(SEEKER)
    assert (giver("body.stamina"), giver("smell.x")) == ("", None)


def test_a_wrong_engine_is_told_when_the_agent_is_made():
    with pytest.raises(ParameterError, match=r"unknown engine 'exakt'\..*Did you mean 'exact'"):
        GoalieAgent(2, engine="exakt")
    with pytest.raises(ParameterError, match="no option 'treads'"):
        GoalieAgent(2, treads=2)
