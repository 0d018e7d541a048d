"""Mates and opponents: the kernels are the model's filter; numbers that are swapped, not told or lost; who enters and leaves the view."""

import numpy as np
import pytest

from cprm_gym.agents.body import DEFAULT
from cprm_gym.agents.knowledge.scene.constants import PlayerConstants
from cprm_gym.agents.knowledge.scene.kernels import players as kernels
from cprm_gym.agents.knowledge.scene.others import MODES, PlayersFilter, make_terms, modes_of, players_model
from cprm_gym.agents.knowledge.scene.pose import PoseFilter
from cprm_gym.architecture.prm import Filter, Grounding, Interval, model_from_json, model_to_json
from cprm_gym.architecture.prm.inference.engines.mixture import MixtureEngine
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import SelfFeature
from cprm_gym.envs.players.senses import Senses

NAMES = ("x", "y", "vx", "vy")


def observed(*things, fresh=1.0, unum=1, count=1):
    """An observation of a player of the left team at the origin who looks along x; things are (place in the array, level, row)."""
    body = np.zeros((count, 24))
    body[:, [6, 12, 13, 14]] = 2.0, fresh, 1.0, unum
    players, level = np.zeros((count, 22, 7)), np.zeros((count, 23))
    for j, told, row in things:
        players[:, j, : len(row)], level[:, 1 + j] = row, told
    return {"body": body, "players": players, "level": level}


def at_origin(count=1, **values):
    me = np.zeros((count, len(SelfFeature)))
    me[:, SelfFeature.LOCATED] = 1.0
    for name, value in values.items():
        me[:, SelfFeature[name]] = value
    return me, np.zeros((count, 2))


def sight(x, y, vx=0.0, vy=0.0, body=0.0):
    """What an exact eye at the origin tells of somebody there."""
    far = np.hypot(x, y)
    return far, np.arctan2(y, x), (x * vx + y * vy) / far, (x * vy - y * vx) / far**2, body, body, 0.0


def believe(filter, k, x, y, vx=0.0, vy=0.0, spread=0.3, speed=0.05, weights=(0.2, 0.5, 0.3)):
    """Let all agents believe that player k is there."""
    t = filter.tracks
    t.w[:, k], t.mu[:, k], t.cv[:, k] = weights, (x, y, vx, vy), np.diag([spread**2, spread**2, speed**2, speed**2])
    t.known[:, k], t.age[:, k] = 2, 0


def fresh_filter(constants=None, senses=None, count=1, **options):
    filter = PlayersFilter(senses or Senses(), DEFAULT, constants, **options)
    filter.reset(count)
    return filter


def place(filter, k, n=0):
    return filter.places()[n, k, :2]


# ---------------------------------------------------------------------------------------------- the kernels and the engine


def readings_for(row, terms, me, unsure=(0.0, 0.0), expected=-1.0):
    """Given numbers and readings of `players_model` for a row of the eye of somebody who is expected `expected` m away, if not below 0."""
    told = np.zeros((4, 4))
    count, _ = kernels.readings_of(np.asarray(row, float), 3.0, terms, *unsure, expected, told)
    assert count == 4
    angle = me[4] + row[1]
    given = {"seen_cos": np.cos(angle), "seen_sin": np.sin(angle), "me_x": me[0], "me_y": me[1], "me_vx": me[2], "me_vy": me[3]}
    given |= {"told_rate": told[2, 3], "told_turn": told[3, 3]}
    for name, (low, high, variance, _) in zip(("far", "aside", "approach", "swing"), told):
        given |= {name: Interval(low, high), f"{name}_sd": np.sqrt(variance)}
    return given


def started(x, y, vx, vy, spread=0.3, speed=0.05):
    return {"start_x": x, "start_y": y, "start_vx": vx, "start_vy": vy, "start_spread": spread, "start_speed": speed}


