"""The attacker: room is what opponents leave, decisions follow it, passes are counted, and he scores against a defence."""

import numpy as np
import pytest

from cprm_gym.agents.attacker import half_field
from cprm_gym.agents.attacker.agent import ATTACKER_NET, COMBINING_NET, HAVE, MEET, PUSH, SHOT, AttackerAgent, attacker_net, make_controller
from cprm_gym.agents.attacker.constants import AttackerConstants, HalfFieldConstants, PairConstants
from cprm_gym.agents.attacker.kernels import ASIDE, EMPTY, gap_at, judge
from cprm_gym.agents.attacker.percepts import FORGET, NAMES, NEAR, Motion, terms
from cprm_gym.agents.body import DEFAULT, Body
from cprm_gym.agents.knowledge import informed
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.passer import PasserAgent
from cprm_gym.agents.passer import make_controller as make_passer
from cprm_gym.agents.registry import AGENTS
from cprm_gym.agents.striker import make_controller as make_striker
from cprm_gym.architecture.petri import Executor
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.knowledge import SENSES, STATED
from cprm_gym.benchmark.statistics import wilson_interval
from cprm_gym.benchmark.tuning import Plan, study
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.players.senses import Senses
from cprm_gym.envs.tasks import Status, make_task
from cprm_gym.errors import ParameterError
from cprm_gym.simulator.state import ViewWidth

BY = terms(DEFAULT, AttackerConstants(wander=0.5, rival_start=1.0, rival_reach=1.0))


def judged(rivals, ball=(0.0, 0.0, 0.0, 0.0), me=(-0.6, 0.0, 0.0, 0.0, 0.0), mate=(0.0, 12.0), age=0.0, by=BY):
    """What an attacker makes of opponents at (x, y, and how far they go in a cycle)."""
    rivals = np.array([[*rival, 0.0, 0.0][:4] for rival in rivals], float).reshape(1, -1, 4)
    out = np.zeros((1, len(NAMES)))
    judge(np.array([ball], float), np.array([me], float), np.array([[mate]], float), np.zeros((1, 1)), rivals,
          np.full(rivals.shape[:2], float(age)), NEAR, by, out)  # fmt: skip
    return dict(zip(NAMES, out[0]))


def room(rivals, x, y, t, age=0.0):
    rivals = np.array([[*rival, 0.0, 0.0][:4] for rival in rivals], float).reshape(-1, 4)
    return gap_at(x, y, float(t), rivals, np.full(len(rivals), float(age)), BY)


def test_room_is_the_way_of_the_nearest_opponent_less_what_he_reaches_and_runs():
    assert room([(10.0, 0.0), (0.0, 30.0)], 0.0, 0.0, 0) == pytest.approx(10.0 - 1.0)
    assert room([(10.0, 0.0)], 0.0, 0.0, 5) == pytest.approx(9.0 - 4.0 * BY.rival_pace)
    assert room([], 0.0, 0.0, 5) == EMPTY


def test_who_was_not_seen_of_late_may_be_anywhere_and_in_the_end_nowhere():
    rooms = [room([(10.0, 0.0)], 0.0, 0.0, 0, age) for age in (0, 4, 12, 30, 100)]
    assert rooms == pytest.approx([9.0, 7.0, 3.0, 3.0, EMPTY])


def test_who_runs_the_other_way_leaves_more_room_than_who_comes():
    comes, stands, leaves = (room([(10.0, 0.0, v, 0.0)], 0.0, 0.0, 6) for v in (-0.9, 0.0, 0.9))
    assert comes < stands < leaves


def test_the_ball_is_driven_to_the_goal_but_not_into_an_opponent():
    assert abs(judged([])["way.angle"]) < 0.01
    assert abs(judged([(4.0, 0.0)])["way.angle"]) > 0.3
    assert judged([(4.0, 0.0)])["way.room"] > room([(4.0, 0.0)], 4.0, 0.0, 4)


def test_no_pass_goes_through_an_opponent_and_none_to_who_is_offside():
    free, blocked = judged([(30.0, -30.0)]), judged([(0.0, 6.0)])
    assert free["pass.room"] > 3.0
    assert free["pass.worth"] > blocked["pass.worth"]
    assert judged([], ball=(5.0, 0.0, 0.0, 0.0), me=(4.4, 0.0, 0.0, 0.0, 0.0), mate=(15.0, 8.0))["pass.worth"] == -1e9


def test_the_ball_is_not_driven_into_a_team_mate_who_is_offside():
    """He may not touch it, and is ruled when it touches him."""
    aside, before, onside = (judged([], mate=mate)["way.angle"] for mate in ((5.0, 8.0), (5.0, 0.0), (-0.5, 3.0)))
    assert abs(aside) < 0.01
    assert abs(onside) < 0.01
    assert abs(before) > np.arctan2(ASIDE, 5.0)


