"""Senses as options: each does what it says, to the agents alone, by luck that depends on seed and world only; the default does nothing."""

import gymnasium
import numpy as np
import pytest

import cprm_gym.envs  # noqa: F401
from cprm_gym.envs import soccer_v2
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import BodyFeature
from cprm_gym.envs.players.senses import Senses
from cprm_gym.errors import ParameterError, UnknownName

ALL = ("memory", "landmarks", "lines", "hear")
BAD = Senses(view="wide", asynchronous=True, lost=0.3, noise=0.5, quantise=2.0, gaussian=0.1, late_ball=2, late_others=1, motion=False,
             numbers=False)  # fmt: skip


def record(senses=None, worlds=8, cycles=25, first=0, task="HFO2v1", restart=None, **options):
    """Observations (T, W, A, ...) of agents who turn and dash by numbers of their own, the same whatever they perceive."""
    extra = {} if senses is None else {"senses": senses}
    core = SoccerCore(task, worlds, seed=4, first_world=first, include=ALL, **extra, **options)
    seen = [{k: v.copy() for k, v in core.reset(4).items()}]
    for t in range(cycles):
        shape = (worlds, len(core.agents))
        params = np.stack([np.full(shape, np.sin(1.0 * t)), np.full(shape, 0.2), *np.zeros((2, *shape))], axis=-1)
        core.step({"type": np.full(shape, 1 + t % 2), "params": params, "turn_neck": 0.3 * params[..., :1]})
        if restart == t:
            core.reset(worlds=np.arange(worlds) % 2 == 1)
        seen.append({k: v.copy() for k, v in core.observation.items()})
    return {k: np.stack([o[k] for o in seen]) for k in seen[0]}, core


def test_the_default_changes_nothing_and_a_mapping_means_the_same():
    plain, _ = record()
    for senses in (Senses(), {}):
        same, _ = record(senses)
        assert all((plain[k] == same[k]).all() for k in plain)


@pytest.mark.parametrize("senses", [BAD, Senses(late=3), Senses(lost=0.5, noise=1.0)], ids=("many", "late", "lost"))
def test_a_world_perceives_the_same_alone_and_in_a_batch(senses):
    batch, _ = record(senses)
    for k in (0, 5):
        alone, _ = record(senses, worlds=1, first=k)
        for key in batch:
            assert np.array_equal(batch[key][:, k], alone[key][:, 0]), key


def test_the_world_itself_and_the_scripted_players_are_not_touched():
    _, plain = record()
    _, bad = record(Senses(lost=0.5, noise=1.0, quantise=4.0, motion=False, numbers=False, late=4))
    assert plain.sim.state_hash() == bad.sim.state_hash()


def fresh(seen):
    return seen["body"][..., BodyFeature.FRESH]


def test_view_and_clock_of_the_eye_say_how_often_there_is_a_look():
    assert fresh(record(Senses(view="narrow"))[0]).mean() == 1.0
    assert fresh(record(Senses(view="wide"), cycles=29)[0]).mean() == pytest.approx(1 / 3, abs=0.02)
    assert fresh(record(cycles=29)[0]).mean() == pytest.approx(0.5, abs=0.02)
    _, core = record(Senses(asynchronous=True), cycles=1)
    assert (core.sim.world["synchronous"][:, :2] == 0).all()
    assert (core.sim.world["synchronous"][:, 11] == 1).all()


def test_messages_are_lost_with_their_probability_but_never_the_first():
    seen, _ = record(Senses(view="narrow", lost=0.4), worlds=60, cycles=40)
    assert fresh(seen)[0].all()
    assert fresh(seen)[1:].mean() == pytest.approx(0.6, abs=0.03)
    blind = fresh(seen) == 0
    assert not seen["level"][blind].any()
    assert not seen["landmark_level"][blind].any()
    assert not seen["players"][blind].any()


