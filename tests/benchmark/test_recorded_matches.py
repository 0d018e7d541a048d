"""What holders of the ball are about to do, read from recorded play: by hand, and from a match where there is one."""

import numpy as np
import pytest
from paths import SHARED

from cprm_gym.benchmark.demonstrations.learning import foreseen, learn, log_loss
from cprm_gym.benchmark.demonstrations.matches import KICK, NEAR, _attacked, from_match
from cprm_gym.errors import CprmError
from cprm_gym.simulator.gamelog.frames import Frame, empty_players

MATCH = SHARED / "matches" / "HELIOS_L_2-vs-HELIOS_R_3.rcg.gz"


def shooting(cycles=8, shot=4, side=1.0):
    """A right player dribbles towards the left goal, or, turned round, a left one towards the right goal, and shoots in a cycle."""
    frames, x, vx, kicks = [], -30.0, -0.5, 0
    for cycle in range(cycles):
        players = empty_players()
        shooter, keeper = (11, 0) if side > 0 else (0, 11)
        players["state"][[shooter, keeper]] = 1
        players["pos"][shooter], players["vel"][shooter] = (side * (x + 0.5), 0.0), (side * vx, 0.0)
        players["pos"][keeper] = (-50.0 * side, side)
        players["counts"][shooter, KICK] = kicks
        frames.append(Frame(cycle, ball=side * np.array([x, 0.0, vx, 0.0]), players=players))
        if cycle == shot:
            vx, kicks = -2.5, 1
        x += vx
    return frames


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_shot_is_that_of_the_cycle_in_which_the_ball_is_kicked_at_either_goal(side):
    log = _attacked(shooting(side=side), side)
    assert log.cycle[log.shot].tolist() == [4]
    assert log.due.tolist()[:5] == [4, 3, 2, 1, 0]
    assert log.line[log.shot] == pytest.approx([0.0], abs=0.1)
    assert (log.holder == 0).all()
    assert len(_attacked(shooting(side=side), -side).world) == 0, "nobody attacks the other goal"


def test_a_log_without_attacks_is_refused(tmp_path):
    path = tmp_path / "empty.rcg"
    path.write_text("ULG5\n")
    with pytest.raises(CprmError):
        from_match(path)


@pytest.mark.slow
@pytest.mark.skipif(not MATCH.exists(), reason="no recorded matches beside the repository")
def test_tables_learned_from_a_match_are_probabilities_of_shots():
    log = from_match(MATCH)
    assert log.shot.sum() >= 5
    assert (log.numbers[:, 3] < NEAR).all()
    chance = foreseen(learn(log, True, "a match", iterations=2), log)[5]
    assert log_loss(chance, log.due < 5) < 0.3
