"""The outfield player of a match: places, covers, tackles; the same in a batch and alone; who plays beside whom."""

import numpy as np
import pytest

from cprm_gym.agents.attacker.percepts import terms
from cprm_gym.agents.body import DEFAULT
from cprm_gym.agents.goalie import GoalieAgent
from cprm_gym.agents.match.agent import MATCH_NET, MatchAgent, make_outfielder
from cprm_gym.agents.match.constants import MatchConstants
from cprm_gym.agents.match.kernels import home, place, tackle_chance
from cprm_gym.agents.match.percepts import place_terms
from cprm_gym.agents.outfielder.agent import KEEP_OFF, OUTFIELDER
from cprm_gym.agents.registry import AGENTS, make_controller
from cprm_gym.architecture.petri import Executor
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError
from cprm_gym.simulator.state import CommandKind

PLACES = place_terms(MatchConstants())
JUDGED_BY = terms(DEFAULT, MatchConstants())
PLAYED, OURS, THEIRS = 1, 2, 3


def goes(ball, me, mates=(), rivals=(), mode=PLAYED, own=20.0, mate=5.0, stamina=1.0, formation=(-36.0, 6.0), support=(30.0, 20.0)):
    """Where a player goes."""
    out = np.zeros(4)
    mates, rivals = (np.array(who, float).reshape(-1, 2) for who in (mates, rivals))
    place(
        np.array([*ball, 0.0, 0.0]), np.array([*me, 0.0, 0.0, 0.0]), mates, np.zeros(len(mates)), rivals, np.zeros(len(rivals)), own, mate,
        60.0, np.array(formation), np.array(support), mode, stamina, PLACES, JUDGED_BY, out,
    )  # fmt: skip
    return out[:2]


def test_who_is_near_supports_the_one_with_the_ball_and_the_others_keep_their_places():
    near = goes((0.0, 0.0), (-5.0, 3.0), mates=[(0.5, 0.0)], rivals=[(20.0, 0.0)])
    far = goes((0.0, 0.0), (-5.0, 3.0), mates=[(0.5, 0.0), (1.0, 1.0), (2.0, 1.0), (3.0, 0.0)], rivals=[(20.0, 0.0)])
    assert near.tolist() == [30.0, 20.0]
    assert far[0] < -25.0


def test_the_second_at_a_ball_of_theirs_stands_behind_it_before_the_own_goal():
    spot = goes((-20.0, 10.0), (-25.0, 0.0), mates=[(-21.0, 10.0)], rivals=[(-20.0, 10.0)])
    assert spot[0] < -20.0
    assert abs(spot[1]) < 10.0


def test_a_man_near_the_own_place_is_marked_from_the_side_of_the_goal():
    mates = [(-11.0, 0.0), (-12.0, 1.0), (-12.0, -1.0)]
    alone = goes((-10.0, 0.0), (-36.0, 6.0), mates, [(-10.0, 0.0)])
    marking = goes((-10.0, 0.0), (-36.0, 6.0), mates, [(-10.0, 0.0), (alone[0] + 3.0, alone[1])])
    assert np.hypot(*(alone - marking)) > 1.0
    assert marking[0] < alone[0] + 3.0


def test_the_distance_is_kept_at_a_set_play_of_theirs():
    for ball in ((-36.0, 6.0), (-30.0, 3.0)):
        spot = goes(ball, (-36.0, 6.0), rivals=[ball], mode=THEIRS)
        assert np.hypot(spot[0] - ball[0], spot[1] - ball[1]) >= KEEP_OFF - 1e-6


def test_who_is_tired_rests_while_his_team_has_the_ball():
    given = {"mates": [(0.5, 0.0), (1.0, 1.0), (2.0, 1.0), (3.0, 0.0)], "rivals": [(40.0, 0.0)]}
    assert goes((0.0, 0.0), (-30.0, 8.0), stamina=0.3, **given).tolist() == [-30.0, 8.0]
    assert goes((0.0, 0.0), (-30.0, 8.0), stamina=0.9, **given).tolist() != [-30.0, 8.0]