def same_track(posterior, name, filter, k):
    """The engine's belief of an object and the kernels' are one."""
    t = filter.tracks
    assert posterior[f"{name}.mode"][0] == pytest.approx(t.w[0, k], abs=1e-9)
    mean, cov = posterior.moments(*(f"{name}.{axis}" for axis in NAMES))
    expected = t.w[0, k] @ t.mu[0, k]
    off = t.mu[0, k] - expected
    spread = np.einsum("m,mij->ij", t.w[0, k], t.cv[0, k] + off[:, :, None] * off[:, None, :])
    assert mean[0] == pytest.approx(expected, abs=1e-9)
    assert cov[0] == pytest.approx(spread, abs=1e-9)


def test_the_kernels_are_the_filter_of_the_model():
    """Five cycles of one who runs, is seen twice, not seen, and turns: means, covariances and modes of the engine, to rounding."""
    constants, me = PlayerConstants(), np.array([1.0, -2.0, 0.1, 0.05, 0.2])
    terms = make_terms(Senses(), DEFAULT, constants)
    engine = Filter(Grounding(players_model(DEFAULT, constants), {"p": "Player"}), engine=MixtureEngine(9, merge=1e9))
    filter = fresh_filter(constants)
    third = tuple(np.full(3, 1.0 / 3.0))
    believe(filter, 13, 15.0, 4.0, 0.2, 0.1, weights=third)
    engine.step({f"p.{n}": v for n, v in started(15.0, 4.0, 0.2, 0.1).items()})
    own, unsure = at_origin(X=me[0], Y=me[1], VX=me[2], VY=me[3], FACE=me[4])
    for rows in (
        (14.4, 0.24, 0.02, 0.01, 0.3, 0.3, 0.0), None, (15.0, 0.27, 0.2, 0.004, 0.3, 0.3, 0.0),
        None, (14.8, 0.4, -0.3, 0.02, 1.3, 1.3, 0.0),
    ):  # fmt: skip
        filter.step(observed(*([] if rows is None else [(13, 3.0, rows)]), fresh=float(rows is not None)), own, unsure)
        told = {} if rows is None else readings_for(rows, terms, me)
        posterior = engine.step({f"p.{name}": value for name, value in told.items()})
        same_track(posterior, "p", filter, 13)


def test_that_he_is_not_seen_is_the_engines_chance():
    """The moments of a chance with a step, which the engine integrates: the same to the error of that."""
    constants = PlayerConstants()
    filter = fresh_filter(constants)
    filter.terms[kernels.NEAR] = 0.0  # the model has no feel
    believe(filter, 13, 10.0, 15.0, 0.0, 0.0, spread=1.5, weights=(1.0, 0.0, 0.0))
    own, unsure = at_origin()
    unsure[:, 1] = 0.01**2
    t = filter.tracks
    mean, cov = t.mu[0, 13, 0].copy(), t.cv[0, 13, 0].copy()
    work = np.zeros(5), np.zeros((5, 5)), np.zeros(5)
    half = np.radians(60.0)
    told = kernels.unseen(mean, cov, own[0, [0, 1, 2, 3, 5]], 0.0, half, constants.seen, 0.0, 0.01**2, *work)
    x, y = 10.0, 15.0
    engine = Filter(Grounding(players_model(DEFAULT, constants), {"p": "Player"}), engine=MixtureEngine(9, merge=1e9))
    far = np.hypot(x, y) ** 2
    given = {"about": np.arctan2(y, x), "about_x": x, "about_y": y, "side_x": -y / far, "side_y": x / far, "turned": 0.01, "half": half}
    posterior = engine.step({f"p.{n}": v for n, v in (started(x, y, 0.0, 0.0, 1.5) | given).items()} | {"p.missed": 1})
    found, spread = posterior.moments("p.x", "p.y")
    assert found[0] == pytest.approx(mean[:2], abs=2e-5)
    assert spread[0] == pytest.approx(cov[:2, :2], abs=2e-5)
    assert posterior.log_likelihood[0] == pytest.approx(told, abs=1e-5)


