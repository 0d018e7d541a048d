"""A registered agent as one state machine: the same commands on the same observations, over whole episodes."""

from __future__ import annotations

import numpy as np
import pytest

from cprm_gym.agents.equivalents.machine import MachineAgent
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.play import agent_in
from cprm_gym.agents.registry import make_controller
from cprm_gym.agents.seeker import make_reckoning
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ControllerError, NetError, ParameterError


def _net(task, agent):
    """The agent of a task on what is reckoned."""
    if task.name in PLAYERS:
        player = PLAYERS[task.name]
        return player.make(task, agent, player.numbers("memory"))
    return make_reckoning(task, agent) if task.name == "GoToBall" else agent_in(make_controller(task, agent))


class _Both:
    """Net and machine side by side; the net plays."""

    made: list[_Both] = []  # noqa: RUF012

    def __init__(self, task, agent):
        self.net, self.machine = _net(task, agent), MachineAgent(_net(task, agent))
        self.needs, self.alike, self.all = self.net.needs, 0, 0
        self.made.append(self)

    def reset(self, observation, seed, worlds=None):
        self.net.reset(observation, seed, worlds)
        self.machine.reset(observation, seed, worlds)

    def act(self, observation):
        action, other = self.net.act(observation), self.machine.act(observation)
        same = [(np.asarray(action[key]) == np.asarray(other[key])).reshape(len(action["type"]), -1).all(axis=1) for key in action]
        self.alike, self.all = self.alike + int(np.all(same, axis=0).sum()), self.all + len(action["type"])
        return action


@pytest.mark.parametrize(
    "task", ["GoToBall", "KickOffShot", "Goalie", "LostAndFound", "Hike", "HFO2v1", "Keepaway3v2", "PassAndAdvance2v1"]
)
def test_a_machine_sends_the_commands_of_the_net_through_whole_episodes(task):
    _Both.made.clear()
    episodes = play_episodes(make_task(task), _Both, 6, 11)
    assert episodes.cycles.sum() > 60
    for both in _Both.made:
        assert both.alike == both.all
        assert len(both.machine.machine.states) > 1


@pytest.mark.parametrize(("task", "states"), [("GoToBall", 5), ("KickOffShot", 270), ("Goalie", 156)])
def test_the_whole_machine_is_written_down(task, states):
    explored = MachineAgent(_net(make_task(task), "left_1")).machine.explore(seconds=120)
    assert explored.complete
    assert explored.states == states


def test_an_agent_who_infers_or_chooses_objects_has_no_machine():
    with pytest.raises(ParameterError, match="model of his own"):
        MachineAgent(agent_in(make_controller(make_task("GoToBall"), "left_1")))
    reads_objects = agent_in(make_controller(make_task("PassAndAdvance"), "left_1", tier="memory", model=""))
    assert reads_objects is not None
    with pytest.raises((NetError, ParameterError)):
        MachineAgent(reads_objects)


def test_to_act_before_an_episode_is_refused():
    with pytest.raises(ControllerError, match="act before reset"):
        MachineAgent(_net(make_task("Hike"), "left_1")).act({})
