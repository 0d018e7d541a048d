"""The engine of Gaussian mixtures against Kalman's formulas, all sequences of modes, fine bins and many particles."""

import importlib.util
from itertools import product

import numpy as np
import pytest
from scipy import stats

from cprm_gym.architecture.prm import (
    BOOL,
    Angle,
    Attribute,
    Bins,
    Chance,
    Filter,
    Given,
    Grounding,
    Interval,
    Labels,
    Mixture,
    Model,
    Noise,
    Prior,
    PRMClass,
    Real,
    Relation,
    Replace,
    Switch,
    Table,
    Uniform,
)  # fmt: skip
from cprm_gym.errors import EvidenceError, ImpossibleEvidence, ModelError

F = np.array([[1.0, 1.0], [0.0, 0.9]])
Q = np.diag([0.3**2, 0.2**2])
START, SPREAD = np.array([1.0, 0.0]), np.diag([4.0, 1.0])


def tracked(**more):
    """A number with a velocity, read with noise."""
    return PRMClass(
        "P",
        attributes=(
            Attribute("x", Real("m", **more), Noise("prev.x + prev.v", sd=0.3), ("prev.x", "prev.v"), initial=Noise("1", sd=2.0)),
            Attribute("v", Real("m/step"), Noise("0.9 * prev.v", sd=0.2), ("prev.v",), initial=Noise("0", sd=1.0)),
            Attribute("z", Real("m"), Noise("x", sd=0.5), ("x",)),
        ),
    )


def world(*classes, relations=(), **objects):
    return Grounding(Model("test", classes, relations), objects or {"a": classes[0].name})


def kalman(readings):
    """Filtered means and covariances, and the log likelihood; NaN is no reading."""
    m, p, total, out = START, SPREAD, 0.0, []
    for t, z in enumerate(readings):
        if t:
            m, p = F @ m, F @ p @ F.T + Q
        if not np.isnan(z):
            s = p[0, 0] + 0.25
            total -= 0.5 * (np.log(2 * np.pi * s) + (z - m[0]) ** 2 / s)
            gain = p[:, 0] / s
            m, p = m + gain * (z - m[0]), p - np.outer(gain, p[0])
        out.append((m, p))
    return out, total


def rauch_tung_striebel(filtered):
    means, covs = [filtered[-1][0]], [filtered[-1][1]]
    for m, p in filtered[-2::-1]:
        ahead = F @ p @ F.T + Q
        gain = p @ F.T @ np.linalg.inv(ahead)
        means.append(m + gain @ (means[-1] - F @ m))
        covs.append(p + gain @ (covs[-1] - ahead) @ gain.T)
    return means[::-1], covs[::-1]


def close(a, b, within=1e-9):
    np.testing.assert_allclose(a, b, rtol=within, atol=within)


def test_linear_model_is_the_kalman_filter_and_smoother():
    rng = np.random.default_rng(1)
    readings = rng.normal(size=(2, 12)) * 2.0
    readings[0, 4:7] = np.nan
    readings[1, 0] = np.nan
    filter = Filter(world(tracked()), batch=2, engine="mixture", window=12)
    answers = [filter.step({"a.z": readings[:, t]}) for t in range(12)]
    for agent in range(2):
        filtered, total = kalman(readings[agent])
        for answer, (m, p) in zip(answers, filtered):
            mean, cov = answer.moments("a.x", "a.v")
            close(mean[agent], m)
            close(cov[agent], p)
        close(answers[-1].log_likelihood[agent], total)
        means, covs = rauch_tung_striebel(filtered)
        for slice_, m, p in zip(filter.smooth(), means, covs):
            close(slice_["a.x"].expectation()[agent], m[0])
            close(slice_["a.x"].variance()[agent], p[0, 0])
            close(slice_["a.v"].expectation()[agent], m[1])
    assert not answers[-1].exact
    assert (answers[-1].loss == 0.0).all()


