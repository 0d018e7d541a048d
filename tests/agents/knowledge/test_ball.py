"""The model of the ball from raw senses: its readings, its modes, and how well it knows."""

import numpy as np
import pytest

from cprm_gym.agents.body import DEFAULT
from cprm_gym.agents.knowledge.ball import BallConstants, ball_model, ball_readings, misplaced, shares
from cprm_gym.agents.knowledge.belief import BeliefTier
from cprm_gym.architecture.prm import model_from_json, model_to_json
from cprm_gym.benchmark.ball_error import ball_error
from cprm_gym.envs.observations import BodyFeature, SelfFeature
from cprm_gym.envs.players.senses import Senses
from cprm_gym.simulator.state import CommandKind


def seen_from(x, y, face, distance, direction, approach=0.0, swing=0.0, level=3.0):
    me = np.zeros((1, len(SelfFeature)))
    me[0, [SelfFeature.X, SelfFeature.Y, SelfFeature.FACE, SelfFeature.LOCATED]] = x, y, face, 1.0
    ball = np.array([[distance, direction, approach, swing]], np.float32)
    return {"ball": ball, "level": np.full((1, 23), level, np.float32)}, me


def test_steps_of_the_eye_are_intervals():
    """13.5 m is told of all that lies within half a step of the logarithm 2.6."""
    told, me = seen_from(0.0, 0.0, 0.0, 13.5, 0.3, approach=-0.54)
    readings, seen = ball_readings(told, me, Senses(), 0.1)
    assert seen.tolist() == [True]
    far = readings["ball.seen_far"]
    assert [float(far.low[0]), float(far.high[0])] == pytest.approx([np.exp(2.55), np.exp(2.65)])
    across = readings["ball.seen_aside"]
    assert float(across.high[0]) == pytest.approx(np.radians(0.5) * 13.5, rel=0.01)
    approach = readings["ball.seen_approach"]
    assert float(approach.high[0] - approach.low[0]) == pytest.approx(0.02 * 13.5, rel=0.05)


def test_what_is_not_seen_or_not_told_is_no_reading():
    told, me = seen_from(0.0, 0.0, 0.0, 13.5, 0.3, level=2.0)
    readings, _ = ball_readings(told, me, Senses(), 0.1)
    assert np.isnan(readings["ball.seen_approach"].low[0])
    assert not np.isnan(readings["ball.seen_far"].low[0])
    told["level"][:] = 0.0
    readings, seen = ball_readings(told, me, Senses(), 0.1)
    assert np.isnan(readings["ball.seen_far"].low[0])
    assert not seen[0]


@pytest.mark.parametrize("senses", [Senses(), Senses(asynchronous=True), Senses(noise=1.0, gaussian=0.1)])
def test_the_model_is_a_file_like_any_other(senses):
    model = ball_model(DEFAULT, senses, BallConstants())
    assert model_from_json(model_to_json(model)) == model


@pytest.mark.parametrize("senses", [Senses(), Senses(lost=0.3), Senses(noise=1.0), Senses(late_ball=2)], ids=str)
def test_it_knows_the_ball_better_than_the_tracker(senses):
    belief, tracker = (ball_error(tier, senses, 40, 31) for tier in ("belief", "tracker"))
    assert belief.capped < tracker.capped
    mean, low, high = belief.less(tracker)
    assert low < mean < high
    assert mean < 0.0
    assert belief.worlds.shape == (40,)
    assert belief.log_density > tracker.log_density + 0.2


@pytest.mark.parametrize("senses", [Senses(), Senses(asynchronous=True)], ids=str)
def test_it_knows_where_the_ball_is_from_him_as_well_as_dead_reckoning_does(senses):
    """What he reaches for is where the ball is from him, and memory tells that as it was seen, with his own error in both."""
    belief, tracker, memory = (ball_error(tier, senses, 60, 31).near for tier in ("belief", "tracker", "memory"))
    assert belief < 1.02 * min(tracker, memory)


@pytest.mark.parametrize("known", [0.01, 0.3, 5.0])
def test_his_own_error_has_its_share_of_what_a_reading_leaves(known):
    """One dimension, by the normal distribution's own formula: E[error | reading] = variance of the error / of the reading * reading."""
    constants, reading = BallConstants(), 0.4
    told, me = seen_from(0.0, 0.0, 0.0, 9.0, 0.0)
    readings, _ = ball_readings(told, me, Senses(), 0.1)
    far = float(readings["ball.told_far"][0])
    width = float(readings["ball.seen_aside"].high[0] - readings["ball.seen_aside"].low[0])
    eye = (shares(Senses(), constants)[1] * far) ** 2 + width**2 / 12.0
    total = known**2 + constants.placed**2 + eye
    # the reading says 0 aside; the ball was believed to be at -reading, and is after the reading at what is left of that
    after = -reading * (1.0 - known**2 / total)
    found = misplaced(readings, np.array([[far, after]]), Senses(), constants)
    assert found[0, 1] == pytest.approx(constants.placed**2 / total * reading)
    assert abs(found[0, 0]) < 0.01
    nothing, _ = ball_readings(told | {"level": np.zeros((1, 23))}, me, Senses(), 0.1)
    assert misplaced(nothing, np.array([[far, after]]), Senses(), constants).tolist() == [[0.0, 0.0]]