def test_who_is_offside_goes_back_even_where_he_is_nearest_to_the_ball():
    """The ball comes to him, and behind him there is no place from which to take a pass."""
    spot = judged([(-10.0, 0.0), (-12.0, 5.0)], ball=(20.0, 0.0, 1.0, 0.0), me=(26.0, 0.5, 0.0, 0.0, 0.0), mate=(5.0, 0.0))
    assert spot["me.time"] < spot["mate.time"]
    assert spot["support.x"] < spot["line.x"] - 1.0
    assert abs(spot["support.y"]) > 3.0


def played(cycles, net=COMBINING_NET):
    """A net that is told these inputs, cycle by cycle; its markings after each."""
    executor = Executor(net)
    nothing = {**dict.fromkeys(executor.input_names, 0.0), "game.playing": 1.0, "mate.age": 0.0, "mate.ball_gap": 30.0, "mate.time": 30.0,
               "me.time": 10.0, "ball.reckoned_distance": 10.0, "pass.worth": -1e9, "support.x": -20.0}  # fmt: skip
    told = []
    for given in cycles:
        executor.step({**nothing, **given})
        told.append({name: float(executor.read(name)[0]) for name in ("offside", "plan", "option")})
    return told


BEYOND = {"me.x": 12.0, "line.x": 5.0}
PUSHES = {"mate.ball_gap": 0.8, "mate.time": 0.0}


def test_who_is_offside_when_his_mate_plays_the_ball_leaves_it_alone():
    told = played([{**PUSHES, **BEYOND}, {**BEYOND, "ball.reckoned_distance": 0.7, "me.time": 0.0}])
    assert [cycle["offside"] for cycle in told] == [1.0, 1.0]
    assert told[1]["plan"] not in (HAVE, MEET)
    assert played([PUSHES, {"ball.reckoned_distance": 0.7, "me.time": 0.0}])[1]["plan"] == HAVE


def test_a_ball_that_passes_him_does_not_put_him_onside_his_mate_does():
    rolls = {"mate.ball_gap": 1.9, "mate.time": 2.0, "me.x": 12.0, "line.x": 13.0}
    assert played([{**PUSHES, **BEYOND}, rolls, rolls])[-1]["offside"] == 1.0
    assert played([{**PUSHES, **BEYOND}, {**PUSHES, "me.x": 12.0, "line.x": 13.0}])[-1]["offside"] == 0.0


def test_an_opponent_whom_the_ball_passes_does_not_put_him_onside_one_who_has_it_does():
    near = {**BEYOND, "rival.has_ball": 1.0}
    assert played([{**PUSHES, **BEYOND}, near, BEYOND, BEYOND])[-1]["offside"] == 1.0
    assert played([{**PUSHES, **BEYOND}, near, near, near, near])[-1]["offside"] == 0.0
    assert played([{**PUSHES, **BEYOND}] + [{**near, **PUSHES}] * 4)[-1]["offside"] == 1.0, "his mate is at it too"


WITH_THE_BALL = {"ball.reckoned_distance": 0.7, "me.time": 0.0, "goal.distance": 25.0, "shot.speed": 2.5}


@pytest.mark.parametrize(
    ("way", "shot", "pair", "other"),
    [(-0.5, -5.0, SHOT, PUSH), (0.5, -5.0, PUSH, PUSH), (-0.5, -9.0, PUSH, PUSH), (-0.5, -0.5, SHOT, SHOT), (0.5, -0.5, SHOT, SHOT)],
)
def test_one_of_the_pair_who_can_push_nowhere_safely_shoots_where_he_would_not_otherwise(way, shot, pair, other):
    told = {**WITH_THE_BALL, "way.room": way, "shot.room": shot}
    assert played([told], attacker_net(0, constants=PairConstants()))[0]["option"] == pair
    assert played([told], attacker_net(0, constants=AttackerConstants()))[0]["option"] == other


def test_no_shot_is_taken_for_want_of_a_push_from_too_far_or_before_enough_passes():
    told = {**WITH_THE_BALL, "way.room": -0.5, "shot.room": -5.0}
    assert played([{**told, "goal.distance": 35.0}], attacker_net(0, constants=PairConstants()))[0]["option"] == PUSH
    assert played([told], attacker_net(3, constants=PairConstants()))[0]["option"] == PUSH


def test_a_pass_leads_a_mate_away_from_the_opponent_beside_him():
    beside = judged([(-3.0, 14.0)])
    aim = np.arctan2(12.0, 0.0)
    assert beside["pass.angle"] < aim - 0.1, "ahead of him, not to his feet"