@pytest.mark.skipif(importlib.util.find_spec("filterpy") is None, reason="filterpy is not installed")
def test_linear_model_agrees_with_filterpy():
    from filterpy.kalman import KalmanFilter

    rng = np.random.default_rng(2)
    other = KalmanFilter(2, 1)
    other.x, other.P, other.F, other.Q = START[:, None].copy(), SPREAD.copy(), F, Q
    other.H, other.R = np.array([[1.0, 0.0]]), np.array([[0.25]])
    filter = Filter(world(tracked()), engine="mixture", window=20)
    means, covs = [], []
    for t in range(20):
        z = rng.normal()
        if t:
            other.predict()
        other.update(z)
        mean, cov = filter.step({"a.z": z}).moments("a.x", "a.v")
        close(mean[0], other.x[:, 0])
        close(cov[0], other.P)
        means.append(other.x.copy())
        covs.append(other.P.copy())
    means, covs, _, _ = other.rts_smoother(np.array(means), np.array(covs))
    for slice_, m, p in zip(filter.smooth(), means, covs):
        close([slice_["a.x"].expectation()[0], slice_["a.v"].expectation()[0]], m[:, 0])
        close([slice_["a.x"].variance()[0], slice_["a.v"].variance()[0]], np.diag(p))


def test_looking_ahead_is_the_filter_without_readings():
    filter = Filter(world(tracked()), engine="mixture")
    filter.step({"a.z": 2.0})
    ahead = filter.predict(3)
    (m, p) = kalman([2.0, np.nan, np.nan, np.nan])[0][-1]
    mean, cov = ahead.moments("a.x", "a.v")
    close(mean[0], m)
    close(cov[0], p)
    assert filter.step_count == 1
    close(ahead["a.z"].variance()[0], p[0, 0] + 0.25)  # a reading that nobody made


SLOPES, SHIFTS, STAY = (0.9, 0.5), (0.3, -1.0), ((0.8, 0.2), (0.3, 0.7))


def switching():
    return PRMClass(
        "S",
        attributes=(
            Attribute("mode", Labels(("a", "b")), Table({("a",): STAY[0], ("b",): STAY[1]}), ("prev.mode",), initial=(0.6, 0.4)),
            Attribute(
                "x", Real(), parents=("prev.x", "mode"), initial=Noise("0", sd=1.0),
                cpd=Switch("mode", {"a": Noise("0.9 * prev.x + 0.3", sd=0.4), "b": Noise("0.5 * prev.x - 1", sd=0.7)}),
            ),
            Attribute("z", Real(), Switch("mode", {"a": Noise("x", sd=0.5), "b": Noise("x", sd=1.0)}), ("x", "mode")),
        ),
    )  # fmt: skip


def all_sequences(readings):
    """Weight, mean and variance of every sequence of modes."""
    out = []
    for modes in product((0, 1), repeat=len(readings)):
        log_weight, m, p = np.log((0.6, 0.4)[modes[0]]), 0.0, 1.0
        for t, (z, s) in enumerate(zip(readings, modes)):
            if t:
                log_weight += np.log(STAY[modes[t - 1]][s])
                m, p = SLOPES[s] * m + SHIFTS[s], SLOPES[s] ** 2 * p + (0.4, 0.7)[s] ** 2
            total = p + (0.5, 1.0)[s] ** 2
            log_weight += stats.norm.logpdf(z, m, np.sqrt(total))
            m, p = m + p / total * (z - m), p - p * p / total
        out.append((log_weight, m, p, modes))
    return out


def test_switching_model_is_all_sequences_of_modes():
    readings = np.random.default_rng(3).normal(size=8) * 1.5
    filter = Filter(world(switching()), engine="mixture", components=256, merge=0.0, window=4)
    for z in readings:
        answer = filter.step({"a.z": z})
    sequences = all_sequences(readings)
    logs = np.array([s[0] for s in sequences])
    total = np.logaddexp.reduce(logs)
    weights = np.exp(logs - total)
    means, variances = np.array([s[1] for s in sequences]), np.array([s[2] for s in sequences])
    mean = weights @ means
    close(answer.log_likelihood[0], total)
    close(answer.read("a.x")[0], mean)
    close(answer.read("a.x", "variance")[0], weights @ (variances + (means - mean) ** 2))
    second = np.array([s[3][-1] for s in sequences])
    close(answer["a.mode"][0, 1], weights @ second)
    assert answer.loss[0] == 0.0
    close(filter.smooth()[0]["a.mode"][0, 1], weights @ np.array([s[3][4] for s in sequences]))


def test_merging_tells_its_loss_and_stays_near():
    readings = np.random.default_rng(4).normal(size=30) * 1.5
    everything = Filter(world(switching()), engine="mixture", components=256, merge=0.0)
    few = Filter(world(switching()), engine="mixture", components=4)
    lost, apart = 0.0, []
    for z in readings:
        a, b = everything.step({"a.z": z}), few.step({"a.z": z})
        lost += b.loss[0]
        apart.append(abs(a.read("a.x") - b.read("a.x"))[0])
    assert 0.0 < lost < 0.5
    assert max(apart) < 0.05