def test_an_uncertain_identity_is_the_mixture_of_both():
    """A nameless sight between two players: each one's belief has the moments that the engine gives with the identity hidden."""
    constants = PlayerConstants(fresh=1e-6, stray=1e-9, gate=200.0)
    world = Grounding(
        players_model(DEFAULT, constants, sights=2), {"a": "Player", "b": "Player", "s": "Sight"}, {"s": {"p1": "a", "p2": "b"}}
    )
    engine = Filter(world, engine=MixtureEngine(256, merge=0.0))
    filter = fresh_filter(constants)
    filter.terms[kernels.SEEN] = 0.0  # in the model nobody has to be seen
    filter.terms[kernels.FRESH] = filter.terms[kernels.STRAY] = 1e-300
    third = tuple(np.full(3, 1.0 / 3.0))
    objects = (("a", 11, 12.0, 0.0), ("b", 12, 12.3, 0.9))
    begun = {}
    for name, k, x, y in objects:
        believe(filter, k, x, y, 0.1, 0.0, weights=third)
        begun |= {f"{name}.{n}": v for n, v in started(x, y, 0.1, 0.0).items()}
    row = (12.2, 0.035, 0.0, 0.0)
    told = {
        n: v for n, v in readings_for(row, filter.terms, np.zeros(5)).items() if not n.startswith(("approach", "swing", "me_v", "told_"))
    }
    engine.step(begun)
    posterior = engine.step({f"s.{n}": v for n, v in told.items()})
    own, unsure = at_origin()
    filter.step(observed((11, 2.0, row)), own, unsure)
    shares = posterior["s.whose"][0]
    assert 0.2 < shares[0] < 0.8
    for name, k, _, _ in objects:
        same_track(posterior, name, filter, k)


def test_the_models_are_files_like_any_other():
    for sights in (0, 2):
        model = players_model(sights=sights)
        assert model_from_json(model_to_json(model)) == model


def test_modes_are_the_models():
    moves = modes_of(DEFAULT, PlayerConstants())
    assert moves.switch.sum(axis=1) == pytest.approx(np.ones(len(MODES)))
    assert moves.keeps[0] == DEFAULT.kind.player_decay


# ---------------------------------------------------------------------------------------------- readings


@pytest.mark.parametrize(
    ("senses", "wide"), [(Senses(), 1.0), (Senses(noise=1.0), 3.0), (Senses(quantise=4.0), 1.9), (Senses(gaussian=0.1), 2.0)], ids=str
)
def test_a_reading_is_believed_as_far_as_the_senses_are_good(senses, wide):
    spreads = []
    for eye in (Senses(), senses):
        filter = fresh_filter(senses=eye)
        filter.step(observed((11, 3.0, sight(14.0, 2.0))), *at_origin())
        assert np.hypot(*(place(filter, 11) - (14.0, 2.0))) < 0.3
        spreads.append(np.sqrt(filter.tracks.cv[0, 11, :, 0, 0] @ filter.tracks.w[0, 11]))
    assert spreads[1] >= wide * spreads[0] * (1.0 - 1e-9)


def test_readings_that_are_too_short_count_for_no_more_than_those_that_are_too_long():
    """Errors are shares of how far he is, not of how far he is told to be."""
    senses, moved = Senses(gaussian=0.1), []
    for distance in (18.0, 22.0):
        filter = fresh_filter(senses=senses)
        believe(filter, 13, 20.0, 0.0, spread=2.0)
        filter.step(observed((13, 2.0, (distance, 0.0, 0.0, 0.0)), fresh=1.0), *at_origin())
        blind = fresh_filter(senses=senses)
        believe(blind, 13, 20.0, 0.0, spread=2.0)
        blind.step(observed(fresh=0.0), *at_origin())
        moved.append(place(filter, 13)[0] - place(blind, 13)[0])
    assert moved[0] < -0.2
    assert moved[1] == pytest.approx(-moved[0], rel=0.02)


def test_a_change_is_told_as_a_share_of_the_distance_that_is_told():
    """Who is told too far is told too fast by the same share; where he is known, so is how fast he is."""
    filter = fresh_filter(senses=Senses(gaussian=0.1))
    believe(filter, 13, 20.0, 0.0, 0.3, 0.0, spread=0.05, speed=0.3, weights=(0.0, 0.0, 1.0))
    filter.step(observed((13, 3.0, (24.0, 0.0, 0.36, 0.0))), *at_origin())
    t = filter.tracks
    assert t.w[0, 13] @ t.mu[0, 13, :, 2] == pytest.approx(0.31, abs=0.01)


