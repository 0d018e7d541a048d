"""The goalie against several attackers: what he takes for a shot, where he stands, when he dares; and that it pays."""

import pytest

from cprm_gym.agents.goalie import reckoning_cprm
from cprm_gym.agents.knowledge import informed
from cprm_gym.agents.knowledge.players import PLAYERS, goalie
from cprm_gym.agents.skills.constants import AttackedConstants, GoalieConstants
from cprm_gym.architecture.analysis.modules.composition import check_composition
from cprm_gym.architecture.petri import Executor
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.statistics import paired_difference
from cprm_gym.envs.tasks import make_task

SEEN = {"self.x": -49.0, "self.y": 0.0, "self.body_deg": 80.0, "ball.x": -42.0, "ball.y": 1.0, "ball.vx": -0.9, "ball.vy": 0.0,
        "rival.x": -40.5, "rival.y": 1.0, "second.x": -44.0, "second.y": -9.0, "ball.distance": 7.1, "ball.seen": 1.0, "body.fresh": 1.0,
        "body.stamina": 8000.0}  # fmt: skip


def known(constants, *places, **changes):
    """What he derives from what he knows; everything that is not said is 0."""
    executor = Executor(reckoning_cprm(constants=constants).net)
    told = dict.fromkeys(executor.input_names, 0.0) | SEEN | changes
    executor.step({name: told[name] for name in executor.input_names})
    values = [float(executor.read(place)[0]) for place in places]
    return values[0] if len(values) == 1 else values


def test_a_slow_ball_at_an_attackers_feet_is_no_shot_whichever_way_it_rolls():
    c = AttackedConstants()
    assert known(GoalieConstants(), "shot") == 1.0, "for the goalie who knows of no dribble it is one"
    assert known(c, "carried", "shot") == [1.0, 0.0]
    assert known(c, "carried", "shot", **{"ball.vx": -2.4}) == [0.0, 1.0], "so fast nobody dribbles"
    assert known(c, "carried", "shot", **{"rival.x": -25.0}) == [0.0, 1.0], "nobody is at it"


def test_who_could_get_a_pass_takes_his_daring_and_moves_his_place():
    c = AttackedConstants(lean=0.5, wary=1.0, dare=10.0, feared=20.0, carry=12.0, touch=2.4)
    near, far = {"second.x": -44.0, "second.y": -9.0}, {"second.x": -20.0, "second.y": -9.0}
    assert known(c, "threat", **near) == pytest.approx((20.0 - 12.38) / 8.0, abs=0.01)
    assert known(c, "threat", **far) == 0.0
    assert known(c, "post_y", **near) < 0.0 < known(c, "post_y", **far)
    standing = {"self.x": -45.0, "rival.x": -42.3, "ball.vx": 0.0}
    assert known(c, "loose", **far, **standing) == 1.0
    assert known(c, "loose", **{"second.x": -47.0, "second.y": -3.0}, **standing) == 0.0, "he does not leave the goal to the other one"


def test_he_guards_where_the_ball_will_be():
    across = {"ball.vx": 0.0, "ball.vy": 1.0, "second.x": 40.0}
    now, soon = (known(AttackedConstants(foresees=k), "post_y", **across) for k in (0.0, 4.0))
    assert soon > now + 0.5


def test_every_constant_stands_in_the_net_and_the_others_net_knows_none_of_them():
    plain = AttackedConstants()
    for name, (low, high) in AttackedConstants.extents().items():
        other = low if getattr(plain, name) != low else high
        changed = AttackedConstants.of({name: other})
        assert reckoning_cprm(constants=changed).net != reckoning_cprm(constants=plain).net, name
    assert not {"carried", "threat", "second_x"} & {place.name for place in reckoning_cprm().net.places}


@pytest.mark.slow
def test_his_modules_are_used_as_their_contracts_assume():
    report = check_composition(reckoning_cprm(constants=AttackedConstants()).net)
    assert report.complete
    assert report.holds, str(report)


def test_the_decisions_pay_on_the_same_worlds_with_the_same_knowledge():
    given = GoalieConstants.tuned("memory")
    decided = AttackedConstants.of({key: value for key, value in given.to_dict().items() if key != "dare"})
    plain, new = (
        play_episodes(make_task("Goalie2v1"), informed(lambda task, agent, c=c: goalie(task, agent, c), "memory"), 400, 5).success
        for c in (given, decided)
    )
    assert paired_difference(new, plain).low > 0.0


def test_the_tasks_have_their_players():
    assert PLAYERS["Goalie2v1"].constants is PLAYERS["Goalie3v2"].constants is AttackedConstants
    assert PLAYERS["Goalie"].constants is GoalieConstants