def test_the_trackers_covariance_stays_one_and_its_density_a_density():
    """Of a first look with large errors the variances of the motion are cut, and what it shares with others with them."""
    found = ball_error("tracker", Senses(noise=1.0), 150, 31337)
    assert found.log_density < 0.0


def believing(senses, ball):
    """The tier of agents who know that they stand in the middle, what they are told of the ball, and what they do: nothing."""
    count = len(ball)
    told = {"ball": np.asarray(ball, np.float32), "level": np.zeros((count, 23), np.float32)}
    told |= {"self": np.zeros((count, len(SelfFeature)), np.float32), "memory": np.zeros((count, 23, 4), np.float32)}
    told["self"][:, SelfFeature.LOCATED] = 1.0
    told["level"][:, 0] = 3.0
    told |= {"body": np.zeros((count, len(BodyFeature)), np.float32), "players": np.zeros((count, 22, 7), np.float32)}
    told["body"][:, [BodyFeature.FRESH, BodyFeature.SIDE, BodyFeature.UNUM]] = 1.0
    told["memory_age"] = np.full((count, 23), 1000.0, np.float32)
    tier = BeliefTier(senses)
    tier.reset(told)
    return tier, told, {"type": np.zeros(count, np.int64), "params": np.zeros((count, 4))}


@pytest.mark.parametrize("senses", [Senses(gaussian=0.1), Senses(noise=1.5)], ids=str)
def test_distances_with_errors_of_their_own_size_are_not_believed_too_short(senses):
    """The mean over 400 agents of what each believes after 12 looks at a ball that lies still; weights by what was told gave 7 % less."""
    rng, away = np.random.default_rng(5), 12.0

    def look():
        factor = 1.0 + 0.2 * rng.normal(size=400) if senses.gaussian else np.exp(0.225 * rng.normal(size=400))
        nothing = np.zeros(400)
        return np.stack([away * factor, nothing, nothing, nothing], axis=1).astype(np.float32)

    tier, told, still = believing(senses, look())
    tier.know(told, None)
    for _ in range(12):
        known = tier.know({**told, "ball": look()}, still)["memory"][:, 0, 0]
    assert known.mean() == pytest.approx(away, rel=0.02)
    assert known.std() < 0.1 * away


def test_when_a_ball_arrives_is_known_better_than_how_far_it_is():
    """Its change is told as a share of the distance that is told: whatever is wrong with that, the quotient of both is right."""
    senses, away, speed = Senses(gaussian=0.1), 16.0, 1.5
    tier, told, still = believing(senses, np.array([[away * 1.2, 0.0, -speed * 1.2, 0.0]]))
    tier.know(told, None)
    ball = told["ball"][0].astype(float)
    for factor in (0.85, 1.1):
        away, speed = away - speed, speed * DEFAULT.ball_decay
        ball[:] = away * factor, 0.0, -speed * factor, 0.0
        tier.know({**told, "ball": ball[None].astype(np.float32)}, still)
    weights, means, covs = tier.posterior.components("ball.x", "ball.vx")
    x, v = np.einsum("nk,nki->i", weights, means)
    assert v / x == pytest.approx(-speed / away, rel=0.02)
    # standard deviation of the quotient, to first order, as a share of it; that of the distance beside it
    slope = np.array([-v / x**2, 1.0 / x])
    best = int(weights[0].argmax())
    assert np.sqrt(slope @ covs[0, best] @ slope) / (speed / away) < 0.03
    assert np.sqrt(covs[0, best, 0, 0]) / x > 0.06


def test_what_an_own_kick_did_is_told_by_news_of_where_the_ball_was():
    """He kicks by news two cycles old: a ball that had gone by then was not hit, one that had come was."""
    lies, kick_at = [0.7, 2.5], 6
    tier, told, act = believing(Senses(late_ball=2), [[far, 0.0, 0.0, 0.0] for far in lies])
    tier.know(told, None)
    for t in range(1, kick_at + 3):
        news = {kick_at: [(2.2, 1.41), (1.65, -0.8)], kick_at + 1: [(3.61, 1.33), (0.85, -0.75)]}.get(t, [(far, 0.0) for far in lies])
        told["ball"][:, 0], told["ball"][:, 2] = np.transpose(news)
        told["level"][:, 0] = 0.0 if t > kick_at + 1 else 3.0
        sent = act | {"type": np.full(2, int(CommandKind.KICK) if t == kick_at else 0), "params": np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))}
        known = tier.know(told, sent)["memory"][:, 0]
    assert known[0] == pytest.approx([7.3, 0.0, 1.1, 0.0], abs=0.4)
    assert known[1, 2] > 0.5


def test_a_kick_is_another_mode():
    """A ball that rolled and then is where no roll leads to: the mode of a changed way takes over."""
    tier, told, still = believing(Senses(view="narrow"), np.array([[9.0, 0.0, 0.0, 0.0]]))
    for _ in range(4):
        tier.know(told, still)
    assert tier.posterior["ball.kicked"][0, 1] < 0.05
    told["ball"] = np.array([[9.97, 0.0, 0.94, 0.0]], np.float32)  # 1 m on, with the speed of a kick
    known = tier.know(told, still)["memory"][0, 0]
    assert tier.posterior["ball.kicked"][0, 1] > 0.9
    assert known[2] > 0.8
