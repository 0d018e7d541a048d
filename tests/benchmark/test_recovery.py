"""Recovery: the watchdog begins anew where nothing is done, and only there; the undisturbed row is always told."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.agents import striker
from cprm_gym.benchmark import recovery
from cprm_gym.benchmark.recovery import LOOP, RIVALS, SECOND_TRIES, Watchdog, measure
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.state import CommandKind
from cprm_gym.wrappers.disturbances import DISTURBANCES


class Sleeper:
    """Acts for three cycles after each of its resets, then never again."""

    needs = ("memory",)

    def reset(self, observation, seed, worlds=None):
        chosen = slice(None) if worlds is None else worlds
        self.age = np.zeros(len(observation["level"]), int) if worlds is None else self.age
        self.age[chosen] = 0

    def act(self, observation):
        action = no_action(len(self.age))
        action["type"][self.age < 3] = CommandKind.TURN
        self.age += 1
        return action


def test_the_watchdog_wakes_whoever_has_done_nothing_for_so_long_and_nobody_else():
    observation = {"level": np.zeros((2, 23))}
    dog = Watchdog(Sleeper(), idle=5)
    dog.reset(observation, 0)
    assert dog.needs == ("memory",)
    acted = []
    for cycle in range(20):
        if cycle == 4:
            dog.reset(observation, 0, np.array([False, True]))
        acted.append(dog.act(observation)["type"] != CommandKind.NONE)
    first, second = np.array(acted).T
    assert np.flatnonzero(first).tolist() == [0, 1, 2, 8, 9, 10, 16, 17, 18]
    assert np.flatnonzero(second).tolist() == [0, 1, 2, 4, 5, 6, 12, 13, 14]


def test_watched_the_net_without_recovery_does_better_undisturbed():
    task = replace(make_task("PassAndAdvance"), max_cycles=600)
    plain, watched = (measure(RIVALS[task.name][name], None, 20, seed=3, task=task) for name in ("without", "watchdog"))
    assert watched.success.mean() >= plain.success.mean() + 0.2


def test_the_striker_without_his_loop_is_left_standing_and_beginning_at_the_kick_off_does_not_help_him():
    disturbed = DISTURBANCES["ball displaced"]
    plain, watched, whole = (measure(RIVALS["KickOffShot"][name], disturbed, 20, 3, make_task("KickOffShot"))
                             for name in ("without", "watchdog", "recovering"))  # fmt: skip
    assert plain.success.mean() + 0.2 <= whole.success.mean()
    assert plain.success.mean() <= watched.success.mean() <= whole.success.mean()
    assert {t.name for t in striker.STRIKER.net.transitions} >= LOOP


@pytest.mark.parametrize("name", ["PassAndAdvance2v1", "KickOffShot2v2"])
def test_the_attacker_without_second_tries_lacks_them_and_nothing_else(name):
    task = make_task(name)
    whole, without = (RIVALS[name][rival](task, "left_1").cprm.net for rival in ("recovering", "without"))
    left = {t.name for t in without.transitions}
    assert {t.name for t in whole.transitions} - left == SECOND_TRIES
    assert without.places == whole.places
    assert isinstance(RIVALS[name]["watchdog"](task, "left_1"), Watchdog)


def test_the_undisturbed_row_is_always_printed(monkeypatch, capsys):
    monkeypatch.setattr(recovery, "measure", lambda *_: recovery.Recovery(*(np.array([v]) for v in (True, True, 3.0, 9))))
    monkeypatch.setattr(sys, "argv", ["recovery", "--episodes", "1", "--only", "ball stopped"])
    recovery.main()
    rows = capsys.readouterr().out.splitlines()[2:]
    assert [row[:18].strip() for row in rows] == ["undisturbed", "ball stopped"]
