"""Where a player is and how he looks, from the landmarks and lines that he sees and from what he did.

Columns of a pose: face (rad, unwrapped), x, y (m) in the frame of the own team. All readings are straight lines of the pose around the
place and face that they are taken at, and intervals: whole degrees, steps of a logarithm.
"""

from __future__ import annotations

import math

import numpy as np

from .....simulator.landmarks import LANDMARK_POSITIONS
from . import kernel
from .reading import read, turned_back

PI = math.pi
MARKS = np.ascontiguousarray(LANDMARK_POSITIONS)
LINE_NORMAL = np.array([0.0, PI, 0.0, -0.5 * PI, 0.5 * PI])
"""Outward direction of no line, left, right, top, bottom, as seen from inside, in the server's frame."""
STATE = 3
APART = 0.1
"""Least angle between two landmarks that tell where he looks, rad."""


@kernel
def moved(mean, cov, turned, turning, go_x, go_y, straying):
    """One cycle: the face turns by `turned` (variance `turning`), he goes (go_x, go_y) m (variance `straying`) as seen from where he looks.

    The way hangs on the face: an error of it sends him aside.
    """
    mean[0] += turned
    cov[0, 0] += turning
    slopes = (-go_y, go_x)
    mean[1] += go_x
    mean[2] += go_y
    for a in range(2):  # x' = x + slope * (face' - its mean)
        cov[1 + a, 0] += slopes[a] * cov[0, 0]
    face = cov[0, 0]
    for a in range(2):
        for b in range(2):
            # with cov[1 + a, 0] already carried on
            old_a, old_b = cov[1 + a, 0] - slopes[a] * face, cov[1 + b, 0] - slopes[b] * face
            cov[1 + a, 1 + b] += slopes[a] * old_b + slopes[b] * old_a + slopes[a] * slopes[b] * face
    for a in range(2):
        cov[1 + a, 1 + a] += straying
        cov[0, 1 + a] = cov[1 + a, 0]


@kernel
def landmark_interval(told, step, rounding):
    """Between what distances one lies that is told so."""
    return max(0.0, told - rounding) * math.exp(-0.5 * step), (told + rounding) * math.exp(0.5 * step)


@kernel
def read_landmark(mean, cov, slopes, at, x, y, told, direction, p):
    """One landmark at (x, y): beside the line on which it was seen, and how far; gives the log likelihood.

    at : (3,) pose around which it is a straight line
    p : see `Terms`
    """
    dx, dy = x - at[1], y - at[2]
    far = max(0.1, math.sqrt(dx * dx + dy * dy))
    sight = at[0] + direction
    ex, ey = math.cos(sight), math.sin(sight)
    low, high = landmark_interval(told, p[0], p[1])
    wide = p[2] * far
    slack = p[4] + p[5] * far * far
    # aside: (x - px) * -ey + (y - py) * ex - far * (face - at face)
    slopes[0], slopes[1], slopes[2] = -far, ey, -ex
    total = read(mean, cov, STATE, slopes, -x * ey + y * ex + far * at[0], slack, -wide, wide)
    ux, uy = dx / far, dy / far
    slopes[0], slopes[1], slopes[2] = 0.0, -ux, -uy
    if p[3] > 0.0:
        low, high = told, told
    return total + read(mean, cov, STATE, slopes, x * ux + y * uy, slack + (p[3] * far) ** 2, low, high)


@kernel
def read_line(mean, cov, slopes, at, side, line, p):
    """The line ahead: its direction tells the face; gives the log likelihood."""
    face = line_face(side, line)
    away = at[0] + turned_back(face - at[0])
    slopes[0], slopes[1], slopes[2] = 1.0, 0.0, 0.0
    return read(mean, cov, STATE, slopes, 0.0, 1e-6, away - p[2], away + p[2])


@kernel
def line_face(side, line):
    """Where he looks who sees this line ahead from inside, rad."""
    s = line[1] - 0.5 * PI if line[1] > 0.0 else line[1] + 0.5 * PI
    return turned_back(LINE_NORMAL[int(line[2])] - s + (PI if side < 0.0 else 0.0))


@kernel
def looked(mean, cov, slopes, at, side, marks, levels, lines, p):
    """Everything that one look tells of the pitch: (log likelihood, how many readings)."""
    total, count = 0.0, 0
    if lines[0, 2] > 0.0 and lines[1, 2] == 0.0:
        total += read_line(mean, cov, slopes, at, side, lines[0], p)
        count += 1
    for k in range(len(MARKS)):
        if levels[k] >= 2.0:
            total += read_landmark(mean, cov, slopes, at, side * MARKS[k, 0], side * MARKS[k, 1], marks[k, 0], marks[k, 1], p)
            count += 2
    return total, count


