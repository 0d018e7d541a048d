"""The keeper: whom he passes to, when he keeps the ball behind his body, and who may be one."""

import numpy as np
import pytest

from cprm_gym.agents.keeper.agent import KEEPER_NET, KeeperAgent, make_controller
from cprm_gym.agents.keeper.constants import KeeperConstants
from cprm_gym.architecture.petri import Place
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError
from cprm_gym.simulator.state import CommandKind

TASK = make_task("Keepaway3v2")


def scene(takers, constants=None):
    """The first keeper's command with the ball at his feet, the mates 8 m away to either side and the takers where they are said to be."""
    agent = KeeperAgent(TASK, constants)
    core = SoccerCore(TASK, 1, controlled="left_1", seed=2, include=agent.needs)
    core.reset(2)
    for player, (x, y) in {1: (-6.0, 0.0), 2: (1.0, 4.5), 3: (1.0, -4.5), 12: takers[0], 13: takers[1]}.items():
        core.place_player(player, x, y, 0.0)
    core.place_ball(-5.4, 0.0)
    observation = {key: value[:, 0] for key, value in core.observe(np.array([0])).items()}
    agent.reset(observation, 0)
    action = agent.act(observation)
    return agent, {key: np.asarray(value)[0] for key, value in action.items()}


def marked(agent, *places):
    return [bool(agent.controller.executor.read(place)[0]) for place in places]


def test_a_keeper_who_is_not_pressed_keeps_the_ball():
    agent, action = scene(((6.0, 1.0), (6.0, -1.0)))
    assert action["type"] == CommandKind.KICK
    assert marked(agent, "shelter.ongoing", "give.ongoing") == [True, False]


def test_a_pressed_keeper_passes_to_whom_the_way_is_clear():
    agent, action = scene(((-4.0, -1.8), (-1.0, -3.5)))
    assert action["type"] == CommandKind.KICK
    assert marked(agent, "shelter.ongoing", "give.ongoing") == [False, True]
    assert agent.controller.executor.read("pass_direction")[0] > 0


def test_who_asks_for_more_room_does_not_pass():
    agent, _ = scene(((-4.0, -1.8), (-1.0, -3.5)), KeeperConstants(room=4.0))
    assert marked(agent, "shelter.ongoing", "give.ongoing") == [True, False]


def test_one_thing_at_a_time():
    agents = [make_controller(TASK, f"left_{k}") for k in (1, 2, 3)]
    core = SoccerCore(TASK, 8, seed=4, include=agents[0].needs)
    observation = core.reset(4)
    for k, agent in enumerate(agents):
        agent.reset({key: value[:, k] for key, value in observation.items()}, 4)
    busy = ("decide", "acted", "with_ball", "meet.ongoing", "walk.ongoing", "give.ongoing", "shelter.ongoing")
    for _ in range(40):
        actions = [agent.act({key: value[:, k] for key, value in observation.items()}) for k, agent in enumerate(agents)]
        for agent in agents:
            assert (sum(agent.controller.executor.read(place) for place in busy) == 1).all()
        core.step({key: np.stack([np.asarray(action[key]) for action in actions], axis=1) for key in actions[0]})
    assert {p.name for p in KEEPER_NET.places if isinstance(p, Place)} == {"looking", "viewing", "decide", "acted", "with_ball"}


def test_takers_and_other_tasks_are_refused():
    with pytest.raises(ParameterError, match="'right_1' is none"):
        make_controller(TASK, "right_1")
    with pytest.raises(ParameterError, match="GoToBall"):
        make_controller(make_task("GoToBall"), "left_1")
