"""The same seed gives the same match, bit for bit: in any batch, on any threads, after any snapshot."""

from __future__ import annotations

import numpy as np
import pytest
from simulator_worlds import same

from cprm_gym.errors import ParameterError
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import PlayerParameters
from cprm_gym.simulator.simulator import Simulator, no_commands
from cprm_gym.simulator.state import WORLD, CommandKind, PlayMode

TYPES = PlayerParameters(random_seed=3)


def commands_for(worlds, rng):
    """Commands of a lively game: mostly dashes, then turns and kicks, now and then the rest."""
    commands = no_commands(worlds, 22)
    shares = {"DASH": 0.5, "TURN": 0.12, "KICK": 0.25, "TACKLE": 0.03, "CATCH": 0.03, "MOVE": 0.02, "DASH_LEGS": 0.05}
    commands["kind"] = rng.choice([CommandKind[name] for name in shares], (worlds, 22), p=list(shares.values()))
    for name, low, high in (("a", -50, 100), ("b", -180, 180), ("c", 0, 100), ("d", -180, 180), ("turn_neck", -90, 90)):
        commands[name] = rng.uniform(low, high, (worlds, 22))
    return commands


def played(simulator, cycles, seed=0, watch=None):
    """Play `cycles` with random commands, the same for every batch that contains world `watch`."""
    simulator.trainer.start()
    for cycle in range(cycles):
        commands = no_commands(simulator.worlds, 22)
        for k in range(simulator.worlds):
            commands[k] = commands_for(1, np.random.default_rng([seed, cycle, k if watch is None else watch]))[0]
        simulator.step(commands)
        if cycle % 10 == 5:
            simulator.see()
    return simulator


def test_a_world_of_a_batch_is_the_same_world_alone():
    batch = played(Simulator(256, player_parameters=TYPES, seed=4), 12)
    for k in (0, 3, 255):
        alone = Simulator(1, player_parameters=TYPES, seed=4)
        alone.world["key"] = Simulator(256, player_parameters=TYPES, seed=4).world["key"][k]
        played(alone, 12, watch=k)
        assert alone.state_hash() == batch.state_hash(k)
        assert same(alone.world[0], batch.world[k])


def test_threads_do_not_matter():
    hashes = {threads: played(Simulator(7, player_parameters=TYPES, seed=1, threads=threads), 40).state_hash() for threads in (1, 2, 5, 16)}
    assert len(set(hashes.values())) == 1


def test_a_restored_snapshot_plays_the_same_future():
    simulator = played(Simulator(3, player_parameters=TYPES, seed=9), 30)
    snapshot = simulator.snapshot()
    futures = []
    for _ in range(2):
        simulator.restore(snapshot)
        rng = np.random.default_rng(5)
        for _ in range(60):
            simulator.step(commands_for(3, rng))
        futures.append(simulator.snapshot())
    assert same(*futures)
    other = Simulator(3, player_parameters=TYPES, seed=77)
    other.restore(snapshot)
    assert not same(other.world, futures[0])
    assert same(other.world, snapshot)


def test_one_snapshot_branches_into_many_worlds():
    simulator = Simulator(4, seed=2)
    simulator.trainer.start()
    simulator.step()
    simulator.restore(simulator.snapshot()[2])
    assert len({simulator.state_hash(k) for k in range(4)}) == 1
    simulator.restore(simulator.snapshot()[:2], [3, 1])
    with pytest.raises(ParameterError, match="`snapshot` takes 1 or 4 records of dtype WORLD"):
        simulator.restore(np.zeros(3, WORLD))
    with pytest.raises(ParameterError, match="`snapshot`"):
        simulator.restore("yesterday")


def test_one_players_commands_do_not_change_anothers_luck():
    simulators = [Simulator(1, seed=6, player_parameters=TYPES) for _ in range(2)]
    for simulator in simulators:
        simulator.world["mode"] = PlayMode.play_on
        for i in range(22):
            simulator.world["pos"][0, i + 1] = 4.0 * i - 40, 20.0
    for cycle in range(30):
        for alternative, simulator in enumerate(simulators):
            commands = commands_for(1, np.random.default_rng(cycle))
            commands["kind"] = CommandKind.TURN
            if alternative:
                commands["kind"][0, 3] = CommandKind.NONE
            simulator.step(commands)
    same = simulators[0].world["body"] == simulators[1].world["body"]
    assert same[0].sum() == 21
    assert not same[0, 3]


