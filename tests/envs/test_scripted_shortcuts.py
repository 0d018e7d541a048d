"""What scripted players work out the short way is what the long way gives, to the last bit."""

import numpy as np
import pytest

from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.players.kernels import memory as memory_kernels
from cprm_gym.envs.players.kernels.motion import LONGEST, intercept
from cprm_gym.envs.players.kernels.team import PATIENCE, rank_to_ball
from cprm_gym.envs.players.memory import Memories
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PLAYERS


def rank_by_intercepts(m, me, count):
    own = intercept(m, m["x"], m["y"], 0.5)[0]
    before = 0
    for k in range(count):
        if k != me and m["age"][k] <= 20 and (k != m["kicker"] - 1 or m["clock"] - m["kicked"] <= PATIENCE):
            t = intercept(m, m["px"][k], m["py"][k], 0.5)[0]
            before += t < own or (t == own and k < me)
    return before


@pytest.mark.parametrize("speed", [0.0, 0.6, 3.0])
def test_who_is_first_at_the_ball_is_who_meets_it_first(speed):
    rng = np.random.default_rng(1)
    records = Memories(Simulator(60), np.ones(PLAYERS, bool)).records
    ranks, owns = [], []
    for m in records[:, 0]:
        m["px"], m["py"] = rng.uniform(-52, 52, PLAYERS), rng.uniform(-34, 34, PLAYERS)
        m["age"] = rng.integers(0, 25, PLAYERS)
        m["x"], m["y"], m["ball_x"], m["ball_y"] = rng.uniform(-40, 40, 4)
        m["ball_vx"], m["ball_vy"] = rng.uniform(-speed, speed, 2)
        for k in range(11):
            if rng.random() < 0.2:  # as far as he is, a tie
                m["px"][k], m["py"][k] = m["x"], m["y"]
        me = int(rng.integers(11))
        ranks.append(rank_to_ball(m, me, 11))
        owns.append(intercept(m, m["x"], m["y"], 0.5)[0])
        assert ranks[-1] == rank_by_intercepts(m, me, 11)
    assert len(set(ranks)) > 4
    assert (np.array(owns) >= LONGEST).any() or speed > 0.0


def test_a_glance_at_the_landmarks_places_a_player_as_the_message_does():
    core = SoccerCore(make_task("Soccer11v11"), 4, include=("memory",))
    core.reset(1)
    rng, updates = np.random.default_rng(1), 0
    sim, ours = core.sim, core._memories
    for _ in range(30):
        before = ours.records.copy()
        core.step({"type": rng.integers(0, 3, (4, 22)), "params": rng.uniform(-1, 1, (4, 22, 4))})
        see, body, marks = sim.see(), sim.sense_body(), sim.landmarks()
        memory_kernels.update(
            sim.world, sim.packed, core.every, before, sim.commands, ours.active, see.fresh, see.ball, see.ball_level, see.players,
            see.players_level, body, True, np.zeros((3, 55)), marks.landmarks, marks.level, marks.lines, marks.line,
        )  # fmt: skip
        updates += see.fresh.sum()
        np.testing.assert_array_equal(before, ours.records)
    assert updates > 500
