"""Which lines are seen: decided by components, as the server's formula with its tangent decides."""

import math

import numpy as np
import pytest

from cprm_gym.simulator.kernels.landmark_sight import line_ahead, lines_in_view, meets_line, slant_to
from cprm_gym.simulator.pitch import HALF_LENGTH, HALF_WIDTH
from cprm_gym.simulator.simulator import Simulator


def by_formula(w, i):
    """The lines in the server's order, each asked whether the face meets it."""
    x, y = w["pos"][i + 1]
    wanted = 1 if abs(x) < HALF_LENGTH and abs(y) < HALF_WIDTH else 2
    found = []
    for line in range(1, 5):
        across = line_ahead(x, y, line, 1.0, 0.0)[0]
        if meets_line(x, y, line, across, slant_to(w, i, line, across)):
            found.append(line)
    return tuple((found + [0, 0])[:wanted] + [0] * (2 - wanted))


@pytest.mark.parametrize("whole", [True, False])
def test_lines_are_seen_as_by_the_formula_inside_outside_and_on_the_edges(whole):
    rng, sim = np.random.default_rng(3), Simulator(60)
    w = sim.world
    w["pos"] = rng.uniform((-58.0, -40.0), (58.0, 40.0), w["pos"].shape)
    w["pos"][10:20, :, 0] = np.sign(w["pos"][10:20, :, 0]) * HALF_LENGTH
    w["pos"][15:25, :, 1] = np.sign(w["pos"][15:25, :, 1]) * HALF_WIDTH
    w["body"], w["neck"] = rng.uniform(-math.pi, math.pi, w["body"].shape), rng.uniform(-1.5, 1.5, w["neck"].shape)
    if whole:
        w["body"], w["neck"] = (np.radians(np.rint(np.degrees(w[name]) / 15.0) * 15.0) for name in ("body", "neck"))
    seen = [(lines_in_view(w[n], i), by_formula(w[n], i)) for n in range(60) for i in range(22)]
    assert all(found == expected for found, expected in seen)
    assert {line for found, _ in seen for line in found} == {0, 1, 2, 3, 4}
