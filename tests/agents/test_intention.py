"""What the holder of the ball is about to do: features, trees, the relational model, the tier, and the goalie who acts on it."""

import json

import numpy as np
import pytest

from cprm_gym.agents.body import DEFAULT, Body
from cprm_gym.agents.intention import (
    DUE,
    FEATURES,
    LINE,
    MODES,
    TOUCHES,
    VIEW,
    Intention,
    IntentionConstants,
    IntentionGoalie,
    IntentionTier,
    Rule,
    Told,
    Tree,
    grow,
    learned,
)  # fmt: skip
from cprm_gym.agents.intention.situation import situation, touch, view
from cprm_gym.agents.knowledge.tiers import Informed
from cprm_gym.agents.knowledge.tracker import Tracker
from cprm_gym.agents.skills.constants import GoalieConstants
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.players.senses import Senses
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import FormatError, UnknownName

SHOOTER = learned("shooter")


def column(numbers, name):
    return numbers[:, FEATURES.index(name)]


def test_a_holder_beside_the_ball_has_it_now_and_one_behind_a_rolling_ball_later():
    ball = np.array([[-30.0, 4.0, 0.0, 0.0], [-30.0, 4.0, -1.0, 0.0]])
    holder = np.array([[-29.4, 4.0, 0.0, 0.0], [-27.0, 4.0, 0.0, 0.0]])
    numbers = situation(ball, holder, np.zeros((2, 2)), np.array([[-50.0, 0.0]] * 2), DEFAULT)
    assert column(numbers, "reach")[0] == 0
    assert column(numbers, "reach")[1] > 3
    assert column(numbers, "gap") == pytest.approx([0.6, 3.0])
    assert column(numbers, "far") == pytest.approx(np.hypot(22.5, 4.0))
    assert column(numbers, "far_there")[1] < column(numbers, "far")[1] - 2
    assert column(numbers, "approach")[1] == pytest.approx(22.5 / np.hypot(22.5, 4.0))


def test_the_side_that_the_goalie_leaves_is_the_open_one():
    ball = np.array([[-35.0, 0.0, 0.0, 0.0]] * 2)
    seen = view(ball, np.array([[-50.0, 2.0], [-50.0, -2.0]]))
    assert seen[0, VIEW.index("open")] < -1 < 1 < seen[1, VIEW.index("open")]


def test_touches_are_told_apart():
    before = np.array([[-30.0, 0.0, -1.0, 0.0]] * 6)
    after = [(-0.94, 0.0), (-1.5, 0.0), (0.0, 0.75), (0.0, -0.75), (1.0, 0.0), (-2.3, 0.8)]
    ball = np.array([[-31.0, 0.0, *v] for v in after])
    assert [TOUCHES[k] for k in touch(before, ball)] == ["none", "on", "left", "right", "back", "hard"]


def test_a_tree_finds_the_questions_and_survives_its_file():
    rng = np.random.default_rng(3)
    numbers = rng.uniform(0, 1, (4000, 3))
    outcome = np.where(numbers[:, 0] < 0.5, 0, np.where(numbers[:, 2] < 0.25, 1, 2))
    tree = grow(numbers, outcome, 6)
    leaf = tree.leaf(numbers)
    wrong = sum((outcome[leaf == k] != np.bincount(outcome[leaf == k]).argmax()).sum() for k in range(tree.leaves))
    assert wrong < 0.02 * len(numbers)
    assert tree.leaves <= 6
    assert 1 not in tree.feature, "what tells nothing is not asked"
    assert Tree.of(json.loads(json.dumps(tree.to_dict()))) == tree


@pytest.mark.parametrize("change", [{"feature": [0]}, {"below": [0, -1, -1]}, {"cut": "x"}, {"above": [9, -1, -1]}])
def test_what_is_no_tree_is_refused(change):
    tree = grow(np.array([[0.0], [1.0]] * 100), np.array([0, 1] * 100), 2)
    with pytest.raises(FormatError):
        Tree.of({**tree.to_dict(), **change})


