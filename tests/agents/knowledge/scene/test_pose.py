"""The own pose from landmarks and lines: the kernel is the model's filter, each reading tells its share, it beats dead reckoning."""

import numpy as np
import pytest

from cprm_gym.agents.body import DEFAULT
from cprm_gym.agents.knowledge.players import player_of
from cprm_gym.agents.knowledge.scene.kernels.pose import MARKS, begin, landmark_interval, looked, moved
from cprm_gym.agents.knowledge.scene.pose import PoseFilter, pose_model
from cprm_gym.architecture.prm import Filter, Grounding, Interval, model_from_json, model_to_json
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import BodyFeature, SelfFeature
from cprm_gym.envs.players.senses import Senses
from cprm_gym.envs.tasks import make_task

TERMS = PoseFilter(Senses()).terms


def look_from(x, y, face, cone=60.0):
    """Landmarks, levels and lines as the eye of a player of the left team rounds them."""
    marks, levels = np.zeros((55, 4)), np.zeros(55)
    dx, dy = MARKS[:, 0] - x, MARKS[:, 1] - y
    away = np.maximum(np.hypot(dx, dy), 0.01)
    direction = (np.degrees(np.arctan2(dy, dx) - face) + 180.0) % 360.0 - 180.0
    seen = np.abs(direction) < cone
    levels[seen] = 2.0
    step = DEFAULT.server.quantize_step_l
    marks[:, 0] = np.where(seen, np.round(np.exp(step * np.round(np.log(away) / step)), 1), 0.0)
    marks[:, 1] = np.where(seen, np.radians(np.round(direction)), 0.0)
    return marks, levels, np.zeros((2, 3))


def start(at, spread=1.0, turn=0.05):
    mean, cov = np.zeros(3), np.zeros((3, 3))
    begin(mean, cov, np.asarray(at, float), spread, turn)
    return mean, cov


def take(mean, cov, at, marks, levels, lines):
    room_mean, room_cov = np.zeros(4), np.zeros((4, 4))
    room_mean[:3], room_cov[:3, :3] = mean, cov
    told, count = looked(room_mean, room_cov, np.zeros(3), np.asarray(at, float), 1.0, marks, levels, lines, TERMS)
    return room_mean[:3], room_cov[:3, :3], told, count


def mark_readings(at, marks, levels):
    """Readings of `pose_model` for each landmark seen, taken around a pose."""
    readings = {}
    for i, k in enumerate(np.flatnonzero(levels)):
        (x, y), sight = MARKS[k], at[0] + marks[k, 1]
        away = np.hypot(x - at[1], y - at[2])
        low, high = landmark_interval(marks[k, 0], TERMS[0], TERMS[1])
        given = {
            "mark_x": x, "mark_y": y, "along_x": (x - at[1]) / away, "along_y": (y - at[2]) / away, "across_x": -np.sin(sight),
            "across_y": np.cos(sight), "away": away, "seen_face": at[0], "slack": np.sqrt(TERMS[4] + TERMS[5] * away**2),
        }  # fmt: skip
        readings |= {f"m{i}.{name}": value for name, value in given.items()}
        readings[f"m{i}.aside"] = Interval(-TERMS[2] * away, TERMS[2] * away)
        readings[f"m{i}.far"] = Interval(low, high)
    return readings


def test_the_kernel_is_the_filter_of_the_model():
    """Three cycles with turns, ways and looks: mean, covariance and log likelihood of the engine, to rounding."""
    true, steps = np.array([0.3, -30.0, 10.0]), ((0.0, 0.0, 0.0), (0.4, 0.8, 0.1), (-0.2, 0.5, -0.3))
    mean, cov = start((0.33, -29.6, 9.5))
    looks = []
    for turned, go, way in steps:
        true[0] += turned
        true[1:] += go * np.cos(true[0] + way), go * np.sin(true[0] + way)
        looks.append(look_from(true[1], true[2], true[0], 25.0))
    count = max(int((levels > 0).sum()) for _, levels, _ in looks)
    assert count >= 4
    objects = {"me": "Self", **{f"m{i}": "Mark" for i in range(count)}}
    world = Grounding(pose_model(), objects, {f"m{i}": {"me": "me"} for i in range(count)})
    engine = Filter(world, engine="mixture")
    begun = {"start_face": mean[0], "start_x": mean[1], "start_y": mean[2], "start_turn": 0.05, "start_spread": 1.0}
    own = {f"me.{name}": value for name, value in begun.items()}
    for k, (turned, go, way) in enumerate(steps):
        about = mean[0] + turned
        go_x, go_y = go * np.cos(about + way), go * np.sin(about + way)
        if k:
            moved(mean, cov, turned, 0.02**2, go_x, go_y, 0.03**2)
        done = {"turned": turned, "turning": 0.02, "go_x": go_x, "go_y": go_y, "straying": 0.03, "about": about}
        posterior = engine.step(own | {f"me.{n}": v for n, v in done.items()} | mark_readings(mean, *looks[k][:2]))
        mean, cov, told, _ = take(mean, cov, mean.copy(), *looks[k])
        believed, covariance = posterior.moments("me.face", "me.x", "me.y")
        assert believed[0] == pytest.approx(mean, abs=1e-9)
        assert covariance[0] == pytest.approx(cov, abs=1e-9)
        assert posterior.increment[0] == pytest.approx(told, abs=1e-7)
    assert np.hypot(*(mean[1:] - true[1:])) < 0.1


def test_the_model_is_a_file_like_any_other():
    assert model_from_json(model_to_json(pose_model())) == pose_model()


