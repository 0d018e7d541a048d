"""Tiers of knowledge: each says what it promises, any controller runs on any of them, and only oracles read the truth."""

import gc
import re
from pathlib import Path

import numpy as np
import pytest
from cprm_baselines import goalie_memory
from paths import ROOT

from cprm_gym.agents import goalie
from cprm_gym.agents.knowledge import ORACLES, TIERS, Informed, informed, make_tier
from cprm_gym.agents.knowledge.oracles import Foresight, idle
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.knowledge.tracker import Tracker
from cprm_gym.agents.registry import AGENTS
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.core import SoccerCore, select_agents
from cprm_gym.envs.others.registry import controller_entries, load_controller
from cprm_gym.envs.players.senses import Senses
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ControllerError, CprmError, ParameterError, UnknownName
from cprm_gym.simulator.state import Count

PARTS = ("memory", "landmarks", "lines")
"""Of an observation, for all tiers."""
MEASURES = {"cprm_gym/benchmark/tracking.py", "cprm_gym/benchmark/scene/error.py"}
"""What says how far a tier is off."""


def of_agent(core, k=0):
    return {key: value[:, k].copy() for key, value in core.observation.items()}


def play(factory, worlds=6, cycles=40, senses=None, task="Goalie", seed=3, first=0, parts=PARTS):
    """(core, observations, actions) of the first agent's episodes; the others are idle."""
    made = make_task(task)
    agent = select_agents(made.controlled, made.left, made.right)[0]
    controller = factory(made, agent)
    include = dict.fromkeys((*(() if parts is None else parts), *getattr(controller, "needs", ())))
    core = SoccerCore(made, worlds, seed=seed, first_world=first, include=tuple(include), senses=senses or Senses())
    core.reset(seed)
    if isinstance(controller, Informed):
        controller.connect(core, agent)
    seen, done = [of_agent(core)], []
    controller.reset(seen[0], 0)
    for _ in range(cycles):
        action = controller.act(seen[-1])
        done.append({key: np.array(value) for key, value in action.items()})
        sent = idle(core) | {key: np.zeros((worlds, len(core.agents), *np.shape(v)[1:])) for key, v in action.items() if key == "turn_neck"}
        for key in sent:
            sent[key][:, 0] = action[key]
        core.step(sent)
        seen.append(of_agent(core))
    return core, seen, done


def same(first, second):
    return all(np.array_equal(a[key], b[key]) for a, b in zip(first, second, strict=True) for key in a)


def test_on_the_tier_memory_a_controller_is_what_it_is_without_one():
    plain = play(goalie_memory.make_controller)[2]
    assert same(plain, play(informed(goalie_memory.make_controller, "memory"))[2])


@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize(
    ("task", "controller"),
    [
        ("Goalie", "cprm"),
        ("Goalie", "goalie_raw"),
        ("Goalie", "scripted"),
        ("KickOffShot", "cprm"),
        ("PassAndAdvance", "cprm"),
        ("GoToBall", "fsm"),
    ],
)
def test_any_controller_runs_on_any_tier_unchanged(task, controller, tier):
    factory = informed(load_controller(controller), tier)
    if tier == "bins" and task != "Goalie":
        with pytest.raises(UnknownName, match="bins"):
            play(factory, task=task)
        return
    _, _, actions = play(factory, worlds=3, cycles=12, task=task)
    assert all(np.isfinite(action["params"]).all() for action in actions)


@pytest.mark.parametrize(
    ("task", "controller"),
    [("Goalie", "cprm"), ("LostAndFound", "cprm"), ("KickOffShot", "cprm"), ("KickOffShot2v2", "cprm"), ("PassAndAdvance", "cprm"),
     ("GoToBall", "cprm"), ("Soccer5v5", "cprm")],
)  # fmt: skip
def test_on_the_belief_no_agent_needs_the_environments_memory(task, controller):
    """The observation has neither what the environment reckons of the ball and the others nor of himself."""
    core, _, actions = play(informed(load_controller(controller), "belief"), worlds=2, cycles=8, task=task, parts=None)
    assert not {"self", "memory", "memory_age"} & set(core.observation)
    assert {"landmarks", "lines"} <= set(core.observation)
    assert all(np.isfinite(action["params"]).all() for action in actions)


