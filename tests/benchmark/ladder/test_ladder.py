"""Ladders: who meets whom, games that can be interrupted, ratings, and that better players stand higher."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from cprm_gym.benchmark.ladder.families import DEFENDERS, FAMILIES, TEAMS
from cprm_gym.benchmark.ladder.plan import AGAINST, LadderPlan, play_games, standings
from cprm_gym.benchmark.ladder.rating import rate
from cprm_gym.benchmark.plan import BlockResult
from cprm_gym.benchmark.runner import run
from cprm_gym.cli import app
from cprm_gym.envs.others.registry import other_player
from cprm_gym.envs.tasks import TASKS
from cprm_gym.errors import CprmError, ParameterError, UnknownName


def test_every_family_has_eight_graded_opponents_and_others_for_testing():
    for family in FAMILIES.values():
        opponents = getattr(family, family.side) if family.side != "either" else family.right
        assert len(opponents) >= 8
        assert len(family.held_out) >= 3
        assert not set(family.held_out) & set(opponents)
        assert set(family.tasks) <= set(TASKS)
        for name in (*family.left, *family.right, *family.held_out):
            other_player(name)


def test_all_pairs_meet_on_both_sides():
    plan = LadderPlan("soccer", games=70, held_out=False)
    blocks = plan.blocks()
    pairs = {block.controller for block in blocks}
    assert pairs == {f"{a}{AGAINST}{b}" for a in TEAMS for b in TEAMS if a != b}
    assert sum(block.count for block in blocks) == 70 * len(pairs)
    plan = LadderPlan("half_field", rivals=("scripted",), more=("eased:share=5",))
    assert len({block.controller for block in plan.blocks()}) == 5 * (len(DEFENDERS) + 4)


def test_strengths_come_out_of_games_that_follow_them():
    rng = np.random.default_rng(0)
    truth = np.array([-1.0, -0.3, 0.2, 1.1])
    chance = 1.0 / (1.0 + np.exp(truth[None] - truth[:, None] - 0.25))
    played = np.full((4, 4), 4000.0) * (1 - np.eye(4))
    won = rng.binomial(played.astype(int), chance).astype(float)
    ratings = rate(won, played, advantage=True)
    expected = 1000 + 400 / np.log(10) * truth
    assert ((ratings.low < expected) & (expected < ratings.high)).all()
    assert abs(ratings.advantage - 400 / np.log(10) * 0.25) < 10
    assert (ratings.high - ratings.low < 40).all()


def test_intervals_hold_the_truth_as_often_as_they_say():
    """95 %: of 400 intervals between 92 and 98 of 100 hold it, up to luck of 4 standard deviations."""
    rng = np.random.default_rng(1)
    truth = np.array([-0.8, -0.1, 0.3, 0.6])
    played = np.full((4, 4), 60.0) * (1 - np.eye(4))
    chance = 1.0 / (1.0 + np.exp(truth[None] - truth[:, None]))
    inside = []
    for _ in range(100):
        r = rate(rng.binomial(played.astype(int), chance).astype(float), played)
        inside.append((r.low <= 1000 + 400 / np.log(10) * truth) & (1000 + 400 / np.log(10) * truth <= r.high))
    assert 0.90 < np.mean(inside) < 0.995


def test_who_wins_all_games_has_a_rating():
    ratings = rate(np.array([[0.0, 50.0], [0.0, 0.0]]), np.array([[0.0, 50.0], [50.0, 0.0]]))
    assert np.isfinite(ratings.points).all()
    assert ratings.points[0] > ratings.points[1]


@pytest.mark.parametrize(
    ("won", "played", "prior", "words"),
    [
        (np.zeros((2, 3)), np.zeros((2, 2)), 1.0, "square"),
        (np.ones((2, 2)), np.zeros((2, 2)), 1.0, "from 0 to the games"),
        (np.zeros((2, 2)), np.zeros((2, 2)), 0.0, "above 0"),
    ],
)
def test_games_that_cannot_be_are_refused(won, played, prior, words):
    with pytest.raises(ParameterError, match=words):
        rate(won, played, prior=prior)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"family": "socer"}, UnknownName, "Did you mean 'soccer'"),
        ({"games": 0}, ParameterError, "at least 1"),
        ({"more": ("strongg",)}, UnknownName, "Did you mean 'strong'"),
        ({"more": ("strong",)}, ParameterError, "on the ladder twice"),
        ({"rivals": ("scripted",)}, ParameterError, "sides of 'soccer' are alike"),
    ],
)
def test_bad_plans_are_refused(options, error, words):
    with pytest.raises(error, match=words):
        LadderPlan(**options)


@pytest.fixture(scope="module")
def little():
    """Some pairs of the goalie's ladder."""

    class Little(LadderPlan):
        def blocks(self):
            return [b for b in super().blocks() if b.controller.split(AGAINST)[1] in ("hold", "random", "strong", "eased:share=10")]

    return Little("goalie", games=8, held_out=False, more=("eased:share=10",))


def test_an_interrupted_ladder_goes_on_to_the_same_numbers(little, tmp_path):
    journal = tmp_path / "episodes.jsonl"
    games = run(little, journal=journal, play=play_games)
    for _ in range(3):
        next(games)
    games.close()
    rows = journal.read_text().splitlines()
    assert len(rows) == 3
    journal.write_text("\n".join(rows) + '\n{"block": {"ta')  # torn by the interruption
    went_on = {r.block: r.reward for r in run(little, journal=journal, play=play_games)}
    at_once = {r.block: r.reward for r in run(little, play=play_games)}
    assert went_on == at_once
    table, _ = standings(little, (BlockResult.from_json(row) for row in journal.read_text().splitlines()))
    attackers = [s.player for s in table if s.side == "right" and s.games]
    assert attackers[0] == "strong"
    assert attackers.index("strong") < attackers.index("hold")


def test_no_games_are_no_ladder(little):
    with pytest.raises(CprmError, match="no game has been played"):
        standings(little, [])
    broken = BlockResult(little.blocks()[0], error="act returned list")
    with pytest.raises(CprmError, match="act returned list"):
        standings(little, [broken])


def test_the_command_writes_the_ladder_and_takes_one_up(tmp_path):
    shown = CliRunner().invoke(app, ["ladder", "--family", "goalie", "--games", "2", "--training", "--output", str(tmp_path)])
    assert shown.exit_code == 0, shown.output
    (folder,) = [p for p in tmp_path.iterdir() if p.is_dir()]
    data = json.loads((folder / "ladder.json").read_text())
    assert data["plan"]["held_out"] is False
    assert len(data["standings"]) == 13
    assert {s["games"] for s in data["standings"] if s["side"] == "right"} == {8}
    page = (folder / "ladder.md").read_text()
    assert "| right | `strong` |" in page
    before = (folder / "ladder.json").read_text()
    again = CliRunner().invoke(app, ["ladder", "--resume", str(folder)])
    assert again.exit_code == 0, again.output
    assert (folder / "ladder.json").read_text() == before
    both = CliRunner().invoke(app, ["ladder", "--resume", str(folder), "--games", "3"])
    assert both.exit_code == 2
    none = CliRunner().invoke(app, ["ladder", "--resume", str(tmp_path / "none")])
    assert none.exit_code == 2
