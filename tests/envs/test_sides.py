"""Reward and success are each agent's own, and those of the two sides mirror each other."""

import numpy as np
import pytest

from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.registration import TASK_NAMES
from cprm_gym.envs.tasks import Status, make_task
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.state import CommandKind, Count, PlayMode

OPTIONS = {
    "GoToBall": {"right": 1},
    "Hike": {"right": 1},
    "KickOffShot": {"right": 1},
    "PassAndAdvance": {"right": 1},
    "HFO1v0": {"right": 1},
    "FrontGoalEmptyGoal": {"right": 1},
}
"""Somebody on the right side where the task has nobody there."""


def ends(name, worlds=24, cycles=400):
    """Episodes of a task with everybody at random, all agents told: steps until all worlds are over, with which were running."""
    task = make_task(name, **OPTIONS.get(name, {}), max_cycles=min(cycles, make_task(name).max_cycles))
    core = SoccerCore(task, worlds, controlled="all", seed=5)
    core.reset(5)
    draws, running = np.random.default_rng(2), np.ones(worlds, bool)
    while running.any():
        shape = (worlds, len(core.agents))
        action = {"type": draws.integers(1, 4, shape), "params": draws.uniform(-1, 1, (*shape, 4)) * [1, 1, 0, 0]}
        step = core.step(action)
        yield core, step, running.copy()
        running &= ~(step.terminated | step.truncated)


@pytest.mark.parametrize("name", TASK_NAMES)
def test_what_one_side_is_paid_the_other_pays_and_one_at_most_succeeds(name):
    over = 0
    for core, step, running in ends(name):
        left, right = core.sides > 0, core.sides < 0
        now = running & (step.terminated | step.truncated)
        over += now.sum()
        for values in (step.reward, *step.terms.values()):
            assert (values[running][:, left] == values[running][:, left][:, :1]).all()
            assert (values[running][:, right] == -values[running][:, left][:, :1]).all()
        won = step.success
        assert (won[:, left] == won[:, left][:, :1]).all()
        assert (won[:, right] == won[:, right][:, :1]).all()
        assert not won[running & ~now].any(), "nobody has succeeded while it goes on"
        both = won[now][:, left][:, 0].astype(int) + won[now][:, right][:, 0]
        drawn = name.startswith(("Soccer", "GoToBall", "Hike"))
        assert ((both == 1) | (drawn & (both == 0))).all()
    assert over == 24


def one(name, **options):
    task = make_task(name, **{**OPTIONS.get(name, {}), **options})
    core = SoccerCore(task, 1, controlled="all", others="hold")
    core.reset(1)
    core.sim.world["mode"] = PlayMode.play_on
    return core


def still(core):
    """One cycle in which nobody acts."""
    shape = (1, len(core.agents))
    return core.step({"type": np.zeros(shape, int), "params": np.zeros((*shape, 4))})


def shoot(core, x, y=0.0):
    """The ball flies over the goal line at x of the given sign, everybody else out of the way."""
    core.place_ball(np.sign(x) * 51.5, y, np.sign(x) * 2.5, 0.0)
    for k, player in enumerate(core.players):
        core.place_player(int(player), -20.0 + 2.0 * k, 25.0, 0.0, (0.0, 0.0))


def of(core, step, side):
    mine = core.sides == side
    return step.reward[0, mine].tolist(), step.success[0, mine].tolist()


def test_goalies_are_paid_for_the_save_and_the_attackers_for_the_goal():
    core = one("Goalie")
    shoot(core, -1)
    step = still(core)
    assert step.status[0] == Status.GOAL
    assert of(core, step, 1) == ([-1.0], [False])
    assert of(core, step, -1) == ([1.0, 1.0], [True, True])
    core = one("Goalie")
    shoot(core, -1)
    core.place_ball(-51.5, 20.0, -2.5, 0.0)
    step = still(core)
    assert step.status[0] == Status.SAVED
    assert of(core, step, 1) == ([1.0], [True])
    assert of(core, step, -1) == ([-1.0, -1.0], [False, False])


