"""A player who joins by text observes what the environment would show him: every part of the observation, cycle by cycle."""

from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.client.perceived import PerceivedSimulator, PlayerEar
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import BodyFeature
from cprm_gym.envs.tasks import make_task
from cprm_gym.joining.player import PerceivedCore
from cprm_gym.simulator.protocol.commands import command_record, command_text, parse_commands
from cprm_gym.simulator.protocol.messages import broadcast_text, hear_text, referee_text, see_text, sense_body_text
from cprm_gym.simulator.state import CommandKind

AGENTS = ("left_1", "left_7", "right_1", "right_10")
PARTS = ("memory", "landmarks", "lines", "hear")
PRINTED = [BodyFeature.STAMINA, BodyFeature.EFFORT, BodyFeature.CAPACITY]


def told(sim, ear):
    """The messages of a cycle, in the server's order."""
    row = ear.row
    for text in (*broadcast_text(sim, 0, row + 1), *referee_text(sim, 0)):
        ear.tell(text)
    ear.tell(sense_body_text(sim, 0, row + 1))
    for text in hear_text(sim, 0, row + 1):
        ear.tell(text)
    if sim.world["saw"][0, row] & 1:
        ear.tell(see_text(sim, 0, row + 1))


def actions(random, agents):
    kinds = random.choice([CommandKind.DASH, CommandKind.TURN, CommandKind.KICK, CommandKind.TACKLE], len(agents))
    return {
        "type": kinds[None].astype(np.int64),
        "params": random.uniform(-1, 1, (1, len(agents), 4)),
        "turn_neck": random.uniform(-0.2, 0.2, (1, len(agents), 1)),
        "view": random.integers(0, 4, (1, len(agents))),
    }


def play(cycles, **rules):
    """How many arrays were compared."""
    task = make_task("Soccer11v11")
    task = replace(task, parameters=replace(task.parameters, **rules))
    core = SoccerCore(task, 1, controlled=AGENTS, others="strong", include=PARTS, seed=5)
    core.reset(5)
    mirrors, ears = [], []
    for agent, row in zip(AGENTS, core.players - 1):
        sim = PerceivedSimulator(core.sim.parameters, core.sim.types)
        ear = PlayerEar(sim, int(row), "Left" if row < 11 else "Right")
        sim.world["goalie"][0, row] = core.sim.world["goalie"][0, row]
        mirror = PerceivedCore(task, agent, sim, PARTS)
        told(core.sim, ear)  # the eyes of the environment are open at the kick-off
        mirror.enter()
        ear.consumed()
        ears.append(ear)
        mirrors.append(mirror)
    random = np.random.default_rng(0)
    compared = 0
    for n in range(cycles):
        action = actions(random, AGENTS)
        for k, mirror in enumerate(mirrors):
            mirror.commanded({key: values[:, k : k + 1] for key, values in action.items()})
        core.step(action)
        for k, (mirror, ear) in enumerate(zip(mirrors, ears)):
            told(core.sim, ear)
            mirror.observe()
            ear.consumed()
            for key, whole in core.observation.items():
                mine, expected = mirror.observation[key][:, 0].copy(), whole[:, k].copy()
                if key == "body":
                    np.testing.assert_allclose(mine[:, PRINTED], expected[:, PRINTED], rtol=1e-5)
                    mine[:, PRINTED] = expected[:, PRINTED]
                assert np.array_equal(mine, expected), (n, AGENTS[k], key)
                compared += 1
    return compared


def test_observations_by_text_are_those_of_the_environment():
    assert play(100) > 100


def test_observations_of_both_halves():
    assert play(110, half_time=5) > 110


@pytest.mark.slow
def test_observations_of_a_whole_match():
    """`pytest -m slow tests/joining/test_observations.py`, about a minute."""
    play(6000)


def test_actions_become_commands_that_mean_the_same():
    """Text of a command, read by the server, is the record that the environment would have executed."""
    core = SoccerCore("Soccer11v11", 1, controlled="left_3", others="hold", action_mode="full")
    core.reset(1)
    random = np.random.default_rng(1)
    for _ in range(300):
        action = actions(random, ("left_3",))
        action["type"][:] = random.integers(0, 8)
        action |= {"attention": random.integers(0, 24, (1, 1)), "point": random.uniform(-1, 1, (1, 1, 3)),
                   "say": random.integers(0, 70, (1, 1, 10))}  # fmt: skip
        record = core.commanded(action)[0, 2]
        parsed = parse_commands(command_text(record))
        assert parsed.error is None
        again = np.zeros((), record.dtype)
        again[()] = record
        for command in parsed.commands:
            read = command_record(command)
            if read is None:
                assert command.name == "say"
                continue
            for name in record.dtype.names:
                blank = np.isnan(read[name]).all() if read[name].dtype.kind == "f" else not np.any(read[name])
                if not blank and name != "b":
                    assert np.array_equal(np.asarray(read[name][0]), np.asarray(record[name]), equal_nan=True), (name, command)