@pytest.mark.parametrize("late", [{}, {"late_ball": 2}, {"late_others": 2}, {"late": 2}, {"asynchronous": True}], ids=str)
def test_a_world_that_begins_anew_is_known_as_one_alone(late):
    """Nothing of the episode before is left, and the first news, told again until others come, are taken once."""
    senses = Senses(**late)
    task = make_task("Goalie")
    core = SoccerCore(task, 3, seed=5, include=PARTS, senses=senses)
    core.reset(5)
    batch, controller = make_tier("belief", task, "left_1", senses), goalie_memory.make_controller(task, "left_1")
    batch.reset(of_agent(core))
    controller.reset(of_agent(core), 0)
    told, done, known = [], [], []
    for cycle in range(20):
        if cycle == 9:
            core.reset([np.random.SeedSequence(77)], np.array([1]))
            for made in ((batch,), (controller, 0)):
                made[0].reset(of_agent(core), *made[1:], np.array([False, True, False]))
            done[-1]["type"][1] = 0
        told.append(of_agent(core))
        known.append(batch.know(told[-1], done[-1] if done else None))
        done.append({key: np.array(value) for key, value in controller.act(told[-1]).items()})
        core.step({key: value[:, None] for key, value in done[-1].items()})
    alone = make_tier("belief", task, "left_1", senses)
    first = {key: value[1:2] for key, value in told[9].items()}
    alone.reset(first)
    for cycle in range(9, 20):
        seen = {key: value[1:2] for key, value in told[cycle].items()}
        mine = alone.know(seen, None if cycle == 9 else {key: value[1:2] for key, value in done[cycle - 1].items()})
        for part in ("self", "memory", "memory_age"):
            assert known[cycle][part][1] == pytest.approx(mine[part][0], abs=1e-4), (cycle, part)


def test_a_tier_tells_himself_and_the_others_where_they_are():
    """Of the goalie's belief after six cycles: himself to 20 cm, his row among the others, the opponents he sees to a metre."""
    core, seen, actions = play(informed(goalie_memory.make_controller, "belief"), worlds=20, cycles=6)
    tier = make_tier("belief", make_task("Goalie"), "left_1")
    tier.reset(seen[0])
    for k, told in enumerate(seen):
        known = tier.know(
            {key: value for key, value in told.items() if key not in ("self", "memory", "memory_age")}, actions[k - 1] if k else None
        )
    true = core.truth("left_1")
    assert np.hypot(*(known["self"][:, k] - true["self"][:, k] for k in (0, 1))).max() < 0.2
    assert known["memory"][:, 1, :2] == pytest.approx(known["self"][:, :2])
    there = (known["memory_age"][:, 12:] <= 1) & (true["memory_age"][:, 12:] == 0)
    gaps = np.hypot(*(known["memory"][:, 12:, k] - true["memory"][:, 12:, k] for k in (0, 1)))[there]
    assert len(gaps) > 10
    assert np.median(gaps) < 0.6


@pytest.mark.parametrize("tier", [t for t in TIERS if t != "bins"])
def test_a_world_is_known_alone_as_in_a_batch(tier):
    senses = Senses(noise=0.5, lost=0.2)
    batch = play(informed(goalie_memory.make_controller, tier, senses), 5, senses=senses)[2]
    alone = play(informed(goalie_memory.make_controller, tier, senses), 1, senses=senses, first=3)[2]
    for many, one in zip(batch, alone, strict=True):
        assert many["type"][3] == one["type"][0]
        assert many["params"][3] == pytest.approx(one["params"][0], abs=1e-6)


def knowledge(name, senses, cycles=30, worlds=60, seed=5):
    """Places of the ball and of the opponents as told by a tier and as they are: (T, W, 4), (T, W, 2, 2) each; the agent is idle."""
    task = make_task("Goalie")
    core = SoccerCore(task, worlds, seed=seed, include=PARTS, senses=senses)
    core.reset(seed)
    tier = make_tier(name, task, "left_1", senses)
    if name in ORACLES:
        tier.connect(core, "left_1")
    tier.reset(of_agent(core))
    told, true, sent = [], [], None
    for _ in range(cycles):
        seen = of_agent(core)
        told.append((seen | dict(tier.know(seen, sent)))["memory"][:, [0, 12, 13]])
        true.append(core.truth("left_1")["memory"][:, [0, 12, 13]])
        sent = no_action(worlds)
        core.step(idle(core))
    return np.array(told), np.array(true)


