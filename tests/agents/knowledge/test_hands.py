"""How likely a goalie's hands are to take the ball: as the simulator decides it, and as an integral."""

import numpy as np
import pytest
from simulator_worlds import D2R, act, put, quiet_world

from cprm_gym.agents.body import Body
from cprm_gym.agents.knowledge import informed
from cprm_gym.agents.knowledge.hands import Hold, Spread, holding
from cprm_gym.agents.knowledge.players import goalie
from cprm_gym.agents.knowledge.tracker import Tracker
from cprm_gym.agents.registry import make_controller
from cprm_gym.agents.skills.constants import GoalieConstants, HoldingConstants
from cprm_gym.benchmark.chapter5.slow import Slow
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.observations import SelfFeature
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.player_types import PlayerType
from cprm_gym.simulator.state import CommandKind, PlayerBit


def himself(count, body=0.0, vx=0.0):
    """(N, 8): at the origin."""
    me = np.zeros((count, len(SelfFeature)))
    me[:, SelfFeature.BODY], me[:, SelfFeature.VX] = body, vx
    return me


def ball(x, y, vx=0.0, vy=0.0, sd=1e-4):
    """One normal in each of N worlds."""
    means = np.stack(np.broadcast_arrays(x, y, vx, vy), axis=-1).astype(float)[:, None]
    return Spread(np.ones(means.shape[:2]), means, np.broadcast_to(np.eye(4) * sd**2, (*means.shape[:2], 4, 4)).copy())


def test_of_a_ball_that_is_known_it_says_what_the_simulator_does():
    rng = np.random.default_rng(1)
    x, y, body = rng.uniform(-1.6, 1.6, 120), rng.uniform(-1.6, 1.6, 120), rng.uniform(-180, 180, 120)
    clear = np.abs(np.hypot(x, y) - 1.2) > 0.01  # of the edge of what the hands cover
    x, y, body = x[clear], y[clear], body[clear]
    said = holding(ball(x, y), np.concatenate([himself(1, b * D2R) for b in body]), Body())[:, Hold.NOW]
    caught = []
    for k in range(len(x)):
        simulator = quiet_world()
        put(simulator, 1, 0, 0)
        simulator.world["body"][0, 0] = simulator.world["body_staged"][0, 0] = body[k] * D2R
        put(simulator, 0, x[k], y[k])
        act(simulator, 1, CommandKind.CATCH, (np.degrees(np.arctan2(y[k], x[k])) - body[k] + 180.0) % 360.0 - 180.0)
        bits = simulator.world["bits_shown"][0, 0]
        caught.append((bits & (PlayerBit.CATCH | PlayerBit.CATCH_FAULT)) == PlayerBit.CATCH)
    assert 30 < sum(caught) < 90
    assert said == pytest.approx(np.array(caught, float), abs=0.02)


def test_it_is_the_integral_of_a_mixture_over_what_the_hands_cover():
    rng = np.random.default_rng(2)
    means = np.array([[[0.9, 0.2, 0.0, 0.0], [1.4, -0.3, 0.0, 0.0]]])
    parts = rng.normal(size=(1, 2, 4, 4)) * 0.3
    spread = Spread(np.array([[0.7, 0.3]]), means, parts @ parts.transpose(0, 1, 3, 2))
    said = holding(spread, himself(1), Body())[0, Hold.NOW]
    which = rng.random(200_000) < 0.7
    drawn = np.where(which[:, None], *(rng.multivariate_normal(means[0, k, :2], spread.covs[0, k, :2, :2], len(which)) for k in (0, 1)))
    axis = np.arctan2(*spread.middle[0, 1::-1])
    along = drawn @ [np.cos(axis), np.sin(axis)]
    aside = drawn @ [-np.sin(axis), np.cos(axis)]
    assert said == pytest.approx(((along > 0) & (along < 1.2) & (np.abs(aside) < 0.5)).mean(), abs=0.02)
    assert 0.1 < said < 0.9


def test_a_cycle_later_both_have_moved():
    told = holding(ball([3.0, 3.0, 0.5], 0.0, [-2.0, -2.0, 2.0]), himself(3, vx=0.0), Body())
    assert told[:, Hold.NOW] == pytest.approx([0.0, 0.0, 1.0])
    assert told[:, Hold.NEXT] == pytest.approx([1.0, 1.0, 0.0], abs=1e-3)
    assert holding(ball([3.0], 0.0, -2.0), himself(1, vx=-1.0), Body())[0, Hold.NEXT] == pytest.approx(0.0, abs=1e-3)


def test_in_the_stretched_area_a_catch_may_fail():
    body = Body(kind=PlayerType(catchable_area_l_stretch=1.3))
    told = holding(ball([0.8, 1.2, 1.6], 0.0), himself(3), body)[:, Hold.NOW]
    assert told == pytest.approx([1.0, 0.5, 0.0], abs=0.01)


def test_far_away_or_never_seen_there_is_no_chance():
    unseen = ball([0.5], 0.0)._replace(weights=np.zeros((1, 1)))
    assert not holding(unseen, himself(1), Body()).any()
    assert not holding(ball([30.0], 0.0), himself(1), Body()).any()


def test_a_tier_that_is_asked_tells_it_besides():
    tier = Tracker(hands=True)
    observation = {
        "self": himself(2), "level": np.zeros((2, 23)), "memory": np.zeros((2, 23, 4)), "memory_age": np.full((2, 23), 9.0),
        "ball": np.zeros((2, 4)), "body": np.zeros((2, 24)),
    }  # fmt: skip
    tier.reset(observation)
    known = tier.know(observation, None)
    assert set(known) == {"memory", "hands"}
    assert not known["hands"].any()


def test_the_registered_goalie_catches_by_it_on_the_belief():
    for name in ("Goalie", "Goalie2v1", "Goalie3v2"):
        made = make_controller(make_task(name), "left_1")
        assert made.controller.holds
        assert made.tier.name == "belief"
        assert made.tier.hands
        assert not make_controller(make_task(name), "left_1", tier="memory").controller.holds


def test_where_nobody_tells_it_he_catches_by_where_the_ball_is_reckoned():
    """As the same goalie does who knows of no distribution."""
    task, numbers = make_task("Goalie"), GoalieConstants.tuned("tracker")
    holding = HoldingConstants.of({**numbers.to_dict(), "grip": 0.3, "patience": 0.1})
    by_chance, by_place = (play_episodes(task, informed(lambda t, a, c=c: goalie(t, a, c), "memory"), 60, 5) for c in (holding, numbers))
    assert np.array_equal(by_chance.success, by_place.success)
    assert np.array_equal(by_chance.cycles, by_place.cycles)
    assert 0 < by_chance.success.sum() < 60


def test_what_slow_knowledge_makes_of_the_hands_is_not_known_before_it_is_inferred():
    """Beside reflexes it is left out; without them it is as late as the rest."""
    task = make_task("Goalie")
    for reflexes, told in ((True, False), (False, True)):
        player = make_controller(task, "left_1")
        seen = []
        act = player.controller.act
        player.controller.act = lambda observation, seen=seen, act=act: (seen.append("hands" in observation), act(observation))[1]
        play_episodes(task, lambda t, a, player=player, r=reflexes: Slow(player, 2, 2, r), 2, 1, most=6)
        assert set(seen) == {told}