def test_modes_that_make_no_difference_take_no_room_and_leave_kalmans_filter():
    """Eight modes of a reading are labels of one normal: what they were a slice ago is needed no more, and nothing is lost by it."""
    modes, chances = Labels(tuple("abcdefgh")), np.arange(1.0, 9.0) / 36.0
    x, v, _ = tracked().attributes
    mode = Attribute("mode", modes, Prior(tuple(chances)))
    z = Attribute("z", Real("m"), Switch("mode", dict.fromkeys("abcdefgh", Noise("x", sd=0.5))), ("x", "mode"))
    filter = Filter(world(PRMClass("P", (x, v, mode, z))), engine="mixture", components=8, merge=1e-9)
    readings = np.random.default_rng(8).normal(size=12)
    for reading, (mean, cov) in zip(readings, kalman(readings)[0]):
        answer = filter.step({"a.z": reading})
        close(answer.read("a.x")[0], mean[0])
        close(answer.read("a.x", "variance")[0], cov[0, 0])
        close(answer["a.mode"][0], chances)
        close(answer.loss[0], 0.0)


def test_model_on_fine_bins_agrees():
    """The same model, its numbers cut into bins for the exact engine."""
    fine = Bins.linear(-12.0, 12.0, 240, clip=True)
    walk = PRMClass(
        "W",
        attributes=(
            Attribute("x", Real("m", bins=fine), Noise("0.8 * prev.x + 1", sd=0.5), ("prev.x",), initial=Noise("0", sd=2.0)),
            Attribute("near", BOOL, Chance("1 if x < 2.5 else 0"), ("x",)),
            Attribute("z", Real("m", bins=fine), Noise("x", sd=0.6), ("x",)),
        ),
    )
    normal, exact = Filter(world(walk), engine="mixture"), Filter(world(walk))
    for z in (1.05, 2.25, 3.45, 3.05, None, 4.15):  # the middles of bins
        a, b = normal.step({"a.z": z}), exact.step({"a.z": z})
        assert abs(a.read("a.x") - b.read("a.x"))[0] < 0.02
        assert abs(a.read("a.x", "deviation") - b.read("a.x", "deviation"))[0] < 0.02
        assert abs(a["a.near"] - b["a.near"]).max() < 0.02
        assert abs(a.read("a.x", "probability(..2.5)") - b.read("a.x", "probability(..2.5)"))[0] < 0.02
        assert abs(a.read("a.x", "quantile(0.9)") - b.read("a.x", "quantile(0.9)"))[0] < 0.03
    a, b = normal.step({"a.near": "no"}), exact.step({"a.near": "no"})  # a threshold read
    assert abs(a.read("a.x") - b.read("a.x"))[0] < 0.05
    a, b = normal.step({"a.z": Interval(4.0, 6.0)}), exact.step({"a.z": Interval(4.0, 6.0)})
    assert abs(a.read("a.x") - b.read("a.x"))[0] < 0.05
    assert a.report["parts"]


def test_threshold_gives_the_moments_of_the_truncated_normal():
    flag = PRMClass(
        "T",
        attributes=(
            Attribute("x", Real(), Noise("1", sd=2.0)),
            Attribute("y", Real(), Noise("2 * x + 1", sd=1.0), ("x",)),
            Attribute("high", BOOL, Chance("1 if x > 1.7 else 0"), ("x",)),
            Attribute("kept", BOOL, Chance("0.5"), ("y",)),
        ),
    )
    answer = Filter(world(flag), engine="mixture").step({"a.high": "yes"})
    cut = stats.truncnorm((1.7 - 1) / 2.0, np.inf, loc=1, scale=2.0)
    close(answer.log_likelihood[0], stats.norm.logsf(0.35), 1e-8)
    close(answer.read("a.x")[0], cut.mean(), 1e-8)
    close(answer.read("a.x", "variance")[0], cut.var(), 1e-8)
    close(answer.read("a.y")[0], 2 * cut.mean() + 1, 1e-8)
    close(answer.read("a.y", "variance")[0], 4 * cut.var() + 1, 1e-8)


