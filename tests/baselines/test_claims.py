"""Everybody who is registered, in each kind of task that he claims: nothing is kept across a reset, and a world alone is as in a batch.

What a player was told is written down, and told him again without any world behind it: he sends the same. So he goes by nothing but his own
observations; not by the truth, nor by what another agent sees.
"""

import numpy as np
import pytest
from cprm_baselines.behaviour.maker import FILES, OTHER_SIDE
from cprm_baselines.lesions import LESIONS
from cprm_baselines.structures import STRUCTURES

from cprm_gym.agents import registry
from cprm_gym.agents.equivalents.machine import MachineAgent
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.others.registry import controller_entries, load_controller
from cprm_gym.envs.tasks import make_task
from cprm_gym.learning.player import shipped

WORLDS, CYCLES, ANEW = 3, 24, 1
"""In world `ANEW` an episode begins half-way."""
MATCHES = ("Soccer", "Soccer5v5", "Soccer11v11")
LESIONED = {"recovery": "PassAndAdvance"}
"""Part -> task of whose agent it is taken; else the goalie's."""


def kinds(where):
    """A task for each module in a table of task -> module; of matches the smallest."""
    found = {}
    for task, module in where.items():
        if task not in ("Soccer", "Soccer11v11"):
            found.setdefault((module, bool(make_task(task).right)), task)
    return list(found.values())


def machine(task, agent):
    """The agent's net as one state machine."""
    player = PLAYERS[task.name]
    return MachineAgent(player.make(task, agent, player.numbers("memory")))


CLAIMS = [
    *((name, task, "left_1") for name in STRUCTURES[1:] for task in kinds(FILES)),
    *((name, task, "right_1") for name in STRUCTURES[1:] for task in kinds(OTHER_SIDE)),
    *((name, "PassAndAdvance2v1", "left_2") for name in STRUCTURES[1:]),
    *(("cprm", task, "left_2" if task in MATCHES else "left_1") for task in kinds(registry.AGENTS)),
    *(("cprm", task, "right_1") for task in kinds(registry.OTHER_SIDE)),
    ("cprm", "HFO2v2", "right_2"), ("cprm", "HFO2v2", "left_2"), ("cprm", "Soccer5v5", "right_1"),
    ("cprm:model=intention", "Goalie", "left_1"), ("cprm:model=intention", "Goalie3v2", "left_2"),
    *((f"lesion:without={part}", LESIONED.get(part, "Goalie"), "left_1") for part in LESIONS),
    ("lesion:without=recovery:watched=true", "PassAndAdvance", "left_2"),
    *(("policy", task, "left_1") for task in sorted({name.split("-")[0] for name in shipped()})),
    *((name, "Goalie", "left_1") for name in ("goalie_memory", "goalie_raw")),
    *((name, task, agent) for name in ("scripted", "eased", "random") for task, agent in (("HFO2v2", "left_1"), ("HFO2v2", "right_1"))),
    (machine, "Goalie", "left_1"), (machine, "KickOffShot", "left_1"), (machine, "HFO2v1", "left_1"),
]  # fmt: skip


def begin(player, observation, seeds, worlds=None):
    """Begin episodes, with each world's luck where there is any."""
    if hasattr(player, "begin"):
        player.begin(observation, seeds, worlds)
    else:
        player.reset(observation, 4, worlds)


def told(player, task, agent):
    """What a player is told and what he does in some worlds; in one of them an episode begins half-way."""
    core = SoccerCore(task, WORLDS, controlled=agent, seed=4, include=tuple(getattr(player, "needs", ())))
    observation, seeds = core.reset(4), np.arange(WORLDS) + 50
    seen, sent = [], []
    for cycle in range(CYCLES):
        anew = np.arange(WORLDS) == ANEW
        if cycle == CYCLES // 2:
            observation, seeds = core.reset([np.random.SeedSequence(9)], np.array([ANEW])), np.where(anew, 99, seeds)
        mine = {key: np.array(value[:, 0]) for key, value in observation.items()}
        if cycle in (0, CYCLES // 2):
            begin(player, mine, seeds, None if cycle == 0 else anew)
        seen.append((mine, seeds))
        sent.append({key: np.array(value) for key, value in player.act(mine).items()})
        core.step({key: value[:, None] for key, value in sent[-1].items()})
        observation = core.observation
    return seen, sent


def again(player, seen, rows):
    """What he does when he is told it again: in all worlds, or in one alone that begins anew where it did."""
    sent = []
    for cycle, (observation, seeds) in enumerate(seen):
        mine = {key: np.array(value[rows]) for key, value in observation.items()}
        if cycle == 0:
            begin(player, mine, seeds[rows])
        elif cycle == CYCLES // 2 and ANEW in np.arange(WORLDS)[rows]:
            begin(player, mine, seeds[rows], np.arange(WORLDS) == ANEW if len(seeds[rows]) == WORLDS else None)
        sent.append({key: np.array(value) for key, value in player.act(mine).items()})
    return sent


def differ(one, other, rows=slice(None)):
    """The largest difference of two records, of some worlds of the first."""
    return max(
        float(np.abs(np.asarray(a[key][rows], float) - np.asarray(b[key], float)).max())
        for a, b in zip(one, other, strict=True)
        for key in a
    )


@pytest.mark.parametrize(("who", "name", "agent"), CLAIMS, ids=[f"{getattr(w, '__name__', w)}-{t}-{a}" for w, t, a in CLAIMS])
def test_a_reset_forgets_everything_and_a_world_alone_is_as_in_a_batch(who, name, agent):
    task = make_task(name)
    player = (load_controller(who) if isinstance(who, str) else who)(task, agent)
    seen, sent = told(player, task, agent)
    assert any(np.any(action["type"]) or np.any(action["turn_neck"]) for action in sent) or name in MATCHES
    assert differ(sent, again(player, seen, slice(None))) == 0.0
    for world in (0, ANEW):
        assert differ(sent, again(player, seen, slice(world, world + 1)), slice(world, world + 1)) < 1e-9


def test_everybody_registered_is_among_them():
    assert {who.split(":")[0] for who, _, _ in CLAIMS if isinstance(who, str)} == set(controller_entries())