def test_a_direction_tells_the_face_and_a_distance_the_place():
    marks, levels, lines = look_from(0.5, 0.0, 0.0, 3.0)
    ahead = np.flatnonzero(levels)
    levels[ahead[1:]] = 0.0
    x, y = MARKS[ahead[0]]
    assert abs(y) < 1e-9 < x
    mean, cov = start((0.0, 0.5, 0.0), spread=0.01)
    _, after, _, count = take(mean, cov, mean, marks, levels, lines)
    assert count == 2
    assert after[0, 0] < 0.05 * cov[0, 0]
    mean, cov = start((0.0, 0.5, 0.0), spread=5.0)
    _, after, _, _ = take(mean, cov, mean, marks, levels, lines)
    assert after[1, 1] < 0.1 * cov[1, 1]


def test_a_line_tells_the_face_to_half_a_degree():
    """The right line dead ahead: its direction is 90 degrees."""
    mean, cov = start((0.1, 0.0, 0.0))
    lines = np.array([[52.5, np.pi / 2, 2.0], [0.0, 0.0, 0.0]])
    after, spread, _, count = take(mean, cov, mean, np.zeros((55, 4)), np.zeros(55), lines)
    assert count == 1
    assert abs(after[0]) < np.radians(0.6)
    assert np.sqrt(spread[0, 0]) < np.radians(0.4)


def record(senses, task="Goalie", worlds=30, cycles=30, seed=31):
    """What a goalie on dead reckoning is told, sends and really is."""
    made = make_task(task)
    core = SoccerCore(made, worlds, seed=seed, include=("memory", "landmarks", "lines"), senses=senses)
    observation = core.reset(seed)
    (controller,) = [player_of(task).on("memory", senses)(made, agent) for agent in core.agents]
    controller.reset({key: value[:, 0] for key, value in observation.items()}, seed)
    told, sent, true, playing = [], [], [], [np.ones(worlds, bool)]
    for _ in range(cycles):
        told.append({key: value[:, 0].copy() for key, value in core.observation.items()})
        true.append(core.truth(core.agents[0])["self"])
        sent.append({key: np.array(value) for key, value in controller.act(told[-1]).items()})
        step = core.step({key: np.asarray(value)[:, None] for key, value in sent[-1].items()})
        playing.append(playing[-1] & ~(step.terminated | step.truncated))
    return told, sent, true, playing[:-1]


@pytest.mark.parametrize("senses", [Senses(), Senses(asynchronous=True), Senses(lost=0.6), Senses(gaussian=0.1)], ids=str)
def test_it_knows_where_he_is_better_than_memory(senses):
    told, sent, true, playing = record(senses)
    filter = PoseFilter(senses)
    filter.reset(30)
    places, faces = {"pose": [], "memory": []}, {"pose": [], "memory": []}
    for k, seen in enumerate(told):
        mine = filter.step(seen, sent[k - 1] if k else None)
        for name, me in (("pose", mine), ("memory", seen["self"])):
            off = (me - true[k])[playing[k]]
            places[name].append(np.hypot(off[:, SelfFeature.X], off[:, SelfFeature.Y]))
            faces[name].append(np.abs((off[:, SelfFeature.FACE] + np.pi) % (2 * np.pi) - np.pi))
    for found in (places, faces):
        pose, memory = (np.concatenate(found[name]) for name in ("pose", "memory"))
        assert np.median(pose) < 0.5 * np.median(memory)
        assert np.sqrt((pose**2).mean()) < np.sqrt((memory**2).mean())


def test_body_and_neck_as_they_are_told_make_the_face():
    """The neck is felt in whole degrees; who adds it to the body has to look where he looks."""
    told, sent, _, _ = record(Senses(), worlds=4, cycles=12)
    filter = PoseFilter(Senses())
    filter.reset(4)
    for k, seen in enumerate(told):
        me = filter.step(seen, sent[k - 1] if k else None)
        off = me[:, SelfFeature.BODY] + seen["body"][:, BodyFeature.NECK] - me[:, SelfFeature.FACE]
        assert np.sin(off) == pytest.approx(np.zeros(4), abs=1e-6)


def test_one_who_was_put_elsewhere_finds_out_with_the_next_look():
    filter = PoseFilter(Senses())
    filter.reset(1)
    for x, y, face in ((-30.0, 5.0, 0.2), (10.0, -8.0, 2.0)):
        marks, levels, lines = look_from(x, y, face)
        body = np.zeros((1, 24))
        body[0, [12, 13]] = 1.0
        told = {"body": body, "landmarks": marks[None], "landmark_level": levels[None], "lines": lines[None]}
        me = filter.step(told, None)[0]
        assert np.hypot(me[0] - x, me[1] - y) < 0.15
        assert abs(me[SelfFeature.FACE] - face) < 0.01


def test_who_sees_nothing_is_not_located_and_contradictions_are_no_nan():
    filter = PoseFilter(Senses())
    filter.reset(1)
    body = np.zeros((1, 24))
    body[0, [12, 13]] = 1.0
    blank = {"body": body, "landmarks": np.zeros((1, 55, 4)), "landmark_level": np.zeros((1, 55)), "lines": np.zeros((1, 2, 3))}
    assert filter.step(blank, None)[0, SelfFeature.LOCATED] == 0.0
    marks, levels, lines = look_from(0.0, 0.0, 0.0)
    for distances in (marks[:, 0], np.zeros(55), np.full(55, 40.0), marks[::-1, 0]):
        odd = np.stack([distances, marks[:, 1], marks[:, 2], marks[:, 3]], axis=1)
        me = filter.step({**blank, "landmarks": odd[None], "landmark_level": levels[None], "lines": lines[None]}, None)
        assert np.isfinite(me).all()
        assert np.isfinite(filter.cov).all()
