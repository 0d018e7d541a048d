"""What a user does with a model of real numbers: views, a look ahead and back, banks, files, drawings; and what is refused by name."""

import numpy as np
import pytest

from cprm_gym.architecture.prm import (
    BOOL,
    Angle,
    Attribute,
    Chance,
    DeepFilter,
    Filter,
    FilterBank,
    Grounding,
    Link,
    Mixture,
    Model,
    Noise,
    PRMClass,
    Real,
    Relation,
    Replace,
    Role,
    Switch,
    Table,
    Uniform,
    View,
    class_diagram_svg,
    ground_net_svg,
    load_model,
    save_model,
    to_bif,
)  # fmt: skip
from cprm_gym.architecture.prm.inference.engines.mixture import MixtureEngine
from cprm_gym.architecture.prm.inference.engines.rao_blackwell import RaoBlackwellEngine
from cprm_gym.errors import ModelError, ParameterError

BALL = PRMClass("Ball", attributes=(
    Attribute("x", Real("m"), Noise("prev.x + prev.vx", sd=0.05), ("prev.x", "prev.vx"), initial=Noise("15", sd=15)),
    Attribute("vx", Real("m/step"), Noise("0.94 * prev.vx", sd=0.1), ("prev.vx",), initial=Noise("0", sd=0.5)),
    Attribute("dir", Angle("deg"), Noise("degrees(atan2(1, x))", sd=1), ("x",)),
    Attribute("dist", Real("m", low=0, high=100), Mixture((0.98, Noise("abs(x)", sd=0.3)), (0.02, Uniform())), ("x",)),
    Attribute("near", BOOL, Chance("1 if x < 10 else 0"), ("x",)),
))  # fmt: skip
MODEL = Model("one ball", (BALL, PRMClass("Opponent", extends="Ball")), (
    Relation("has", {"o": "Opponent", "b": "Ball"}, changes=(Replace("b.x", ("o.x",), Noise("o.x", sd=0.3)),)),
    Relation("held", {"o": "Opponent"}, changes=(Replace("o.vx", ("prev.o.vx",), Noise("0.5 * prev.o.vx", sd=0.2)),)),
))  # fmt: skip
WORLD = Grounding(MODEL, {"ball": "Ball", "o1": "Opponent", "o2": "Opponent"})


@pytest.mark.parametrize("engine", ["mixture", "rao-blackwell"])
def test_views_agree_with_each_other_now_ahead_and_back(engine):
    filter = Filter(WORLD, batch=2, engine=engine, window=4)
    for dist in (14.0, 13.0, 12.5):
        seen = filter.step({"ball.dist": dist, "ball.dir": 4.0}, relations=["has(o1,ball)"] if dist < 13 else [])
    mean, low, high = (seen.read("ball.x", view) for view in ("expectation", "quantile(0.1)", "quantile(0.9)"))
    assert (low < mean).all()
    assert (mean < high).all()
    for value in (float(low[0]), float(high[0])):
        below, above = (seen.read("ball.x", f"probability({interval})")[0] for interval in (f"..{value!r}", f"{value!r}.."))
        assert below + above == pytest.approx(1.0)
    np.testing.assert_allclose(seen.read("ball.x", "deviation") ** 2, seen.read("ball.x", "variance"))
    assert seen.read("ball.x", f"probability(..{float(low[0])!r})")[0] == pytest.approx(0.1, abs=1e-9)
    ahead = filter.predict(3)
    assert (ahead.read("ball.x", "deviation") > seen.read("ball.x", "deviation")).all()
    assert abs(filter.smooth()[0]["ball.x"].expectation()[0] - 14.0) < 0.6
    assert filter.sample(5, 1)["ball.x"].shape == (2, 5)


@pytest.mark.parametrize("engine", ["mixture", "rao-blackwell"])
def test_agents_who_mean_different_opponents_share_a_bank(engine):
    bank = FilterBank(WORLD, batch=3, engine=engine, seed=1)
    whom = Role("Opponent", np.array([0, 1, 1]))
    for _ in range(4):
        bank.step({"o1.dist": np.array([3.0, 4.0, 5.0]), "o2.dist": np.array([26.0, 17.0, 18.0])}, [Link("held", (whom,))])
    np.testing.assert_allclose(np.abs(bank.view_of(View.parse("expectation"), whom, "x"))[1:], [17.0, 18.0], atol=1.0)


@pytest.mark.parametrize("quick", [MixtureEngine(components=1), RaoBlackwellEngine(particles=2, seed=1)])
def test_frequent_simple_inference_goes_on_from_occasional_deep(quick):
    """One normal or two, and in every fourth step all sequences of modes, which tell what they would have told alone."""
    gait = PRMClass("Man", attributes=(
        Attribute("runs", BOOL, Table({("no",): (0.8, 0.2), ("yes",): (0.3, 0.7)}), ("prev.runs",), initial=(0.6, 0.4)),
        Attribute("x", Real("m"), Switch("runs", {"no": Noise("prev.x", sd=0.1), "yes": Noise("prev.x + 0.5", sd=0.3)}),
                  ("prev.x", "runs"), initial=Noise("0", sd=1)),
        Attribute("z", Real("m"), Noise("x", sd=0.4), ("x",)),
    ))  # fmt: skip
    world = Grounding(Model("gait", (gait,)), {"a": "Man"})
    all_of_them = MixtureEngine(components=256, merge=0.0)
    both = DeepFilter(world, engine=quick, deep=all_of_them, every=4)
    alone, simple = Filter(world, engine=all_of_them), Filter(world, engine=quick)
    off = []
    for t, z in enumerate((0.1, 0.3, 0.9, 1.2, 2.0, 1.9, 2.3, 2.2)):
        answers = [filter.step({"a.z": z}) for filter in (both, alone, simple)]
        found, expected, plain = (answer.read("a.x")[0] for answer in answers)
        if t % 4 == 3:
            assert found == pytest.approx(expected, abs=1e-9)
        off.append((abs(found - expected), abs(plain - expected)))
    assert 0.0 < off[4][0] < off[4][1]
    with pytest.raises(ParameterError, match="'mixture' keeps real numbers"):
        DeepFilter(world, engine="mixture", deep="exact")


def test_files_and_drawings_know_them_and_bif_refuses_them_by_name(tmp_path):
    save_model(MODEL, tmp_path / "model.json")
    assert load_model(tmp_path / "model.json") == MODEL
    assert "vx" in class_diagram_svg(MODEL)
    assert "vx" in ground_net_svg(WORLD.ground(["has(o1,ball)"]))
    with pytest.raises(ModelError, match=r"BIF has states only: 'ball\.x'"):
        to_bif(WORLD.ground(first=True))


@pytest.mark.parametrize(("name", "view", "message"), [("ball.x", "resultant", "only an angle"), ("ball.dir", "quantile(0.5)", "no order"),
                                                       ("ball.x", "probability(yes)", "no states")])  # fmt: skip
def test_views_without_meaning_are_refused_by_name(name, view, message):
    answer = Filter(WORLD, engine="mixture").step({"ball.dist": 14.0})
    with pytest.raises(ModelError, match=message):
        answer.read(name, view)
