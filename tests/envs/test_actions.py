"""Action views: what they mean, and what they refuse."""

import numpy as np
import pytest

from cprm_gym.envs.actions import NO_COMMAND, SAY_CHARACTERS, action_view, scaled
from cprm_gym.errors import CommandError, UnknownName
from cprm_gym.simulator.state import COMMAND, CommandKind


def commands(view, action, shape=(1, 1)):
    out = np.zeros(shape, COMMAND)
    action_view(view).commands(action, out)
    return out


def hybrid(**changes):
    action = {"type": np.array([[1]]), "params": np.array([[[0.8, 0.05, 0.0, 0.0]]])}
    return {**action, **changes}


def test_hybrid_action_is_the_command_itself():
    out = commands("hybrid", hybrid(turn_neck=np.array([[[0.25]]]), view=np.array([[2]])))[0, 0]
    assert (out["kind"], out["a"], out["b"], out["turn_neck"], out["view_width"]) == (CommandKind.DASH, 80.0, 9.0, 45.0, 2)
    assert np.isnan(out["point"]).all()
    assert out["say_length"] == 0


def test_side_commands_are_said_attended_and_pointed():
    word = np.zeros((1, 1, 10), int)
    word[0, 0, :2] = [SAY_CHARACTERS.index(c) + 1 for c in "Go"]
    out = commands("full", hybrid(say=word, attention=np.array([[14]]), point=np.array([[[1.0, 0.5, -0.5]]])))[0, 0]
    assert out["say_length"] == 2
    assert bytes(out["say"][:2]) == b"Go"
    assert (out["attention_side"], out["attention_unum"]) == (2, 3)
    assert out["point"].tolist() == [30.0, -90.0]
    quiet = commands("full", hybrid(say=0 * word, attention=np.array([[23]]), point=np.array([[[-1.0, 0.5, 0.5]]])))[0, 0]
    assert (quiet["say_length"], quiet["attention_side"]) == (0, 3)
    assert np.isnan(quiet["point"]).all()
    with pytest.raises(CommandError, match=r"'attention': entry \(0, 0\) is 24; allowed is 0 to 23"):
        commands("full", hybrid(attention=np.array([[24]])))
    with pytest.raises(CommandError, match=r"'point': entry .* is nan; allowed are finite numbers from -1 to 1"):
        commands("full", hybrid(point=np.full((1, 1, 3), np.nan)))


def test_discrete_action_chooses_from_the_listed_values():
    out = commands("discrete", np.array([[[3, 4, 11, 1]]]))[0, 0]
    assert (out["kind"], out["a"], out["b"], out["turn_neck"]) == (CommandKind.KICK, 100.0, 0.0, -60.0)
    turn = commands("discrete", np.array([[[2, 0, 17, 0]]]))[0, 0]
    assert (turn["kind"], turn["a"]) == (CommandKind.TURN, 90.0)
    assert np.isnan(turn["turn_neck"])


def test_box_action_does_the_preferred_command():
    out = commands("box", np.array([[[0.1, 0.9, -0.3, 1.0, 0.5, 0.0]]]))[0, 0]
    assert (out["kind"], out["a"]) == (CommandKind.TURN, 90.0)
    dash = commands("box", np.array([[[0.9, 0.1, -0.3, 0.0, 0.5, 0.0]]]))[0, 0]
    assert (dash["kind"], dash["a"]) == (CommandKind.DASH, 50.0)


def test_scaled_parameters_are_the_servers_units_again():
    kinds = np.array([CommandKind.DASH, CommandKind.TURN, CommandKind.MOVE, CommandKind.DASH_LEGS])
    params = scaled(kinds, [70.0, -90.0, -20.0, 50.0], [15.0, 0.0, 10.0, 45.0], [0.0, 0.0, 0.0, -30.0], [0.0, 0.0, 0.0, 90.0])
    out = commands("hybrid", {"type": kinds[None], "params": params[None]}, shape=(1, 4))[0]
    assert out["a"] == pytest.approx([70.0, -90.0, -20.0, 50.0])
    assert out["b"] == pytest.approx([15.0, 0.0, 10.0, 45.0])
    assert out["c"][3] == pytest.approx(-30.0)
    assert out["d"][3] == pytest.approx(90.0)
    assert scaled(int(CommandKind.KICK), 500.0)[0] == 1.0