def test_a_seed_repeats_and_another_does_not():
    one, same, other = (played(Simulator(2, player_parameters=TYPES, seed=seed), 30).state_hash() for seed in (1, 1, 2))
    assert one == same != other


@pytest.mark.parametrize("seed", [5, np.random.SeedSequence(5), [5, 6, 7]])
def test_seeds_of_every_form_give_every_world_streams_of_its_own(seed):
    keys = Simulator(3, seed=seed).world["key"]
    assert len(np.unique(keys)) == 12
    assert (keys == Simulator(3, seed=seed).world["key"]).all()


def test_reset_begins_anew_where_asked():
    simulator = played(Simulator(4, player_parameters=TYPES, seed=3), 20)
    before = simulator.snapshot()
    simulator.reset(worlds=[1, 2])
    assert simulator.world["time"].tolist() == [before["time"][0], 0, 0, before["time"][3]]
    assert (simulator.world["mode"][1:3] == PlayMode.before_kick_off).all()
    assert (simulator.world["key"] == before["key"]).all()
    assert (simulator.world["steps"] == before["steps"]).all()
    simulator.reset(3)
    played(simulator, 20)
    assert simulator.state_hash() == Simulator.state_hash(played(Simulator(4, player_parameters=TYPES, seed=3), 20))
    assert same(simulator.world, before)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"worlds": 0}, "`worlds`"),
        ({"worlds": 2.0}, "`worlds`"),
        ({"threads": 0}, "`threads`"),
        ({"left": 12}, "`left`"),
        ({"right": -1}, "`right`"),
        ({"goalies": (12, 1)}, "`goalies`"),
        ({"left": 3, "goalies": (4, 1)}, "`goalies`"),
        ({"goalies": 1}, "`goalies`"),
        ({"seed": -1}, "`seed`"),
        ({"seed": [1, 2, 3]}, "`seed`"),
        ({"seed": "x"}, "`seed`"),
        ({"player_parameters": None, "seed": "x"}, "`seed`"),
        ({"rules": 4096}, "`rules`"),
        ({"rules": "all"}, "`rules`"),
        ({"parameters": {}}, "`parameters` takes a ServerParameters"),
        ({"player_parameters": 3}, "`player_parameters`"),
        ({"player_types": [1]}, r"`player_types\[0\]` takes a PlayerType"),
    ],
)
def test_impossible_arguments_are_named(arguments, named):
    with pytest.raises(ParameterError, match=named):
        Simulator(**{"player_parameters": TYPES, **arguments})


@pytest.mark.parametrize("worlds", [4, [0, 9], "all", [True, False], 1.5])
def test_worlds_that_do_not_exist_are_refused(worlds):
    with pytest.raises(ParameterError, match="`worlds` takes indices 0 to 2"):
        Simulator(3).reset(worlds=worlds)


def test_the_length_of_an_episode_does_not_change_how_the_next_begins():
    starts = []
    for cycles in (3, 40):
        simulator = played(Simulator(2, ServerParameters(wind_random=True), TYPES, seed=8), cycles)
        simulator.reset()
        starts.append((simulator.world["wind"].copy(), simulator.uniforms(None, 5), simulator.uniforms(None, 5)))
    for one, other in zip(*starts):
        assert (one == other).all()
    assert not np.isin(starts[0][1], starts[0][2]).any()


def test_a_step_allocates_nothing():
    import tracemalloc

    simulator = played(Simulator(2, player_parameters=TYPES), 5)
    buffers = simulator.see(), simulator.sense_body()
    commands = commands_for(2, np.random.default_rng(0))
    simulator.step(commands)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for _ in range(200):
            simulator.step(commands)
            simulator.see(buffers[0])
            simulator.sense_body(buffers[1])
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert grown < 2000


def test_a_world_is_small():
    assert WORLD.itemsize <= 16 * 1024


def test_parameters_change_the_match():
    slow = played(Simulator(1, ServerParameters(player_speed_max=0.9), TYPES, seed=1), 50)
    assert slow.state_hash() != played(Simulator(1, player_parameters=TYPES, seed=1), 50).state_hash()
