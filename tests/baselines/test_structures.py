"""Every structure plays every task that it claims, in batch as alone, and remembers nothing across a reset."""

import numpy as np
import pytest
from cprm_baselines import behavior_tree, belief_region, code, fsm, subsumption
from cprm_baselines.behaviour.layers import Layer, Layers
from cprm_baselines.behaviour.machine import Machine, Move, State
from cprm_baselines.behaviour.regions import Region, Regions
from cprm_baselines.behaviour.scenes import make_scene
from cprm_baselines.structures import compare, main

from cprm_gym import make_task
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.others.registry import controller_entries
from cprm_gym.errors import ModelError, UnknownName

STRUCTURES = {"fsm": fsm, "subsumption": subsumption, "behavior_tree": behavior_tree, "code": code, "belief_region": belief_region}
TASKS = {
    "fsm": tuple(fsm.TABLES), "subsumption": tuple(subsumption.LAYERS), "behavior_tree": tuple(behavior_tree.TREES),
    "code": tuple(code.PROGRAMS), "belief_region": tuple(belief_region.POLICIES),
}  # fmt: skip
OTHER_STEPS = {
    *("PassAndAdvance2v2", "PassAndAdvance2v3", "HFO1v1", "HFO2v2", "HFO3v2", "HFO3v3", "HFO4v5", "Keepaway4v3", "Keepaway5v4"),
    *("FrontGoalEmptyGoal", "FrontGoalBlockedShot", "FrontGoalSupportOption", "FrontGoalPassingLane"),
}
"""Between the first and the last of their kind."""
PLAYED = [(name, task) for name, tasks in TASKS.items() for task in tasks if task not in OTHER_STEPS]
LEAST = {
    "Hike": 0.9,
    "GoToBall": 0.9,
    "KickOffShot": 0.8,
    "PassAndAdvance": 0.8,
    "KickOffShot2v2": 0.6,
    "PassAndAdvance2v1": 0.6,
    "Goalie": 0.6,
    "Goalie2v1": 0.6,
    "Goalie3v2": 0.5,
    "LostAndFound": 0.6,
    "HFO1v0": 0.85,
    "HFO2v1": 0.6,
    "FrontGoalCompactDefense": 0.4,
}
"""Share of 20 worlds that each structure wins at least; it is far higher in most."""


def test_who_has_no_memory_never_gets_home():
    """The same belief in the middle of the way, the same command: out and home cannot both be right (dissertation 5.3.2)."""
    played = play_episodes(make_task("Hike"), belief_region.make_controller, 20, seed=3)
    assert not played.success.any()


@pytest.mark.parametrize(("name", "task"), [pair for pair in PLAYED if pair[1] in LEAST and pair != ("belief_region", "Hike")])
def test_each_wins(name, task):
    played = play_episodes(make_task(task), STRUCTURES[name].make_controller, 20, seed=3)
    assert played.success.mean() >= LEAST[task]


@pytest.mark.parametrize("name", STRUCTURES)
def test_each_keeps_the_ball(name):
    """Keepaway is a matter of how long; nobody lasts to its end. Who holds it at random loses it within four seconds."""
    assert set(LEAST) == {task for _, task in PLAYED} - {"Keepaway3v2"}
    played = play_episodes(make_task("Keepaway3v2"), STRUCTURES[name].make_controller, 20, seed=3)
    assert played.cycles.mean() >= 80


@pytest.mark.parametrize(
    ("name", "task"), [(n, t) for n, t in PLAYED if t in ("GoToBall", "Goalie", "KickOffShot", "LostAndFound", "HFO2v1")]
)
def test_alone_as_in_batch(name, task):
    batch = play_episodes(make_task(task), STRUCTURES[name].make_controller, 4, seed=8)
    for k in range(2):
        alone = play_episodes(make_task(task), STRUCTURES[name].make_controller, 1, seed=8, first_world=k)
        assert alone.cycles[0] == batch.cycles[k]
        assert alone.success[0] == batch.success[k]


@pytest.mark.parametrize("name", STRUCTURES)
def test_an_episode_begins_without_memory_of_the_last_one(name):
    """The second time round the same worlds are played in the same way, also where single worlds begin anew."""
    task = make_task("Goalie")
    controller = STRUCTURES[name].make_controller(task, "left_1")
    runs = []
    for chosen in (None, np.ones(3, bool)):
        core = SoccerCore(task, 3, seed=4, include=("memory",))
        observation = core.reset(4)
        controller.reset({key: value[:, 0] for key, value in observation.items()}, 4, chosen)
        sent = []
        for _ in range(25):
            action = controller.act({key: value[:, 0] for key, value in observation.items()})
            core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
            sent.append(np.concatenate([np.asarray(action["params"]).ravel(), np.asarray(action["turn_neck"]).ravel()]))
        runs.append(np.array(sent))
    np.testing.assert_array_equal(runs[0], runs[1])