def error(told, true, thing=0, after=6):
    """Median of the metres between."""
    gap = told[after:, :, thing, :2] - true[after:, :, thing, :2]
    return float(np.median(np.hypot(gap[..., 0], gap[..., 1])))


def test_state_is_the_truth_and_frozen_knows_less_than_memory():
    told, true = knowledge("state", Senses(noise=1.0))
    assert (told == true).all()
    frozen, memory = (error(*knowledge(name, Senses(lost=0.5))) for name in ("frozen", "memory"))
    assert frozen > 1.3 * memory


def test_frozen_keeps_what_was_seen_last_as_it_was():
    tier = make_tier("frozen", make_task("Goalie"), "left_1")
    seen = {"level": np.array([[3.0]]), "self": np.ones((1, 8)), "memory": np.arange(4.0).reshape(1, 1, 4)}
    tier.reset(seen)
    assert tier.know(seen, None)["memory"][0, 0].tolist() == [0, 1, 2, 3]
    closed = {**seen, "level": np.zeros((1, 1)), "memory": seen["memory"] + 5}
    assert tier.know(closed, None)["memory"][0, 0].tolist() == [0, 1, 2, 3]
    slow = {**closed, "level": np.full((1, 1), 2.0)}
    assert tier.know(slow, None)["memory"][0, 0].tolist() == [5, 6, 2, 3]
    tier.reset(seen, np.array([True]))
    assert not tier.know(closed, None)["memory"].any()


def velocity_error(told, true, after=6):
    """Median of the m / cycle between."""
    gap = told[after:, :, 0, 2:] - true[after:, :, 0, 2:]
    return float(np.median(np.hypot(gap[..., 0], gap[..., 1])))


@pytest.mark.parametrize(
    ("senses", "place", "velocity"),
    [
        ({"noise": 1.0}, 0.85, 0.5), ({"noise": 0.5}, 0.8, 0.55), ({"gaussian": 0.1}, 0.95, 0.9),
        ({"late_ball": 2}, 0.4, 0.5), ({"late_ball": 4}, 0.25, 0.35), ({"late": 2}, 0.4, 0.6),
    ],
    ids=str,
)  # fmt: skip
def test_the_tracker_knows_the_ball_better_than_memory_in_noise_and_delay(senses, place, velocity):
    tracker, memory = (knowledge(name, Senses(**senses)) for name in ("tracker", "memory"))
    assert error(*tracker) < place * error(*memory)
    assert velocity_error(*tracker) < velocity * velocity_error(*memory)


def test_the_tracker_knows_no_less_at_the_servers_own_senses_and_of_opponents_in_noise():
    assert error(*knowledge("tracker", Senses())) < 1.05 * error(*knowledge("memory", Senses()))
    for senses in (Senses(noise=1.0), Senses(late_others=3)):
        assert error(*knowledge("tracker", senses), 1) < error(*knowledge("memory", senses), 1)


def test_the_tracker_knows_what_its_own_kick_does():
    core = SoccerCore("GoToBall", 20, seed=2, include=("memory",))
    core.reset(2)
    for x, y in ((0.0, 0.0),):
        core.place_player(1, x, y, 0.0, (0.0, 0.0))
        core.place_ball(x + 0.6, y, 0.0, 0.0)
    core.observe(np.arange(20))
    tier, seen = Tracker(), of_agent(core)
    tier.reset(seen)
    tier.know(seen, None)
    kick = no_action(20)
    kick["type"][:], kick["params"][:, 0] = 3, 0.6
    core.step({key: value[:, None] for key, value in kick.items()})
    blind = of_agent(core)
    blind["level"][:] = 0.0
    told = tier.know(blind, kick)["memory"][:, 0]
    true = core.truth("left_1")["memory"][:, 0]
    assert told[:, 2] == pytest.approx(true[:, 2], abs=0.25)
    assert (true[:, 2] > 1.0).all()


def test_branches_are_the_future_bit_for_bit_and_leave_the_present_alone():
    core = SoccerCore("Goalie", 12, seed=4, include=("memory",))
    core.reset(4)
    core.step(idle(core))
    now = core.sim.state_hash()
    future = core.branch()
    for _ in range(5):
        future.step(idle(future))
    assert core.sim.state_hash() == now
    for _ in range(5):
        core.step(idle(core))
    assert core.sim.state_hash() == future.sim.state_hash()