def test_tables_of_other_features_or_shapes_are_refused():
    data = json.loads(SHOOTER.to_json())
    with pytest.raises(FormatError, match="learned from"):
        Intention.of(json.dumps({**data, "features": ["gap"]}))
    tables = {**data["tables"], "mode": [[1.0]]}
    with pytest.raises(FormatError, match="'mode'"):
        Intention.of(json.dumps({**data, "tables": tables}))
    with pytest.raises(FormatError):
        Intention.of("[]")
    with pytest.raises(UnknownName, match="shooter"):
        learned("nobody")


def test_the_model_says_what_the_tables_say():
    from cprm_gym.architecture.prm.grounding.grounding import Grounding
    from cprm_gym.architecture.prm.inference.filter import Filter
    from cprm_gym.architecture.prm.model.domains import Index

    world = Grounding(SHOOTER.model(), {"ball": "Ball", "o1": "Opponent"})
    tracked = Filter(world)
    holds = ("possesses(o1,ball)",)
    first = tracked.step({"o1.situation": Index(7), "ball.touch": "on"}, holds)
    p = SHOOTER.tables["begin"] * SHOOTER.tables["touch"][:, TOUCHES.index("on")]
    p /= p.sum()
    assert first["o1.mode"][0] == pytest.approx(p)
    assert first["o1.due"][0] == pytest.approx(p @ SHOOTER.tables["due"][:, 7])
    second = tracked.step({"o1.situation": Index(3)}, holds)
    assert second["o1.mode"][0] == pytest.approx(p @ SHOOTER.tables["mode"])
    free = tracked.step({})
    assert free["o1.due"][0, DUE.index("later")] > 0.9, "who has no ball does not shoot"


def tier(senses=None, **options):
    return IntentionTier(Tracker(senses or Senses()), SHOOTER, 2, **options)


def watched(make, senses=None, worlds=60, cycles=45, seed=9, shots=0.0):
    """Told (T, W, 8), cycles until the next shot (T, W), where it crossed, and which worlds still played (T, W)."""
    task = make_task("Goalie", shots=shots)
    core = SoccerCore(task, worlds, seed=seed, include=("memory",), senses=senses or Senses())
    core.reset(seed)
    watching = make(senses or Senses())
    watching.reset({key: value[:, 0] for key, value in core.observation.items()})
    told, kicked, line, playing = [], [], [], []
    alive = np.ones(worlds, bool)
    for cycle in range(cycles):
        seen = {key: value[:, 0] for key, value in core.observation.items()}
        idle = {"type": np.zeros((worlds, 1), np.int64), "params": np.zeros((worlds, 1, 4))}
        told.append(watching.know(seen, None if cycle == 0 else {key: value[:, 0] for key, value in idle.items()})["intention"])
        playing.append(alive.copy())
        step = core.step(idle)
        (x, y), (vx, vy) = core.sim.world["pos"][:, 0].T, core.sim.world["vel"][:, 0].T
        kicked.append((np.hypot(vx, vy) > 1.7) & (vx < -1))
        line.append(y + vy / np.minimum(vx, -0.2) * (-52.5 - x))
        alive &= ~(step.terminated | step.truncated)
    told, kicked, line, playing = (np.array(part) for part in (told, kicked, line, playing))
    due = np.full(kicked.shape, 99)
    for t in range(cycles - 1, -1, -1):
        due[t] = np.where(kicked[t], 0, due[t + 1] + 1 if t + 1 < cycles else 99)
    return told, due, line, playing


def test_the_chance_of_a_shot_rises_before_it_and_the_side_is_right():
    told, due, line, playing = watched(lambda senses: tier(senses))
    first = (due == 0) & playing & (np.cumsum(due == 0, axis=0) == 1)
    before = np.zeros_like(first)
    before[:-2] = first[2:]
    calm = playing & (due > 8) & (due < 90)
    at_kick, earlier = told[..., Told.CHANCE][first].mean(), told[..., Told.CHANCE][calm].mean()
    assert first.sum() > 40
    assert at_kick > 0.6
    assert earlier < 0.1
    assert told[..., Told.WITHIN_5][before & playing].mean() > 4 * told[..., Told.WITHIN_5][calm].mean()
    sure = first & (told[..., Told.CHANCE] > 0.6)
    aside = np.sign(told[..., Told.LINE][sure]) == np.sign(line[sure])
    assert aside.mean() > 0.85