@pytest.mark.parametrize(("low", "high"), [(-1.0, 0.5), (3.0, 3.4), (2.0, np.inf), (-np.inf, -9.0), (0.1, 0.1001), (40.0, 41.0)])
def test_interval_gives_the_moments_of_the_truncated_normal(low, high):
    one = PRMClass("T", attributes=(Attribute("x", Real(), Noise("0", sd=1.0)), Attribute("z", Real(), Noise("x", sd=0.0), ("x",))))
    answer = Filter(world(one), engine="mixture").step({"a.z": Interval(low, high)})
    if low < 30:
        cut = stats.truncnorm(low, high)
        close(answer.log_likelihood[0], np.log(stats.norm.cdf(high) - stats.norm.cdf(low)) if low < 5 else 0.0, 1e-7)
        close(answer.read("a.x")[0], cut.mean(), 1e-7)
        close(answer.read("a.x", "variance")[0], cut.var(), 1e-6)
    else:
        assert 40.0 < answer.read("a.x")[0] < 40.1
        close(answer.log_likelihood[0], stats.norm.logsf(40.0), 1e-3)


def polar():
    return PRMClass(
        "B",
        attributes=(
            Attribute("x", Real("m"), Noise("prev.x + prev.vx", sd=0.1), ("prev.x", "prev.vx"), initial=Noise("12", sd=3.0)),
            Attribute("y", Real("m"), Noise("prev.y + prev.vy", sd=0.1), ("prev.y", "prev.vy"), initial=Noise("5", sd=3.0)),
            Attribute("vx", Real("m"), Noise("0.94 * prev.vx", sd=0.05), ("prev.vx",), initial=Noise("0", sd=0.5)),
            Attribute("vy", Real("m"), Noise("0.94 * prev.vy", sd=0.05), ("prev.vy",), initial=Noise("0", sd=0.5)),
            Attribute("dir", Angle("deg"), Noise("degrees(atan2(y, x))", sd=2.0), ("x", "y")),
            Attribute("dist", Real("m"), Noise("hypot(x, y)", sd="0.2 + 0.02 * hypot(x, y)"), ("x", "y")),
        ),
    )


def test_nonlinear_model_is_near_a_hundred_thousand_particles():
    rng = np.random.default_rng(5)
    count = 100_000
    x = np.stack([rng.normal(12, 3, count), rng.normal(5, 3, count), rng.normal(0, 0.5, count), rng.normal(0, 0.5, count)])
    truth = np.array([10.0, 4.0, -0.4, 0.2])
    filter, total = Filter(world(polar()), engine="mixture"), 0.0
    for t in range(8):
        if t:
            x = np.stack([x[0] + x[2], x[1] + x[3], 0.94 * x[2], 0.94 * x[3]])
            x += rng.normal(size=x.shape) * np.array([0.1, 0.1, 0.05, 0.05])[:, None]
            truth = np.array([truth[0] + truth[2], truth[1] + truth[3], 0.94 * truth[2], 0.94 * truth[3]])
        dist = np.hypot(*truth[:2]) + rng.normal() * (0.2 + 0.02 * np.hypot(*truth[:2]))
        angle = np.degrees(np.arctan2(truth[1], truth[0])) + rng.normal() * 2.0
        away = np.hypot(x[0], x[1])
        w = stats.norm.pdf(dist, away, 0.2 + 0.02 * away) * stats.norm.pdf(angle, np.degrees(np.arctan2(x[1], x[0])), 2.0)
        total += np.log(w.mean())
        w /= w.sum()
        answer = filter.step({"a.dist": dist, "a.dir": angle})
        for k, name in enumerate(("x", "y", "vx", "vy")):
            mean = w @ x[k]
            spread = np.sqrt(w @ (x[k] - mean) ** 2)
            assert abs(answer.read(f"a.{name}")[0] - mean) < 0.35 * spread
            assert abs(answer.read(f"a.{name}", "deviation")[0] / spread - 1.0) < 0.2
        x = x[:, rng.choice(count, count, p=w)]
    assert abs(answer.log_likelihood[0] - total) < 0.5


