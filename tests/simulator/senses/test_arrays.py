"""See as arrays: the same as the text, without anything that the text would not tell."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from senses_recordings import random_worlds

from cprm_gym.simulator.kernels import rounding
from cprm_gym.simulator.kernels.senses import look
from cprm_gym.simulator.landmarks import LANDMARK_NAMES, LANDMARK_POSITIONS, LINE_NAMES
from cprm_gym.simulator.protocol.message_parser import parse_see
from cprm_gym.simulator.protocol.messages import see_text
from cprm_gym.simulator.senses import BallLevel, PlayerFlag, PlayerLevel, new_landmarks, new_see, see, see_landmarks
from cprm_gym.simulator.simulator import Simulator

R2D = 180 / math.pi


def told_ball(ball, level):
    """The numbers that the ball's row stands for in a message."""
    numbers = [ball[0], ball[1] * R2D]
    return numbers + [ball[2], ball[3] * R2D] if level == BallLevel.MOVING else numbers


def told_player(row, level, flags):
    """(distance, direction, ...) as in a message."""
    rest = [row[2], row[3] * R2D, row[4] * R2D, row[5] * R2D] if level == PlayerLevel.NUMBER else []
    rest += [row[6] * R2D] if flags & PlayerFlag.POINTING else []
    return [row[0], row[1] * R2D, *rest]


def numbers_of(seen):
    values = (seen.distance, seen.direction, seen.distance_change, seen.direction_change, seen.body, seen.head, seen.pointing)
    return [value for value in values if value is not None]


@pytest.mark.parametrize("changes", [{}, {"focus_distance": 15.0}, {"gaussian": 1}, {"protocol": 17}], ids=str)
def test_arrays_and_texts_tell_the_same(changes):
    sim = random_worlds(9, seed=11, spread=0.8)
    w = sim.world
    for name, value in changes.items():
        w[name] = value
    w["arm_timer"][:, ::3], w["tackle_cycles"][:, 1::5], w["kick_cycles"][:, 2::7] = 0, 3, 0
    arrays, pitch = sim.see(), sim.landmarks()
    for world in range(9):
        for row in range(22):
            objects = parse_see(see_text(sim, world, row + 1)).objects
            ball = [seen for seen in objects if seen.kind == "ball"]
            level = arrays.ball_level[world, row]
            assert len(ball) == (level > 0)
            assert all(seen.close == (level == BallLevel.FELT) for seen in ball)
            for seen in ball:
                assert told_ball(arrays.ball[world, row], level) == pytest.approx(numbers_of(seen), rel=1e-5, abs=1e-9)
            left = {"L": [], "R": [], None: []}
            for seen in (seen for seen in objects if seen.kind == "player"):
                side = None if seen.team is None else seen.team[0]
                if seen.unum is None:
                    left[side].append(numbers_of(seen))
                    continue
                slot = seen.unum - 1 + (0 if side == "L" else 11)
                flags = arrays.players_flags[world, row, slot]
                assert arrays.players_level[world, row, slot] == PlayerLevel.NUMBER
                told = told_player(arrays.players[world, row, slot], PlayerLevel.NUMBER, flags)
                assert told == pytest.approx(numbers_of(seen), rel=1e-5, abs=1e-9)
                assert seen.tackling == bool(flags & PlayerFlag.TACKLING)
                assert seen.kicking == bool(flags & PlayerFlag.KICKING)
            for side, slots in (("L", range(11)), ("R", range(11, 22)), (None, range(22))):
                wanted = PlayerLevel.UNKNOWN if side is None else PlayerLevel.TEAM
                mine = [slot for slot in slots if arrays.players_level[world, row, slot] == wanted]
                rows = [told_player(arrays.players[world, row, k], wanted, arrays.players_flags[world, row, k]) for k in mine]
                assert len(rows) == len(left[side])
                for a, b in zip(sorted(rows), sorted(left[side])):
                    assert a == pytest.approx(b, rel=1e-5, abs=1e-9)
            compare_pitch(pitch, world, row, objects)