def test_late_news_are_rolled_forward_so_that_the_shot_is_still_expected_when_it_comes():
    senses = Senses(late_ball=2)
    late, due, _, playing = watched(lambda s: tier(s), senses)
    first = (due == 0) & playing & (np.cumsum(due == 0, axis=0) == 1)
    unseen = np.zeros_like(first)
    unseen[1:] = first[:-1]
    assert late[..., Told.CHANCE][first].mean() > 0.6
    # a cycle after the kick, of which he has heard nothing yet, he holds it for made all the more
    assert late[..., Told.CHANCE][unseen & playing].mean() > late[..., Told.CHANCE][first].mean()


def test_lesions_remove_what_they_name():
    off, *_ = watched(lambda senses: tier(senses, possesses=False), cycles=25)
    assert not off[..., Told.CHANCE].any()
    whole, *_ = watched(lambda senses: tier(senses), cycles=25)
    blurred, *_ = watched(lambda senses: tier(senses, memory=False), cycles=25)
    unseen, *_ = watched(lambda senses: tier(senses, attended=False), cycles=25)
    for other in (blurred, unseen):
        assert np.abs(other - whole).max() > 0.01


def test_the_rule_expects_the_shot_of_who_is_near_ball_and_goal():
    told, *_ = watched(lambda senses: tier(senses, rule=Rule()), cycles=25)
    assert set(np.unique(told[..., Told.CHANCE])) == {0.0, 1.0}
    never, *_ = watched(lambda senses: tier(senses, rule=Rule(gap=0.0)), cycles=25)
    assert not never[..., Told.CHANCE].any()


def play(constants, worlds=8, cycles=30, first=0, seed=4):
    task = make_task("Goalie", shots=0.0)
    core = SoccerCore(task, worlds, seed=seed, first_world=first, include=("memory",))
    core.reset(seed)
    goalie = Informed(IntentionGoalie(2, Body.of(task), constants), tier())
    goalie.reset({key: value[:, 0] for key, value in core.observation.items()}, 0)
    done = []
    for _ in range(cycles):
        action = goalie.act({key: value[:, 0] for key, value in core.observation.items()})
        done.append({key: np.array(value) for key, value in action.items()})
        core.step({key: value[:, None] for key, value in action.items()})
    return done


def test_who_is_never_sure_plays_as_without_intention():
    from cprm_gym.agents.goalie import ReckoningGoalie

    never = play(IntentionConstants(sure=1.0, **GoalieConstants.tuned("memory").to_dict()))
    task = make_task("Goalie", shots=0.0)
    core = SoccerCore(task, 8, seed=4, include=("memory",))
    core.reset(4)
    plain = Informed(ReckoningGoalie(2, Body.of(task), GoalieConstants.tuned("memory")), Tracker(Senses()))
    plain.reset({key: value[:, 0] for key, value in core.observation.items()}, 0)
    for action in never:
        other = plain.act({key: value[:, 0] for key, value in core.observation.items()})
        assert all(np.array_equal(action[key], other[key]) for key in action)
        core.step({key: value[:, None] for key, value in other.items()})


def test_a_world_is_played_alone_as_in_a_batch():
    constants = IntentionConstants(**GoalieConstants.tuned("memory").to_dict())
    batch, alone = play(constants), play(constants, 1, first=5)
    for many, one in zip(batch, alone, strict=True):
        assert many["type"][5] == one["type"][0]
        assert many["params"][5] == pytest.approx(one["params"][0], abs=1e-6)


def test_tables_are_probabilities_and_small():
    for play_of in ("shooter",):
        intention = learned(play_of)
        for name, table in intention.tables.items():
            assert table.min() >= 0, name
            assert table.sum(axis=-1) == pytest.approx(1.0)
        assert len(intention.to_json()) < 200_000
        assert intention.source
    assert SHOOTER.tables["line"].shape == (len(MODES), SHOOTER.views.leaves, len(LINE))