def test_first_look_from_nowhere_finds_the_place():
    """Direction and distance bend far over a wide prior: both are taken again where they lead to together."""
    ball = PRMClass(
        "B",
        attributes=(
            Attribute("x", Real("m"), Noise("15", sd=15.0)),
            Attribute("y", Real("m"), Noise("0", sd=15.0)),
            Attribute("dir", Angle("deg"), Noise("degrees(atan2(y, x))", sd=1.0), ("x", "y")),
            Attribute("dist", Real("m"), Noise("hypot(x, y)", sd=0.3), ("x", "y")),
        ),
    )
    rng = np.random.default_rng(8)
    for dist, angle in ((14.2, 31.0), (9.0, -100.0), (30.0, 5.0), (22.0, 60.0)):
        answer = Filter(world(ball), engine="mixture").step({"a.dist": dist, "a.dir": angle})
        r, a = rng.normal(dist, 0.3, 100_000), np.radians(rng.normal(angle, 1.0, 100_000))
        x, y = r * np.cos(a), r * np.sin(a)
        w = stats.norm.pdf(x, 15, 15) * stats.norm.pdf(y, 0, 15) * r  # by importance; r: a ring has the more room the farther
        mean, cov = answer.moments("a.x", "a.y")
        np.testing.assert_allclose(mean[0], [np.average(x, weights=w), np.average(y, weights=w)], atol=0.05)
        np.testing.assert_allclose(cov[0], np.cov(x, y, aweights=w), atol=0.02)


def test_rooms_of_the_kernels_are_never_read_before_they_are_written():
    filter = Filter(world(polar()), engine="mixture")
    other = Filter(world(polar()), engine="mixture")
    for reading in ({"a.dist": 9.0, "a.dir": 20.0}, {"a.dist": 8.5}, {}, {"a.dir": Interval(20.0, 30.0)}):
        a = filter.step(reading).moments("a.x", "a.vy")
        for rooms in other.engine._scratch.values():
            for array in rooms:
                array.fill(np.nan if array.dtype.kind == "f" else -99)
        b = other.step(reading).moments("a.x", "a.vy")
        np.testing.assert_array_equal(a[0], b[0])
        np.testing.assert_array_equal(a[1], b[1])


def test_angles_go_round():
    compass = PRMClass(
        "C",
        given=(Given("turned", Real("deg"), default=0.0),),
        attributes=(
            Attribute("dir", Angle("deg"), Noise("prev.dir + turned", sd=1.0), ("prev.dir", "turned"), initial=Noise("178", sd=2.0)),
            Attribute("seen", Angle("deg"), Noise("dir", sd=2.0), ("dir",)),
        ),
    )
    filter = Filter(world(compass), engine="mixture")
    answer = filter.step({"a.seen": -178.0})
    assert abs(abs(answer.read("a.dir")[0]) - 180.0) < 1e-9
    answer = filter.step({"a.turned": 20.0})
    close(answer.read("a.dir")[0], -160.0)
    close(answer.read("a.dir", "probability(170..-150)")[0], 1.0, 1e-3)
    assert answer.read("a.dir", "resultant")[0] > 0.99
    answer = filter.step({"a.turned": -20.0, "a.seen": Interval(175.0, -175.0)})
    assert abs(answer.read("a.dir")[0]) > 179.0


def test_outliers_are_recognised():
    robust = PRMClass(
        "R",
        attributes=(
            Attribute("x", Real("m", low=-50.0, high=50.0), Noise("prev.x", sd=0.1), ("prev.x",), initial=Uniform()),
            Attribute("z", Real("m", low=-50.0, high=50.0), Mixture((0.9, Noise("x", sd=0.3)), (0.1, Uniform())), ("x",)),
        ),
    )
    filter = Filter(world(robust), engine="mixture")
    for z in (1.0, 1.2, 0.9, 1.1, 30.0, 1.0):
        answer = filter.step({"a.z": z})
        assert abs(answer.read("a.x")[0] - 1.0) < 0.35 or z == 1.0
    assert answer.read("a.x", "deviation")[0] < 0.3


def followed():
    """A ball that rolls, or is with whoever possesses it."""
    thing = PRMClass(
        "Thing", abstract=True,
        attributes=(
            Attribute("x", Real("m"), Noise("prev.x", sd=0.5), ("prev.x",), initial=Noise("0", sd=3.0)),
            Attribute("z", Real("m"), Noise("x", sd=0.4), ("x",)),
        ),
    )  # fmt: skip
    held = Relation("held", {"o": "Man", "b": "Ball"}, changes=(Replace("b.x", ("o.x",), Noise("o.x", sd=0.2)),), conflict="mixture")
    return thing, PRMClass("Man", extends="Thing"), PRMClass("Ball", extends="Thing"), held