def compare_pitch(pitch, world, row, objects):
    """Landmarks and lines of one player: arrays against a parsed message."""
    named = {f"{seen.kind[0]} {seen.name}": seen for seen in objects if seen.kind in ("flag", "goal") and not seen.close}
    levels = pitch.level[world, row]
    assert {LANDMARK_NAMES[j] for j in np.flatnonzero(levels > BallLevel.FELT)} == set(named)
    for j in np.flatnonzero(levels > BallLevel.FELT):
        told = told_ball(pitch.landmarks[world, row, j], levels[j])
        assert told == pytest.approx(numbers_of(named[LANDMARK_NAMES[j]]), rel=1e-5, abs=1e-9)
    felt = sorted(told_ball(pitch.landmarks[world, row, j], 1) for j in np.flatnonzero(levels == BallLevel.FELT))
    close = sorted(numbers_of(seen) for seen in objects if seen.kind in ("flag", "goal") and seen.close)
    assert len(felt) == len(close)
    assert all(a == pytest.approx(b, rel=1e-5) for a, b in zip(felt, close))
    lines = [(LINE_NAMES[line][2:], *told_ball(pitch.lines[world, row, k], 1)) for k, line in enumerate(pitch.line[world, row]) if line]
    assert [line[0] for line in lines] == [seen.name for seen in objects if seen.kind == "line"]
    for line, seen in zip(lines, [seen for seen in objects if seen.kind == "line"]):
        assert list(line[1:]) == pytest.approx(numbers_of(seen), rel=1e-5)


SEE_FIELDS = ("ball", "ball_level", "players", "players_level", "players_flags")


def permuted(sim, permutation, observer):
    """The same worlds with the players (rows, all but the observer) exchanged."""
    w = sim.world.copy()
    for name in w.dtype.names:
        if w[name].ndim >= 2 and w[name].shape[1] == 22:
            w[name] = sim.world[name][:, permutation]
        elif w[name].ndim >= 2 and w[name].shape[1] == 23:
            w[name][:, 1:] = sim.world[name][:, 1:][:, permutation]
    assert permutation[observer] == observer
    return w


@given(st.integers(0, 10_000), st.integers(0, 21))
@settings(max_examples=40)
def test_who_is_not_recognised_cannot_be_told_from_his_place(seed, observer):
    """Exchange team-mates of whom no number is seen: the arrays of the observer stay the same, bit for bit."""
    sim = random_worlds(1, seed=seed)
    sim.world["view_width"], sim.world["arm_timer"] = 3, 20
    # beyond 40 m no number is ever seen, so no draw depends on the index of the object
    sim.world["pos"][:, 1:] = np.where(np.arange(22)[:, None] == observer, 0.0, sim.world["pos"][:, 1:])
    away = sim.world["pos"][0, 1:]
    lengths = np.maximum(np.hypot(away[:, 0], away[:, 1]), 1.0)[:, None]
    others = np.arange(22) != observer
    sim.world["pos"][0, 1:][others] = (away / lengths * np.clip(lengths, 43.0, None))[others]
    rng = np.random.default_rng(seed)
    permutation = np.arange(22)
    for team in (np.arange(11), np.arange(11, 22)):
        movable = team[team != observer]
        permutation[movable] = rng.permutation(movable)
    before = see(sim.world, sim.packed)
    after = see(permuted(sim, permutation, observer), sim.packed)
    for name in SEE_FIELDS:
        assert np.array_equal(getattr(before, name)[0, observer], getattr(after, name)[0, observer])
    assert (before.players_level[0, observer] > 0).sum() > 2


@given(st.integers(0, 10_000))
@settings(max_examples=30)
def test_rows_without_a_number_stand_in_the_first_free_places_nearest_first(seed):
    sim = random_worlds(4, seed=seed, spread=[1.0, 0.1][seed % 2])
    sim.world["protocol"] = [19, 17][seed % 2]
    arrays = sim.see()
    for world in range(4):
        for row in range(22):
            levels, players = arrays.players_level[world, row], arrays.players[world, row]
            assert levels[row] == 0
            assert not players[row].any()
            own = 0 if row < 11 else 11
            for level, order in ((2, range(11)), (2, range(11, 22)), (1, [*range(11 - own, 22 - own), *range(own, own + 11)])):
                free = [slot for slot in order if levels[slot] <= level and slot != row]
                count = sum(levels[slot] == level for slot in order)
                assert all(levels[slot] == level for slot in free[:count])
                distances = [players[slot, 0] for slot in free[:count]]
                assert distances == sorted(distances)
            assert not players[levels == 0].any()


def test_everything_is_quantised_as_in_the_message():
    arrays = random_worlds(50, seed=4).see()
    seen = arrays.players_level > 0
    rows = arrays.players[seen]
    assert np.array_equal(np.rint(rows[:, 0] / 0.1) * 0.1, rows[:, 0])
    for column in (1, 4, 5):
        degrees = rows[:, column] * R2D
        assert np.abs(degrees - np.rint(degrees)).max() < 1e-9