@pytest.mark.parametrize("view", ["hybrid", "full", "discrete", "box"])
def test_every_sample_of_a_view_is_a_command(view):
    space = action_view(view).space
    space.seed(3)
    for _ in range(50):
        sample = space.sample()
        lifted = {k: np.asarray(v)[None, None] for k, v in sample.items()} if isinstance(sample, dict) else sample[None, None]
        out = commands(view, lifted)
        assert 0 <= out["kind"][0, 0] <= 7
        assert np.isfinite(out["a"]).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"params": np.array([[[np.nan, 0, 0, 0]]])}, r"'params': entry \(0, 0, 0\) is nan; allowed are finite numbers from -1 to 1"),
        ({"params": np.zeros((1, 1, 3))}, r"'params': expected shape \(4,\) for every agent, got \(3,\)"),
        ({"params": np.zeros(4)}, r"'params': expected shape \(1, 1, 4\), worlds and agents first, got \(4,\)"),
        ({"params": np.zeros((1, 1, 4), complex)}, "'params': expected numbers, got complex128"),
        ({"params": np.array([[["1", "0", "0", "0"]]])}, "'params': expected numbers, got <U1"),
        ({"params": np.ones((1, 1, 4), bool)}, "'params': expected numbers, got bool"),
        ({"params": np.full((1, 1, 4), 2.0)}, r"is 2.0; allowed is -1 to 1"),
        ({"type": np.array([[8]])}, r"'type': entry \(0, 0\) is 8; allowed is 0 to 7"),
        ({"type": np.array([[1.5]])}, "'type': expected whole numbers"),
        ({"type": "dash"}, "'type'"),
        ({"colour": 1}, "unknown key 'colour'; allowed are type, params, turn_neck, view, say"),
    ],
)
def test_a_bad_hybrid_action_is_refused_by_name(change, message):
    with pytest.raises(CommandError, match=message):
        commands("hybrid", hybrid(**change))


def test_a_missing_key_is_named():
    with pytest.raises(CommandError, match="key 'params' is missing"):
        commands("hybrid", {"type": np.array([[1]])})


@pytest.mark.parametrize(
    ("view", "action", "message"),
    [
        ("hybrid", np.zeros((1, 1)), "expected a dict with the keys type, params, turn_neck, view; got \\[\\[0.0\\]\\]"),
        ("discrete", np.array([[[9, 0, 0, 0]]]), "'discrete command': entry .* is 9; allowed is 0 to 5"),
        ("discrete", np.array([[[0, 0, 0]]]), r"expected shape \(4,\) for every agent, got \(3,\)"),
        ("discrete", np.array([[[0, np.inf, 0, 0]]]), r"'discrete': entry \(0, 0, 1\) is inf; expected finite whole numbers"),
        ("discrete", np.array([[[np.nan, 0, 0, 0]]]), r"'discrete': entry \(0, 0, 0\) is nan; expected finite whole numbers"),
        ("box", np.array([[[np.inf] * 6]]), "allowed are finite numbers from -1 to 1"),
    ],
)
def test_a_bad_action_of_another_view_is_refused(view, action, message):
    with pytest.raises(CommandError, match=message):
        commands(view, action)


def test_an_unknown_view_lists_the_views():
    with pytest.raises(UnknownName, match=r"unknown action view 'hybird'. Did you mean 'hybrid'\? Known: box, discrete, full, hybrid"):
        action_view("hybird")


def test_no_command_does_nothing():
    assert NO_COMMAND["kind"][0] == CommandKind.NONE
    assert np.isnan(NO_COMMAND["turn_neck"][0])
