"""What is counted of a match, on scenes of which the answer is known."""

import numpy as np
import pytest

from cprm_gym.simulator.gamelog.frames import Frame, Team, empty_players
from cprm_gym.simulator.gamelog.statistics import Counting, match_statistics
from cprm_gym.simulator.state import Count, PlayerBit, PlayMode

STAND, KICK, FAULT, TACKLE = PlayerBit.STAND, PlayerBit.KICK, PlayerBit.KICK_FAULT, PlayerBit.TACKLE


def frame(time, ball=(0, 0, 0, 0), kicks=(), mode=PlayMode.play_on, score=(0, 0), places=None, bits=KICK):
    made = Frame(time, 0, mode, Team("L", score[0]), Team("R", score[1]))
    made.ball = np.array(ball, float)
    made.players = empty_players()
    made.players["state"], made.players["pos"], made.players["stamina"] = STAND, 0.0, 8000
    for row in kicks:
        made.players["state"][row] |= bits
    for row, place in (places or {}).items():
        made.players["pos"][row] = place
    return made


def counted(*frames):
    counting = Counting(half=10)
    for one in frames:
        counting.add(one)
    return counting.result()


def test_passes_and_lost_balls():
    found = counted(
        frame(1, kicks=[1]), frame(2), frame(3, kicks=[2]), frame(4, kicks=[2]), frame(5, kicks=[13]),
        frame(6, kicks=[14], bits=KICK | FAULT), frame(7, kicks=[15]), frame(8, kicks=[3]),
    ).whole  # fmt: skip
    assert (found.passes, found.lost, found.touches) == ([1, 1], [1, 1], [4, 2])
    assert found.possession == [5, 3]


def test_a_set_play_ends_the_chain_of_passes():
    found = counted(frame(1, kicks=[1]), frame(2, mode=PlayMode.kick_in_l), frame(3, kicks=[2])).whole
    assert found.passes == [0, 0]
    assert found.modes["kick_in_l"] == 1


@pytest.mark.parametrize(
    ("ball", "shot"),
    [((40, 0, 2, 0), 1), ((40, 0, -2, 0), 0), ((40, 0, 0.5, 0), 0), ((10, 0, 2.9, 0), 0), ((40, 0, 2, 2), 0), ((40, 6, 2, 0.2), 1)],
)
def test_shots(ball, shot):
    assert counted(frame(1, ball, kicks=[9])).whole.shots == [shot, 0]
    mirrored = (-ball[0], ball[1], -ball[2], ball[3])
    assert counted(frame(1, mirrored, kicks=[20])).whole.shots == [0, shot]


def test_a_long_tackle_is_one_touch():
    assert counted(*(frame(t, kicks=[4], bits=TACKLE) for t in range(1, 8))).whole.touches == [1, 0]


def test_ways_goals_and_halves():
    found = counted(
        frame(1), frame(2, places={0: (1, 0)}), frame(3, places={0: (1, 1)}), frame(3, places={0: (30, 0)}),
        frame(4, mode=PlayMode.goal_l, score=(1, 0), places={0: (9, 0)}), frame(12, score=(1, 0)),
        frame(13, mode=PlayMode.goal_r, score=(1, 1)),
    )  # fmt: skip
    assert found.whole.way[0] == pytest.approx(2.0)
    assert found.whole.goals == [1, 1]
    assert [part.goals for part in found.halves] == [[1, 0], [0, 1]]
    assert found.teams == ("L", "R")


@pytest.mark.parametrize("seed", [1, 4])
def test_of_a_log(tmp_path, seed):
    from cprm_gym.envs.core import SoccerCore
    from cprm_gym.simulator.gamelog.writer import GameLogWriter

    core = SoccerCore("Soccer11v11", 1, controlled=(), others="strong", seed=seed)
    core.reset(seed)
    with GameLogWriter.for_simulator(tmp_path / "game.rcg", core.sim) as log:
        counts, kicked, played = core.sim.world["counts"][0], 0, 0
        for _ in range(300):
            before = counts.copy()
            core.step(None)
            log.record(core.sim)
            kicks, tackles = ((counts[:, which] > before[:, which]).any() for which in (Count.KICK, Count.TACKLE))
            kicked, played = kicked + kicks, played + (kicks or tackles)
    found = match_statistics(tmp_path / "game.rcg").whole
    assert found.cycles == 300
    assert 0 < kicked <= sum(found.touches) <= played, "one touch a cycle, whoever else kicks in it"
    assert found.way.sum() > 1000
    assert found.heat[0].sum() <= 300