def test_a_speed_that_is_told_carries_him_on_and_without_one_he_stays():
    for told, way in ((3.0, 0.5), (2.0, 0.0)):
        filter = fresh_filter(PlayerConstants(lasting=0.99))
        filter.step(observed((11, told, sight(14.0, 2.0, 0.0, 0.4))), *at_origin())
        filter.tracks.known[:] = np.minimum(filter.tracks.known, 1) * 2
        filter.step(observed(fresh=0.0), *at_origin())
        assert (place(filter, 11)[1] - 2.0 > way) if way else (abs(place(filter, 11)[1] - 2.0) < 0.2)


def test_the_way_he_faces_is_kept():
    filter = fresh_filter()
    filter.step(observed((11, 3.0, sight(14.0, 2.0, body=1.2))), *at_origin(FACE=0.0))
    assert filter.tracks.arms[0, 11, 0] == pytest.approx(1.2, abs=0.02)
    filter.step(observed(fresh=0.0), *at_origin())
    assert filter.tracks.arms[0, 11, 1] > 0.05


# ---------------------------------------------------------------------------------------------- who is who


def test_swapped_numbers_are_put_right_at_once():
    """Who is told with his number elsewhere than believed is there, and so is the other one."""
    filter = fresh_filter()
    believe(filter, 11, 12.0, -6.0)
    believe(filter, 12, 12.0, 6.0)
    filter.step(observed((11, 3.0, sight(12.0, 6.0)), (12, 3.0, sight(12.0, -6.0))), *at_origin())
    assert np.hypot(*(place(filter, 11) - (12.0, 6.0))) < 0.5
    assert np.hypot(*(place(filter, 12) - (12.0, -6.0))) < 0.5


def test_nameless_readings_go_to_those_who_are_near_and_nobody_gets_two():
    filter = fresh_filter()
    believe(filter, 13, 15.0, 4.0)
    believe(filter, 17, 15.0, -4.0)
    filter.step(observed((11, 2.0, sight(15.2, -3.9)), (12, 2.0, sight(15.0, 4.2))), *at_origin())
    assert np.hypot(*(place(filter, 17) - (15.2, -3.9))) < 0.4
    assert np.hypot(*(place(filter, 13) - (15.0, 4.2))) < 0.4
    assert filter.tracks.age[0, [13, 17]].tolist() == [0, 0]
    assert filter.known[0].sum() == 2


def test_a_nameless_reading_far_from_all_is_of_a_newcomer_who_gets_his_number_later():
    filter = fresh_filter()
    believe(filter, 11, 15.0, 10.0)
    filter.step(observed((11, 2.0, sight(30.0, -10.0)), (12, 2.0, sight(15.0, 10.0))), *at_origin())
    assert filter.known[0].sum() == 2
    assert filter.tracks.known[0, 12] == 1
    filter.step(observed((16, 3.0, sight(30.0, -10.0)), (11, 3.0, sight(15.0, 10.0))), *at_origin())
    assert np.flatnonzero(filter.known[0]).tolist() == [11, 16]
    assert filter.tracks.known[0, 16] == 2


def test_one_without_a_number_makes_room_for_the_one_whose_it_is():
    filter = fresh_filter()
    filter.step(observed((11, 2.0, sight(30.0, -10.0))), *at_origin())
    assert np.flatnonzero(filter.known[0]).tolist() == [11]
    filter.step(observed((11, 3.0, sight(10.0, 10.0)), (12, 2.0, sight(30.0, -10.0))), *at_origin())
    assert np.hypot(*(place(filter, 11) - (10.0, 10.0))) < 0.5
    assert np.hypot(*(place(filter, 12) - (30.0, -10.0))) < 1.5


