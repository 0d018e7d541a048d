"""What is drawn in seeing has the frequencies and distributions recorded from a real server."""

import math

import numpy as np
import pytest
from scipy import stats
from senses_recordings import load, recording

from cprm_gym.simulator.landmarks import landmark_index
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PlayMode

FORMS = {"full_6": 3, "nounum_2": 2, "noteam_2": 1}


def observer(worlds, protocol=19):
    """Player 1 at (-52, 0) looking along x, narrow; player 12 and the ball are free to be placed; nobody else."""
    sim = Simulator(worlds, seed=protocol, left=1, right=1, goalies=(0, 0))
    w = sim.world
    w["mode"], w["saw"], w["view_width"], w["protocol"], w["kick_cycles"] = PlayMode.play_on, 1, 1, protocol, -1
    w["body"], w["pos"] = 0.0, (-52.0, 20.0)
    w["pos"][:, 1] = -52.0, 0.0
    return sim


def disagreement(a, b):
    """Squared standardised difference of two counts (k of n), and whether there is any freedom in it."""
    (k1, n1), (k2, n2) = a, b
    pooled = (k1 + k2) / (n1 + n2)
    if pooled in (0.0, 1.0):
        return 0.0, 0
    return (k1 / n1 - k2 / n2) ** 2 / (pooled * (1 - pooled) * (1 / n1 + 1 / n2)), 1


@pytest.mark.parametrize(("name", "protocol"), [("sight_prob", 19), ("sight_prob_v17", 17)])
def test_numbers_teams_and_changes_are_lost_as_often_as_recorded(name, protocol):
    """By distance: full, without number, without team; ball with and without changes. One chi-square over all distances."""
    n = 500
    sim = observer(n, protocol)
    w = sim.world
    total, freedom, loose = 0.0, 0, 0
    for record in recording(name).records:
        if record["rec"] == "flag":
            continue
        if record["rec"] == "player":
            w["pos"][:, 12], w["steps"] = (-52.0 + record["d_true"], 0.0), w["steps"] + 1
            arrays = sim.see()
            assert np.allclose(arrays.players[:, 0, :, 0].max(axis=1), record["q"][0])
            levels = np.sort(arrays.players_level[:, 0], axis=1)[:, -1]
            counts = [((levels == level).sum(), record["forms"].get(form, 0), record["n"]) for form, level in FORMS.items()]
        else:
            w["pos"][:, 0], w["steps"] = (-52.0 + record["d"], 0.0), w["steps"] + 1
            arrays = sim.see()
            assert np.allclose(arrays.ball[:, 0, 0], record["q"])
            moving = (arrays.ball_level[:, 0] == 3).sum()
            counts = [(moving, record["vel"], record["vel"] + record["novel"])]
        for ours, theirs, of in counts:
            squared, free = disagreement((ours, n), (theirs, of))
            total, freedom, loose = total + squared, freedom + free, loose + (theirs not in (0, of))
    assert loose > 40
    assert stats.chi2.sf(total, freedom) > 1e-3


def standardised(rows, kinds, rates):
    """(seen - true) / sigma of recorded rows of the given kinds."""
    return np.array([(r[3] - r[1]) / (r[1] * rates[r[0]] + r[2] * rates[r[0]]) for r in rows if r[0] in kinds and r[1] > 0.9])


RATES = {"f": 0.00125, "b": 0.0125, "p": 0.0125}