def test_a_shot_goes_where_the_keeper_is_not():
    by = terms(DEFAULT, AttackerConstants(), keeper=0)
    spot = {"ball": (40.0, 0.0, 0.0, 0.0), "me": (39.4, 0.0, 0.0, 0.0, 0.0), "by": by}
    left, right = (judged([(51.0, y)], **spot) for y in (2.5, -2.5))
    assert left["shot.y"] < -1.0
    assert right["shot.y"] > 1.0
    assert judged([], **spot)["shot.room"] > left["shot.room"]


def test_a_kick_gives_no_more_than_the_leg_has():
    across = judged([], ball=(40.0, 0.0, 0.0, 1.5), me=(39.4, 0.0, 0.0, 0.0, 0.0))
    still = judged([], ball=(40.0, 0.0, 0.0, 0.0), me=(39.4, 0.0, 0.0, 0.0, 0.0))
    assert 0.0 < across["shot.speed"] < still["shot.speed"] <= BY.kick_speed


def test_motions_are_told_from_two_sights_and_forgotten():
    motion = Motion(2)
    motion.reset(1)
    place, age = np.array([[[10.0, 0.0], [5.0, 5.0]]]), np.array([[0.0, 0.0]])
    motion.follow(place, age)
    for k in range(1, 8):
        moved = motion.follow(place + [[[-0.8 * k, 0.0], [0.0, 0.4 * k]]], age)
    assert moved == pytest.approx(np.array([[[-0.8, 0.0], [0.0, 0.4]]]), abs=0.01)
    for _ in range(int(FORGET) + 1):
        moved = motion.follow(place, age + 20.0)
    assert not moved.any()


def test_constants_out_of_their_extent_are_refused_by_name():
    with pytest.raises(ParameterError, match=r"attacker: run: 1\.5 given"):
        AttackerConstants(run=1.5)


def test_against_opponents_striker_and_passer_are_attackers_without_they_are_not():
    for name, make in (("KickOffShot2v2", make_striker), ("PassAndAdvance2v1", make_passer)):
        assert isinstance(make(make_task(name), "left_1"), AttackerAgent)
        assert not isinstance(make(make_task(name[:-3]), "left_1"), AttackerAgent)
    assert isinstance(make_passer(make_task("PassAndAdvance"), "left_2"), PasserAgent)
    assert {"KickOffShot2v2", "PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3"} <= AGENTS.keys()


def test_only_who_must_pass_counts_passes():
    counting, other = ({place.name for place in net.places} for net in (COMBINING_NET, ATTACKER_NET))
    assert "swaps" in counting
    assert "swaps" not in other


@pytest.mark.parametrize(("name", "least"), [("PassAndAdvance2v1", 0.7), ("KickOffShot2v2", 0.4)])
def test_he_scores_against_a_defence_when_he_knows_everything(name, least):
    make = informed(make_controller, "state")
    won = play_episodes(make_task(name), make, 60, seed=5).success
    assert wilson_interval(int(won.sum()), 60).low > least


def test_he_shoots_only_after_enough_passes():
    core = SoccerCore(make_task("PassAndAdvance2v1"), 60, seed=8, include=("memory",))
    agents = [informed(make_controller, "state")(core.task, name) for name in core.agents]
    observation = core.reset(8)
    for i, (name, agent) in enumerate(zip(core.agents, agents)):
        agent.connect(core, name)
        agent.reset({key: value[:, i] for key, value in observation.items()}, 8)
    status = np.zeros(60, int)
    while (status == 0).any():
        actions = [agent.act({key: value[:, i] for key, value in observation.items()}) for i, agent in enumerate(agents)]
        step = core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
        over = (step.terminated | step.truncated) & (status == 0)
        status[over] = step.status[over]
    assert (status == Status.TOO_EARLY).sum() <= 3
    assert (status == Status.GOAL).sum() >= 40


def test_he_plays_alike_alone_and_in_a_batch():
    task = make_task("KickOffShot2v2")
    cores = [SoccerCore(task, 5, seed=6, include=("memory",)), SoccerCore(task, 1, seed=6, first_world=3, include=("memory",))]
    agents = [make_controller(task, "left_1") for _ in cores]
    observations = [{key: value[:, 0] for key, value in core.reset(6).items()} for core in cores]
    for agent, observation in zip(agents, observations):
        agent.reset(observation, 0)
    for _ in range(80):
        actions = [agent.act(observation) for agent, observation in zip(agents, observations)]
        for key in actions[0]:
            assert (actions[0][key][3] == actions[1][key][0]).all()
        for core, action in zip(cores, actions):
            core.step({key: np.asarray(value)[:, None] for key, value in action.items()})


