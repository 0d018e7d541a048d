"""Lesions: what is taken out is out, the rest stays, and what is not there cannot be taken out."""

import numpy as np
import pytest
from cprm_baselines.lesions import LESIONS, main, make_controller

from cprm_gym.agents.intention import Told
from cprm_gym.agents.play import agent_in
from cprm_gym.agents.registry import make_controller as cprm
from cprm_gym.benchmark.recovery import Watchdog
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError, UnknownName

TASK = make_task("Goalie")


def played(controller, cycles=15, worlds=4):
    """The actions in some worlds, and after each cycle what `look` says of the controller."""
    core = SoccerCore(TASK, worlds, seed=6, include=controller.needs)
    observation = {key: value[:, 0] for key, value in core.reset(6).items()}
    controller.reset(observation, 6)
    runner, sent, relations, believed = None, [], [], []
    for _ in range(cycles):
        action = controller.act(observation)
        sent.append({key: np.array(value) for key, value in action.items()})
        agent = agent_in(controller)
        if agent is not None:
            runner = agent.controller
            if runner.bank is not None:
                relations.append(runner.relations(0))
                believed.append((observation["level"][:, 0] > 0, np.array(runner.executor.read("ball_x"))))
        core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
    return sent, relations, believed


def test_without_relations_none_comes_into_force():
    assert any(held for held in played(cprm(TASK, "left_1", model="bins"))[1])
    assert not any(held for held in played(make_controller(TASK, "left_1", "relations"))[1])


def test_without_time_what_was_seen_is_forgotten_in_the_next_cycle():
    """Where the ball is not seen, all that is left is the prior, whatever was seen before."""
    blind = np.concatenate([x[~seen] for seen, x in played(make_controller(TASK, "left_1", "time"))[2]])
    assert len(blind) > 5
    assert np.ptp(blind) < 1e-6
    whole = np.concatenate([x[~seen] for seen, x in played(cprm(TASK, "left_1", model="bins"))[2][2:]])
    assert np.ptp(whole) > 1.0


def test_without_looking_neither_neck_nor_view_is_moved():
    assert any(np.any(action["turn_neck"]) for action in played(cprm(TASK, "left_1"))[0])
    sent = played(make_controller(TASK, "left_1"))[0]
    assert not any(np.any(action["turn_neck"]) or np.any(action["view"]) for action in sent)
    assert any(np.any(action["type"]) for action in sent)


def test_without_reflexes_he_acts_otherwise():
    whole, bare = (played(c, 20)[0] for c in (cprm(TASK, "left_1", model="bins"), make_controller(TASK, "left_1", "reflexes")))
    assert any(np.any(a["params"] != b["params"]) for a, b in zip(whole, bare, strict=True))


@pytest.mark.parametrize("part", ["intention", "attention", "mind"])
def test_without_a_part_of_the_intention_he_acts_otherwise(part):
    whole, bare = (played(c, 25, 12)[0] for c in (cprm(TASK, "left_1", model="intention"), make_controller(TASK, "left_1", part)))
    assert any(np.any(a["params"] != b["params"]) for a, b in zip(whole, bare, strict=True))


def test_without_intention_no_shot_is_ever_expected():
    core = SoccerCore(TASK, 12, seed=6, include=("memory",))
    for part, some in (("attention", True), ("intention", False)):
        controller = make_controller(TASK, "left_1", part)
        observation = {key: value[:, 0] for key, value in core.reset(6).items()}
        controller.reset(observation, 6)
        chances = []
        for _ in range(25):
            action = controller.act(observation)
            chances.append(controller.known["intention"][:, Told.CHANCE])
            core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
        assert (np.max(chances) > 0.05) == some


@pytest.mark.parametrize("given", [{"tier": "memory"}, {"t_b": 5}])
def test_who_expects_shots_has_no_other_tier_and_no_options(given):
    with pytest.raises(ParameterError, match=next(iter(given))):
        cprm(TASK, "left_1", model="intention", **given)


def test_who_is_watched_has_a_watchdog():
    task = make_task("PassAndAdvance")
    assert isinstance(make_controller(task, "left_1", "recovery", watched=True), Watchdog)
    assert not isinstance(make_controller(task, "left_1", "recovery"), Watchdog)


@pytest.mark.parametrize("part", sorted({*LESIONS} - {"looking"}))
def test_a_part_that_an_agent_has_not_is_refused(part):
    with pytest.raises(ParameterError, match=r"Hike"):
        make_controller(make_task("Hike"), "left_1", part)


def test_an_unknown_part_is_refused():
    with pytest.raises(UnknownName, match="relations"):
        make_controller(TASK, "left_1", "relation")


def test_the_command_measures_parts_beside_the_whole_in_the_same_worlds(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["lesions", "--without", "looking,looking+watched", "--whole", "lesion", "--episodes", "4"])
    main()
    whole, one, watched = (line.split(" | ") for line in capsys.readouterr().out.splitlines()[-3:])
    assert whole[0] == "| nothing: lesion"
    assert one[1] == whole[1]
    assert one[2].startswith("+0.0 (")
    assert watched[0] == "| looking+watched"
    monkeypatch.setattr("sys.argv", ["lesions", "--task", "Hike", "--without", "time"])
    with pytest.raises(SystemExit):
        main()
    assert "Hike has no model" in capsys.readouterr().err
