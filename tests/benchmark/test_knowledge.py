"""The suite ``knowledge``: the same worlds for all tiers, paired, resumable; its command and its plan."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from typer.testing import CliRunner

from cprm_gym.agents.knowledge import TIERS
from cprm_gym.agents.knowledge.players import PLAYERS, Player
from cprm_gym.benchmark import knowledge
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.knowledge import SENSES, KnowledgePlan, play_block, summarise
from cprm_gym.benchmark.plan import Block
from cprm_gym.benchmark.runner import run
from cprm_gym.benchmark.statistics import paired_difference
from cprm_gym.cli import app
from cprm_gym.envs.players.senses import Senses
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import CprmError, ParameterError, UnknownName

SMALL = KnowledgePlan(("Goalie",), ("default", "noise 1"), ("frozen", "memory", "state"), episodes=80, seed=5)


def test_all_tiers_play_the_same_worlds_and_differences_are_paired():
    results = list(run(SMALL, play=play_block))
    report = summarise(SMALL, results)
    rows = {(r.senses, r.tier): r for r in report.rows}
    assert list(rows) == [(s, t) for s in SMALL.senses for t in SMALL.tiers]
    assert rows["default", "state"].rate == rows["noise 1", "state"].rate, "whoever knows everything does not care for the noise"
    assert rows["noise 1", "memory"].rate < rows["default", "memory"].rate
    memory, state = (np.array(next(r.success for r in results if r.block.controller == f"noise 1/{t}")) for t in ("memory", "state"))
    expected = paired_difference(state, memory)
    row = rows["noise 1", "state"]
    assert (row.difference, row.difference_low, row.difference_high, row.p) == expected
    assert row.difference_low > 0
    assert rows["noise 1", "memory"].difference is None


def test_an_interrupted_run_goes_on_and_ends_the_same(tmp_path):
    whole = summarise(SMALL, list(run(SMALL, play=play_block)))
    course = run(SMALL, journal=tmp_path / "episodes.jsonl", play=play_block)
    for _ in range(3):
        next(course)
    course.close()
    lines = (tmp_path / "episodes.jsonl").read_text().splitlines()
    assert len(lines) == 3
    with (tmp_path / "episodes.jsonl").open("a") as file:
        file.write(lines[0][:40])
    played = []
    told = lambda r, done, total: played.append((done, total))  # noqa: E731
    results = list(run(SMALL, journal=tmp_path / "episodes.jsonl", on_result=told, play=play_block))
    assert summarise(SMALL, results) == whole
    assert played[-1] == (6, 6)
    assert len((tmp_path / "episodes.jsonl").read_text().splitlines()) == 6


def test_two_workers_give_the_same_rows_in_the_same_order(tmp_path):
    few = replace(SMALL, senses=("default",), episodes=20)
    alone, two = (summarise(few, list(run(few, workers=n, play=play_block))) for n in (1, 2))
    assert two == alone
    assert summarise(few, list(reversed(list(run(few, play=play_block))))) == alone, "in whatever order they are finished"


def test_the_command_writes_table_and_plot_and_takes_a_run_up(tmp_path, monkeypatch):
    monkeypatch.setattr(KnowledgePlan, "quick", classmethod(lambda cls: SMALL))
    call = CliRunner().invoke
    result = call(app, ["benchmark", "--suite", "knowledge", "--quick", "--episodes", "6", "--output", str(tmp_path)])
    assert result.exit_code == 0, result.output
    (folder,) = tmp_path.iterdir()
    found = json.loads((folder / "knowledge.json").read_text())
    assert len(found["rows"]) == 6
    assert found["plan"]["episodes"] == 6
    assert (folder / "knowledge.png").stat().st_size > 5000
    text = (folder / "knowledge.md").read_text()
    assert f"| Goalie | noise 1 | state | {PLAYERS['Goalie'].origin('state')} | 6 |" in text
    assert "36 episodes, about 0 s of CPU time" in result.output
    again = call(app, ["benchmark", "--suite", "knowledge", "--resume", str(folder)])
    assert again.exit_code == 0
    assert (folder / "knowledge.md").read_text() == text
    for wrong, word in (
        (["--suite", "knwledge"], "knowledge"),
        (["--quick"], "--suite"),
        (["--suite", "knowledge", "--tasks", "Goali"], "Goalie2v1, "),
        (["--suite", "knowledge", "--senses", "default,noise"], "noise 1"),
        (["--suite", "knowledge", "--senses", ""], "none given"),
        (["--suite", "knowledge", "--tiers", "state,state"], "twice"),
        (["--suite", "knowledge", "--controllers", "fsm"], "--controllers"),
        (["--tiers", "memory"], "--suite"),
        (["--suite", "knowledge", "--workers", "0"], "workers"),
        (["--suite", "knowledge", "--timeout", "3"], "--timeout does not go with --suite"),
        (["--suite", "knowledge", "--resume", str(folder), "--quick"], "--quick"),
        (["--suite", "knowledge", "--resume", str(tmp_path)], "plan.json"),
    ):
        refused = call(app, ["benchmark", *wrong])
        assert refused.exit_code == 2
        assert word in refused.output


def test_tasks_senses_and_tiers_can_be_chosen(tmp_path):
    chosen = ["--tasks", "Goalie", "--senses", "lost .3,wide", "--tiers", "frozen,memory"]
    result = CliRunner().invoke(
        app, ["benchmark", "--suite", "knowledge", *chosen, "--episodes", "3", "--seed", "4", "--output", str(tmp_path)]
    )
    assert result.exit_code == 0, result.output
    (folder,) = tmp_path.iterdir()
    assert KnowledgePlan.read(folder) == KnowledgePlan(("Goalie",), ("lost .3", "wide"), ("frozen", "memory"), 3, 4)


def test_worlds_are_the_same_however_many_are_played_at_once():
    senses = Senses(noise=0.5, lost=0.2, late_ball=1, asynchronous=True)
    make = PLAYERS["Goalie"].on("tracker", senses)
    whole, few = (play_episodes(make_task("Goalie"), make, 40, 3, 5, senses, slots) for slots in (40, 7))
    assert whole.success.tolist() == few.success.tolist()
    assert whole.cycles.tolist() == few.cycles.tolist()
    alone = play_episodes(make_task("Goalie"), make, 1, 3, 5 + 39, senses)
    assert (alone.success[0], alone.cycles[0]) == (whole.success[39], whole.cycles[39])


def test_the_quick_plan_is_small_and_the_full_one_takes_everything():
    quick, full = KnowledgePlan.quick(), KnowledgePlan()
    assert len(quick.blocks()) == 35
    assert 10 < quick.seconds < 120 < 3600 < full.seconds
    assert KnowledgePlan(episodes=500).seconds == pytest.approx(full.seconds / 2)
    assert {b.controller for b in full.blocks() if b.task == "Goalie"} == {f"{s}/{t}" for s in SENSES for t in TIERS}
    assert not any(b.controller.endswith("bins") for b in full.blocks() if b.task == "KickOffShot")


def test_where_a_seed_draws_what_its_worlds_share_episodes_are_spread_over_seeds():
    spread = KnowledgePlan(("KickOffShot2v2",), ("default",), ("memory",), episodes=25, seed=3).blocks()
    assert [(b.first, b.count, b.seed) for b in spread] == [(3 * k, 3, 3 + k) for k in range(8)] + [(24, 1, 11)]
    (alone,) = KnowledgePlan(("Goalie",), ("default",), ("memory",), episodes=25, seed=3).blocks()
    assert (alone.first, alone.count, alone.seed) == (0, 25, 3)


def test_the_striker_runs_on_oracles_too():
    result = play_block(Block("KickOffShot", "ball late 2/foresight", 0, 4, 1))
    assert sum(result.success) >= 3
    result.check()


def test_plans_that_make_no_sense_are_refused(tmp_path):
    with pytest.raises(UnknownName, match="tracker"):
        KnowledgePlan(tiers=("trackr",))
    with pytest.raises(UnknownName, match="default"):
        KnowledgePlan(senses=("defaul",))
    with pytest.raises(ParameterError, match="episodes"):
        KnowledgePlan(episodes=0)
    (tmp_path / "plan.json").write_text('{"tasks": ["Goalie"]}')
    with pytest.raises(CprmError, match="another suite"):
        KnowledgePlan.read(tmp_path)
    SMALL.write(tmp_path)
    assert KnowledgePlan.read(tmp_path) == SMALL
    text = (tmp_path / "plan.json").read_text()
    haste = f'"haste": {SMALL.constants()["Goalie"]["default/memory"]["haste"]}'
    (tmp_path / "plan.json").write_text(text.replace(haste, '"haste": 2.5', 1))
    with pytest.raises(CprmError, match=r"constants of Goalie on .* are others by now"):
        KnowledgePlan.read(tmp_path)
    assert knowledge.RIVAL in TIERS


def test_paired_differences_are_exact_where_they_should_be():
    yes, no = np.ones(8, bool), np.zeros(8, bool)
    assert paired_difference(yes, no) == (1.0, 1.0, 1.0, pytest.approx(2 * 0.5**8))
    assert paired_difference(yes, yes) == (0.0, 0.0, 0.0, 1.0)
    with pytest.raises(ValueError, match="shapes"):
        paired_difference(yes, no[:4])


def test_the_belief_plays_with_the_trackers_numbers_where_there_are_some():
    goalie, pair = PLAYERS["Goalie"], PLAYERS["PassAndAdvance2v1"]
    told, tracker = (goalie.numbers(tier).to_dict() for tier in ("belief", "tracker"))
    assert tracker.items() <= told.items(), "and numbers for his hands besides, which only the belief tells of"
    assert goalie.numbers("tracker") != goalie.numbers("memory")
    assert goalie.origin("belief") == "study tracker"
    assert pair.numbers("belief") == pair.numbers("memory")


def made(folder, tier, senses=None):
    """A study of nothing: its numbers are those set by hand."""
    folder.mkdir(parents=True, exist_ok=True)
    head = {"tier": tier, **({"senses": asdict(senses)} if senses else {})}
    path = folder / f"{tier}.jsonl"
    path.write_text(json.dumps(head) + "\n" + json.dumps({"mean": PLAYERS["Goalie2v1"].constants().to_dict()}) + "\n")


def test_who_has_no_study_in_these_senses_plays_with_that_of_the_tier_like_his(tmp_path, monkeypatch):
    monkeypatch.setattr("cprm_gym.agents.skills.constants.STUDIES", tmp_path)
    player = Player(PLAYERS["Goalie2v1"].make, PLAYERS["Goalie2v1"].constants, study="mine")
    lost = SENSES["lost .6"]
    made(tmp_path / "mine", "memory", lost)
    assert [player.origin(tier, lost) for tier in ("belief", "foresight")] == ["study memory"] * 2
    made(tmp_path / "mine", "tracker", lost)
    made(tmp_path / "mine", "state", lost)
    assert [player.origin(tier, lost) for tier in ("belief", "foresight")] == ["study tracker", "study state"]
    made(tmp_path / "mine", "belief")
    assert [player.origin("belief", senses) for senses in (lost, None)] == ["study tracker", "study belief"]
    made(tmp_path / "mine", "foresight")
    assert player.origin("foresight", lost) == "study foresight", "an oracle does not mind the senses"