def mirrored(world):
    """The world seen from the other end: teams exchanged, everything turned by 180 degrees."""
    w = world.copy()
    swap = np.r_[11:22, 0:11]
    for name in w.dtype.names:
        if w[name].ndim >= 2 and w[name].shape[1] == 22:
            w[name] = world[name][:, swap]
    for name in ("pos", "vel"):
        w[name][:, 0] = -world[name][:, 0]
        w[name][:, 1:] = -world[name][:, 1:][:, swap]
    w["body"] = np.where(w["body"] > 0, w["body"] - np.pi, w["body"] + np.pi)
    return w


def test_a_world_seen_from_the_other_end_looks_the_same():
    """Numbers, teams and places mirror; draws have been made impossible by distances of less than 20 m."""
    sim = random_worlds(60, seed=8, spread=0.15)
    here, there = see(sim.world, sim.packed), see(mirrored(sim.world), sim.packed)
    swap = np.r_[11:22, 0:11]
    assert np.array_equal(here.ball_level, there.ball_level[:, swap])
    assert np.array_equal(here.players_level, there.players_level[:, swap][:, :, swap])
    assert np.allclose(here.players[..., [0, 1, 4, 5]], there.players[:, swap][:, :, swap][..., [0, 1, 4, 5]], atol=0.018)


def test_a_player_without_a_message_gets_zeros_and_out_is_overwritten():
    sim = random_worlds(3)
    sim.world["saw"][:, ::2] = 0
    out, pitch = new_see(3), new_landmarks(3)
    for array in (*out, *pitch):
        array[...] = 1
    assert sim.see(out) is out
    assert sim.landmarks(pitch) is pitch
    fresh = np.arange(22) % 2 == 1
    assert (out.fresh == fresh).all()
    assert not out.players[:, ~fresh].any()
    assert not out.ball_level[:, ~fresh].any()
    assert not out.players_flags[:, ~fresh].any()
    assert not pitch.level[:, ~fresh].any()
    assert not pitch.line[:, ~fresh].any()
    assert pitch.level[:, fresh].any()
    for ours, theirs in zip(out, see(sim.world, sim.packed)):
        assert np.array_equal(ours, theirs)
    for ours, theirs in zip(pitch, see_landmarks(sim.world, sim.packed)):
        assert np.array_equal(ours, theirs)


def test_looking_changes_nothing_and_depends_on_nothing_but_the_world():
    sim = random_worlds(12, seed=2)
    before = sim.world.copy()
    arrays = [array.copy() for array in sim.see()]
    sim.landmarks(), sim.sense_body(), sim.hear()
    assert all(np.array_equal(sim.world[name], before[name]) for name in before.dtype.names)
    for name, array in zip(SEE_FIELDS, arrays[1:]):
        assert array.tobytes() == getattr(sim.see(), name).tobytes()
    threaded = Simulator(12, seed=2, threads=3)
    threaded.world[...] = before
    alone = see(before[7:8].copy(), sim.packed)
    for ours, theirs, single in zip(arrays, threaded.see(), alone):
        assert np.array_equal(ours, theirs)
        assert np.array_equal(ours[7:8], single)


def test_seeing_allocates_nothing():
    import tracemalloc

    sim = random_worlds(8)
    out = new_see(8)
    sim.see(out)
    tracemalloc.start()
    for _ in range(20):
        sim.see(out)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 4096


def test_an_asynchronous_player_is_fresh_in_the_cycles_in_which_a_message_comes():
    """Normal width, high quality: two messages in 300 ms; low quality and narrow: several in every cycle."""
    sim = Simulator(1, seed=1)
    w = sim.world[0]
    w["mode"], w["synchronous"], w["protocol"] = 3, 0, 17
    w["view_width"][1], w["view_quality"][1] = 1, 2
    fresh = []
    for _ in range(12):
        sim.advance()
        fresh.append(sim.see().fresh[0, :2].tolist())
    normal, quick = np.array(fresh)[3:].T
    assert quick.all()
    assert normal.sum() == 6


@given(st.floats(0.0, 200.0))
def test_the_table_of_bands_is_the_formula(distance):
    for step in (0.1, 0.01, 0.2):
        assert rounding.banded_distance(distance, step) == rounding.seen_distance(distance, distance, step)


def test_the_table_of_bands_is_the_formula_at_its_boundaries():
    for step, lows in ((0.1, range(-30, 53)), (0.01, range(-300, 530))):
        for k in lows:
            edge = math.exp((k + 0.5) * step)
            for distance in (edge, math.nextafter(edge, 0), math.nextafter(edge, 999), edge * (1 + 1e-9), edge * (1 - 1e-9), edge - 2e-6):
                assert rounding.banded_distance(distance, step) == rounding.seen_distance(distance, distance, step)


