"""Expressions over the cycles of a run, and what would be true."""

import pytest

from cprm_gym.errors import ParameterError
from cprm_gym.studio.running.setup import Setup
from cprm_gym.studio.watching.curves import Curves, true_value
from cprm_gym.studio.watching.session import Session


@pytest.fixture
def session():
    made = Session(lambda *args, **kwargs: None, Setup("Goalie", seed=2))
    made.open()
    yield made
    made.close()


def told(session, *what, cycles=200):
    curves = Curves(session)
    return curves, curves.curves("left_1", list(what), cycles)


def test_past_cycles_are_filled_in_as_they_were(session):
    before = Curves(session)
    before.curves("left_1", ["E(ball.x)", "P(ball.x < -45)", "clock(drop)"])
    session.step(30)
    live = [session.frames[c]["curves"]["left_1"] for c in range(31)]
    stood, actions = session.run.core.sim.world.copy(), str(session.run.actions)
    for c in range(31):
        del session.frames[c]["curves"]
    again = before.curves("left_1", list(live[0]))
    assert again["cycles"] == list(range(31))
    assert again["values"] == {text: [of[text] for of in live] for text in live[0]}
    assert len({value for value, _ in again["values"]["E(ball.x)"]}) > 10
    assert (session.run.core.sim.world == stood).all()
    assert str(session.run.actions) == actions
    assert session.run.cycle == 30


def test_the_true_value_is_that_of_the_world(session):
    session.step(10)
    _, answer = told(session, "E(ball.x)", "2 * E(o1.y) + 1", "P(ball.x < -45)", "ball_x", "E(ball.x) + save.ongoing", cycles=5)
    worlds = [session.frames[c]["world"] for c in answer["cycles"]]
    assert len(worlds) == 5
    shooters = [next(p for p in world["players"] if p[0] == 12) for world in worlds]
    side = float(session.run.core.sides[0])
    truth = {text: [true for _, true in values] for text, values in answer["values"].items()}
    assert truth["E(ball.x)"] == pytest.approx([side * w["ball"][0] for w in worlds], abs=0.01)
    assert truth["ball_x"] == truth["E(ball.x)"]
    assert truth["2 * E(o1.y) + 1"] == pytest.approx([2 * side * p[2] + 1 for p in shooters], abs=0.02)
    assert truth["P(ball.x < -45)"] == [float(x < -45) for x in truth["E(ball.x)"]]
    assert truth["E(ball.x) + save.ongoing"] == [None] * 5
    assert true_value(session.run, 0, "cycle") is None


def test_what_is_no_expression_is_told_and_the_others_are_drawn(session):
    curves, answer = told(session, "E(ball.x)", "nix", "P(ball.x")
    assert list(answer["values"]) == ["E(ball.x)"]
    assert "'nix' is neither a percept nor a place" in answer["wrong"]["nix"]
    assert "P(ball.x" in answer["wrong"]
    with pytest.raises(ParameterError, match="at most 6"):
        curves.curves("left_1", [f"cycle + {k}" for k in range(7)])
    with pytest.raises(ParameterError, match="cycles: 1 to 6000"):
        curves.curves("left_1", [], 0)


def test_what_comes_after_a_cycle_gone_back_to_is_forgotten(session):
    curves, _ = told(session, "E(ball.x)")
    session.step(10)
    session.go(4)
    assert curves.curves("left_1", ["E(ball.x)"])["cycles"] == [0, 1, 2, 3, 4]
