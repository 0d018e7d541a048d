"""Presets, memories, macros and scripted players follow the server's parameters and the players' types."""

import dataclasses

import numpy as np
import pytest

from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.players.kernels import motion
from cprm_gym.envs.players.memory import MEMORY, embody
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import TypeColumn

SETS = {
    "default": {},
    "long legs": {"kickable_margin": 1.5},
    "short legs": {"kickable_margin": 0.3},
    "heavy ball": {"ball_decay": 0.85},
    "slow to turn": {"inertia_moment": 12.0},
    "slippery": {"player_decay": 0.6, "dash_power_rate": 0.004},
    "narrow goal, large ball": {"goal_width": 8.0, "ball_size": 0.2},
    "strong kicks, tired players": {"kick_power_rate": 0.04, "stamina_max": 4000.0},
    "stiff necks": {"maxneckang": 45.0, "minneckang": -45.0},
}
sets = pytest.mark.parametrize("name", SETS)


def parameters(name, noise=False):
    given = ServerParameters(**SETS[name])
    return given if noise else given.without_noise()


def still(core):
    shape = (core.worlds, len(core.agents))
    return {"type": np.zeros(shape, int), "params": np.zeros((*shape, 4))}


@sets
@pytest.mark.parametrize("preset", ["hfo_high", "hfo_low"])
def test_the_kickable_flag_says_what_the_server_says(name, preset):
    gaps = np.linspace(0.55, 2.6, 42)
    core = SoccerCore(make_task("HFO1v0", parameters=parameters(name), full_state=True), len(gaps), observation=preset)
    core.reset(1)
    core.place_ball(0.0, 0.0)
    core.place_player(1, -gaps, 0.0, 0.0)
    core.observe()
    flag = core.output[:, 0, core.preset.names.index("kickable")] > 0
    assert (flag == core.sim.kickable(1)).all()
    assert flag.any()
    assert not flag.all()


def test_the_kickable_flag_follows_the_own_type():
    core = SoccerCore(make_task("HFO1v0", full_state=True), 2, observation="hfo_high")
    core.reset(1)
    core.sim.packed[0]["types"][3] = core.sim.packed[0]["types"][0]
    core.sim.packed[0]["types"][3, TypeColumn.KICKABLE_MARGIN] = 1.5
    core.sim.packed[0]["types"][3, TypeColumn.KICKABLE_SQUARED] = 1.885**2
    core.sim.world["type"][1, 0] = 3
    core.place_ball(0.0, 0.0)
    core.place_player(1, -1.5, 0.0, 0.0)
    core.observe()
    assert core.output[:, 0, core.preset.names.index("kickable")].tolist() == [-1.0, 1.0]
    assert core.remembered()["reach"][:, 0] == pytest.approx([1.085, 1.885])


@sets
def test_a_blind_player_carries_on_turn_way_and_ball_as_the_server_does(name):
    core = SoccerCore(make_task("GoToBall", parameters=parameters(name)), 1, include=("memory",))
    core.reset(3)
    core.place_ball(5.0, 1.0, 0.9, 0.3)
    core.place_player(1, 0.0, 0.0, 0.2, (0.25, 0.05))
    core.observe(np.arange(1))
    core.step(still(core))
    core.step(still(core))
    w, r = core.sim.world[0], core._memories.records[0, 0]
    r["x"], r["y"], r["body"], r["face"] = *w["pos"][1], w["body"][0], w["body"][0] + w["neck"][0]
    r["ball_x"], r["ball_y"], r["ball_vx"], r["ball_vy"], r["ball_age"] = *w["pos"][0], *w["vel"][0], 0
    core.sim.world["see_counter"] = -10
    turn = {"type": np.full((1, 1), 2), "params": np.array([[[0.5, 0.0, 0.0, 0.0]]])}
    for action in (turn, still(core), still(core)):
        core.step(action)
    m = core.remembered()[0, 0]
    assert m["ball_age"] == 3
    assert m["body"] == pytest.approx(w["body"][0], abs=0.03), "felt speeds are rounded to 0.01"
    assert [m["ball_x"], m["ball_y"]] == pytest.approx(w["pos"][0].tolist(), abs=1e-6)
    assert [m["x"], m["y"]] == pytest.approx(w["pos"][1].tolist(), abs=0.06)


