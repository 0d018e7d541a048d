"""The suite ``demonstrations``: pairs, floors, resumption, tuning, and learning from logged play."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from cprm_gym.agents.intention import DUE, FEATURES, MODES, VIEW, Intention, IntentionConstants, learned
from cprm_gym.agents.skills.constants import GoalieConstants
from cprm_gym.benchmark import demonstrations, knowledge
from cprm_gym.benchmark.demonstrations import ARMS, DEMONSTRATIONS, ArmSearch, DemonstrationPlan, play_block, summarise
from cprm_gym.benchmark.demonstrations.learning import Log, calibration, foreseen, joined, learn, log_loss, logged
from cprm_gym.benchmark.demonstrations.report import Row
from cprm_gym.benchmark.runner import run
from cprm_gym.benchmark.statistics import paired_difference
from cprm_gym.benchmark.tuning import study
from cprm_gym.cli import app
from cprm_gym.errors import CprmError, ParameterError, UnknownName

SMALL = DemonstrationPlan(("A",), episodes=60, seed=6)


def test_every_demonstration_names_arms_and_senses_that_there_are():
    for name, one in DEMONSTRATIONS.items():
        assert one.senses in knowledge.SENSES, name
        assert set(one.arms) <= set(ARMS), name
        assert one.model not in one.floors
        assert one.episodes >= (10_000 if 0 < min(floor for floor in one.floors.values() if floor) <= 2 else 2000), name
        for arm in one.arms:
            assert isinstance(one.numbers(arm), ARMS[arm].constants(one.task))


def test_all_play_with_the_same_numbers_where_nobody_was_tuned_for_the_senses():
    memory = GoalieConstants.tuned("memory").to_dict()
    for arm in ("memory", "tracker", "rule", "model"):
        numbers = DEMONSTRATIONS["C .6"].numbers(arm).to_dict()
        assert {name: numbers[name] for name in memory} == memory


def test_differences_are_the_models_less_the_rivals_in_the_same_worlds():
    results = list(run(SMALL, play=play_block))
    report = summarise(SMALL, results)
    success = {r.block.controller.rsplit("/", 1)[1]: np.array(r.success) for r in results}
    rows = {row.arm: row for row in report.rows}
    assert list(rows) == list(DEMONSTRATIONS["A"].arms)
    model = DEMONSTRATIONS["A"].model
    for arm in ("tracker", "rule", "memory", "state"):
        expected = paired_difference(success[model], success[arm])
        assert (rows[arm].difference, rows[arm].difference_low, rows[arm].difference_high) == expected[:3]
    assert rows[model].difference is None
    assert rows[model].rate > rows["memory"].rate
    assert rows["tracker"].floor == 9.0
    assert rows["memory"].floor is None
    assert f"| A | {model} |" in report.to_markdown()


@pytest.mark.parametrize(
    ("difference", "low", "floor", "met"),
    [(0.1, 0.01, 9.0, True), (0.08, 0.01, 9.0, False), (0.1, -0.01, 9.0, False), (-0.005, -0.015, 0.0, True), (-0.012, -0.015, 0.0, False),
     (0.0, -0.03, 0.0, False), (0.1, 0.05, None, None), (-0.09, -0.11, -10.0, True), (-0.11, -0.12, -10.0, False)],
)  # fmt: skip
def test_a_floor_is_met_by_the_point_estimate_with_an_interval_beyond_0(difference, low, floor, met):
    assert Row("A", "rule", 100, 0.5, 0.4, 0.6, difference, low, 2 * difference - low, floor).met is met


def test_an_interrupted_run_goes_on_and_ends_the_same(tmp_path):
    plan = DemonstrationPlan(("E",), episodes=20, seed=6)
    whole = summarise(plan, list(run(plan, play=play_block)))
    course = run(plan, journal=tmp_path / "episodes.jsonl", play=play_block)
    next(course)
    course.close()
    assert len((tmp_path / "episodes.jsonl").read_text().splitlines()) == 1
    assert summarise(plan, list(run(plan, journal=tmp_path / "episodes.jsonl", play=play_block))) == whole


def test_the_command(tmp_path, monkeypatch):
    call = CliRunner().invoke
    short = ["benchmark", "--suite", "demonstrations", "--quick", "--episodes", "6", "--tasks", "A", "--output", str(tmp_path)]
    result = call(app, short)
    assert result.exit_code == 0, result.output
    (folder,) = tmp_path.iterdir()
    assert {path.name for path in folder.iterdir()} >= {"plan.json", "episodes.jsonl", "demonstrations.json", "demonstrations.md"}
    again = call(app, ["benchmark", "--suite", "demonstrations", "--resume", str(folder)])
    assert again.exit_code == 0, again.output
    wrong = call(app, [*short, "--senses", "default"])
    assert wrong.exit_code != 0
    assert "a demonstration has its own" in wrong.output
    plan = json.loads((folder / "plan.json").read_text())
    plan["constants"]["A"]["model"]["sure"] = 0.123
    (folder / "plan.json").write_text(json.dumps(plan))
    with pytest.raises(CprmError, match="others by now"):
        DemonstrationPlan.read(folder)


def test_what_there_is_not_is_refused():
    with pytest.raises(UnknownName, match="demonstration"):
        DemonstrationPlan(("Z",))
    with pytest.raises(ParameterError, match="twice"):
        DemonstrationPlan(("A", "A"))
    with pytest.raises(ParameterError, match="episodes"):
        DemonstrationPlan(episodes=-1)
    with pytest.raises(CprmError, match="not the plan"):
        DemonstrationPlan.read(demonstrations_folder())


def demonstrations_folder():
    from pathlib import Path

    return Path(demonstrations.__file__).parent


def test_a_study_begins_with_the_numbers_of_memory_and_goes_on_from_its_journal(tmp_path):
    search = ArmSearch("A", "rule", worlds=4, population=3, elite=1, generations=1)
    begin = search.begin()
    assert isinstance(begin, IntentionConstants)
    assert begin.run == GoalieConstants.tuned("memory").run
    (first,) = study(search, tmp_path / "rule.jsonl")
    assert first.centre == search.score(begin, 0)
    assert list(study(search, tmp_path / "rule.jsonl")) == [first]


# ---------------------------------------------------------------------- learning


@pytest.fixture(scope="module")
def shooter_log():
    return logged("shooter", 60, 5, slots=60)


def test_logged_play_says_when_the_next_shot_comes(shooter_log):
    log, due = shooter_log, shooter_log.due
    assert log.numbers.shape[1:] == (len(FEATURES),)
    assert log.seen.shape[1:] == (len(VIEW) + len(FEATURES),)
    assert log.shot.sum() > 30
    assert (due[log.shot] == 0).all()
    for k in np.flatnonzero(log.shot):
        before = (log.world == log.world[k]) & (log.cycle == log.cycle[k] - 3) & ~log.shot
        others = (log.world == log.world[k]) & (log.cycle < log.cycle[k]) & log.shot
        if before.any() and not others.any():
            assert due[before][0] == DUE.index("4")
    assert (log.mode == -1).all(), "the shooter has no mode that could be logged"


def test_modes_of_who_mixes_are_logged_and_counted():
    log = logged("attackers", 12, 5, slots=12)
    assert set(np.unique(log.mode)) <= set(range(len(MODES)))
    assert len(np.unique(log.mode)) >= 4
    found = learn(log, False, "test")
    stays = np.diag(found.tables["mode"])
    assert stays[: MODES.index("shoot")].min() > 0.5, "what he has in mind lasts"


def test_what_is_learned_foresees_shots_of_other_worlds(shooter_log):
    found = learn(shooter_log, True, "test", iterations=2)
    other = logged("shooter", 40, 6, slots=40)
    for cycles, chance in foreseen(found, other).items():
        assert ((chance >= 0) & (chance <= 1)).all()
        happened = other.due < cycles
        assert log_loss(chance, happened) < log_loss(np.full(len(chance), happened.mean()), happened)


def test_the_committed_tables_are_as_good_as_the_docs_say():
    other = logged("shooter", 150, 8, slots=150)
    near = other.numbers[:, 0] < 2.5
    chances = foreseen(learned("shooter"), other)
    for cycles, most in ((1, 0.20), (3, 0.32), (5, 0.37)):
        assert log_loss(chances[cycles][near], other.due[near] < cycles) < most


def test_logs_are_joined_with_worlds_of_their_own(shooter_log):
    both = joined([shooter_log, shooter_log])
    assert len(both.world) == 2 * len(shooter_log.world)
    half = len(shooter_log.world)
    assert not set(both.world[:half]) & set(both.world[half:])
    assert (both.due[half:] == shooter_log.due).all()
    assert isinstance(both, Log)


def test_log_loss_and_calibration_by_hand():
    assert log_loss(np.array([0.5, 0.5]), np.array([True, False])) == pytest.approx(np.log(2))
    assert log_loss(np.array([0.0]), np.array([True])) == pytest.approx(-np.log(1e-3))
    said = calibration(np.array([0.05, 0.05, 0.95, 1.0]), np.array([False, True, True, True]))
    assert said == [(0.05, 0.5, 2), (pytest.approx(0.975), 1.0, 2)]


def test_tables_survive_their_file():
    found = learned("shooter")
    again = Intention.of(found.to_json())
    for name, table in found.tables.items():
        assert again.tables[name] == pytest.approx(table, abs=2e-4)
    assert (again.situations, again.views, again.source) == (found.situations, found.views, found.source)


def test_a_story_is_of_a_save_that_began_before_the_kick():
    from cprm_gym.benchmark.demonstrations import story

    made = np.zeros((20, 2, 4, 2))
    made[..., 0, 0] = -30.0
    made[11:, :, 0, 0] = -30.0 - 2.0 * np.arange(1, 10)[:, None]
    made[..., 1, 0] = -50.0
    made[7:, 1, 1, 1] = 0.5
    made[11:, :, 0, 1] = 0.3 * np.arange(1, 10)[:, None]
    told, kicked = np.zeros((20, 2, 8)), np.zeros((20, 2), bool)
    told[..., 0], told[..., 4] = 0.9, 3.0
    kicked[10] = True
    model = story.Played(made, made[:, :, 0], told, kicked, np.ones((20, 2), bool), np.array([True, True]))
    behind = made.copy()
    behind[:, :, 1, 1] = 0.0
    rival = model._replace(saved=np.array([False, False]), places=behind)
    assert story.found(model, rival) == (1, 10), "in world 0 he has not moved"
    picture = story.drawn(model, rival, 1, 10)
    assert picture.count("<rect") == len(story.SHOWN)
    assert "chance 0.90, line +3.0 m" in picture
    with pytest.raises(CprmError, match="no such save"):
        story.found(model, rival._replace(saved=np.array([True, True])))


@pytest.mark.parametrize("name", sorted(DEMONSTRATIONS))
def test_everybody_of_a_demonstration_plays(name):
    for block in DemonstrationPlan((name,), 6).blocks():
        assert len(play_block(block).success) == 6, block.controller
