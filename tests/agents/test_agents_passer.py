"""The passing pair: it advances by passing and scores; what goes wrong is noticed, passed up and repaired."""

from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.agents.passer import PASSER_NET, make_controller, passer_net
from cprm_gym.agents.registry import AGENTS
from cprm_gym.architecture.petri import flatten
from cprm_gym.benchmark.recovery import measure
from cprm_gym.benchmark.runner import Block, play_block
from cprm_gym.benchmark.statistics import wilson_interval
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.wrappers.disturbances import DISTURBANCES


def with_recovery(task, agent):
    return make_controller(task, agent)


def without_recovery(task, agent):
    return make_controller(task, agent, recovering=False)


def test_it_completes_its_advance_undisturbed():
    result = measure(with_recovery, None, episodes=100, seed=4)
    assert wilson_interval(int(result.success.sum()), 100).low > 0.9
    assert not result.struck.any()


@pytest.mark.slow
def test_it_completes_its_advance_in_at_least_80_percent_of_a_thousand():
    assert measure(with_recovery, None, episodes=1000, seed=21).interval.low >= 0.8


@pytest.mark.parametrize("name", DISTURBANCES)
def test_under_each_disturbance_the_recovering_pair_succeeds_more_often(name):
    disturbance, task = replace(DISTURBANCES[name], first=20, last=120), replace(make_task("PassAndAdvance"), max_cycles=500)
    recovering = measure(with_recovery, disturbance, episodes=60, seed=2, task=task)
    without = measure(without_recovery, disturbance, episodes=60, seed=2, task=task)
    assert recovering.interval.low > without.interval.high
    again, struck = recovering.recovered
    assert struck > 50
    assert again > 0.9 * struck
    assert 1.0 <= recovering.median_time < 100.0


def test_the_net_without_recovery_is_a_part_of_the_net_with_it():
    small, large = flatten(passer_net(recovering=False)), flatten(passer_net(recovering=True))
    assert set(small.transitions) < set(large.transitions)
    assert set(small.places) < set(large.places)


def test_every_error_of_a_skill_is_taken_by_some_recovery():
    taken = {place for t in PASSER_NET.transitions for place in t.inputs}
    errors = {f"{name}.{port}" for name, module in PASSER_NET.modules.items() for port in module.ports.errors}
    # nobody aborts passing, receive and shoot
    assert errors - taken <= {"passing.aborted", "receive.aborted", "shoot.aborted"}
    lost = {place for t in passer_net(recovering=False).transitions for place in t.inputs}
    assert {"passing.failed", "receive.missed", "go.lost_ball"}.isdisjoint(lost)


def played(seed, cycles, after_step=None):
    """Plays one world with traced players; the transitions that each fired."""
    task = make_task("PassAndAdvance")
    core = SoccerCore(task, 1, seed=seed, include=("memory",))
    players = [make_controller(task, agent) for agent in core.agents]
    observation = core.reset(seed)
    for i, player in enumerate(players):
        player.options["trace"] = True
        player.reset({k: v[:, i] for k, v in observation.items()}, seed)
    for _ in range(cycles):
        actions = [player.act({k: v[:, i] for k, v in observation.items()}) for i, player in enumerate(players)]
        core.step({k: np.stack([a[k] for a in actions], axis=1) for k in actions[0]})
        if after_step:
            after_step(core, players)
    return core, [[f.transition for f in p.controller.executor.trace.firings(0)] for p in players]


def test_a_coming_ball_aborts_the_advance_and_begins_to_receive():
    _, fired = played(0, 60)
    assert any({"hold", "get_ready", "take"} <= set(f) for f in fired)
    for f in fired:
        for k, name in enumerate(f):
            if name == "hold":
                assert "advance.stop_ready" in f[k : k + 4] or "advance.stop_acted" in f[k : k + 4]


def test_a_pass_whose_ball_is_stopped_at_once_has_failed_and_is_made_again():
    def stop(core, players):
        for number, player in zip(core.players, players):
            if player.controller.executor.read("passing.kick.acted")[0] and core.cycle[0] < 25:
                core.place_ball(np.array([0]), core.sim.world["pos"][:, number] + [0.7, 0.0])

    _, fired = played(0, 120, stop)
    assert any("passing.stuck" in f and "pass_again" in f and "go_on" in f[f.index("passing.stuck") :] for f in fired)


def test_each_player_is_told_only_what_he_sees_himself():
    assert AGENTS["PassAndAdvance"] == "passer"
    result = play_block(Block("PassAndAdvance", "cprm", 0, 6, 0))
    assert result.error is None
    assert sum(result.success) >= 5
    assert result.decisions == 2 * result.played
