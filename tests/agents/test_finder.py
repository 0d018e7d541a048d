"""The finder: looks where the ball can be, outwards from there, meets it, and finds the more the more he knows."""

import numpy as np
import pytest

from cprm_gym.agents.finder.agent import FINDER_NET, finder_net, finder_percepts, make_controller
from cprm_gym.agents.knowledge import informed
from cprm_gym.agents.knowledge.players import ANYWHERE
from cprm_gym.agents.skills.constants import FinderConstants
from cprm_gym.architecture.petri import Executor
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.players.senses import Senses
from cprm_gym.envs.tasks import make_task

BALL_BEHIND = {"ball.x": -10.0, "ball.y": 2.0, "ball.vx": -1.0, "ball.vy": 0.5, "ball.age": 4.0, "me.x": 0.0, "me.y": 0.0,
               "me.facing_deg": 0.0, "me.vx": 0.0, "me.vy": 0.0, "body.speed": 0.0, "body.fresh": 1.0, "body.neck_deg": 0.0,
               "body.half_view_deg": 30.0}  # fmt: skip


def cycle(executor, **changes):
    return executor.step({name: {**BALL_BEHIND, **changes}[name] for name in executor.input_names}).of(0)


def test_he_looks_where_the_ball_is_expected_and_turns_where_the_neck_does_not_reach():
    commands = cycle(Executor(FINDER_NET))
    expected = np.degrees(np.arctan2(2.5, -11.0))
    assert commands["look"]["direction"] == pytest.approx(expected, abs=0.1)
    assert commands["turn"]["moment"] == pytest.approx(expected, abs=0.5)


def test_looks_that_do_not_show_it_go_outwards_the_side_to_which_it_went_first():
    executor, step = Executor(FINDER_NET), FinderConstants().step
    ahead = {"ball.x": 20.0, "ball.y": 0.0, "ball.vx": 0.0, "ball.vy": 0.8}
    gazes, neck = [], 0.0
    for _ in range(6):
        neck = cycle(executor, **ahead, **{"body.neck_deg": neck})["look"]["direction"]
        gazes.append(neck)
    middle = np.degrees(np.arctan2(0.8, 20.0))
    assert np.array(gazes) - middle == pytest.approx([step, -step, 2 * step, -2 * step, 3 * step, -3 * step], abs=0.1)
    back = cycle(executor, **ahead, **{"ball.age": 0.0, "body.neck_deg": neck})["look"]["direction"]
    assert back == pytest.approx(middle, abs=0.1), "it was seen: from the middle again"


@pytest.mark.parametrize("blind", [{"body.fresh": 0.0}, {"body.neck_deg": 80.0}], ids=["eyes shut", "looked elsewhere"])
def test_a_look_that_was_not_there_says_nothing(blind):
    executor = Executor(FINDER_NET)
    ahead = {"ball.x": 20.0, "ball.y": 0.0, "ball.vx": 0.0, "ball.vy": 0.0}
    for _ in range(3):
        assert cycle(executor, **{**ahead, **blind})["look"]["direction"] == pytest.approx(0.0, abs=0.1)
    assert executor.read("eyes.missed")[0] == 0


def test_he_meets_a_rolling_ball_instead_of_running_after_it():
    commands = cycle(Executor(FINDER_NET), **{"ball.x": 10.0, "ball.y": -5.0, "ball.vx": 0.0, "ball.vy": 0.6, "ball.age": 0.0})
    assert "dash" in commands, "the ball comes into his way"
    straight = cycle(Executor(FINDER_NET), **{"ball.x": 10.0, "ball.y": -5.0, "ball.vx": 0.0, "ball.vy": 0.0, "ball.age": 0.0})
    assert straight["turn"]["moment"] < -20.0


def test_beyond_his_trust_he_does_not_run_on():
    net = finder_net(constants=FinderConstants(trust=10.0))
    far = {"ball.x": 20.0, "ball.y": 0.0, "ball.vx": 0.0, "ball.vy": 0.0, "body.fresh": 0.0}
    assert "dash" in cycle(Executor(net), **far, **{"ball.age": 9.0})
    assert "dash" not in cycle(Executor(net), **far, **{"ball.age": 10.0})


def test_every_constant_stands_in_the_net():
    for name, (low, high) in FinderConstants.extents().items():
        other = low if getattr(FinderConstants(), name) != low else high
        assert finder_net(constants=FinderConstants.of({name: other})) != FINDER_NET, name


def rate(tier, senses, count=100):
    return play_episodes(make_task("LostAndFound"), informed(make_controller, tier, senses), count, 4, senses=senses).success.mean()


def test_he_finds_the_more_the_more_he_knows():
    senses = Senses(lost=0.8)
    frozen, memory, state = (rate(tier, senses) for tier in ("frozen", "memory", "state"))
    assert frozen + 0.12 < memory < state - 0.12
    assert state > 0.8


@pytest.mark.parametrize("tier", ANYWHERE)
def test_a_world_is_played_the_same_alone_and_in_a_batch(tier):
    senses, task = Senses(lost=0.5), make_task("LostAndFound")
    batch = play_episodes(task, informed(make_controller, tier, senses), 5, 3, senses=senses)
    alone = play_episodes(task, informed(make_controller, tier, senses), 1, 3, 2, senses=senses)
    assert (batch.success[2], batch.cycles[2]) == (alone.success[0], alone.cycles[0])


def test_his_percepts_are_the_memorys_and_the_view_he_has():
    core = SoccerCore("LostAndFound", 3, seed=1, include=("memory",))
    seen = {key: value[:, 0] for key, value in core.reset(1).items()}
    percepts = finder_percepts(seen)
    assert percepts["ball.vx"] == pytest.approx(seen["memory"][:, 0, 2])
    assert percepts["body.half_view_deg"].tolist() == [30.0] * 3