def dense(steps):
    """Kalman filter of ball and two men; each step says who holds the ball and what was read."""
    m, p = np.zeros(3), 9.0 * np.eye(3)
    for t, (holder, readings) in enumerate(steps):
        f, q = np.eye(3), 0.25 * np.eye(3)
        if t:
            m, p = f @ m, p + q
        if holder is not None:
            g = np.eye(3)
            g[0] = 0.0
            g[0, holder] = 1.0
            m, p = g @ m, g @ p @ g.T + np.diag([0.04, 0.0, 0.0])
        for k, z in readings.items():
            s = p[k, k] + 0.16
            gain = p[:, k] / s
            m, p = m + gain * (z - m[k]), p - np.outer(gain, p[k])
    return m, p


def test_relations_switch_what_hangs_together():
    thing, man, ball, held = followed()
    filter = Filter(world(thing, man, ball, relations=(held,), ball="Ball", o1="Man", o2="Man"), engine="mixture")
    steps = [
        (None, {0: 1.0, 1: 2.0}),
        (None, {1: 2.5}),
        (1, {1: 3.0}),
        (1, {2: -1.0}),
        (None, {1: 3.5}),
        (2, {0: -0.8}),
        (None, {0: -0.5, 1: 4.0}),
    ]
    names = ("ball", "o1", "o2")
    for k, (holder, readings) in enumerate(steps):
        relations = () if holder is None else (f"held({names[holder]},ball)",)
        answer = filter.step({f"{names[i]}.z": z for i, z in readings.items()}, relations)
        m, p = dense(steps[: k + 1])
        mean, cov = answer.moments("ball.x", "o1.x", "o2.x")
        close(mean[0], m)
        close(cov[0], p)


def test_selector_tells_who_has_the_ball():
    thing, man, ball, held = followed()
    filter = Filter(world(thing, man, ball, relations=(held,), ball="Ball", o1="Man", o2="Man"), engine="mixture")
    filter.step({"o1.z": 5.0, "o2.z": -5.0})
    answer = filter.step({"ball.z": 4.8, "o1.z": 5.0, "o2.z": -5.0}, ("held(o1,ball)", "held(o2,ball)"))
    assert answer["ball.selector"][0, 0] > 0.99
    assert abs(answer.read("ball.x")[0] - 4.9) < 0.3


def test_late_reading_tells_of_the_slice_before():
    late = PRMClass(
        "L",
        given=(Given("late", BOOL, default="no"),),
        attributes=(
            Attribute("x", Real(), Noise("0.5 * prev.x", sd=0.5), ("prev.x",), initial=Noise("0", sd=2.0)),
            Attribute(
                "z", Real(), Switch("late", {"yes": Noise("prev.x", sd=0.1), "no": Noise("x", sd=0.1)}), ("x", "prev.x", "late"),
                initial=Noise("x", sd=0.1), initial_parents=("x",),
            ),
        ),
    )  # fmt: skip
    filter = Filter(world(late), engine="mixture")
    filter.step({})
    answer = filter.step({"a.z": 3.0, "a.late": "yes"})
    gain = 4.0 / 4.01
    close(answer.read("a.x")[0], 0.5 * gain * 3.0)
    close(answer.read("a.x", "variance")[0], 0.25 * 4.0 * (1 - gain) + 0.25)


def test_a_reading_between_slices_counts_at_its_time():
    """A walk, read some way before the slice: as a filter has it that takes ten steps for each of the slices."""
    walk = PRMClass(
        "W",
        given=(Given("ago", Real(), default=0.0),),
        attributes=(
            Attribute("x", Real("m"), Noise("prev.x", sd=0.5), ("prev.x",), initial=Noise("0", sd=2.0)),
            Attribute(
                "z", Real("m"), Noise("x + ago * (prev.x - x)", sd="hypot(0.3, 0.5 * sqrt(ago * (1 - ago)))"), ("x", "prev.x", "ago"),
                initial=Noise("x", sd=0.3), initial_parents=("x",),
            ),
        ),
    )  # fmt: skip
    filter = Filter(world(walk), engine="mixture")
    m, p = 0.0, 4.0
    for t, (ago, z) in enumerate(((0, 1.0), (3, 1.4), (10, 0.2), (9, 0.6), (0, -0.5))):  # tenths of a slice
        for tenth in range(11) if t else (10,):  # the end of the slice before, and each tenth after it
            p += 0.025 if t and tenth else 0.0
            if tenth == 10 - ago:
                gain = p / (p + 0.09)
                m, p = m + gain * (z - m), p - gain * p
        answer = filter.step({"a.z": z, "a.ago": ago / 10})
        close(answer.read("a.x")[0], m)
        close(answer.read("a.x", "variance")[0], p)