def test_the_first_look_stays_when_other_worlds_begin_anew():
    seen, _ = record(Senses(view="narrow", lost=0.9), worlds=40, cycles=6, restart=5)
    assert fresh(seen)[6, 1::2].all()
    assert not fresh(seen)[6, ::2].all()


def differences(senses, key="ball"):
    """Readings with the senses less those without, where both saw the ball moving: (n, 4)."""
    plain, other = record(worlds=60, cycles=12)[0], record(senses, worlds=60, cycles=12)[0]
    both = (plain["level"][..., 0] >= 3) & (other["level"][..., 0] >= 3)
    return plain[key][both].astype(float), other[key][both].astype(float)


def test_noise_is_of_the_size_asked_for():
    plain, noisy = differences(Senses(noise=0.5))
    assert len(plain) > 300
    assert np.std(np.log(noisy[:, 0] / plain[:, 0])) == pytest.approx(0.075, rel=0.15)
    turned = (noisy[:, 1] - plain[:, 1] + np.pi) % (2 * np.pi) - np.pi
    assert np.std(turned) == pytest.approx(np.radians(4.0), rel=0.15)
    assert np.std(noisy[:, 2] - plain[:, 2]) == pytest.approx(0.15, rel=0.15)
    assert np.std(noisy[:, 3] - plain[:, 3]) == pytest.approx(np.radians(3.0), rel=0.15)


def test_coarse_senses_have_coarse_steps():
    _, coarse = differences(Senses(quantise=4.0))
    steps = np.log(coarse[:, 0]) / 0.4
    assert steps == pytest.approx(np.rint(steps), abs=1e-4)
    degrees = np.degrees(coarse[:, 1]) / 4.0
    assert degrees == pytest.approx(np.rint(degrees), abs=1e-4)


def test_gaussian_senses_err_by_their_rate():
    _, core = record(Senses(gaussian=0.1), worlds=200, cycles=0)
    truth = np.hypot(*(core.sim.world["pos"][:, 0] - core.sim.world["pos"][:, 1]).T)
    seen = core.observation["level"][:, 0, 0] >= 2
    error = (core.observation["ball"][:, 0, 0] / truth)[seen] - 1.0
    assert np.std(error) == pytest.approx(0.2, rel=0.25)  # the rate of the distance, and of that from the focus, which is the eye


def test_without_motion_or_numbers_neither_is_told_and_nobody_is_lost():
    plain, _ = record(task="Soccer5v5", controlled="left")
    seen, _ = record(Senses(motion=False, numbers=False), task="Soccer5v5", controlled="left")
    assert plain["level"].max() == 3
    assert seen["level"].max() == 2
    assert not seen["ball"][..., 2:].any()
    assert not seen["players"][..., 2:6].any()
    assert ((seen["level"][..., 1:] > 0).sum(axis=-1) == (plain["level"][..., 1:] > 0).sum(axis=-1)).all()
    for team in (slice(0, 11), slice(11, 22)):
        ones, others = (np.sort(o["players"][..., team, 0] * (o["level"][..., 1:][..., team] >= 2), axis=-1) for o in (plain, seen))
        assert (ones == others).all()
    # nearest first, so that a place in the array tells nothing; the own place stays empty
    opponents, told = seen["players"][..., 11:, 0], seen["level"][..., 12:] == 2
    assert (np.diff(np.where(told, opponents, 1e3), axis=-1) >= 0).all()
    assert not seen["level"][:, :, np.arange(5), 1 + np.arange(5)].any()