def test_nobody_waits_offside():
    x, _ = home(np.array([10.0, 0.0, 0.0, 0.0]), -10.5, 0.0, 25.0, PLACES)
    assert 20.0 < x <= 25.0 - PLACES.margin


def test_a_tackle_hits_what_lies_ahead_and_near():
    me = np.zeros(5)
    chances = [tackle_chance(x, y, me, 2.0, 1.25, 6.0) for x, y in ((0.5, 0.0), (1.9, 0.0), (2.5, 0.0), (-0.5, 0.0))]
    assert chances[0] > 0.99 > chances[1] > 0.0
    assert chances[2:] == [0.0, 0.0]


def test_he_tackles_an_opponent_who_has_the_ball_and_nobody_else():
    def sends(**given):
        executor = Executor(MATCH_NET)
        nothing = {**dict.fromkeys(executor.input_names, 0.0), "game.playing": 1.0, "mate.ball_gap": 30.0, "mate.time": 30.0,
                   "me.time": 2.0, "ball.reckoned_distance": 1.5,
                   "pass.worth": -1e9, "meet.distance": 1.5}  # fmt: skip
        firing = executor.step({**nothing, **given})
        return [*firing.of()]

    assert "tackle" in sends(**{"tackle.chance": 0.95, "rival.gap": 0.8})
    assert "tackle" not in sends(**{"tackle.chance": 0.95, "rival.gap": 5.0})
    assert "tackle" not in sends(**{"tackle.chance": 0.5, "rival.gap": 0.8})


def test_the_registry_gives_a_team_to_every_match_and_with_a_model_the_eleven():
    for task in ("Soccer", "Soccer5v5", "Soccer11v11"):
        assert AGENTS[task] == "match.agent"
        made = make_task(task)
        assert isinstance(make_controller(made, "right_1"), GoalieAgent)
        assert make_controller(made, "left_4").cprm.net == MATCH_NET
        assert make_controller(made, "left_4", model="bins").cprm == OUTFIELDER
    with pytest.raises(ParameterError, match="no option 't_b'; write model=bins"):
        make_controller(made, "left_4", t_b=5)


def played(worlds, anew=None, cycles=40):
    """What a player does in each world of a batch, cycle by cycle; in `anew` the episode begins again half-way."""
    task = make_task("Soccer5v5", controlled="left_3", others="medium")
    core, agent = SoccerCore(task, worlds, include=("memory",), seed=3), make_outfielder(task, "left_3")
    agent.reset({key: value[:, 0] for key, value in core.reset(3).items()}, 0)
    done = []
    for cycle in range(cycles):
        if anew is not None and cycle == cycles // 2:
            observation = core.reset([np.random.SeedSequence(9)], np.array([anew]))
            agent.reset({key: value[:, 0] for key, value in observation.items()}, 0, np.arange(worlds) == anew)
        action = agent.act({key: value[:, 0] for key, value in core.observation.items()})
        done.append({key: value.copy() for key, value in action.items()})
        core.step({key: value[:, None] for key, value in action.items()})
    return done


def test_a_world_is_played_in_a_batch_as_alone_and_what_begins_anew_changes_no_other():
    alone, batch, begun = played(1), played(3), played(3, anew=2)
    assert any(action["type"][0] != CommandKind.NONE for action in alone)
    for one, many, other in zip(alone, batch, begun, strict=True):
        for key in one:
            np.testing.assert_array_equal(one[key][0], many[key][0], err_msg=key)
            np.testing.assert_array_equal(many[key][:2], other[key][:2], err_msg=key)


@pytest.mark.slow
def test_the_team_scores_more_than_the_strong_scripted_one():
    core = SoccerCore(make_task("Soccer5v5", max_cycles=1500), 12, controlled=(), others=("cprm", "strong"))
    core.reset(17)
    for _ in range(1500):
        core.step(None)
    ours, theirs = core.sim.world["score"].sum(axis=0)
    assert ours > theirs


def test_every_number_is_used():
    assert {*MatchConstants.extents()} > {*PLACES._fields} - {"distance", "half_length", "ahead"}
    assert MatchAgent(4, 5, constants=MatchConstants(lunge=0.5)).cprm.net != MATCH_NET
