"""The passing pair: it advances by passing and scores; what goes wrong is noticed, passed up and repaired."""

from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.agents.models import BEARING
from cprm_gym.agents.passer import PASSER, PASSER_NET, make_controller, passer_net
from cprm_gym.agents.registry import AGENTS
from cprm_gym.architecture.cprm import cprm_from_json, cprm_to_json
from cprm_gym.architecture.petri import flatten
from cprm_gym.benchmark.plan import Block
from cprm_gym.benchmark.recovery import measure
from cprm_gym.benchmark.runner import play_block
from cprm_gym.benchmark.statistics import wilson_interval
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.state import WORLD, Count
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


QUICK = ("ball displaced", "blind spell", "noise burst")


@pytest.mark.parametrize("name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in DISTURBANCES])
def test_under_each_disturbance_the_recovering_pair_succeeds_more_often(name):
    disturbance, task = replace(DISTURBANCES[name], first=20, last=120), replace(make_task("PassAndAdvance"), max_cycles=500)
    recovering = measure(with_recovery, disturbance, episodes=24, seed=2, task=task)
    without = measure(without_recovery, disturbance, episodes=24, seed=2, task=task)
    assert recovering.interval.low > without.interval.high
    again, struck = recovering.recovered
    assert struck > 20
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
                assert "advance.stop" in f[k : k + 4]


def test_a_pass_whose_ball_is_stopped_at_once_has_failed_and_is_made_again():
    def stop(core, players):
        for number, player in zip(core.players, players):
            if player.controller.executor.read("passing.kick.acted")[0] and core.cycle[0] < 25:
                core.place_ball(*(core.sim.world["pos"][0, number] + [0.7, 0.0]))

    _, fired = played(0, 120, stop)
    assert any("passing.stuck" in f and "pass_again" in f and "go_on" in f[f.index("passing.stuck") :] for f in fired)


def stage(first, ball, second=(-20.0, 8.0, 0.0), velocity=(0.0, 0.0)):
    """One world with the two at (x, y, body) and a ball; (core, observation of the first, his agent)."""
    core = SoccerCore(make_task("PassAndAdvance"), 1, seed=2, include=("memory",))
    core.reset(2)
    core.place_ball(*ball, *velocity)
    for number, (x, y, body) in ((1, first), (2, second)):
        core.place_player(number, x, y, np.radians(body))
    observation = {key: value[:, 0] for key, value in core.observe(np.array([0])).items()}
    agent = make_controller(core.task, "left_1")
    agent.reset(observation, 2)
    return core, observation, agent


def told(agent, observation, **changes):
    """One cycle of an agent who is told that, with changes by percept (``ball_seen`` is ``ball.seen``)."""
    percepts = agent.percepts(observation)
    changes |= {
        f"{what}_{part}": changes[f"{what}_seen"] for what, part in (("ball", "placed"), ("m1", "faced")) if f"{what}_seen" in changes
    }
    percepts.update({name.replace("_", ".", 1): np.array([float(value)]) for name, value in changes.items()})
    percepts["body.turned_deg"] = percepts["body.advanced"] = np.zeros(1)
    agent.controller.step(percepts, agent.objects(observation))


def near(agent, direction, width=20.0):
    """Probability that the ball's bearing is within `width` degrees of a direction."""
    off = (np.asarray(BEARING.values) - direction + 180.0) % 360.0 - 180.0
    return agent.controller.bank.marginal("ball.bearing_deg")[np.abs(off) < width].sum()


def test_not_seeing_the_ball_is_evidence_only_where_the_eyes_point():
    looking, behind = (stage((-20.0, 0.0, 0.0), (-8.0, 0.0)) for _ in range(2))
    for _, observation, agent in (looking, behind):
        for _ in range(3):
            told(agent, observation)
        assert near(agent, 0.0) > 0.95
    for _ in range(6):
        told(looking[2], looking[1], ball_seen=0, ball_moving=0, me_eyes_deg=0)
        told(behind[2], behind[1], ball_seen=0, ball_moving=0, me_eyes_deg=170)
    assert near(looking[2], 0.0) < 0.2
    assert near(behind[2], 0.0) > 0.9
    blind = stage((-20.0, 0.0, 0.0), (-8.0, 0.0))
    for k in range(8):
        told(blind[2], blind[1], **({"ball_seen": 0, "ball_moving": 0, "body_fresh": 0} if k > 2 else {}))
    assert near(blind[2], 0.0) > 0.9, "closed eyes tell nothing"


def test_a_ball_near_enough_to_be_felt_is_no_evidence_when_it_is_not_seen():
    _, observation, agent = stage((-20.0, 0.0, 0.0), (-17.5, 0.0))
    for _ in range(3):
        told(agent, observation)
    told(agent, observation, ball_seen=0, ball_moving=0, me_eyes_deg=0)
    assert agent.controller.explain().evidence["ball.seen"] is None


def test_relations_follow_the_object_tokens():
    _, observation, agent = stage((-20.0, 0.0, 0.0), (-8.0, 0.0), second=(-10.0, 4.0, 180.0))
    told(agent, observation)
    assert agent.controller.relations(0) == ("attendedTeammate(m1)",)
    _, observation, agent = stage((-20.0, 0.0, 0.0), (-8.0, 0.0), second=(-7.5, 0.5, 180.0))
    told(agent, observation)
    assert agent.controller.relations(0) == ("attendedTeammate(m1)", "possessesTeammate(m1,ball)")
    _, observation, agent = stage((-20.0, 0.0, 0.0), (-8.0, 0.0), second=(-30.0, 0.0, 180.0))
    told(agent, observation)
    assert agent.controller.relations(0) == (), "nobody has been seen"


def test_a_team_mate_who_has_the_ball_and_faces_him_is_expected_to_pass():
    def expected(facing):
        _, observation, agent = stage((-20.0, 0.0, 0.0), (-8.0, 0.0), second=(-7.5, 0.5, facing))
        for _ in range(4):
            told(agent, observation)
        for _ in range(2):
            told(agent, observation, ball_seen=0, ball_moving=0, body_fresh=0, m1_seen=0)
        return float(agent.controller.executor.read("rolled")[0])

    assert expected(180.0) > 0.05
    assert expected(180.0) > expected(0.0) + 0.05
    assert expected(0.0) == pytest.approx(0.0, abs=0.03)


def test_the_partner_is_remembered_where_he_was_seen():
    _, observation, agent = stage((-20.0, 0.0, 0.0), (-19.0, 0.0), second=(-8.0, 5.0, 180.0))
    for _ in range(4):
        told(agent, observation)
    for _ in range(20):
        told(agent, observation, m1_seen=0)
    read = {name: float(agent.controller.executor.read(name)[0]) for name in ("mate_x", "mate_y")}
    assert read["mate_x"] == pytest.approx(-8.0, abs=1.0)
    assert read["mate_y"] == pytest.approx(5.0, abs=1.0)


def test_beliefs_stay_with_the_truth_through_closed_eyes_own_steps_and_own_kicks():
    errors = {"dist": [], "direction": [], "mate": [], "after": []}
    kicked = {}

    def compare(core, players):
        w = core.sim.world
        counts = w["counts"][0, :, Count.KICK]
        for number, player in zip(core.players, players):
            if core.cycle[0] < 12:
                kicked[number] = counts[number - 1]
                continue
            read = {n: float(player.controller.executor.read(n)[0])
                    for n in ("ball_distance", "ball_direction", "mate_x", "mate_y", "ball_age", "mate_age")}  # fmt: skip
            before = places[-1]
            to_ball = before["pos"][0] - before["pos"][number]
            distance = np.hypot(*to_ball)
            off = np.degrees(np.arctan2(to_ball[1], to_ball[0]) - before["body"][number - 1]) - read["ball_direction"]
            off = abs((off + 180.0) % 360.0 - 180.0)
            if read["ball_age"] > 0:
                errors["dist"].append(abs(read["ball_distance"] - distance) / max(1.0, distance))
                errors["direction"].append(off * min(1.0, distance))
            if counts[number - 1] > kicked[number] and read["ball_age"] > 0:
                errors["after"].append(abs(read["ball_distance"] - distance))
            if read["mate_age"] < 5:
                mate = before["pos"][3 - number]
                errors["mate"].append(np.hypot(read["mate_x"] - mate[0], read["mate_y"] - mate[1]))
            kicked[number] = before["counts"][number - 1, Count.KICK]
        places.append(w[0].copy())

    places = []
    for seed in (0, 1):
        places[:] = [np.zeros(1, WORLD)[0]]
        played(seed, 200, compare)
    middle = {name: float(np.median(values)) for name, values in errors.items()}
    assert len(errors["dist"]) > 200
    assert len(errors["after"]) > 5
    assert middle["dist"] < 0.06
    assert middle["direction"] < 5.0
    assert middle["mate"] < 1.0
    assert middle["after"] < 0.4


def test_in_a_noise_burst_the_belief_is_nearer_to_the_truth_than_what_is_seen():
    core, _, agent = stage((-20.0, 0.0, 0.0), (-8.0, 0.0))
    errors = np.random.default_rng(4)
    seen, believed = [], []
    for k in range(60):
        blurred = 12.0 * np.exp(0.15 * errors.standard_normal())
        observation = {key: value[:, 0] for key, value in core.observation.items()}
        told(agent, observation, ball_distance=blurred if k > 10 else 12.0, ball_rolling=0.3 * errors.standard_normal() if k > 10 else 0.0)
        seen.append(abs(blurred - 12.0))
        believed.append(abs(float(agent.controller.executor.read("ball_distance")[0]) - 12.0))
    assert np.mean(believed[11:]) < 0.75 * np.mean(seen[11:])


def test_with_more_team_mates_the_partner_is_the_nearest_who_has_been_seen():
    core = SoccerCore(replace(make_task("PassAndAdvance"), left=3), 1, seed=2, include=("memory",))
    core.reset(2)
    for number, x, y, body in ((1, -10.0, 4.0, 180.0), (2, -20.0, 0.0, 0.0), (3, -13.0, -2.0, 180.0)):
        core.place_player(number, x, y, np.radians(body))
    observation = {key: value[:, 1] for key, value in core.observe(np.array([0])).items()}
    agent = make_controller(core.task, "left_2")
    agent.reset(observation, 2)
    for _ in range(3):
        told(agent, observation)
    assert agent.controller.relations(0) == ("attendedTeammate(m2)",), "m1 and m2 are numbers 1 and 3"
    assert float(agent.controller.executor.read("mate_x")[0]) == pytest.approx(-13.0, abs=1.0)
    assert float(agent.controller.executor.read("mate_y")[0]) == pytest.approx(-2.0, abs=1.0)


def test_the_passer_is_a_value_that_can_be_saved():
    assert cprm_from_json(cprm_to_json(PASSER)) == PASSER


def test_each_player_is_told_only_what_he_sees_himself():
    assert AGENTS["PassAndAdvance"] == "passer"
    result = play_block(Block("PassAndAdvance", "cprm", 0, 6, 0))
    assert result.error is None
    assert sum(result.success) >= 5
    assert result.decisions == 2 * result.played