@given(st.floats(-60, 60), st.floats(-40, 40), st.floats(-math.pi, math.pi), st.floats(-1.6, 1.6))
@settings(max_examples=300)
def test_the_quick_angle_is_the_formula(dx, dy, body, neck):
    c, s = math.cos(body + neck), math.sin(body + neck)
    quick = rounding.face_degrees(dx, dy, dx * c + dy * s, dy * c - dx * s, body, neck)
    assert quick == rounding.rounded_degrees(rounding.face_direction(dx, dy, body, neck))


def test_the_quick_angle_is_the_formula_next_to_halves_of_degrees():
    for half in np.arange(-359, 360) / 2:
        for off in (0.0, 1e-13, -1e-13, 1e-9, -1e-9, 2e-5, -2e-5, 2e-4, -2e-4):
            angle = math.radians(half + off)
            dx, dy = 7.3 * math.cos(angle + 0.4), 7.3 * math.sin(angle + 0.4)
            c, s = math.cos(0.4), math.sin(0.4)
            quick = rounding.face_degrees(dx, dy, dx * c + dy * s, dy * c - dx * s, 0.3, 0.1)
            assert quick == rounding.rounded_degrees(rounding.face_direction(dx, dy, 0.3, 0.1))


def test_distances_of_the_recorded_vector():
    """Test vector 25 of specification/simulator.md 9."""
    told = [rounding.banded_distance(float(true), 0.1) for true in (3, 6, 9, 12, 15, 18)]
    assert told == pytest.approx([3, 6, 9, 12.2, 14.9, 18.2])


def test_compiled_and_python_kernels_agree():
    sim = random_worlds(2, seed=6)
    compiled, python = new_see(2), new_see(2)
    for world in range(2):
        for row in range(22):
            for out, kernel in ((compiled, look), (python, look.py_func)):
                rest = out.ball[world], out.players[world], out.players_level[world], out.players_flags[world]
                kernel(sim.world.view(np.recarray)[world], sim.packed.view(np.recarray)[0], row, 19, 0, *rest)
    for ours, theirs in zip(compiled, python):
        assert np.array_equal(ours, theirs)


def test_text_has_the_servers_number_format():
    sim = random_worlds(30, seed=12)
    text = " ".join(see_text(sim, k, 5) for k in range(30))
    numbers = re.findall(r"\) ([-\d. ]+)\)", text)
    assert all(re.fullmatch(r"-?(\d+|\d+\.\d*[1-9])", number) for group in numbers for number in group.split())
    assert " -0" in text


def is_told(w, row, half, position):
    """Whether player `row` with half a cone of so many degrees is told of what stands at `position`."""
    x, y = np.asarray(position) - w["pos"][row + 1]
    turned = (math.degrees(math.atan2(y, x) - w["body"][row] - w["neck"][row]) + 180) % 360 - 180
    distance = math.hypot(x, y)
    return (abs(turned) < half and distance < math.hypot(105, 68)) or distance <= 3.0


@given(st.integers(0, 10_000), st.sampled_from([10, 37, 90, 120, 200, 360]), st.booleans())
@settings(max_examples=40)
def test_who_is_told_is_who_is_in_the_cone_or_near(seed, angle, synchronous):
    """Against the definition, for cones of any size: in the cone and nearer than the observation length, or within 3 m."""
    sim = random_worlds(1, seed=seed, spread=[1.0, 0.1, 2.5][seed % 3])
    sim.packed["visible_angle"] = angle
    w = sim.world[0]
    w["synchronous"], w["enabled"][5], w["enabled"][14] = synchronous, 0, 0
    arrays, pitch = sim.see(), sim.landmarks()
    for row in range(22):
        half = {True: (30, 60, 90), False: (angle / 4, angle / 2, angle)}[synchronous][w["view_width"][row] - 1]

        if not w["enabled"][row]:
            assert not arrays.fresh[0, row]
            continue
        expected = [is_told(w, row, half, w["pos"][j + 1]) and bool(w["enabled"][j]) and j != row for j in range(22)]
        assert (arrays.players_level[0, row] > 0).sum() == sum(expected)
        assert (arrays.ball_level[0, row] > 0) == is_told(w, row, half, w["pos"][0])
        assert (pitch.level[0, row] > 0).sum() == sum(is_told(w, row, half, position) for position in LANDMARK_POSITIONS)