def test_objects_enter_and_leave():
    filter = Filter(world(tracked(), a="P", b="P"), engine="mixture")
    filter.step({"a.z": 1.0}, objects=("a",))
    answer = filter.step({"a.z": 1.0, "b.z": 4.0}, objects=("a", "b"))
    close(answer.read("b.x")[0], kalman([4.0])[0][0][0][0])
    answer = filter.step({"b.z": 4.0}, objects=("b",))
    assert "a.x" not in answer


def test_agents_are_alone_in_the_batch_and_begin_anew():
    readings = np.random.default_rng(6).normal(size=(5, 3))
    together = Filter(world(switching()), batch=3, engine="mixture", components=4)
    alone = [Filter(world(switching()), engine="mixture", components=4) for _ in range(3)]
    for t in range(5):
        if t == 3:
            together.reset([1])
            alone[1].reset()
        answer = together.step({"a.z": readings[t]})
        for k, other in enumerate(alone):
            own = other.step({"a.z": readings[t, k]})
            np.testing.assert_array_equal(answer.read("a.x")[k], own.read("a.x")[0])
            np.testing.assert_array_equal(answer.log_likelihood[k], own.log_likelihood[0])


def test_samples_have_the_moments_of_the_belief():
    filter = Filter(world(tracked()), engine="mixture")
    filter.step({"a.z": 2.0})
    answer = filter.step({"a.z": 2.0})
    drawn = filter.sample(20_000, seed=1)
    mean, cov = answer.moments("a.x", "a.v")
    np.testing.assert_allclose(np.cov(drawn["a.x"][0], drawn["a.v"][0]), cov[0], atol=0.03)
    np.testing.assert_allclose([drawn["a.x"].mean(), drawn["a.v"].mean()], mean[0], atol=0.03)


# ----------------------------------------------------------------------------------------------------- what cannot be


@pytest.mark.parametrize("value", [np.inf, -np.inf, "near", True, Interval(3.0, 1.0), Interval(np.nan, 1.0), [1.0, 2.0]])
@pytest.mark.parametrize("engine", ["mixture", "rao-blackwell"])
def test_what_is_no_reading_is_refused_by_name(engine, value):
    filter = Filter(world(tracked()), engine=engine)
    with pytest.raises(EvidenceError, match=r"evidence for 'a\.z'"):
        filter.step({"a.z": value})
    assert filter.step_count == 0


@pytest.mark.parametrize("value", [None, np.nan, np.ma.masked_array([1.0], [True]), Interval(np.nan, np.nan)])
@pytest.mark.parametrize("engine", ["mixture", "rao-blackwell"])
def test_nothing_read_is_nothing_learned(engine, value):
    answer = Filter(world(tracked()), engine=engine).step({"a.z": value})
    close(answer.read("a.x")[0], 1.0)
    assert answer.log_likelihood[0] == 0.0


def known():
    return PRMClass(
        "K",
        attributes=(
            Attribute("x", Real(), Noise("prev.x", sd=0.0), ("prev.x",), initial=Noise("0", sd=1.0)),
            Attribute("z", Real(), Noise("x", sd=0.0), ("x",)),
            Attribute("y", Real(), Noise("x", sd=0.0), ("x",)),
        ),
    )


@pytest.mark.parametrize("engine", ["mixture", "rao-blackwell"])
def test_readings_that_coincide_are_one_and_those_that_contradict_are_impossible(engine):
    filter = Filter(world(known()), engine=engine)
    answer = filter.step({"a.z": 0.7, "a.y": 0.7})
    assert np.isfinite(answer.log_likelihood[0])
    close(answer.read("a.x")[0], 0.7)
    with pytest.raises(ImpossibleEvidence, match=r"0\.9") as told:
        filter.step({"a.z": 0.7, "a.y": 0.9})
    assert told.value.conflict == ("a.y",)
    assert filter.step_count == 1