def test_who_is_felt_without_a_team_is_somebody_who_is_known():
    filter = fresh_filter()
    believe(filter, 4, -2.0, 0.5)
    filter.step(observed((11, 1.0, sight(-2.0, 0.6))), *at_origin())
    assert filter.known[0].sum() == 1
    assert filter.tracks.age[0, 4] == 0
    filter = fresh_filter()
    filter.step(observed((11, 1.0, sight(-2.0, 0.6))), *at_origin())
    assert filter.known[0].sum() == 0


def test_a_small_budget_says_what_it_lost():
    """Six readings among six who stand together: one hypothesis loses more than many, thousands next to nothing."""
    lost = []
    for hypotheses in (1, 8, 2000):
        filter = fresh_filter(hypotheses=hypotheses)
        places = [(15.0 + 0.2 * k, 0.25 * k) for k in range(6)]
        for k, (x, y) in enumerate(places):
            believe(filter, 11 + k, x, y, spread=0.5)
        filter.step(observed(*[(11 + k, 2.0, sight(*p)) for k, p in enumerate(places)]), *at_origin())
        lost.append(float(filter.tracks.dropped[0]))
        assert filter.tracks.merged[0] > 0.0 or hypotheses == 1
    assert lost[0] > lost[1] > 0.05
    assert lost[2] < 1e-4 * lost[1]


# ---------------------------------------------------------------------------------------------- entering and leaving the view


def test_who_should_be_seen_and_is_not_is_elsewhere():
    """Near the edge of the view he is believed to have left it; in the middle of it the belief spreads no nearer."""
    filter = fresh_filter()
    x, y = 15.0 * np.cos(np.radians(58.0)), 15.0 * np.sin(np.radians(58.0))
    believe(filter, 13, x, y, spread=1.0)
    filter.step(observed(), *at_origin())
    after = np.degrees(np.arctan2(*place(filter, 13)[::-1]))
    assert after > 60.0
    assert filter.tracks.age[0, 13] == 1
    blind = fresh_filter()
    believe(blind, 13, x, y, spread=1.0)
    blind.step(observed(fresh=0.0), *at_origin())
    assert np.degrees(np.arctan2(*place(blind, 13)[::-1])) == pytest.approx(58.0, abs=0.5)


def test_one_without_a_number_who_is_not_seen_where_he_should_be_is_given_up():
    filter = fresh_filter()
    filter.step(observed((11, 2.0, sight(15.0, 0.0))), *at_origin())
    assert filter.known[0, 11]
    for _ in range(3):
        filter.step(observed(), *at_origin())
    assert not filter.known[0, 11]


def test_who_comes_into_view_again_is_the_same_one():
    filter = fresh_filter()
    believe(filter, 13, -10.0, 8.0)
    for _ in range(4):
        filter.step(observed(), *at_origin())
    assert filter.known[0, 13]
    filter.step(observed((11, 2.0, sight(-9.5, 8.2))), *at_origin(FACE=np.pi))
    face = observed((11, 2.0, (*sight(-9.5, 8.2)[:1], np.arctan2(8.2, -9.5) - np.pi)))
    filter.step(face, *at_origin(FACE=np.pi))
    assert filter.tracks.age[0, 13] == 0


# ---------------------------------------------------------------------------------------------- bad input, long runs


@pytest.mark.parametrize("level", [1.0, 2.0, 3.0])
def test_coincident_and_impossible_readings_are_no_nan(level):
    filter = fresh_filter()
    rows = [(0.0, 0.0), (0.0, 0.0), (1e-9, 3.1), (180.0, 0.5), (10.0, 0.1, 30.0, 6.0), (10.0, 0.1, -30.0, -6.0)]
    for _ in range(5):
        filter.step(observed(*[(11 + k, level, row) for k, row in enumerate(rows)]), *at_origin())
        filter.step(observed(*[(11 + k, level, row) for k, row in enumerate(rows[::-1])]), *at_origin())
    t = filter.tracks
    known = filter.known
    assert all(np.isfinite(a[known]).all() for a in (t.w, t.mu, t.cv, t.arms))
    assert np.isfinite(t.dropped).all()
    assert (np.linalg.eigvalsh(t.cv[known][t.w[known] > 1e-6]) > -1e-9).all()