def test_foresight_tells_the_kick_before_it_happens_and_otherwise_the_truth():
    core = SoccerCore("Goalie", 60, seed=4, include=("memory",))
    core.reset(4)
    tier = Foresight(1)
    tier.connect(core, "left_1")
    told_before, kicked = 0, 0
    for _ in range(40):
        told, true = tier.know(of_agent(core), None)["memory"], core.truth("left_1")["memory"]
        counts = core.sim.world["counts"][:, 11:13, Count.KICK].sum(axis=1)
        core.step(idle(core))
        hit = core.sim.world["counts"][:, 11:13, Count.KICK].sum(axis=1) > counts
        assert (told[~hit] == true[~hit]).all()
        after = core.truth("left_1")["memory"]
        assert told[hit, 0, :2] + told[hit, 0, 2:] == pytest.approx(after[hit, 0, :2], abs=2e-3)
        kicked += hit.sum()
        told_before += (np.abs(told[hit, 0] - true[hit, 0]).max(axis=1) > 0.1).sum()
    assert kicked > 30
    assert told_before > 0.5 * kicked


# ---------------------------------------------------------------------- who reads the truth


def reads_only_observations(factory, senses=None, task="Goalie", cycles=25):
    """Whether the same observations, with other worlds behind them, give the same actions."""
    _, seen, actions = play(factory, senses=senses, cycles=cycles, task=task)
    made = make_task(task)
    elsewhere = SoccerCore(made, 6, seed=77, include=PARTS)
    elsewhere.reset(77)
    controller = factory(made, elsewhere.agents[0])
    if isinstance(controller, Informed):
        controller.connect(elsewhere, elsewhere.agents[0])
    controller.reset(seen[0], 0)
    again = []
    for observation in seen[:-1]:
        again.append({key: np.array(value) for key, value in controller.act(observation).items()})
        elsewhere.step(idle(elsewhere))
    return same(actions, again)


TASKS_OF_CONTROLLERS = {*AGENTS, *PLAYERS} - {"Soccer", "Soccer11v11"}
"""Tasks in which somebody can act; of the matches the smallest."""


def playable(controller, task):
    """Whether a registered controller plays a task."""
    try:
        load_controller(controller)(make_task(task), "left_1")
    except CprmError:
        return False
    return True


def test_no_registered_controller_reads_the_truth():
    played = set()
    for controller in controller_entries():
        for task in sorted(TASKS_OF_CONTROLLERS):
            if playable(controller, task):
                assert reads_only_observations(load_controller(controller), task=task, cycles=12), (controller, task)
                played.add(controller)
    assert played == set(controller_entries()), "each was played in one task at least"


@pytest.mark.parametrize("tier", TIERS)
def test_oracles_alone_read_the_truth_whoever_plays_on_them(tier):
    for task, player in PLAYERS.items():
        if tier in player.tiers:
            assert reads_only_observations(player.on(tier), task=task) == (tier not in ORACLES), task
    assert tuple(name for name in TIERS if make_tier(name, make_task("Goalie"), "left_1").oracle) == ORACLES


class Cheat:
    """Looks for the worlds wherever they are, and runs after the ball."""

    needs = ("memory",)

    def reset(self, observation, seed, worlds=None):
        self.core = [c for c in gc.get_objects() if type(c) is SoccerCore and c.worlds == len(observation["level"])][-1]

    def act(self, observation):
        action = no_action(len(observation["level"]))
        action["type"][:], action["params"][:, 1] = 1, self.core.sim.world["pos"][:, 0, 1] / 60.0
        return action


def test_a_controller_that_cheats_is_caught():
    assert not reads_only_observations(lambda task, agent: Cheat())


def test_the_hooks_of_the_truth_are_used_by_oracles_alone():
    users = set()
    for folder in ("cprm_gym", "baselines"):
        for path in Path(ROOT, folder).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            # what measures how far a tier is off is no controller
            if path.relative_to(ROOT).as_posix() not in MEASURES and re.search(r"core\.(truth|branch)\(|true_memory\(", text):
                users.add(path.relative_to(ROOT).as_posix())
    assert users == {"cprm_gym/agents/knowledge/oracles.py", "cprm_gym/envs/core.py", "cprm_gym/envs/players/memory.py"}