@pytest.mark.parametrize("policy", ["drop", "soften", "restart"])
@pytest.mark.parametrize("engine", ["mixture", "rao-blackwell"])
def test_policies_for_the_impossible_leave_no_nan(engine, policy):
    filter = Filter(world(known()), batch=2, engine=engine, on_impossible=policy)
    filter.step({"a.z": np.array([0.7, 0.2])})
    answer = filter.step({"a.z": np.array([0.9, 0.2])})
    assert answer.impossible.tolist() == [True, False]
    close(answer.read("a.x"), [0.9 if policy == "restart" else 0.7, 0.2])
    assert np.isfinite(answer.log_likelihood).all()


def test_reading_beyond_all_reason_is_unlikely_and_no_more():
    answer = Filter(world(tracked()), engine="mixture").step({"a.z": 1e8})
    assert np.isfinite(answer.log_likelihood[0])
    assert np.isfinite(answer.read("a.x")[0])


def test_formula_without_a_value_is_told():
    odd = PRMClass("O", attributes=(Attribute("x", Real(), Noise("-1", sd=0.1)), Attribute("z", Real(), Noise("log(x)", sd=0.1), ("x",))))
    with pytest.raises(ModelError, match=r"'log\(x\) with sd 0.1' has no finite value"):
        Filter(world(odd), engine="mixture").step({"a.z": 1.0})
    chance = PRMClass("O", attributes=(Attribute("x", Real(), Noise("3", sd=0.1)), Attribute("f", BOOL, Chance("x"), ("x",))))
    with pytest.raises(ModelError, match="gives no probability"):
        Filter(world(chance), engine="mixture").step({"a.f": "yes"})


@pytest.mark.parametrize(
    ("attribute", "message"),
    [
        (Attribute("x", Real(), Uniform()), "Uniform needs limits"),
        (Attribute("x", Real(), Chance("0.5")), "a real number takes Noise"),
        (Attribute("x", Real(), Noise("w", sd=1.0)), "'w' is not a parent"),
        (Attribute("x", Real(), Switch("z", {"*": Noise("0", sd=1.0)}), ("z",)), "a switch turns on states"),
    ],
)
def test_models_without_meaning_are_refused_by_name(attribute, message):
    with pytest.raises(ModelError, match=message):
        Model("m", (PRMClass("C", attributes=(Attribute("z", Real(), Noise("0", sd=1.0)), attribute)),))


def test_what_needs_states_is_refused_of_numbers_by_name():
    filter = Filter(world(tracked()), engine="mixture")
    filter.step({"a.z": 1.0})
    with pytest.raises(EvidenceError, match=r"jeffrey: 'a\.x' is a real number"):
        filter.jeffrey({"a.x": [0.5, 0.5]})
    with pytest.raises(EvidenceError, match=r"soft evidence for 'a\.x'"):
        filter.step({}, soft={"a.x": [1.0, 2.0]})


def test_exact_engine_asks_for_bins():
    with pytest.raises(ModelError, match=r"attribute|'x': a Real without bins"):
        Filter(world(tracked()))


@pytest.mark.parametrize("steps", [5_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_long_runs_do_not_drift(steps):
    """The covariance at last is that of Riccati's fixed point, and the belief has not grown.

    Long: ``pytest -m slow tests/architecture/prm/inference/engines/test_mixture.py -k drift``.
    """
    filter = Filter(world(tracked()), engine="mixture")
    p = SPREAD
    for t in range(400):
        p = F @ p @ F.T + Q if t else p
        p = p - np.outer(p[:, 0], p[0]) / (p[0, 0] + 0.25)
    rng = np.random.default_rng(7)
    for _ in range(steps):
        answer = filter.step({"a.z": float(rng.normal())})
    close(answer.moments("a.x", "a.v")[1][0], p, 1e-9)
    assert filter.state.belief.groups[0].log_weights.shape == (1, 1)


def test_normals_of_a_posterior_are_told():
    filter = Filter(world(switching()), engine="mixture", components=8)
    for z in (0.5, -1.0, 0.2):
        answer = filter.step({"a.z": z})
    weights, means, covs = answer.components("a.x")
    close(weights.sum(), 1.0)
    close((weights * means[..., 0]).sum(), answer.read("a.x")[0])
    assert covs.shape == (1, 8, 1, 1)
    with pytest.raises(ModelError, match=r"real numbers of the slice, got 'a\.mode'"):
        answer.components("a.mode")