@pytest.mark.parametrize("weight", [1e-323, 1e-310, 1e-200, 1e-80, 1e-40])
def test_a_mode_that_is_all_but_impossible_has_a_covariance_or_none(weight):
    filter = fresh_filter()
    believe(filter, 13, -37.5, -3.1, 0.1, 0.2, weights=(weight, 0.3, 0.7))
    filter.tracks.cv[0, 13, 1:, 0, 1] = filter.tracks.cv[0, 13, 1:, 1, 0] = 0.05
    filter.modes.switch[:] = np.eye(3)
    filter.step(observed((11, 2.0, sight(-37.45, -3.05))), *at_origin(FACE=np.pi))
    t = filter.tracks
    there = t.w[0, 13] > 0.0
    assert there.tolist() == [weight > kernels.LIGHTEST, True, True]
    assert np.linalg.eigvalsh(t.cv[0, 13][there]).min() > 0.0


def test_all_on_one_place_share_the_readings():
    filter = fresh_filter()
    for k in range(11, 22):
        believe(filter, k, 12.0, 0.0, spread=0.0)
    filter.step(observed(*[(11 + k, 2.0, sight(12.0, 0.0)) for k in range(11)]), *at_origin())
    assert np.isfinite(filter.places()).all()
    assert filter.tracks.dropped[0] > 0.0


def test_an_agent_is_the_same_alone_and_in_a_batch():
    random = np.random.default_rng(3)
    batch, alone = fresh_filter(count=5), fresh_filter()
    for _ in range(12):
        rows = np.stack([random.uniform(5, 30, (5, 22)), random.uniform(-0.9, 0.9, (5, 22))], axis=2)
        told = observed(count=5)
        told["players"][:, :, :2] = rows
        told["level"][:, 1:] = random.integers(0, 4, (5, 22))
        me = at_origin(5)
        batch.step(told, *me)
        alone.step({key: value[3:4] for key, value in told.items()}, me[0][3:4], me[1][3:4])
    assert np.array_equal(batch.tracks.mu[3], alone.tracks.mu[0])
    assert np.array_equal(batch.known[3], alone.known[0])


def test_long_blindness_is_no_growth_without_end():
    """10,000 cycles: weights sum to 1, nothing is infinite."""
    filter = fresh_filter()
    believe(filter, 13, 10.0, 5.0, 0.2, 0.1)
    blind, me = observed(fresh=0.0), at_origin()
    for _ in range(10_000):
        filter.step(blind, *me)
    assert filter.tracks.w[0, 13].sum() == pytest.approx(1.0)
    assert np.isfinite(filter.tracks.cv[0, 13]).all()
    assert np.hypot(*(place(filter, 13) - (10.0, 5.0))) < 60.0


@pytest.mark.slow
def test_a_hundred_thousand_cycles_of_a_match_leave_it_as_exact_as_the_first():
    """The looks of a match again and again: nothing grows, and after each round the places are those of the round before."""
    core = SoccerCore("Soccer5v5", 1, controlled="left_3", others="strong", include=("landmarks", "lines"), seed=3)
    core.reset(3)
    told = []
    for _ in range(50):
        told.append({key: value[:, 0].copy() for key, value in core.observation.items()})
        core.step({key: value[:, None] for key, value in no_action(1).items()})
    pose, others = PoseFilter(Senses()), fresh_filter()
    pose.reset(1)
    rounds = []
    for _ in range(2000):
        for seen in told:
            me = pose.step(seen, None)
            others.step(seen, me, np.stack([pose.cov[:, 1, 1], pose.cov[:, 0, 0]], axis=1))
        rounds.append(np.concatenate([pose.mean[0, 1:], others.places()[others.known].ravel()]))
        assert np.isfinite(rounds[-1]).all()
    assert rounds[-1] == pytest.approx(rounds[5], abs=1e-6)
    assert np.abs(pose.mean[0, 0]) < 1e3