def test_late_news_are_what_was_told_then_and_their_age_says_so():
    plain, _ = record(cycles=20)
    late, _ = record(Senses(late_ball=3), cycles=20)
    for key in ("body", "self", "players", "landmarks"):
        assert np.array_equal(late[key], plain[key]), key
    assert np.array_equal(late["ball"][3:], plain["ball"][:-3])
    assert np.array_equal(late["memory"][3:, ..., 0, :], plain["memory"][:-3, ..., 0, :])
    assert np.array_equal(late["memory_age"][3:, ..., 0], np.minimum(plain["memory_age"][:-3, ..., 0] + 3, 1000))
    assert np.array_equal(late["memory"][..., 1:, :], plain["memory"][..., 1:, :])
    assert np.array_equal(late["ball"][:3], np.repeat(plain["ball"][:1], 3, axis=0))
    assert np.array_equal(late["age"][1, ..., 0], np.minimum(plain["age"][0, ..., 0] + 1, 1000))
    everything, _ = record(Senses(late=2), cycles=20)
    for key in ("body", "self", "players", "level", "landmarks", "lines"):
        assert np.array_equal(everything[key][2:], plain[key][:-2]), key
    others, _ = record(Senses(late_others=2), cycles=20)
    assert np.array_equal(others["memory"][2:, ..., 1:, :], plain["memory"][:-2, ..., 1:, :])
    assert np.array_equal(others["ball"], plain["ball"])


def test_an_episode_that_begins_anew_has_its_first_look_at_once():
    seen, core = record(Senses(late=4), cycles=9, restart=8)
    began = np.arange(8) % 2 == 1
    assert (seen["body"][-1][began][..., BodyFeature.TIME] == core.sim.world["time"][began, None]).all()
    assert (seen["body"][-1][~began][..., BodyFeature.TIME] == core.sim.world["time"][~began, None] - 4).all()


def test_a_saved_state_holds_what_has_not_been_told_yet():
    def go_on(core):
        told = []
        for _ in range(6):
            shape = (core.worlds, len(core.agents))
            core.step({"type": np.ones(shape, int), "params": np.full((*shape, 4), 0.5)})
            told.append({k: v.copy() for k, v in core.observation.items()})
        return told

    core = SoccerCore("HFO2v1", 3, seed=4, include=ALL, senses=BAD)
    core.reset(4)
    go_on(core)
    state = core.save_state()
    first = go_on(core)
    core.load_state(state)
    second = go_on(core)
    assert all(np.array_equal(a[k], b[k]) for a, b in zip(first, second, strict=True) for k in a)


def test_every_face_takes_them():
    env = gymnasium.make("cprm/Goalie-v2", senses={"view": "wide", "lost": 0.5})
    assert env.unwrapped.core.senses == Senses(view="wide", lost=0.5)
    several = soccer_v2.parallel_env(task="HFO2v1", observation="raw", senses=Senses(late_ball=2))
    several.reset(seed=1)
    assert several.core.senses.late_ball == 2


@pytest.mark.parametrize(
    ("given", "error", "text"),
    [
        ({"lost": 1.5}, ParameterError, "lost: 1.5 given; allowed are numbers from 0 to 1"),
        ({"late": -1}, ParameterError, "late: -1 given"),
        ({"late_ball": 1.5}, ParameterError, "late_ball: 1.5 given; allowed are whole numbers"),
        ({"quantise": 0.5}, ParameterError, "quantise"),
        ({"noise": float("nan")}, ParameterError, "noise"),
        ({"motion": 1}, ParameterError, "motion: 1 given"),
        ({"view": "broad"}, UnknownName, "view"),
        ({"nois": 1.0}, ParameterError, "no 'nois'"),
        ("bad", ParameterError, "expected Senses or a mapping of its fields"),
    ],
)
def test_what_makes_no_sense_is_refused(given, error, text):
    with pytest.raises(error, match=text):
        SoccerCore("Goalie", 1, senses=given)


def test_senses_do_not_go_with_what_looks_past_them():
    with pytest.raises(ParameterError, match="'full' tells the truth"):
        SoccerCore("Goalie", 1, senses={"lost": 0.5}, observation="full")
    for options in ({"observation": "hfo_low"}, {"action_mode": "macro"}):
        with pytest.raises(ParameterError, match="late news"):
            SoccerCore("HFO2v1", 1, senses={"late": 1}, **options)
