"""The eleven: its beliefs and choices, one at a time and as a team; set plays; alone and in a batch alike."""

from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.agents.catalogue import shipped_net
from cprm_gym.agents.eleven import Eleven, make_controller
from cprm_gym.agents.goalie import GoalieAgent
from cprm_gym.agents.kernels import outfield as kernels
from cprm_gym.agents.outfielder.agent import OUTFIELDER, OUTFIELDER_NET, OutfieldAgent
from cprm_gym.agents.outfielder.model import OUTFIELD_MODEL
from cprm_gym.agents.outfielder.percepts import outfield_attributes, outfield_percepts, terms
from cprm_gym.agents.registry import WITH_MODEL
from cprm_gym.agents.registry import make_controller as registered
from cprm_gym.architecture.cprm import cprm_from_json, cprm_to_json
from cprm_gym.architecture.petri import instances
from cprm_gym.architecture.petri.drawing.dot import to_dot
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import BodyFeature, SelfFeature
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import UnknownName
from cprm_gym.simulator.pitch import HALF_LENGTH
from cprm_gym.simulator.state import Count, PlayMode

MATCH = make_task("Soccer11v11")


def seen(unum=10, me=(0.0, 0.0), ball=(10.0, 0.0), ball_velocity=(0.0, 0.0), mates=None, opponents=None, mode=PlayMode.play_on, copies=1):
    """What a player of the left team has just seen, all of it known; x, y of team-mates and opponents by number."""
    observation = {
        "body": np.zeros((copies, len(BodyFeature))), "ball": np.zeros((copies, 4)), "players": np.zeros((copies, 22, 7)),
        "level": np.full((copies, 23), 3.0), "age": np.zeros((copies, 23)), "self": np.zeros((copies, len(SelfFeature))),
        "memory": np.zeros((copies, 23, 4)), "memory_age": np.full((copies, 23), 1000.0),
    }  # fmt: skip
    body = observation["body"]
    body[:, BodyFeature.STAMINA], body[:, BodyFeature.EFFORT], body[:, BodyFeature.FRESH] = 8000.0, 1.0, 1.0
    body[:, BodyFeature.SIDE], body[:, BodyFeature.UNUM], body[:, BodyFeature.PLAY_MODE] = 1.0, unum, int(mode)
    observation["self"][:, SelfFeature.X], observation["self"][:, SelfFeature.Y], observation["self"][:, SelfFeature.LOCATED] = *me, 1.0
    observation["memory"][:, 0] = (*ball, *ball_velocity)
    observation["memory_age"][:, 0] = 0.0
    dx, dy = ball[0] - me[0], ball[1] - me[1]
    observation["ball"][:, 0], observation["ball"][:, 1] = np.hypot(dx, dy), np.arctan2(dy, dx)
    for first, players in ((0, mates or {}), (11, opponents or {})):
        for number, (x, y) in players.items():
            observation["memory"][:, first + number, :2] = x, y
            observation["memory_age"][:, first + number] = 0.0
    observation["memory"][:, unum, :2], observation["memory_age"][:, unum] = me, 0.0
    return observation


def decided(agent, observation, cycles=1, **change):
    """The agent's net after some cycles of the same view."""
    agent.reset(observation, 0)
    for _ in range(cycles):
        action = agent.act(observation)
    executor = agent.controller.executor
    return executor, action


def test_the_net_and_its_model_come_back_from_json_equal():
    assert cprm_from_json(cprm_to_json(OUTFIELDER)) == OUTFIELDER


def test_the_net_is_shipped_named_and_drawn_with_its_skills():
    assert shipped_net("outfielder") is OUTFIELDER_NET
    names = {instance.net.name for path, instance in instances(OUTFIELDER_NET).items() if path}
    assert names >= {"advance", "clear", "drive", "go_to_ball_reflex", "kick", "pass_ball", "receive", "setup", "shoot"}
    picture = to_dot(OUTFIELDER_NET)
    assert "with_ball" in picture


def test_the_ball_is_two_copies_of_one_component_and_players_are_components_of_their_own():
    assert {c.name for c in OUTFIELD_MODEL.classes} == {"Ball", "Player", "Opponent", "Teammate"}
    agent = OutfieldAgent()
    decided(agent, seen(me=(9.5, 0.0), ball=(10.0, 0.0), mates={2: (20.0, 5.0)}, opponents={3: (30.0, 0.0), 1: (50.0, 0.0)}), cycles=4)
    assert agent.controller.relations(0) == ("attendedOpponent(o3)", "attendedTeammate(t2)")


