"""The most probable explanation assigns what was declared, and sums out the rest: against enumeration."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from inference_worlds import table, unrolled_joint

from cprm_gym.architecture.prm import (
    BOOL,
    AnyCause,
    Attribute,
    BayesNet,
    Bins,
    Count,
    Filter,
    Grounding,
    Index,
    Max,
    Model,
    PRMClass,
    Reference,
    Relation,
    Replace,
    Table,
    load_bif,
    save_bif,
)
from cprm_gym.architecture.prm.grounding.slices import GroundCPD, Grounds, GroundSlice, GroundVariable

THEM = (Reference("as_", "A", many=True),)


def rows(rng, states=("no", "yes")):
    """A table of one binary parent."""
    found = {}
    for s in states:
        p = float(rng.uniform(0.05, 0.95))
        found[s] = (1.0 - p, p)
    return Table(found)


def explanations(ground, evidence):
    """Declared variables without evidence, and the probability of each of their joint values and the evidence."""
    names = [n for n, v in ground.variables.items() if not v.auxiliary and n not in evidence]
    joint = unrolled_joint([ground], [evidence], [{}], [(n, 0) for n in names])
    return names, joint


def check(ground, evidence):
    values, log_value = BayesNet(ground).most_probable({n: Index(v) for n, v in evidence.items()})
    names, joint = explanations(ground, evidence)
    assert set(values) == {*names, *evidence}
    assert np.exp(log_value[0]) == pytest.approx(joint.max(), rel=1e-12)
    assert joint[tuple(int(values[n].value[0]) for n in names)] == pytest.approx(joint.max(), rel=1e-12)
    return values


def judged_by(aggregate, seed):
    rng = np.random.default_rng(seed)
    p = float(rng.uniform(0.2, 0.8))
    one = PRMClass("A", (Attribute("on", BOOL, (1.0 - p, p)),))
    judge = PRMClass("B", (Attribute("alarm", BOOL, rows(rng), parents=(aggregate,)),), references=THEM)
    return Grounding(Model("m", (one, judge)), {"a0": "A", "a1": "A", "a2": "A", "b": "B"}).ground((), first=True)


@pytest.mark.parametrize("seed", range(8))
def test_the_noise_of_an_aggregate_is_summed_out(seed):
    """It was maximised over, and the explanation was not the most probable one."""
    ground = judged_by(AnyCause("as_.on", strength=0.5, leak=0.2), seed)
    assert any(v.auxiliary for v in ground.variables.values())
    for evidence in ({}, {"b.alarm": 1}, {"b.alarm": 0, "a1.on": 1}):
        check(ground, evidence)


@pytest.mark.parametrize("seed", range(4))
def test_an_aggregate_that_is_determined_changes_nothing(seed):
    check(judged_by(Max("as_.on"), seed), {"b.alarm": 1})


def test_a_long_chain_of_a_count_stays_cheap():
    """Summed out it would link all thirty objects: 2^30 cells."""
    one = PRMClass("A", (Attribute("on", BOOL, (0.6, 0.4)),))
    several = Count("as_.on", "yes", at_most=3)
    judge = PRMClass(
        "B",
        (Attribute("n", BOOL, Table({"3+": (0.01, 0.99), "*": (0.9, 0.1)}), (several,)),),
        references=THEM,
    )
    ground = Grounding(Model("m", (one, judge)), {**{f"a{k}": "A" for k in range(30)}, "b": "B"}).ground((), first=True)
    values, log_value = BayesNet(ground).most_probable({"b.n": 1})
    assert sum(int(values[f"a{k}.on"].value[0]) for k in range(30)) == 3
    assert log_value[0] == pytest.approx(27 * np.log(0.6) + 3 * np.log(0.4) + np.log(0.99))


@pytest.mark.parametrize("seed", range(8))
def test_who_selects_among_relations_is_summed_out(seed):
    rng = np.random.default_rng(seed)
    flag = Attribute("x", BOOL, tuple(rng.dirichlet((1, 1))))
    held = Relation("held", {"o": "Opp", "b": "Ball"}, (Replace("b.x", ("o.x",), rows(rng)),), conflict="mixture")
    model = Model("m", (PRMClass("Ball", (flag,)), PRMClass("Opp", (flag,))), (held,))
    grounding = Grounding(model, {"ball": "Ball", **{f"o{k}": "Opp" for k in range(3)}})
    values = check(grounding.ground(["held(o0,ball)", "held(o1,ball)", "held(o2,ball)"], first=True), {"ball.x": 1})
    assert "ball.selector" not in values


def test_an_explanation_with_bins_is_evidence_again():
    """The numbers of its bins were taken for quantities."""
    place = Attribute("place", Bins.linear(0, 30, 6), (0.1, 0.1, 0.1, 0.1, 0.5, 0.1))
    grounding = Grounding(Model("m", (PRMClass("A", (place,)),)), {"a": "A"})
    net = BayesNet(grounding.ground((), first=True))
    values, log_value = net.most_probable()
    assert int(values["a.place"].value[0]) == 4
    assert net.query(values).log_evidence[0] == pytest.approx(log_value[0])
    filter_ = Filter(grounding, window=1)
    filter_.step({})
    (path,) = filter_.most_probable_path()
    assert Filter(grounding).step(path)["a.place"][0, 4] == 1.0


def test_a_bif_file_keeps_who_was_not_declared(tmp_path):
    ground = judged_by(AnyCause("as_.on", strength=0.5), 0)
    save_bif(ground, tmp_path / "net.bif")
    again = load_bif(tmp_path / "net.bif")
    assert {n for n, v in again.variables.items() if v.auxiliary} == {n for n, v in ground.variables.items() if v.auxiliary} != set()


class Chain(Grounds):
    """A hidden chain and its readings."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        self.prior, self.move, self.sense = table(rng, (3,)), table(rng, (3, 3)), table(rng, (3, 4))
        names = {"x": GroundVariable("x", tuple("012")), "y": GroundVariable("y", tuple("0123"))}
        reading = GroundCPD("y", (("x", 0),), self.sense, "sense")
        self.slices = {
            True: GroundSlice(names, (GroundCPD("x", (), self.prior, "prior"), reading)),
            False: GroundSlice(names, (GroundCPD("x", (("x", 1),), self.move, "move"), reading)),
        }

    def ground(self, relations=(), first=False):
        return self.slices[first]


