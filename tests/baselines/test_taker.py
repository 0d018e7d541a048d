"""The taker: he kicks the ball out, tackles, covers; the structures take it as he does; alone as in a batch."""

import numpy as np
import pytest
from cprm_baselines import behavior_tree, belief_region, code, fsm, subsumption

from cprm_gym.agents.knowledge import Informed
from cprm_gym.agents.registry import make_controller as cprm
from cprm_gym.agents.taker.agent import TAKER_NET, TakerAgent, make_controller
from cprm_gym.agents.taker.constants import TakerConstants
from cprm_gym.architecture.petri import Place
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import Status, make_task
from cprm_gym.errors import ParameterError
from cprm_gym.simulator.state import CommandKind

TASK = make_task("Keepaway3v2", controlled="right")
STRUCTURES = {"fsm": fsm, "subsumption": subsumption, "behavior_tree": behavior_tree, "code": code, "belief_region": belief_region}


def scene(taker, ball, keepers=((8.0, 8.0), (8.0, -8.0), (-8.0, 8.0)), constants=None, body=np.pi, other=(9.0, 0.0)):
    """The first taker's command; places in the frame of the pitch, in which he looks to the left."""
    agent = TakerAgent(TASK, constants)
    core = SoccerCore(TASK, 1, controlled="right_1", seed=2, include=agent.needs)
    core.reset(2)
    for player, (x, y) in {1: keepers[0], 2: keepers[1], 3: keepers[2], 13: other}.items():
        core.place_player(player, x, y, 0.0)
    core.place_player(12, *taker, body)
    core.place_ball(*ball)
    observation = {key: value[:, 0] for key, value in core.observe(np.array([0])).items()}
    agent.reset(observation, 0)
    action = agent.act(observation)
    return agent, {key: np.asarray(value)[0] for key, value in action.items()}


def test_at_the_ball_he_kicks_it_out_by_the_shortest_free_way():
    agent, action = scene((-6.0, 0.0), (-6.6, 0.0))
    assert action["type"] == CommandKind.KICK
    assert abs(agent.controller.executor.read("out_direction")[0]) < 30.0, "ahead of him is the nearest line"
    barred, _ = scene((-6.0, 0.0), (-6.6, 0.0), keepers=((-8.0, 0.0), (8.0, -8.0), (8.0, 8.0)))
    assert abs(barred.controller.executor.read("out_direction")[0]) > 30.0


def test_a_keeper_who_has_the_ball_is_tackled_where_it_is_likely_to_be_hit():
    _, action = scene((-4.5, 0.0), (-6.0, 0.0), keepers=((-6.7, 0.0), (8.0, 8.0), (8.0, -8.0)))
    assert action["type"] == CommandKind.TACKLE
    _, action = scene((-4.5, 0.0), (-6.0, 0.0), keepers=((-6.7, 0.0), (8.0, 8.0), (8.0, -8.0)), body=0.0)
    assert action["type"] != CommandKind.TACKLE
    _, action = scene((-4.5, 0.0), (-6.0, 0.0))
    assert action["type"] != CommandKind.TACKLE, "nobody has it"


def test_of_two_both_run_at_the_ball_or_the_second_covers_a_keeper():
    who = {"taker": (6.0, 0.0), "ball": (-6.0, 0.0), "other": (0.0, 0.0), "keepers": ((-6.7, 0.0), (0.0, 8.0), (4.0, -8.0))}
    both, _ = scene(**who)
    assert both.controller.executor.read("meet.ongoing")[0] == 1
    one, _ = scene(**who, constants=TakerConstants(hunters=1.0))
    assert one.controller.executor.read("walk.ongoing")[0] == 1


def test_one_thing_at_a_time():
    agents = [make_controller(TASK, f"right_{k}") for k in (1, 2)]
    core = SoccerCore(TASK, 8, seed=4, include=agents[0].needs)
    observation = core.reset(4)
    for k, agent in enumerate(agents):
        agent.reset({key: value[:, k] for key, value in observation.items()}, 4)
    busy = ("decide", "acted", "with_ball", "meet.ongoing", "walk.ongoing", "oust.ongoing")
    for _ in range(40):
        actions = [agent.act({key: value[:, k] for key, value in observation.items()}) for k, agent in enumerate(agents)]
        for agent in agents:
            assert (sum(agent.controller.executor.read(place) for place in busy) == 1).all()
        core.step({key: np.stack([np.asarray(action[key]) for action in actions], axis=1) for key in actions[0]})
    assert {p.name for p in TAKER_NET.places if isinstance(p, Place)} == {"looking", "decide", "acted", "with_ball"}


def test_keepers_and_other_tasks_are_refused():
    with pytest.raises(ParameterError, match="'left_1' is none"):
        make_controller(TASK, "left_1")
    with pytest.raises(ParameterError, match="GoToBall"):
        make_controller(make_task("GoToBall"), "right_1")


def test_the_registry_gives_takers_to_the_right_side():
    assert isinstance(cprm(TASK, "right_2"), TakerAgent)
    informed = cprm(TASK, "right_2", tier="belief")
    assert isinstance(informed, Informed)
    assert isinstance(informed.controller, TakerAgent)


@pytest.mark.parametrize("name", ["cprm", *STRUCTURES])
def test_takers_of_every_structure_take_the_ball_and_alone_as_in_a_batch(name):
    make = STRUCTURES[name].make_controller if name in STRUCTURES else cprm
    batch = play_episodes(TASK, make, 12, seed=8)
    assert batch.success.mean() >= 0.9
    assert batch.cycles.mean() <= 80
    for k in range(2):
        alone = play_episodes(TASK, make, 1, seed=8, first_world=k)
        assert (alone.cycles[0], alone.success[0]) == (batch.cycles[k], batch.success[k])


def test_takers_play_beside_keepers_of_any_kind():
    core = SoccerCore(make_task("Keepaway4v3"), 4, controlled=(), others=("cprm", "cprm"))
    core.reset(3)
    status = np.zeros(4, np.int64)
    for _ in range(600):
        status = np.maximum(status, core.step(None).status)
    assert (status > 0).all()
    assert {*status} <= {int(Status.TAKEN), int(Status.OUT_OF_BOUNDS)}