def test_an_opponent_at_the_ball_possesses_it_and_then_it_is_believed_to_come():
    beliefs = []
    for x in (30.0, 10.8):
        agent = OutfieldAgent()
        view = seen(me=(-20.0, 0.0), ball=(10.0, 0.0), opponents={3: (x, 0.0)})
        decided(agent, view, cycles=6)
        assert ("possessesOpponent(o3,ball)" in agent.controller.relations(0)) == (x < 20)
        view["memory_age"][:, 0], view["level"][:, 0], view["body"][:, BodyFeature.FRESH] = 5.0, 0.0, 0.0
        for _ in range(4):
            agent.act(view)
        beliefs.append(agent.controller.executor.read("ball_x")[0])
    assert beliefs[0] == pytest.approx(10.0, abs=1.5)
    assert beliefs[1] < beliefs[0] - 0.5


def test_he_who_is_first_at_the_ball_goes_and_the_others_hold_their_places():
    executor, _ = decided(OutfieldAgent(), seen(ball=(10.0, 0.0), mates={9: (30.0, 0.0)}))
    assert executor.read("go.ongoing")[0] == 1
    executor, _ = decided(OutfieldAgent(), seen(ball=(10.0, 0.0), mates={9: (8.0, 0.0)}))
    assert executor.read("walk.ongoing")[0] == 1
    assert executor.read("mates_time")[0] < executor.read("me_time")[0]


def test_a_rolling_ball_is_met_on_its_way_and_a_coming_one_received():
    executor, _ = decided(OutfieldAgent(), seen(ball=(10.0, 5.0), ball_velocity=(1.0, 0.0)))
    assert executor.read("run.ongoing")[0] == 1
    assert executor.read("meet_x")[0] > 15.0
    executor, _ = decided(OutfieldAgent(), seen(ball=(10.0, 0.0), ball_velocity=(-1.2, 0.0)))
    assert executor.read("receive.ongoing")[0] == 1


def test_with_the_ball_he_shoots_in_range_passes_to_the_best_else_drives():
    at_goal = seen(me=(40.0, 0.0), ball=(40.7, 0.0))
    executor, _ = decided(OutfieldAgent(), at_goal)
    assert executor.read("shoot.ongoing")[0] == 1
    free = {"mates": {5: (20.0, 2.0), 7: (22.0, -14.0)}, "opponents": {1: (50.0, 0.0), 2: (40.0, 0.0)}}
    executor, _ = decided(OutfieldAgent(), seen(me=(0.0, 0.0), ball=(0.7, 0.0), **free))
    assert executor.read("passing.ongoing")[0] == 1
    assert executor.holds("receiver")[0] == 6
    executor, _ = decided(OutfieldAgent(), seen(me=(0.0, 0.0), ball=(0.7, 0.0), opponents={1: (50.0, 0.0), 2: (40.0, 0.0)}))
    assert executor.read("drive.ongoing")[0] == 1


def test_pressed_he_passes_in_haste_and_offside_team_mates_get_no_pass():
    press = {2: (1.5, 1.0), 1: (50.0, 0.0), 3: (40.0, 20.0)}
    executor, _ = decided(OutfieldAgent(), seen(ball=(0.7, 0.0), mates={7: (12.0, -12.0)}, opponents=press), cycles=1)
    assert executor.holds("receiver")[0] == 6
    attending = OutfieldAgent()
    executor, _ = decided(attending, seen(ball=(1.4, 0.0), mates={7: (12.0, -12.0)}, opponents=press), cycles=3)
    attending.act(seen(ball=(0.7, 0.0), mates={7: (12.0, -12.0)}, opponents=press))
    assert executor.read("pressed")[0] == 1
    assert executor.read("can_pass")[0] == 1
    assert executor.read("unmolested")[0] == executor.read("can_shoot")[0] == 0
    executor, _ = decided(OutfieldAgent(), seen(ball=(0.7, 0.0), mates={7: (20.0, -12.0)}, opponents={2: (15.0, 3.0), 1: (50.0, 0.0)}))
    assert executor.holds("receiver")[0] == -1


def test_the_receiver_is_believed_where_he_stands_once_he_is_attended_to():
    agent = OutfieldAgent()
    executor, _ = decided(agent, seen(ball=(2.5, 0.0), mates={7: (12.3, -12.0)}, opponents={1: (50.0, 0.0), 3: (40.0, 20.0)}), cycles=4)
    assert executor.read("mate_x")[0] == pytest.approx(12.3, abs=1.0)
    assert executor.read("sure")[0] == 1


