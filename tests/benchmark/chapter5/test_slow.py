"""Slow inference: what is told when, and what it costs."""

import numpy as np
import pytest

from cprm_gym.agents.knowledge import informed
from cprm_gym.benchmark.chapter5 import Chapter5Plan, play_cell, summarise
from cprm_gym.benchmark.chapter5.cells import FULL
from cprm_gym.benchmark.chapter5.conditions import CONDITIONS
from cprm_gym.benchmark.chapter5.experiments import EXPERIMENTS, slow
from cprm_gym.benchmark.chapter5.players import LATE, NET, ON, REFLEXES
from cprm_gym.benchmark.chapter5.slow import Slow
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.plan import Block
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError
from cprm_gym.wrappers.disturbances import DISTURBANCES


def play(task, key, count=12, first=0, seed=3):
    return play_cell(Block(task, key, first, count, seed))


class Echo:
    """Keeps what it is told."""

    needs = ("memory",)

    def reset(self, observation, seed, worlds=None):
        self.told = []

    def act(self, observation):
        self.told.append({key: np.array(observation[key]) for key in ("self", "memory", "memory_age", "body", "age")})
        return no_action(len(observation["level"]))


def told(period, latency, reflexes, cycles=12):
    found = []

    def make(task, agent):
        player = Slow(informed(lambda task, agent: Echo(), "memory")(task, agent), period, latency, reflexes)
        found.append(player.player.controller)
        return player

    play_episodes(make_task("Goalie"), make, 3, 5, slots=3, most=cycles)
    return found[0].told


@pytest.mark.parametrize(("period", "latency"), [(1, 0), (1, 3), (4, 0), (3, 2)])
def test_what_is_told_is_what_the_inference_that_has_ended_said(period, latency):
    now, late = told(1, 0, False), told(period, latency, False)
    for t, heard in enumerate(late):
        begun = [c for c in range(0, t - latency + 1) if c % period == 0]
        source = begun[-1] if begun else 0
        np.testing.assert_array_equal(heard["memory"], now[source]["memory"])
        np.testing.assert_array_equal(heard["body"], now[source]["body"])
        np.testing.assert_allclose(heard["memory_age"], np.minimum(now[source]["memory_age"] + t - source, 1000.0))


def test_reflexes_are_told_of_this_cycle_where_the_ball_is_seen():
    now, late = told(1, 0, False), told(1, 4, True)
    for t in range(5, len(now)):
        np.testing.assert_array_equal(late[t]["body"], now[t]["body"])
        seen = now[t]["memory_age"][:, 0] == 0
        np.testing.assert_array_equal(late[t]["memory"][seen, 0], now[t]["memory"][seen, 0])
        np.testing.assert_array_equal(late[t]["memory"][:, 1:], now[t - 4]["memory"][:, 1:])


def test_knowledge_that_is_not_late_changes_nothing():
    plain, slow = play("Goalie", f"default/{NET}{ON}memory"), play("Goalie", f"default/fsm{ON}memory{LATE}")
    same_one = play("Goalie", f"default/fsm{ON}memory")
    assert (slow.success, slow.cycles) == (same_one.success, same_one.cycles)
    assert plain.more["asked"] == play("Goalie", f"default/{NET}{ON}memory").more["asked"]


def test_regions_that_see_are_compared_with_those_that_infer_alone():
    conditions = ("default", "inference 10 late")
    names = (slow.SEEING, slow.REGIONS)
    results = [play("Goalie", f"{where}/{name}", 40) for where in conditions for name in names]
    (told,) = summarise(Chapter5Plan(("slow",)), results).told
    assert [(c.condition, c.first, c.second) for c in told.comparisons] == [(where, *names) for where in conditions]
    late = told.comparisons[1]
    assert late.better == slow.SEEING
    (finding,) = told.findings
    assert finding.verdict == "holds"
    assert "Reflexes put belief regions ahead in 1 of 1 kinds of slowness" in finding.figure


def test_periods_and_latencies_that_there_are_not_are_refused():
    with pytest.raises(ParameterError, match="period 0 and latency 0"):
        Slow(None, 0, 0)


def test_late_knowledge_answers_later_and_saves_less():
    key = f"inference 5 late/{NET}{ON}memory"
    late, quick = play("Goalie", key + LATE, 60), play("Goalie", key + REFLEXES, 60)
    assert sum(late.success) + 10 < sum(quick.success)
    medians = [np.median([a for a in r.more["answer"] if a is not None]) for r in (late, quick)]
    assert medians[0] >= medians[1] + 2


def test_the_strike_of_an_episode_is_the_same_in_any_slots_and_blocks():
    whole = play("KickOffShot", "ball displaced/fsm", 60)
    part = play("KickOffShot", "ball displaced/fsm", 5, first=52)
    for name in ("success", "cycles"):
        assert getattr(whole, name)[52:57] == getattr(part, name)
    for name in ("struck", "again"):
        assert whole.more[name][52:57] == part.more[name]
    assert sum(whole.more["struck"]) > 20
    assert set(DISTURBANCES) <= set(CONDITIONS)


def test_the_goalie_is_struck_before_the_shot_is_over():
    conditions = {one.cell.condition for one in EXPERIMENTS["disturbances"].wanted(FULL) if one.cell.task == "Goalie"}
    assert conditions == {"default", *(name + " early" for name in DISTURBANCES)}
    late, early = play("Goalie", "player displaced/fsm", 60), play("Goalie", "player displaced early/fsm", 60)
    assert sum(late.more["struck"]) < 6
    assert sum(early.more["struck"]) > 50
    assert sum(early.success) < sum(late.success)


def test_structures_of_the_goalie_are_compared_with_the_net_that_knows_what_they_know():
    results = [play("Goalie", f"blind spell early/{name}", 4) for name in ("cprm", NET, "fsm", "policy", "scripted")]
    (told,) = summarise(Chapter5Plan(("disturbances",)), results).told
    assert [(c.first, c.second) for c in told.comparisons] == [("cprm", NET), (NET, "fsm"), ("cprm", "policy"), ("cprm", "scripted")]
