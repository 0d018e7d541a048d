"""Many matches in a row in one process: memory stays flat, results are the same again."""

import gc
import resource

import numpy as np
import pytest

from cprm_gym.server import Port, Server, Settings

MATCH = ["server::synch_mode=true", "server::coach_w_referee=true", "server::auto_mode=true", "server::penalty_shoot_outs=false",
         "server::nr_extra_halfs=0", "server::kick_off_wait=2", "server::game_over_wait=1"]  # fmt: skip


def match(seed, *words):
    """A match of 22 players, of whom each dashes, turns or kicks; its last state, cycles and how many datagrams were sent."""
    server, random = Server(Settings.from_words([*MATCH, *words]), seed), np.random.default_rng(seed)
    players = []
    for n in range(22):
        first = f"(init {'Left' if n < 11 else 'Right'} (version 19){' (goalie)' if n % 11 == 0 else ''})".encode()
        players.append(server.receive(Port.PLAYER, n, first))
    sent = cycles = 0
    while not server.over:
        numbers = random.integers(-90, 90, 22)
        server.receive_many([(player, b"(dash 60 %d)(turn_neck 5)(done)\0" % k) for player, k in zip(players, numbers)])
        assert server.is_complete
        server.step()
        server.think()
        cycles += 1
        sent += len(server.take_outbox())
    return server.stadium.sim.state_hash(), cycles, sent


def memory():
    with open("/proc/self/statm") as stream:
        return int(stream.read().split()[1]) * resource.getpagesize() / 2**20


def play(matches, *words):
    """Growth of memory in MiB from the second match to the last."""
    first, cycles, _ = match(1, *words)
    total, begin = cycles, 0.0
    for n in range(1, matches):
        again, cycles, _ = match(1 if n == matches - 1 else n + 1, *words)
        total += cycles
        if n == 1:
            gc.collect()
            begin = memory()
    assert again == first
    gc.collect()
    return memory() - begin, total


def test_some_short_matches():
    growth, cycles = play(4, "server::half_time=5")
    assert cycles > 400
    assert growth < 10


@pytest.mark.slow
def test_a_day_of_matches():
    """864,000 cycles, a day of play: `pytest -m slow tests/server/test_long.py`, about 4 minutes of CPU."""
    growth, cycles = play(144)
    assert cycles >= 864_000
    assert growth < 20