def watched(name, constants=None, cycles=50, worlds=20):
    """The parts ``memory_age`` and the views asked for, cycle by cycle, of the first agent with most of his looks lost."""
    senses = Senses(lost=0.6)
    core = SoccerCore(make_task(name), worlds, seed=4, include=("memory",), senses=senses)
    agents = [make_controller(core.task, agent, constants) for agent in core.agents]
    observation = core.reset(4)
    for i, agent in enumerate(agents):
        agent.reset({key: value[:, i] for key, value in observation.items()}, 4)
    ages, views = [], []
    for _ in range(cycles):
        actions = [agent.act({key: value[:, i] for key, value in observation.items()}) for i, agent in enumerate(agents)]
        ages.append(np.array(observation["memory_age"][:, 0]))
        views.append(np.array(actions[0]["view"]))
        core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
    return np.array(ages), np.array(views)


def test_near_the_ball_he_looks_at_it_with_the_narrow_cone():
    _, views = watched("PassAndAdvance2v1")
    assert (views == ViewWidth.NARROW).mean() > 0.3
    assert (views == ViewWidth.NORMAL).any()
    _, wide = watched("PassAndAdvance2v1", AttackerConstants(focus=0.0))
    assert not (wide == ViewWidth.NARROW).any()


def test_the_narrow_cone_sees_the_ball_more_often_when_looks_are_lost():
    narrow, wide = (watched("PassAndAdvance2v1", AttackerConstants(focus=focus))[0][5:20, :, 0].mean() for focus in (15.0, 0.0))
    assert narrow < wide


def test_the_team_mate_who_was_never_seen_is_looked_for():
    ages, _ = watched("PassAndAdvance2v1")
    assert (ages[0, :, 2] >= 1000).all(), "he stands aside"
    assert (ages[-1, :, 2] < 60).mean() > 0.8


def test_the_pair_scores_although_most_looks_are_lost():
    """Who never looked for the team-mate, and kept the cone normal, scored in 3 of 100."""
    player, senses = PLAYERS["PassAndAdvance2v1"], Senses(lost=0.6)
    make = player.on("memory", senses, AttackerConstants())
    won = play_episodes(make_task("PassAndAdvance2v1", **player.options), make, 60, 3, senses=senses, slots=60).success
    assert wilson_interval(int(won.sum()), 60).low > 0.08


VARIANTS = ("KickOffShot2v2", "PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3")


def successes(name, tier, episodes, seed):
    player, senses = PLAYERS[name], SENSES[STATED[name]]
    won = play_episodes(make_task(name, **player.options), player.on(tier, senses), episodes, seed, senses=senses).success
    return wilson_interval(int(won.sum()), episodes)


def test_before_a_set_play_he_looks_round_for_his_team_mate():
    """Who had not seen him kicked off straight ahead: 60 of 60 goals were the team-mate's, and against a defence there were 15 of 60."""
    make = lambda task, agent: AttackerAgent(opponents=max(1, task.right), keeper=task.right_goalie)  # noqa: E731
    assert play_episodes(make_task("KickOffShot"), make, 30, 3).success.mean() > 0.9
    player = PLAYERS["KickOffShot2v2"]
    won = play_episodes(make_task("KickOffShot2v2", **player.options), player.on("memory", None, AttackerConstants()), 40, 3).success
    assert won.mean() > 0.7


def test_foresight_scores_where_who_carries_nothing_on_does_not():
    assert successes("PassAndAdvance2v1", "foresight", 40, 9).low > successes("PassAndAdvance2v1", "frozen", 40, 9).high


@pytest.mark.parametrize("name", VARIANTS)
def test_the_numbers_of_each_tier_can_be_loaded(name):
    for tier in PLAYERS[name].tiers:
        assert isinstance(PLAYERS[name].numbers(tier), AttackerConstants)
        assert PLAYERS[name].origin(tier) != "none"


def test_a_player_is_tuned_and_measured_where_his_options_say(monkeypatch):
    seen = []

    def noted(task, *_, **__):
        seen.append(task.others)
        raise InterruptedError

    monkeypatch.setattr("cprm_gym.benchmark.tuning.play_episodes", noted)
    with pytest.raises(InterruptedError):
        next(iter(study(Plan("KickOffShot2v2", "frozen", worlds=1))))
    assert seen == [("medium", "weak")]


def test_in_half_fields_he_plays_with_the_numbers_of_the_study_for_the_task():
    for name in (*half_field.STUDY, "HFO3v3"):
        studied = name in half_field.STUDY
        task, numbers = make_task(name), HalfFieldConstants.tuned("memory", half_field.STUDY[name]) if studied else HalfFieldConstants()
        assert half_field.make_controller(task, "left_1").cprm.net == attacker_net(0, Body.of(task), numbers), name
        assert PLAYERS[name].numbers("belief") == half_field.numbers_of(name) == numbers
        assert (numbers != HalfFieldConstants()) == studied