def test_a_set_play_of_theirs_keeps_the_distance_and_one_of_ours_is_taken():
    executor, _ = decided(OutfieldAgent(), seen(me=(8.0, 0.0), ball=(10.0, 0.0), mode=PlayMode.free_kick_r))
    assert executor.read("walk.ongoing")[0] == 1
    away = np.hypot(executor.read("go_x") - 10.0, executor.read("go_y"))[0]
    assert away >= 9.15
    executor, action = decided(OutfieldAgent(), seen(ball=(0.7, 0.0), mates={7: (12.0, -12.0)}, mode=PlayMode.free_kick_l))
    assert action["params"][0, 0] > 0.1
    assert executor.read("taking.ongoing")[0] == 1


def test_after_his_set_play_he_leaves_the_ball_to_others_until_it_has_gone():
    agent = OutfieldAgent()
    executor, _ = decided(agent, seen(ball=(0.7, 0.0), mode=PlayMode.free_kick_l))
    for x in (2.0, 4.0, 6.0):
        action = agent.act(seen(ball=(x, 0.0), ball_velocity=(1.5, 0.0)))
        assert action["type"][0] == 0
        assert executor.read("hands_off")[0] == 1 or executor.read("taking.ongoing")[0] == 1
    for _ in range(2):
        agent.act(seen(ball=(9.0, 0.0), ball_velocity=(1.5, 0.0)))
    assert executor.read("hands_off")[0] == 0


MEN = {2: (-34.0, -9.0), 5: (-33.0, 17.0)}
"""Number of a back -> where an opponent stands in his part of the own half."""


def where_he_marks(unum, agent):
    """Where a back goes whose opponent stands there while the ball is in the own half."""
    x, y = MEN[unum]
    view = seen(unum=unum, me=(x + 2.0, y), ball=(-12.0, 0.0), mates={9: (-12.5, 0.0)}, opponents={7: (x, y)})
    executor, _ = decided(agent, view, cycles=2)
    assert executor.read("marking")[0] == 1, "he has a man to mark"
    return np.array([executor.read("go_x")[0], executor.read("go_y")[0]])


def between_man_and_goal(unum, agent):
    """Whether the place lies on the way from his man to the own goal, nearer to the man."""
    place, man, goal = where_he_marks(unum, agent), np.array(MEN[unum]), np.array([-HALF_LENGTH, 0.0])
    way = (goal - man) / np.hypot(*(goal - man))
    along, aside = (place - man) @ way, (place - man) @ np.array([-way[1], way[0]])
    return 0.5 < along < 3.0 and abs(aside) < 0.1


def on_the_wrong_side(agent, *places):
    """The mutation: 1.5 m beyond his man instead of before him."""
    changed = tuple(
        replace(place, expression=place.expression.replace("- 1.5", "+ 1.5")) if place.name in places else place
        for place in agent.cprm.net.places
    )
    assert changed != agent.cprm.net.places
    agent.cprm = replace(agent.cprm, net=replace(agent.cprm.net, places=changed))
    return agent


@pytest.mark.parametrize("unum", MEN)
def test_he_who_marks_stands_between_his_man_and_the_goal_and_the_wrong_side_is_caught(unum):
    assert between_man_and_goal(unum, OutfieldAgent())
    for places in (("mark_x", "mark_y"), ("mark_x",), ("mark_y",)):
        assert not between_man_and_goal(unum, on_the_wrong_side(OutfieldAgent(), *places)), places


def test_the_places_of_the_formation_shift_with_the_ball():
    places = []
    last = {1: (50.0, 0.0), 2: (45.0, 0.0)}
    for x in (-30.0, 20.0):
        view = seen(unum=8, me=(-10.0, 10.0), ball=(x, 0.0), mates={9: (x, 0.5)}, opponents=last)
        executor, _ = decided(OutfieldAgent(), view)
        places.append(executor.read("home_x")[0])
    assert places[1] > places[0] + 20.0


def test_a_forward_lane_is_closed_by_an_opponent_on_it_and_open_beside_him():
    memory, age = np.zeros((23, 4)), np.full(23, 1000.0)
    memory[12], age[12] = (10.0, 0.0, 0.0, 0.0), 0.0
    assert kernels.lane(memory, age, 20.0, 0.0, 2.0, 15.0) < 0.0
    assert kernels.lane(memory, age, 0.0, 20.0, 2.0, 15.0) > 5.0
    age[12] = 1000.0
    assert kernels.lane(memory, age, 20.0, 0.0, 2.0, 15.0) == 20.0


