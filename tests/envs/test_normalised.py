"""The default observation: bounds that hold, a mask for what is unknown, names, and what its numbers mean."""

import gymnasium
import numpy as np
import pytest

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.kernels.vectors import RECENT
from cprm_gym.envs.tasks import TASKS, make_task
from cprm_gym.envs.tasks.half_field import HalfField
from cprm_gym.envs.vectors.normalised import BALL, FARTHEST, GOALS, ME, PLAYER, Columns
from cprm_gym.errors import ParameterError
from cprm_gym.simulator.state import PlayMode


def playing(task, worlds=8, cycles=120, seed=1, **options):
    """A batch under random actions, cycle by cycle; worlds that end begin anew."""
    core = SoccerCore(task, worlds, action_mode="discrete", observation="normalised", **options)
    rng = np.random.default_rng(seed)
    core.reset(seed)
    yield core
    for _ in range(cycles):
        action = rng.integers(0, [6, 5, 24, 5], (worlds, len(core.agents), 4))
        step = core.step(action)
        over = step.terminated | step.truncated
        if over.any():
            core.reset(None, over)
        yield core


@pytest.mark.parametrize("name", sorted(TASKS))
def test_declared_bounds_hold_in_random_play_of_every_task(name):
    small = name == "Soccer11v11"
    low, high = None, None
    for core in playing(name, worlds=2 if small else 6, cycles=25 if small else 60, controlled="all", flatten=True):
        vector = core.output
        assert np.isfinite(vector).all()
        low = vector.min(axis=(0, 1)) if low is None else np.minimum(low, vector.min(axis=(0, 1)))
        high = vector.max(axis=(0, 1)) if high is None else np.maximum(high, vector.max(axis=(0, 1)))
    space = core.preset.space
    assert vector.dtype == space.dtype == np.float32
    assert (low >= space.low).all(), [core.preset.names[k] for k in np.flatnonzero(low < space.low)]
    assert (high <= space.high).all(), [core.preset.names[k] for k in np.flatnonzero(high > space.high)]
    assert np.abs(np.concatenate([space.low, space.high])).max() <= 1.0


def test_what_is_unknown_is_zero_and_masked_and_what_is_known_was_seen_lately():
    seen = set()
    for core in playing("HFO2v2", worlds=30, cycles=60, controlled="left"):
        o = core.output
        for part, known in (("ball", o["known"][..., :1]), ("players", o["known"][..., 1:])):
            rows = o[part] if part == "players" else o[part][..., None, :]
            assert (rows[known == 0] == 0).all()
            assert (np.hypot(rows[known == 1][:, 0], rows[known == 1][:, 1]) > 0.99).all(), "a direction where there is a place"
        ages = np.stack([m["ball_age"] for m in core.remembered()[:, :2].T], axis=1)
        assert ((ages <= RECENT) == (o["known"][..., 0] == 1)).all()
        seen |= set(np.unique(o["known"]).tolist())
    assert seen == {0.0, 1.0}


def test_every_entry_has_a_name_of_its_own_and_the_flat_vector_holds_the_parts_in_order():
    parts, flat = (gymnasium.make("cprm/HFO3v2-v2", flatten=f) for f in (False, True))
    names = flat.unwrapped.core.preset.names
    assert len(names) == len(set(names)) == flat.observation_space.shape[0]
    assert names[0] == "me_located"
    assert names[len(ME) + 2] == "ball_distance"
    assert names[-1] == "known_opponent_2"
    o, vector = parts.reset(seed=3)[0], flat.reset(seed=3)[0]
    assert vector.tolist() == np.concatenate([o[part].ravel() for part in ("me", "ball", "goals", "players", "known")]).tolist()
    assert flat.observation_space.contains(vector)
    assert parts.observation_space.contains(o)
    assert o["players"].shape == (4, len(PLAYER))
    assert set(gymnasium.make("cprm/GoToBall-v2").observation_space.spaces) == {"me", "ball", "goals", "known"}