@pytest.mark.parametrize("number", [0, 1])
def test_gaussian_distances_have_the_recorded_distribution(number):
    """Player 1 without a focus point, player 2 with one: two-sample Kolmogorov-Smirnov of the errors in units of sigma."""
    recorded = recording("sight_gauss")
    rows = [record for record in recorded.records if record["rec"] == "rows"][number]["rows"]
    states = [record["state"] for record in recorded.records if record["rec"] == "raw"]
    source = recorded.simulator()
    source.world["mode"], source.world["gaussian"], source.world["saw"] = PlayMode.play_on, 1, 1
    load(source, states[0], states[0]["t"])
    sim = Simulator(200, recorded.parameters, None, source.types, seed=5)
    keys = sim.world["key"].copy()
    sim.world[...] = source.world[0]
    sim.world["key"], sim.world["view_width"], sim.world["saw"] = keys, 2, 1
    sim.world["neck"] = 0.0
    arrays, pitch = sim.see(), sim.landmarks()
    w = source.world[0]
    own = w["pos"][1 + number]
    angle = w["body"][number] + w["neck"][number] + w["focus_direction"][number]
    focus = own + w["focus_distance"][number] * np.array([math.cos(angle), math.sin(angle)])

    def errors(seen, position, rate):
        true, other = math.dist(own, position), math.dist(focus, position)
        return (seen - true) / (rate * (true + other))

    felt_or_seen = arrays.ball_level[:, number] > 0
    movables = [errors(arrays.ball[felt_or_seen, number, 0], w["pos"][0], 0.0125)]
    for row in range(11, 18):
        known = arrays.players_level[:, number, row] == 3
        movables.append(errors(arrays.players[known, number, row, 0], w["pos"][row + 1], 0.0125))
    flags = [
        errors(pitch.landmarks[pitch.level[:, number, landmark_index(name)] > 1, number, landmark_index(name), 0], position, 0.00125)
        for name, position in (("f c", (0, 0)), ("f p l c", (-36, 0)), ("f p r c", (36, 0)))
    ]
    for ours, kinds in ((np.concatenate(movables), "bp"), (np.concatenate(flags), "f")):
        theirs = standardised(rows, kinds, RATES)
        assert len(theirs) > 500
        assert stats.ks_2samp(ours, theirs).pvalue > 1e-3
        assert stats.kstest(ours, "norm").pvalue > 1e-3


def test_gaussian_changes_are_those_of_the_formula():
    """Recorded changes follow from the recorded noisy distance, up to the digits of the record."""
    from cprm_gym.simulator.kernels.senses import changes

    rows = [row for record in recording("sight_gauss").records if record["rec"] == "rows" for row in record["rows"]]
    rows = [row for row in rows if row[5] is not None and row[1] > 0.9]
    assert len(rows) > 3000
    for _, true, _, seen, change, seen_change, turn, seen_turn, _ in rows:
        ours, ours_turn = changes(change, math.radians(turn) * true, true, 0.0, true, seen, True)
        assert ours == pytest.approx(seen_change, abs=1e-9) or abs(abs(change * seen / true / 0.01 % 1) - 0.5) < 1e-3
        assert math.degrees(ours_turn) == pytest.approx(seen_turn, abs=1e-9) or abs(abs(turn / 0.1 % 1) - 0.5) < 1e-3


def test_pointing_directions_have_the_recorded_distribution():
    rows = [row for record in recording("sight_point").records if record["rec"] == "rows" for row in record["rows"]]
    true_directions = {distance: direction for distance, direction, _ in rows if direction is not None}
    assert len(true_directions) == 5
    sim = observer(2000)
    w = sim.world
    for distance, direction in true_directions.items():
        position = np.array([-52.0 + distance, 0.0])
        angle = math.radians(direction)
        w["pos"][:, 12], w["arm_timer"][:, 11] = position, 0
        w["arm_target"][:, 11] = position + 10.0 * np.array([math.cos(angle), math.sin(angle)])
        arrays = sim.see()
        seen = arrays.players_level[:, 0] >= 2
        ours = np.rint(np.degrees(arrays.players[:, 0][seen][:, 6]))
        theirs = np.array([row[2] for row in rows if row[0] == distance])
        wrapped = [(values - direction + 180) % 360 - 180 for values in (ours, theirs)]
        assert len(theirs) > 1000
        assert len(ours) == 2000
        assert stats.ks_2samp(*wrapped).pvalue > 1e-3


def test_draws_of_one_observer_do_not_depend_on_the_others():
    """Another player's view, pointing or presence changes nobody's luck."""
    sim = observer(200)
    w = sim.world
    w["pos"][:, 12] = -20.0, 0.0
    before = sim.see().players_level[:, 0].copy()
    assert 0 < (before.max(axis=1) == 3).sum() < 200
    w["view_width"][:, 11], w["arm_timer"][:, 11], w["enabled"][:, 5] = 3, 0, 1
    assert np.array_equal(sim.see().players_level[:, 0].max(axis=1), before.max(axis=1))
