"""Messages written in bulk are those written one by one, to the byte."""

import dataclasses

import numpy as np
import pytest

from cprm_gym.envs.core import SoccerCore
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.protocol.bulk import BulkCommands, BulkMessages
from cprm_gym.simulator.protocol.commands import command_record, parse_commands
from cprm_gym.simulator.protocol.messages import see_text, sense_body_text
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PLAYERS

ROWS = list(range(PLAYERS))


def texts(sim, message=0):
    bodies = [sense_body_text(sim, 0, row + 1).encode() + b"\0" for row in ROWS]
    return bodies, [see_text(sim, 0, row + 1, message=message).encode() + b"\0" for row in ROWS]


def test_of_a_match_in_every_version():
    core = SoccerCore("Soccer11v11", 1, controlled=(), others="strong", seed=2)
    core.reset(2)
    bulk = BulkMessages(core.sim)
    for n in range(60):
        core.step(None)
        core.sim.world["protocol"][0] = 5 + (np.arange(PLAYERS) + n) % 15
        bodies, sights = texts(core.sim, n % 3)
        assert bulk.bodies(ROWS) == bodies
        assert bulk.sights(ROWS, n % 3) == sights
    assert bulk.sights(ROWS[3:9:2]) == texts(core.sim)[1][3:9:2]


def test_of_strange_worlds():
    """Every field of a body, low quality, pointing, cards, promoted goalies, fixed names, Gaussian distances, exponents."""
    parameters = dataclasses.replace(ServerParameters(), fixed_teamname_l="FixL", fixed_teamname_r="F")
    sim = Simulator(1, parameters, seed=1)
    sim.team_names = ("Left", "Some-other_team")
    bulk, random = BulkMessages(sim), np.random.default_rng(0)
    w = sim.world[0]
    for n in range(80):
        w["pos"] = random.uniform(-60, 60, (23, 2)) * random.choice([1, 0.1, 0.02])
        w["vel"] = random.normal(0, 0.5, (23, 2)) * random.choice([1, 1e-3, 1e-6])
        w["body"], w["neck"] = random.uniform(-np.pi, np.pi, 22), random.uniform(-1.5, 1.5, 22)
        w["stamina"], w["effort"], w["capacity"] = random.uniform(0, 8000, 22), random.uniform(0, 1, 22), random.uniform(0, 1.3e6, 22)
        for name, most in (("counts", 3000), ("tackle_cycles", 11), ("foul_cycles", 6), ("arm_timer", 25), ("kick_cycles", 2)):
            w[name] = random.integers(0, most, w[name].shape)
        w["kick_cycles"] -= 1
        w["arm_target"] = random.uniform(-60, 60, (22, 2))
        w["attention"], w["collided"] = random.integers(0, 23, 22), random.integers(0, 8, 22) << 4
        w["bits"] = random.choice([1, 9, 0x40001, 0x80000], 22)
        w["goalie"], w["gaussian"] = random.integers(0, 3, 22), random.integers(0, 2, 22)
        w["synchronous"], w["view_width"] = random.integers(0, 2, 22), random.integers(1, 4, 22)
        w["view_quality"] = random.integers(1, 3, 22)
        w["focus_distance"], w["focus_direction"] = random.uniform(0, 40, 22), random.uniform(-1, 1, 22)
        w["protocol"], w["time"], w["steps"] = random.integers(3, 20, 22), random.integers(0, 6000), n
        bodies, sights = texts(sim)
        assert bulk.bodies(ROWS) == bodies
        assert bulk.sights(ROWS) == sights


@pytest.mark.parametrize("value", [np.inf, np.nan, 1e300])
def test_numbers_that_no_kernel_writes_are_left_to_the_slow_way(value):
    sim = Simulator(1, seed=1)
    sim.world["stamina"][0, 2] = value
    assert BulkMessages(sim).bodies([1, 2, 3]) == texts(sim)[0][1:4]


PLAIN = [
    "(dash 100)",
    "(dash 50 -30.5)",
    "(dash 0.25 180)",
    "(turn -90)",
    "(kick 80 12.125)",
    "(catch 10)",
    "(tackle 45)",
    "(turn_neck 33)",
    "(done)",
]
OTHER = [
    "(dash +5)", "(dash 5.)", "(dash .5)", "(dash 1e2)", "(dash )", "(dash 1 2 3)", "(kick 5)", "(turn 1 2)", "(turn x)",
    "(move 1 2)", "(say hi)", "(nonsense)", "(tackle 1 on)", "(dash (l 1 2))", "dash", ")", "(", "(dash 100", "(done",
    "(turn  5)", " (turn 5)", "(bye)", "(dash 99999999999999999999999)", "(catch -)",
]  # fmt: skip


def slowly(sim, row, text):
    """What the grammar executes of a datagram, one command after the other."""
    parsed = parse_commands(text)
    for command in parsed.commands:
        record = command_record(command, 1 if row < 11 else -1)
        if record is not None:
            sim.command_phase(0, row + 1, record)
    return any(command.name == "done" for command in parsed.commands), parsed.error


def test_commands_in_bulk_are_commands_one_by_one():
    random = np.random.default_rng(4)
    one, many = Simulator(1, seed=3), Simulator(1, seed=3)
    bulk = BulkCommands(many)
    for sim in (one, many):
        sim.trainer.change_mode("play_on")
    for _ in range(150):
        for sim in (one, many):
            sim.world["announced"] = 0
        rows, texts = [], []
        for row in random.permutation(22)[: random.integers(1, 23)]:
            pieces = [random.choice(PLAIN) for _ in range(random.integers(1, 4))]
            if random.random() < 0.3:
                pieces.insert(int(random.integers(0, len(pieces) + 1)), random.choice(OTHER))
            rows.append(int(row))
            texts.append("".join(pieces))
        at, said = 0, []
        while at < len(texts):
            read, done = bulk.execute(rows[at:], [text.encode() for text in texts[at:]])
            assert read
            for row, text, size, finished in zip(rows[at:], texts[at:], read, done):
                rest, wrong = slowly(many, row, text[size:]) if size < len(text) else (False, None)
                said.append((finished or rest, wrong is not None))
            many.world["announced"] = 0
            at += len(read)
        expected = []
        for row, text in zip(rows, texts):
            finished, wrong = slowly(one, row, text)
            expected.append((finished, wrong is not None))
        assert said == expected
        assert one.state_hash() == many.state_hash()
        for sim in (one, many):
            sim.advance()