@pytest.mark.parametrize("side", ["left_1", "right_1"])
def test_with_full_state_it_is_the_truth_in_the_frame_of_the_body(side):
    core = SoccerCore(make_task("HFO1v1", full_state=True), 40, observation="normalised", controlled=side, others="hold")
    core.reset(5)
    w, me = core.sim.world, 1 if side == "left_1" else 12
    other, sign = (12, 1.0) if me == 1 else (1, -1.0)
    w["vel"][:, 0], w["vel"][:, me] = (0.5, -0.2), (0.2, 0.1)
    core.observe()
    o = {part: values[:, 0] for part, values in core.output.items()}
    body = w["body"][:, me - 1]
    ahead = np.stack([np.cos(body), np.sin(body)], axis=1)
    aside = np.stack([-np.sin(body), np.cos(body)], axis=1)

    def way(to):
        d = np.broadcast_to(to, (40, 2)) - w["pos"][:, me]
        length = np.hypot(*d.T)
        return np.stack([(d * aside).sum(1) / length, (d * ahead).sum(1) / length, np.log1p(length) / np.log1p(FARTHEST)], axis=1)

    assert o["ball"][:, :3] == pytest.approx(way(w["pos"][:, 0]), abs=1e-6)
    assert o["players"][:, 0, :3] == pytest.approx(way(w["pos"][:, other]), abs=1e-6)
    assert o["goals"] == pytest.approx(np.concatenate([way([52.5 * sign, 0]), way([-52.5 * sign, 0])], axis=1), abs=1e-6)
    speed = core.parameters.ball_speed_max
    rolls = np.stack([(w["vel"][:, 0] * ahead).sum(1), (w["vel"][:, 0] * aside).sum(1)], axis=1) / speed
    assert o["ball"][:, 3:5] == pytest.approx(rolls, abs=1e-6)
    assert o["me"][:, 1:3] == pytest.approx(sign * w["pos"][:, me] / (52.5, 34.0), abs=1e-6)
    assert (o["known"] == 1).all()
    assert (o["me"][:, [c.name for c in ME].index("goalie")] == (me == 12)).all()


def test_the_play_mode_says_whose_ball_it_is():
    core = SoccerCore(make_task("Soccer", left=1, right=1), 1, observation="normalised", controlled="all", others="hold")
    core.reset(1)
    flags = slice(14, 17)
    for mode, left, right in (("play_on", [1, 0, 0], [1, 0, 0]), ("kick_in_l", [0, 1, 0], [0, 0, 1]), ("offside_r", [0, 0, 0], [0, 0, 0])):
        core.sim.world["mode"][:] = PlayMode[mode]
        core.observe()
        assert core.output["me"][0, :, flags].tolist() == [left, right]


def test_teams_of_different_sizes_share_one_space_whose_spare_rows_are_unknown():
    env = soccer_v2.parallel_env(task="HFO2v1", controlled="all")
    observations, _ = env.reset(seed=1)
    assert env.observation_space("left_1") == env.observation_space("right_1")
    rows = Columns(1, 2).others
    assert rows == ("mate_1", "opponent_1", "opponent_2")
    for _ in range(30):
        assert observations["left_1"]["known"][3] == observations["right_1"]["known"][1] == 0
        for agent in env.agents:
            assert env.observation_space(agent).contains(observations[agent])
        observations = env.step({a: env.action_space(a).sample() for a in env.agents})[0]


def test_what_a_task_adds_is_scaled_from_its_bounds():
    class Told(HalfField):
        def features(self, pitch, out):
            out[..., 0], out[..., 1] = 30.0, 7.0

    task = Told(name="HFO1v1", task_features=(("near", 20.0, 40.0), ("far", -1.0, 1.0)))
    core = SoccerCore(task, 2, observation="normalised")
    core.reset(1)
    assert core.output["task"].tolist() == [[[0.0, 1.0]]] * 2
    assert core.preset.names[-2:] == ("task_near", "task_far")


def test_the_mask_of_macros_goes_beside_the_parts_or_the_vector():
    parts, flat = (
        gymnasium.make("cprm/HFO1v1-v2", action_mode="macro", include="action_mask", flatten=f).reset(seed=1)[0] for f in (False, True)
    )
    assert set(parts) == {"me", "ball", "goals", "players", "known", "action_mask"}
    assert set(flat) == {"observations", "action_mask"}


def test_late_news_are_refused_with_what_goes_instead():
    with pytest.raises(ParameterError, match="late news go with the observations 'raw' and 'memory'"):
        gymnasium.make("cprm/Goalie-v2", senses={"late_ball": 2})


def test_a_saved_state_holds_the_observation():
    env = gymnasium.make("cprm/GoToBall-v2").unwrapped
    env.reset(seed=4)
    env.step(np.array([1, 4, 11, 0]))
    state = env.save_state()
    now = {part: values.tolist() for part, values in env._observation().items()}
    env.step(np.array([2, 0, 3, 0]))
    env.load_state(state)
    assert {part: values.tolist() for part, values in env._observation().items()} == now


def test_columns_say_what_one_means():
    for column in (*ME, *BALL, *GOALS, *PLAYER):
        assert -1 <= column.low < column.high == 1
        assert column.unit
        assert column.meaning