@pytest.mark.parametrize("tier", ORACLES)
def test_an_oracle_that_was_shown_no_worlds_says_so(tier):
    oracle = make_tier(tier, make_task("Goalie"), "left_1")
    with pytest.raises(ControllerError, match="connect"):
        oracle.know({}, None)


def test_what_there_is_not_is_refused_by_name():
    with pytest.raises(UnknownName, match="tracker"):
        make_tier("trakcer", make_task("Goalie"), "left_1")
    with pytest.raises(ParameterError, match="belief has hands, foresight has ahead, the others none"):
        make_tier("memory", make_task("Goalie"), "left_1", ahead=2)
    with pytest.raises(ParameterError, match="ahead: 0 given"):
        make_tier("foresight", make_task("Goalie"), "left_1", ahead=0)
    with pytest.raises(ParameterError, match="'noise 1' given; Senses are needed"):
        make_tier("tracker", make_task("Goalie"), "left_1", "noise 1")
    with pytest.raises(UnknownName, match="right_1"):
        SoccerCore("Goalie", 1).truth("right_1")


def test_the_bins_are_what_the_goalies_model_expects():
    task, senses = make_task("Goalie"), Senses()
    core = SoccerCore(task, 4, seed=3, include=("memory",), senses=senses)
    core.reset(3)
    tier, agent = make_tier("bins", task, "left_1"), goalie.make_controller(task, "left_1")
    tier.reset(of_agent(core))
    agent.reset(of_agent(core), 0)
    for _ in range(8):
        seen = of_agent(core)
        told = tier.know(seen, None)["memory"]
        agent.act(seen)
        assert told[:, 0, 0] == pytest.approx(agent.controller.executor.read("ball_x"), abs=1e-4)
        core.step(idle(core))


@pytest.mark.parametrize("senses", [Senses(late_ball=2), Senses(late=2)], ids=str)
def test_a_late_world_that_begins_while_others_go_on_is_known_as_one_that_begins_with_all(senses):
    """Its first cycle counts as none, so that the first news, which are told until others come, are not taken for new ones."""
    task, make = make_task("Goalie"), PLAYERS["Goalie"].on("tracker", senses)
    some, all_ = (play_episodes(task, make, 24, 5, 0, senses, slots) for slots in (6, 24))
    assert some.cycles.tolist() == all_.cycles.tolist()
    assert some.success.tolist() == all_.success.tolist()


def test_the_belief_in_late_news_is_as_good_where_worlds_begin_one_by_one():
    """8 points of saves were lost there: the tracker's goalie keeps as many, or a few less."""
    senses, task = Senses(late_ball=2), make_task("Goalie")
    belief, tracker = (play_episodes(task, PLAYERS["Goalie"].on(tier, senses), 250, 99, 0, senses, 50) for tier in ("belief", "tracker"))
    assert belief.success.mean() > tracker.success.mean() - 0.04


@pytest.mark.parametrize("tier", ["tracker", "belief"])
def test_what_a_model_of_intention_asks_of_a_tier_is_told(tier):
    """How old the ball is, and how fast the shooter runs: in sight, near the truth."""
    core = SoccerCore("Goalie", 30, seed=5, include=("memory", "landmarks", "lines"), senses=Senses())
    known = make_tier(tier, make_task("Goalie"), "left_1")
    mine = {key: value[:, 0] for key, value in core.reset(5).items()}
    known.reset(mine)
    told = known.know(mine, None)
    errors, speeds = [], []
    for _ in range(20):
        sent = no_action(30)
        before = core.sim.world["pos"][:, 12].copy()
        core.step({key: value[:, None] for key, value in sent.items()})
        mine = {key: value[:, 0] for key, value in core.observation.items()}
        told = known.know(mine, sent)
        np.testing.assert_array_equal(known.ball_age, told["memory_age"][:, 0] if tier == "belief" else mine["memory_age"][:, 0])
        seen = mine["memory_age"][:, 12] == 0
        true = core.sim.world["pos"][:, 12] - before
        errors.append(np.hypot(*(known.velocities[:, 11] - true)[seen].T))
        speeds.append(np.hypot(*true[seen].T))
    assert np.median(np.concatenate(speeds)) > 0.4
    assert np.median(np.concatenate(errors)) < 0.3