@pytest.mark.parametrize("seed", range(12))
def test_a_path_sums_out_what_was_before_the_window(seed):
    """The slice before the window was maximised over as well."""
    world, readings = Chain(seed), (2, 0, 3, 1)
    filter_ = Filter(world, window=2)
    for y in readings:
        filter_.step({"y": y})
    totals = {}
    for path in itertools.product(range(3), repeat=4):
        p = world.prior[path[0]] * np.prod([world.move[a, b] for a, b in itertools.pairwise(path)])
        totals[path[2:]] = totals.get(path[2:], 0.0) + p * np.prod([world.sense[x, y] for x, y in zip(path, readings)])
    found = tuple(int(values["x"].value[0]) for values in filter_.most_probable_path())
    assert found == max(totals, key=totals.__getitem__)


@pytest.mark.parametrize("seed", range(6))
def test_a_path_sums_out_an_aggregate_of_the_slice_before_the_window(seed):
    rng = np.random.default_rng(seed)
    moving = PRMClass("A", (Attribute("on", BOOL, rows(rng), parents=("prev.on",), initial=(0.5, 0.5)),))
    judge = PRMClass("B", (Attribute("alarm", BOOL, rows(rng), parents=(Max("prev.as_.on"),)),), references=THEM)
    grounding = Grounding(Model("m", (moving, judge)), {"x0": "A", "x1": "A", "y": "B"})
    filter_ = Filter(grounding, window=1)
    alarms = (0, 1, 1)
    for alarm in alarms:
        filter_.step({"y.alarm": alarm})
    (path,) = filter_.most_probable_path()
    slices = [grounding.ground((), first=True)] + [grounding.ground(())] * 2
    joint = unrolled_joint(slices, [{"y.alarm": a} for a in alarms], [{}] * 3, [("x0.on", 2), ("x1.on", 2)])
    assert joint[path["x0.on"].value[0], path["x1.on"].value[0]] == pytest.approx(joint.max(), rel=1e-12)
    assert all(not filter_.settings.grounding.ground(()).variables[n].auxiliary for n in path)
