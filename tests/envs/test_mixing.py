"""Players who mix: hidden modes that the world's luck draws, that last, that are linked, and that nobody is told."""

from itertools import pairwise

import numpy as np
import pytest

from cprm_gym.agents.knowledge.oracles import idle
from cprm_gym.envs import soccer_v2
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.players.mixing import NOBODY, Mix, Mode
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError
from cprm_gym.simulator.state import Count, PlayMode

ATTACKERS = [11, 12]


def engine(worlds=40, seed=3, first=0, task="Goalie2v1", **options):
    core = SoccerCore(make_task(task, **options), worlds, seed=seed, first_world=first, include=("memory",))
    core.reset(seed)
    return core


def modes(core, cycles):
    """(T, W, 2) modes of both attackers, the goalie being idle."""
    told = []
    for _ in range(cycles):
        core.step(idle(core))
        told.append(core.intentions()[:, ATTACKERS])
    return np.array(told)


def test_modes_are_drawn_in_the_stated_shares_and_last_as_stated():
    told = modes(engine(mix={"dribble": 1, "feint": 2, "passing": 3, "shoot": 4, "link": 0, "shortest": 3, "longest": 5}), 120)
    assert np.bincount(told.ravel(), minlength=4) / told.size == pytest.approx([0.1, 0.2, 0.3, 0.4], abs=0.03)
    lengths = [np.diff(np.flatnonzero(np.diff(told[:, w, k]))) for w in range(40) for k in range(2)]
    shortest = min(runs.min() for runs in lengths if len(runs))
    assert shortest == 3


def test_a_mode_leads_to_the_next_where_links_are_certain():
    told = modes(engine(mix={"link": 1.0}), 80)
    changes = {(a, b) for w in range(40) for a, b in pairwise(told[:, w, 0].tolist()) if a != b}
    assert changes <= {(Mode.DRIBBLE, Mode.FEINT), (Mode.FEINT, Mode.SHOOT), (Mode.PASS, Mode.DRIBBLE), (Mode.SHOOT, Mode.DRIBBLE)}
    assert len(changes) == 4


def first_kick(core, cycles=60):
    """(W, 3): the cycle of the first kick at goal speed, the ball's vx and vy after it; zeros where there was none."""
    found = np.zeros((core.worlds, 3))
    for cycle in range(cycles):
        before = core.sim.world["counts"][:, ATTACKERS, Count.KICK].sum(axis=1)
        core.step(idle(core))
        kicked = core.sim.world["counts"][:, ATTACKERS, Count.KICK].sum(axis=1) > before
        speed = core.sim.world["vel"][:, 0]
        hit = kicked & (np.hypot(*speed.T) > 1.7) & (found[:, 0] == 0)
        found[hit, 0], found[hit, 1:] = cycle + 1, speed[hit]
    return found


def test_who_only_shoots_shoots_at_once_and_who_mixes_does_not():
    start = {"near": 14.0, "far": 18.0}
    always = first_kick(engine(mix={"dribble": 0, "feint": 0, "passing": 0, "shoot": 1, "link": 0}, **start))[:, 0]
    mixed = first_kick(engine(**start))[:, 0]
    assert np.median(always) <= 4
    assert np.median(mixed) > 2 * np.median(always)
    assert np.std(mixed) > 2.0


def test_who_only_passes_passes_to_his_mate_and_who_only_dribbles_keeps_the_ball_from_afar():
    only = {"dribble": 0, "feint": 0, "passing": 0, "shoot": 0, "link": 0, "close": 0.0}
    core = engine(mix={**only, "passing": 1}, near=28.0, far=30.0)
    for _ in range(40):
        core.step(idle(core))
    assert (core.sim.world["counts"][:, 12, Count.KICK] > 0).mean() > 0.8, "the second attacker has got it"
    core = engine(mix={**only, "dribble": 1}, near=28.0, far=30.0)
    for _ in range(15):
        core.step(idle(core))
    assert (core.sim.world["counts"][:, 12, Count.KICK] > 0).mean() < 0.1


def test_the_shot_after_a_feint_goes_to_the_other_corner():
    feints = {"feint": 1, "dribble": 0, "passing": 0, "shoot": 0, "link": 1, "close": 0}
    core = engine(60, task="Goalie", others="mixing", shots=0, mix=feints)
    core.place_ball(-36.0, 0.0)
    core.place_player(12, -35.3, 0.0, np.pi, (0.0, 0.0))
    core.observe(np.arange(60))
    core.step(idle(core))
    side = -core.scripted.mixing.intents["side"][:, 11]  # in the frame of the pitch
    assert set(side) == {-1, 1}
    cycle, vx, vy = first_kick(core).T
    shot = (cycle > 0) & (vx < -1.0)
    assert shot.mean() > 0.7
    assert (np.sign(vy[shot]) == -side[shot]).mean() > 0.9