@pytest.mark.parametrize("name", ["HFO2v2", "KickOffShot", "PassAndAdvance"])
def test_a_goal_is_the_attackers_and_time_is_the_defenders(name):
    core = one(name, max_cycles=3)
    for _ in range(3):
        step = still(core)
    assert step.status[0] == Status.OUT_OF_TIME
    assert not step.success[0, core.sides > 0].any()
    assert step.success[0, core.sides < 0].all()
    if name == "HFO2v2":
        core = one(name)
        shoot(core, 1)
        step = still(core)
        assert step.status[0] == Status.GOAL
        assert of(core, step, 1) == ([1.0, 1.0], [True, True])
        assert of(core, step, -1) == ([-1.0, -1.0], [False, False])


def test_keepers_succeed_at_the_last_cycle_and_takers_before_it():
    core = one("Keepaway3v2", max_cycles=2)
    for _ in range(2):
        step = still(core)
    assert step.truncated[0]
    assert of(core, step, 1)[1] == [True] * 3
    assert of(core, step, -1)[1] == [False] * 2
    core = one("Keepaway3v2")
    core.place_ball(9.5, 0.0, 2.0, 0.0)
    step = still(core)
    assert step.status[0] == Status.OUT_OF_BOUNDS
    assert of(core, step, 1)[1] == [False] * 3
    assert of(core, step, -1)[1] == [True] * 2


@pytest.mark.parametrize("side", [1, -1])
def test_a_match_in_the_mirror_has_the_opposite_rewards(side):
    core = one("Soccer", left=2, right=2)
    shoot(core, side)
    steps = [still(core) for _ in range(3)]
    total = np.sum([s.reward[0] for s in steps], axis=0)
    assert total.tolist() == [side, side, -side, -side]


@pytest.mark.parametrize("side", [1, -1])
def test_who_reaches_the_ball_first_is_paid_whichever_his_side(side):
    core = one("GoToBall")
    core.place_ball(0.0, 0.0)
    core.place_player(1, -0.7 if side > 0 else -9.0, 0.0, 0.0)
    core.place_player(12, 0.7 if side < 0 else 9.0, 0.0, np.pi)
    step = still(core)
    assert of(core, step, side) == ([1.0], [True])
    assert of(core, step, -side) == ([-1.0], [False])


def caught_and_stolen(core):
    """The ball in front of the goalie's hands and at an attacker's feet, who kicks it at the goal in the cycle of the catch."""
    core.place_ball(-48.0, 0.0, 0.0, 0.0)
    core.place_player(1, -48.6, 0.0, 0.0, (0.0, 0.0))
    core.place_player(12, -47.4, 0.0, np.pi, (0.0, 0.0))
    core.place_player(13, -20.0, 25.0, 0.0, (0.0, 0.0))
    act = {"type": np.zeros((core.worlds, 3), int), "params": np.zeros((core.worlds, 3, 4))}
    act["type"][:, 0], act["type"][:, 1] = CommandKind.CATCH, CommandKind.KICK
    act["params"][:, 1, 0] = 1.0
    return act


def test_a_caught_ball_is_saved_even_when_an_attacker_kicks_it_in_the_same_cycle():
    core = SoccerCore("Goalie", 40, controlled="all", seed=3)
    core.reset(3)
    step = core.step(caught_and_stolen(core))
    assert (core.sim.world["counts"][:, 0, Count.CATCH] == 1).all()
    gap = np.hypot(*(core.sim.world["pos"][:, 0] - core.sim.world["pos"][:, 1]).T)
    assert (gap > 1.1).any(), "in some worlds the ball was kicked out of his reach afterwards"
    assert (step.status == Status.SAVED).all()


def test_a_punched_ball_is_not_caught():
    parameters = ServerParameters(catch_probability=0.0)
    core = SoccerCore(make_task("Goalie", parameters=parameters), 5, controlled="all", seed=3)
    core.reset(3)
    act = caught_and_stolen(core)
    act["type"][:, 1] = 0
    step = core.step(act)
    assert (core.sim.world["counts"][:, 0, Count.CATCH] == 1).all()
    assert (step.status == Status.IN_GAME).all()