@sets
def test_macros_with_the_ball_can_be_done_where_it_can_be_kicked(name):
    gaps = np.linspace(0.55, 2.6, 42)
    core = SoccerCore(make_task("HFO1v0", parameters=parameters(name), full_state=True), 42, action_mode="macro")
    core.reset(1)
    core.place_ball(0.0, 0.0)
    core.place_player(1, -gaps, 0.0, 0.0)
    core.observe()
    can = core.action_mask[:, 0, core.macros.names.index("shoot")]
    kickable = core.sim.kickable(1)
    assert not (can & ~kickable).any()
    margin = core.parameters.kickable_margin
    sure = np.abs(gaps - 0.3 - core.parameters.ball_size - margin) > 0.16 * margin
    assert (can == kickable)[sure].all()
    core.step(np.where(can, core.macros.names.index("shoot"), 0)[:, None])
    assert (np.hypot(*core.sim.world["vel"][:, 0].T)[can] > 0.5).all(), "the kick has effect wherever the mask allows it"


@sets
def test_a_pass_arrives_as_fast_as_it_should(name):
    records = np.zeros((1, 22), MEMORY)
    given = parameters(name)
    embody(records, given)
    for distance in (4.0, 9.0, 14.0):
        speed = motion.pass_speed(records[0, 0], distance, 0.8)
        if speed < given.ball_speed_max:
            # a ball that has rolled s metres has lost (1 - decay) s of its speed
            assert speed - (1.0 - given.ball_decay) * distance == pytest.approx(0.8)


@sets
@pytest.mark.parametrize("policy", ["weak", "medium", "strong"])
def test_scripted_players_reach_the_ball_and_kick_it(name, policy):
    task = make_task("GoToBall", parameters=parameters(name, noise=True), max_cycles=160, far=20.0)
    core = SoccerCore(task, 40, controlled=(), others=policy, seed=3)
    core.reset(3)
    won = np.zeros(40, bool)
    for _ in range(160):
        won |= core.step(None).terminated
    assert won.mean() >= 0.9
    task = dataclasses.replace(make_task("HFO1v0", parameters=parameters(name, noise=True)), max_cycles=400)
    core = SoccerCore(task, 40, controlled=(), others=policy, seed=4)
    core.reset(4)
    scored = np.zeros(40, bool)
    for _ in range(400):
        core.step(None)
        scored |= core.crossed_goal_line(right=True)
    assert scored.mean() >= (0.5 if policy == "weak" else 0.7)


@sets
def test_holding_keeps_the_ball_within_reach(name):
    core = SoccerCore(make_task("Keepaway3v2", parameters=parameters(name), full_state=True), 1, controlled="left_1", action_mode="macro",
                      others="hold")  # fmt: skip
    core.reset(2)
    reach = float(np.sqrt(core.sim.packed[0]["types"][0, TypeColumn.KICKABLE_SQUARED]))
    core.place_ball(0.8 * reach, 0.0)
    core.place_player(1, 0.0, 0.0, 0.0)
    core.place_player(12, 0.8 * reach + 1.0, 0.0, 0.0)
    core.place_player(13, 8.0, 8.0, 0.0)
    core.observe()
    hold = np.array([[core.macros.names.index("hold")]])
    for _ in range(15):
        core.step(hold)
        assert core.sim.kickable(1)[0]
    own, ball, opponent = (core.sim.world["pos"][0, k] for k in (1, 0, 12))
    assert ball[0] < own[0] or np.linalg.norm(ball - opponent) > 2.0, "on the side away from the opponent, or out of his way"
