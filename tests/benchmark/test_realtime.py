"""The eleven against the clock: times, deadline misses, cycles that go by."""

import gc

import numpy as np
import pytest

from cprm_gym.benchmark.realtime import Match, main, table
from cprm_gym.errors import ParameterError, UnknownName
from cprm_gym.simulator.state import Count

BODY = [Count.KICK, Count.DASH, Count.TURN, Count.CATCH, Count.MOVE, Count.TURN_NECK]


class Clock:
    """Time that passes when it is looked at, by a step, or when somebody sleeps."""

    def __init__(self, step):
        self.time, self.step, self.slept = 0.0, step, 0.0

    def __call__(self):
        self.time += self.step
        return self.time

    def sleep(self, seconds):
        self.time += seconds
        self.slept += seconds


def commands(match):
    """Commands that the server has executed for the eleven."""
    return int(match.core.sim.world["counts"][0, :11][:, BODY].sum())


def test_in_time_every_action_is_sent():
    match = Match(together=True, fast=True, practice=2, deadline_ms=60_000.0)
    course = match.play(6)
    assert course.wall.shape == course.cpu.shape == (6, 2)
    assert (course.wall > 0).all()
    assert (course.cpu > 0).all()
    assert course.misses == 0
    assert commands(match) > 6
    assert course.agents == ("left_1", "left_2 ... left_11")


def test_late_actions_are_counted_and_their_players_do_nothing():
    match = Match(together=True, fast=True, practice=0, deadline_ms=0.01)
    course = match.play(5)
    assert course.late.all()
    assert course.misses == 5 * 11
    assert commands(match) == 0
    assert "55 of 55 actions missed" in table(course)


def test_only_he_who_is_late_is_idle():
    clock = Clock(0.001)  # twice looked at for each decision: 2 ms each
    match = Match(fast=True, practice=0, deadline_ms=9.5, clock=clock, sleep=clock.sleep)
    course = match.play(1)
    assert course.late[0].tolist() == [False] * 4 + [True] * 7


def test_the_server_waits_for_the_next_cycle_and_goes_on_without_those_who_take_longer():
    patient = Clock(0.001)
    match = Match(together=True, practice=0, clock=patient, sleep=patient.sleep)
    course = match.play(4)
    assert course.misses == course.skipped == 0
    assert patient.slept == pytest.approx(4 * 0.1, abs=0.05)
    slow = Clock(0.15)
    match = Match(together=True, practice=0, clock=slow, sleep=slow.sleep)
    course = match.play(2)
    assert course.late.all()
    assert course.skipped > 2
    assert course.misses == (2 + course.skipped) * 11
    assert match.core.cycle[0] == 2 + course.skipped


def test_the_garbage_collector_rests_while_somebody_decides_and_is_as_before_afterwards():
    match = Match(together=True, fast=True, practice=0)
    running = []
    act = match.eleven.agents[0].act
    match.eleven.agents[0].act = lambda observation: (running.append(gc.isenabled()), act(observation))[1]
    course = match.play(3)
    assert running == [False] * 3
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0
    assert (course.collect > 0).all()


def test_the_match_begins_with_the_kick_off_after_practice():
    match = Match(together=True, fast=True, practice=5)
    assert match.core.cycle[0] == 0
    assert match.core.sim.world["time"][0] == 0
    assert (match.eleven.agents[1].controller.executor.cycle == 0).all()


def test_wrong_opponents_and_times_are_refused():
    with pytest.raises(UnknownName, match=r"unknown opponent 'week'\. Did you mean 'weak'"):
        Match("week")
    with pytest.raises(ParameterError, match=r"cycle_ms 0.0: a time in milliseconds above 0"):
        Match(cycle_ms=0.0)


def test_the_command_prints_times_and_misses(capsys):
    main(["--fast", "--cycles", "3", "--practice", "2", "--together", "--cycle-ms", "60000"])
    text = capsys.readouterr().out
    assert "against weak, 3 cycles, as fast as it goes, seed 0: goals 0 : 0" in text
    assert "left_2 ... left_11" in text
    assert "to spare of 60000 ms: CPU median 100.0%" in text
    assert "0 of 33 actions missed, 0 cycles skipped" in text


@pytest.mark.slow
def test_eleven_apart_keep_a_cycle_of_a_second_on_any_machine():
    match = Match(fast=True, cycle_ms=1000.0, practice=100)
    course = match.play(100)
    assert course.misses == 0
    wall, _ = course.together
    assert np.median(wall) < 200.0