@kernel
def located(side, marks, levels, lines, at):
    """A first pose from a line or from two landmarks far apart, into `at`; whether there are such."""
    first, last, count = -1, -1, 0
    for k in range(len(MARKS)):
        if levels[k] >= 2.0:
            count += 1
            if first < 0 or marks[k, 1] < marks[first, 1]:
                first = k
            if last < 0 or marks[k, 1] > marks[last, 1]:
                last = k
    if count == 0:
        return False
    if lines[0, 2] > 0.0 and lines[1, 2] == 0.0:
        at[0] = line_face(side, lines[0])
    elif marks[last, 1] - marks[first, 1] >= APART:
        ex = marks[last, 0] * math.cos(marks[last, 1]) - marks[first, 0] * math.cos(marks[first, 1])
        ey = marks[last, 0] * math.sin(marks[last, 1]) - marks[first, 0] * math.sin(marks[first, 1])
        px, py = side * (MARKS[last, 0] - MARKS[first, 0]), side * (MARKS[last, 1] - MARKS[first, 1])
        at[0] = turned_back(math.atan2(py, px) - math.atan2(ey, ex))
    else:
        return False
    total, x, y = 0.0, 0.0, 0.0
    for k in range(len(MARKS)):
        if levels[k] >= 2.0:
            weight = 1.0 / (0.05 + marks[k, 0] ** 2)
            angle = at[0] + marks[k, 1]
            x += weight * (side * MARKS[k, 0] - marks[k, 0] * math.cos(angle))
            y += weight * (side * MARKS[k, 1] - marks[k, 0] * math.sin(angle))
            total += weight
    at[1], at[2] = x / total, y / total
    return True


@kernel
def copied(mean, cov, to_mean, to_cov):
    """The pose of one room in another."""
    for i in range(STATE):
        to_mean[i] = mean[i]
        for j in range(STATE):
            to_cov[i, j] = cov[i, j]


@kernel
def taken(mean, cov, work_mean, work_cov, slopes, at, side, marks, levels, lines, passes, p):
    """Condition a pose on a look, taken again around where it leads to; gives the log likelihood for each reading."""
    for i in range(STATE):
        at[i] = mean[i]
    total, count = 0.0, 0
    for _ in range(passes):
        copied(mean, cov, work_mean, work_cov)
        total, count = looked(work_mean, work_cov, slopes, at, side, marks, levels, lines, p)
        if not total > -np.inf:
            return -np.inf, count
        for i in range(STATE):
            at[i] = work_mean[i]
    copied(work_mean, work_cov, mean, cov)
    return total, count


@kernel
def begin(mean, cov, at, spread, turn):
    """A pose that is hardly known, around `at`."""
    for i in range(STATE):
        mean[i] = at[i]
        for j in range(STATE):
            cov[i, j] = 0.0
    cov[0, 0], cov[1, 1], cov[2, 2] = turn * turn, spread * spread, spread * spread


@kernel
def merge(mean, cov, other_mean, other_cov, share):
    """Two poses as one with their first two moments; `share` is the weight of the other."""
    for i in range(STATE):
        other_mean[i] -= mean[i]
    for i in range(STATE):
        for j in range(STATE):
            cov[i, j] = (1.0 - share) * cov[i, j] + share * other_cov[i, j] + share * (1.0 - share) * other_mean[i] * other_mean[j]
    for i in range(STATE):
        mean[i] += share * other_mean[i]


@kernel
def know_pose(mean, cov, known, late, side, motion, fresh, marks, levels, lines, passes, p, work):
    """A cycle of the poses of N agents, in place.

    mean : (N, 3); cov : (N, 3, 3); known, fresh : (N,) bool; side : (N,) +1 left, -1 right
    late : (N,) share of the look that is of before the step; p[6] what is expected of it, 0 for an eye that keeps step
    motion : (N, 5) `turned`, `turning`, and the way in the frame of the face after it: its length, its direction, `straying`
    marks, levels, lines : as observed
    work : (4, 4, 4) scratch
    """
    slopes, at = work[2, 0], work[2, 1]
    room_mean, room_cov, other_mean, other_cov = work[2, 2], work[0], work[2, 3], work[1]
    for n in range(len(mean)):
        m, c = mean[n], cov[n]
        late[n] = 0.0
        turned, turning, step, way, straying = motion[n, 0], motion[n, 1], motion[n, 2], motion[n, 3], motion[n, 4]
        seen = fresh[n]
        told, again = -np.inf, -np.inf
        asynchronous = seen and p[6] > 0.0 and known[n]
        if asynchronous:  # what if the look was of before?
            copied(m, c, other_mean, other_cov)
            found, _ = taken(other_mean, other_cov, room_mean, room_cov, slopes, at, side[n], marks[n], levels[n], lines[n], passes, p)
            again = math.log(p[6]) + found
            face = other_mean[0] + turned + way
            moved(other_mean, other_cov, turned, turning, step * math.cos(face), step * math.sin(face), straying)
        if known[n]:
            face = m[0] + turned + way
            moved(m, c, turned, turning, step * math.cos(face), step * math.sin(face), straying)
        if not seen:
            continue
        count = 0
        if known[n]:
            found, count = taken(m, c, room_mean, room_cov, slopes, at, side[n], marks[n], levels[n], lines[n], passes, p)
            told = found + (math.log(1.0 - p[6]) if asynchronous else 0.0)
            if asynchronous and again > -np.inf:
                share = 1.0 if told == -np.inf else 1.0 / (1.0 + math.exp(min(700.0, told - again)))
                late[n] = share
                if share > 0.5:
                    told = again
                if share >= 1.0 - 1e-12:
                    copied(other_mean, other_cov, m, c)
                elif share > 1e-12:
                    merge(m, c, other_mean, other_cov, share)
        if not known[n] or (count > 0 and told < -p[7] * count):
            if located(side[n], marks[n], levels[n], lines[n], at):
                begin(m, c, at, p[8], p[9])
                taken(m, c, room_mean, room_cov, slopes, at, side[n], marks[n], levels[n], lines[n], passes + 1, p)
                known[n] = True
                late[n] = 0.0