def test_the_meeting_with_a_rolling_ball_is_where_it_is_when_he_is_there():
    ball = np.array([10.0, 0.0, 1.0, 0.0])
    meetings = [kernels.meeting(ball, x, 0.0, terms()) for x in (0.0, 25.0)]
    for time, x, y in meetings:
        assert x == pytest.approx(10.0 + (1.0 - 0.94**time) / 0.06, abs=0.3)
        assert y == 0.0
    (later, _, _), (time, x, _) = meetings
    assert time < later
    assert abs(x - 25.0) - 0.8 == pytest.approx(0.95 * time, abs=1.5)


def test_what_one_copy_perceives_does_not_depend_on_the_others():
    near, far = seen(me=(9.5, 0.0), mates={4: (20.0, 3.0)}, opponents={2: (15.0, 1.0)}), seen(me=(-20.0, 5.0), mates={4: (20.0, 3.0)})
    both = {key: np.concatenate([near[key], far[key]]) for key in near}
    for view in (outfield_percepts, lambda o: {f"{c}.{a}": v for c, d in outfield_attributes(o).items() for a, v in d.items()}):
        together, apart = view(both), (view(near), view(far))
        for name, values in together.items():
            for k in (0, 1):
                np.testing.assert_array_equal(values[k], apart[k][name][0], err_msg=name)


def test_the_registry_gives_the_eleven_for_every_match_to_who_asks_for_a_model():
    for task in ("Soccer", "Soccer5v5", "Soccer11v11"):
        assert WITH_MODEL[task] == "eleven"
        assert registered(make_task(task), "right_1", model="bins").cprm.name == "goalie"
        assert registered(make_task(task), "left_4", model="bins").cprm == OUTFIELDER


def test_the_goalie_is_number_one_and_an_unknown_side_is_refused():
    assert isinstance(make_controller(MATCH, "left_1"), GoalieAgent)
    assert isinstance(make_controller(MATCH, "right_7"), OutfieldAgent)
    eleven = Eleven(MATCH, "right", together=True)
    assert [rows.stop - rows.start for rows in eleven.rows] == [1, 10]
    assert eleven.names[0] == "right_1"
    with pytest.raises(UnknownName, match="unknown side 'middle'"):
        Eleven(MATCH, "middle")


def played(eleven, cycles, seed=1, worlds=1, others="weak"):
    """The engine after some cycles, the play modes on the way and the actions of the first cycles."""
    core = SoccerCore(MATCH, worlds, controlled="left", others=("hold", others), include=("memory",), seed=seed)
    eleven.reset(core.reset(seed), seed)
    modes, actions = [], []
    for _ in range(cycles):
        action = eleven.act(core.observation)
        core.step(action)
        modes.append(core.sim.world["mode"].copy())
        if len(actions) < 8:
            actions.append({key: value.copy() for key, value in action.items()})
    return core, np.array(modes), actions


def test_ten_in_a_batch_decide_as_ten_apart():
    _, _, apart = played(Eleven(MATCH), 8)
    _, _, together = played(Eleven(MATCH, together=True), 8)
    for one, many in zip(apart, together, strict=True):
        np.testing.assert_array_equal(one["type"], many["type"])
        np.testing.assert_allclose(one["params"], many["params"], atol=1e-6)


def test_the_eleven_kicks_off_plays_on_and_holds_one_thing_to_do_each():
    eleven = Eleven(MATCH, together=True)
    core, modes, _ = played(eleven, 100)
    assert modes[0, 0] == PlayMode.kick_off_l
    assert (modes[60:, 0] == PlayMode.play_on).any()
    assert core.sim.world["counts"][0, 1:11, Count.KICK].sum() > 0
    read = eleven.agents[1].controller.executor.read
    modules = ("setup", "walk", "run", "go", "receive", "passing", "quick", "taking", "boot", "drive", "shoot")
    outcomes = [f"{m}.{place}" for m in modules for place in OUTFIELDER_NET.modules[m].ports.outcomes]
    doing = ("decide", "acted", "with_ball", "hands_off", *(f"{m}.ongoing" for m in modules), *outcomes)
    assert (sum(read(place) for place in doing) == 1).all()


@pytest.mark.slow
def test_set_plays_are_taken_and_the_weak_team_is_beaten_over_some_matches():
    eleven = Eleven(MATCH, together=True)
    core, modes, _ = played(eleven, 1500, worlds=4)
    ours = [m for m in PlayMode if PlayMode.kick_off_l <= m <= PlayMode.goal_kick_r and m % 2 == PlayMode.kick_off_l % 2]
    for world in modes.T:
        waits, waiting = [0], 0
        for mode in world:
            waiting = waiting + 1 if mode in ours else 0
            waits.append(waiting)
        assert max(waits) < 100
    goals = core.sim.world["score"].sum(axis=0)
    assert goals[0] > goals[1]