@pytest.mark.parametrize("name", STRUCTURES)
def test_what_cannot_be_played_is_refused(name):
    assert name in controller_entries()
    with pytest.raises(UnknownName, match=f"controller '{name}'.*KickOffShot"):
        STRUCTURES[name].make_controller(make_task("Soccer"), "left_1")


def test_tables_are_checked_when_they_are_made():
    scene = make_scene(make_task("Goalie"), "left_1")
    with pytest.raises(ModelError, match=r"no state 'sav'. Did you mean 'save'"):
        Machine(scene, {"watch": State(moves=(Move("sav", "coming"),)), "save": State(order="x")})
    with pytest.raises(ModelError, match=r"nothing follows on .*missed"):
        Machine(scene, {"save": State("save", on={"caught": "save"})})
    with pytest.raises(ModelError, match=r"no outcome 'cauht'. Did you mean 'caught'"):
        Layers(scene, (Layer("save", "coming", skill="save", sets={"cauht": ("held", 3)}),), "")
    with pytest.raises(ModelError, match=r"says nothing"):
        Layers(scene, (Layer("save", "coming"),), "")
    with pytest.raises(ModelError, match=r"one of both"):
        Regions(scene, (Region("anywhere", "1"),))


def test_a_condition_on_what_is_not_there_is_named():
    scene = make_scene(make_task("Goalie"), "left_1")
    scene.begin(2)
    scene.see(dict.fromkeys(scene.sheet.names, np.zeros(2)))
    with pytest.raises(UnknownName, match=r"ball_agge"):
        scene.holds("ball_agge > 3")


def test_a_higher_layer_suppresses_the_lower_one_for_as_long_as_it_holds():
    scene = make_scene(make_task("KickOffShot"), "left_1")
    layers = Layers(scene, (Layer("low", "1", order="sweep"), Layer("high", "ball_age < 1", order="face", holds=2)), "")
    scene.begin(1)
    layers.begin(1, 0)
    sent = []
    for age in (5.0, 0.0, 5.0, 5.0, 5.0):
        percepts = dict.fromkeys(scene.sheet.names, np.zeros(1))
        percepts["ball.age"] = np.array([age])
        scene.see(percepts)
        layers.decide(scene)
        number = scene.chosen[0, 0]
        sent.append(scene.commands[number][1]["moment"] if number >= 0 else None)
    assert sent == ["turn_moment", "face_moment", None, "turn_moment", "turn_moment"]


def test_regions_that_overlap_send_a_command_to_body_and_neck():
    scene = make_scene(make_task("KickOffShot"), "left_1")
    regions = Regions(scene, (Region("a", "1", order="sweep"), Region("b", "1", order="face")), (Region("c", "1", order="look"),))
    scene.begin(1)
    scene.see(dict.fromkeys(scene.sheet.names, np.zeros(1)))
    regions.decide(scene)
    assert [scene.commands[k][0] for k in scene.chosen[0]] == ["turn", "look"]
    assert scene.commands[scene.chosen[0, 0]][1] == {"moment": "turn_moment"}


def test_structure_by_knowledge():
    rows = compare("Goalie", "noise .5", ("frozen", "state"), ("net", "fsm", "code"), episodes=30)
    assert [(row.structure, row.tier) for row in rows] == [(s, t) for t in ("frozen", "state") for s in ("net", "fsm", "code")]
    assert all(row.success > 0.7 for row in rows if row.tier == "state")
    assert all(row.success < 0.8 for row in rows if row.tier == "frozen")
    assert rows[0].difference is None
    assert rows[1].difference[0] == pytest.approx(rows[1].success - rows[0].success)
    with pytest.raises(UnknownName, match=r"unknown senses 'nois \.5'"):
        compare("Goalie", "nois .5")
    with pytest.raises(UnknownName, match=r"unknown structure 'fms'\. Did you mean 'fsm'"):
        compare("Goalie", structures=("fms",))


def test_the_command_says_so_where_nobody_plays_the_task(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["structures", "--task", "Soccer", "--structures", "fsm,code", "--episodes", "2"])
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 2
    assert "plays Soccer" in capsys.readouterr().err