def test_the_same_world_has_the_same_modes_alone_and_in_a_batch_and_another_seed_has_others():
    batch = modes(engine(6), 30)
    assert np.array_equal(batch[:, 4], modes(engine(1, first=4), 30)[:, 0])
    assert np.array_equal(batch, modes(engine(6), 30))
    assert not np.array_equal(batch, modes(engine(6, seed=4), 30))


def test_a_branch_has_the_modes_to_come():
    core = engine(20)
    modes(core, 5)
    future = core.branch()
    assert np.array_equal(modes(future, 25), modes(core, 25))
    assert future.sim.state_hash() == core.sim.state_hash()


def test_teams_that_mix_play_a_match():
    core = SoccerCore(make_task("Soccer", left=3, right=3), 4, seed=1, controlled=(), others="mixing")
    core.reset(1)
    for _ in range(250):
        core.step(None)
    kicks = core.sim.world["counts"][..., Count.KICK]
    assert (kicks[:, [0, 1, 2, 11, 12, 13]].sum(axis=1) > 5).all()
    assert (core.sim.world["mode"] == PlayMode.play_on).any()


def test_nobody_perceives_a_mode():
    """Two worlds that differ in nothing but what the attackers have in mind are perceived alike until they act on it."""
    one, other = engine(30), engine(30)
    other.scripted.mixing.intents["mode"] = (other.scripted.mixing.intents["mode"] + 1) % 4
    other.scripted.mixing.intents["begun"], other.scripted.mixing.intents["cycles"] = 1, 9
    one.observe(np.arange(30))
    other.observe(np.arange(30))
    assert not np.array_equal(one.intentions(), other.intentions())
    assert all(np.array_equal(one.observation[key], other.observation[key]) for key in one.observation)


def test_the_state_tells_the_modes_where_somebody_mixes():
    env = soccer_v2.parallel_env(task="Goalie3v2", debug_info=False)
    env.reset(seed=2)
    assert env.state()[-22:].tolist() == [NOBODY] * 22
    env.step({"left_1": env.action_space("left_1").sample()})
    told = env.state()[-22:]
    assert env.state_space.contains(env.state())
    assert (told[11:14] >= 0).all()
    assert (np.delete(told, [11, 12, 13]) == NOBODY).all()
    plain = soccer_v2.parallel_env(task="Goalie")
    plain.reset(seed=2)
    assert len(env.state()) == len(plain.state()) + 22


def test_the_modes_are_read_by_the_state_alone():
    import re
    from pathlib import Path

    from paths import ROOT

    users = {
        path.relative_to(ROOT).as_posix()
        for folder in ("cprm_gym", "baselines")
        for path in Path(ROOT, folder).rglob("*.py")
        if re.search(r"\.intentions\(|\.intents\b|mixing\.modes", path.read_text(encoding="utf-8"))
    }
    learned_from = "cprm_gym/benchmark/demonstrations/learning.py"  # logged play, in which what somebody had in mind is known afterwards
    assert users == {"cprm_gym/envs/core.py", "cprm_gym/envs/soccer_v2.py", "cprm_gym/envs/players/mixing.py", learned_from}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"shoot": -1}, "mix: shoot: -1 given; allowed are numbers from 0"),
        ({"link": 1.5}, "mix: link: 1.5 given; allowed are numbers from 0 to 1"),
        ({"shortest": 0}, "mix: shortest: 0 given; allowed are whole numbers from 1 to 1000"),
        ({"shortest": 20}, "mix: shortest: 20 given; allowed are numbers up to longest, 14"),
        ({"dribble": 0, "feint": 0, "passing": 0, "shoot": 0}, "all 0"),
        ({"shots": 1}, "Did you mean 'shoot'"),
        (3, "expected Mix or a mapping of its fields"),
    ],
)
def test_a_mix_that_makes_no_sense_is_refused(given, message):
    with pytest.raises(ParameterError, match=message):
        make_task("Goalie2v1", mix=given)
    assert Mix.of(Mix(shoot=1.0)) == Mix(shoot=1.0)
