"""Tuning: one seeded procedure, which goes on where it was interrupted, and whose studies are those that the constants come from."""

import json
from dataclasses import replace
from typing import NamedTuple

import pytest
from typer.testing import CliRunner

from cprm_gym.agents.goalie import RECKONED, goalie_net, reckoning_cprm
from cprm_gym.agents.knowledge.players import DEFENDERS, PLAYERS, TEAMS, Player, player_of
from cprm_gym.agents.knowledge.studies import studies
from cprm_gym.agents.knowledge.tracker import Tracker, TrackerConstants
from cprm_gym.agents.skills.constants import FIRST, STUDIES, FinderConstants, GoalieConstants, last_mean
from cprm_gym.benchmark import tuning
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.tracking import TrackingPlan, error_of
from cprm_gym.benchmark.tuning import Plan, study
from cprm_gym.cli import app
from cprm_gym.envs.players.senses import Senses
from cprm_gym.errors import CprmError, ParameterError, UnknownName

SMALL = Plan(worlds=6, population=4, elite=2, generations=3, seed=1)
CROSS = replace(SMALL, method="cross-entropy")


@pytest.mark.parametrize("plan", [SMALL, CROSS], ids=["cma-es", "cross-entropy"])
def test_a_study_goes_on_where_it_was_interrupted_and_ends_the_same(plan, tmp_path):
    whole = list(study(plan, tmp_path / "whole.jsonl"))
    assert [g.number for g in whole] == [0, 1, 2]
    run = study(plan, tmp_path / "cut.jsonl")
    next(run)
    run.close()
    text = (tmp_path / "cut.jsonl").read_text()
    assert len(text.splitlines()) == 2
    (tmp_path / "cut.jsonl").write_text(text + '{"number": 1, "mea')  # killed while it wrote
    assert list(study(plan, tmp_path / "cut.jsonl")) == whole
    assert (tmp_path / "cut.jsonl").read_text() == (tmp_path / "whole.jsonl").read_text()
    assert list(study(plan)) == whole
    assert last_mean(tmp_path / "whole.jsonl") == whole[-1].mean


class Bowl(NamedTuple):
    """A search whose best constants are known."""

    seed: int
    method: str
    population: int = 12
    elite: int = 4
    generations: int = 40
    constants: type = FinderConstants

    def score(self, constants, generation):
        extents = self.constants.extents()
        return -sum(((constants.to_dict()[k] - low) / (high - low) - 0.7) ** 2 for k, (low, high) in extents.items())


@pytest.mark.parametrize(("method", "left"), [("cma-es", 0.001), ("cross-entropy", 0.2)])
def test_both_methods_go_to_the_bottom_of_a_bowl_and_the_library_all_the_way(method, left):
    for seed in range(3):
        first, *_, last = study(Bowl(seed, method))
        assert last.centre > left * first.centre


def test_a_journal_without_the_scores_of_its_candidates_is_refused(tmp_path):
    journal = tmp_path / "x.jsonl"
    next(study(SMALL, journal))
    head, line = journal.read_text().splitlines()
    journal.write_text(head + "\n" + json.dumps({**json.loads(line), "scores": [0.5]}) + "\n")
    with pytest.raises(CprmError, match="does not tell the scores of its candidates"):
        list(study(SMALL, journal))


def test_a_journal_of_another_study_or_a_damaged_one_is_refused(tmp_path):
    journal = tmp_path / "x.jsonl"
    next(study(SMALL, journal))
    with pytest.raises(CprmError, match="another study"):
        next(study(Plan(worlds=7, population=4, elite=2), journal))
    journal.write_text(journal.read_text() + '{"number": 5}\n')
    with pytest.raises(CprmError, match="not the journal"):
        next(study(SMALL, journal))
    lines = journal.read_text().splitlines()[:2]
    journal.write_text("\n".join([*lines, json.dumps({**json.loads(lines[1]), "number": 2})]) + "\n")
    with pytest.raises(CprmError, match="missing"):
        next(study(SMALL, journal))


def test_plans_that_make_no_sense_are_refused():
    with pytest.raises(UnknownName, match="memory"):
        Plan(tier="memry")
    with pytest.raises(UnknownName, match="Goalie"):
        Plan(task="Goali")
    with pytest.raises(ParameterError, match="KickOffShot has no constants"):
        Plan(task="KickOffShot")
    with pytest.raises(ParameterError, match="elite 9"):
        Plan(population=4, elite=9)
    with pytest.raises(ParameterError, match="population: 3 given, a whole number of at least 4"):
        Plan(population=3, elite=2)
    with pytest.raises(ParameterError, match="worlds"):
        Plan(worlds=0)
    with pytest.raises(UnknownName, match="strong"):
        Plan(task="KickOffShot2v2", others="medium,stong")
    with pytest.raises(UnknownName, match=r"method 'cmaes'.*cma-es"):
        Plan(method="cmaes")


def test_a_study_may_be_of_other_opponents_and_its_journal_says_so(tmp_path):
    plan = Plan(task="KickOffShot2v2", tier="state", worlds=2, population=4, elite=1, generations=1, others="hold,strong")
    assert (plan.played().others, Plan(task="KickOffShot2v2").played().others) == (("hold", "strong"), ("medium", "weak"))
    next(study(plan, tmp_path / "x.jsonl"))
    assert json.loads((tmp_path / "x.jsonl").read_text().splitlines()[0])["others"] == "hold,strong"
    next(study(Plan(worlds=2, population=4, elite=1, generations=1), tmp_path / "y.jsonl"))
    assert "others" not in json.loads((tmp_path / "y.jsonl").read_text().splitlines()[0])


def test_a_study_may_be_of_those_who_defend_and_is_judged_by_what_they_are_paid(tmp_path):
    sizes = {"worlds": 3, "population": 4, "elite": 1, "generations": 1}
    plan = Plan("Keepaway3v2", side="right", **sizes)
    assert (plan.played().controlled, plan.constants.whose) == ("right", "taker")
    (found,) = study(plan, tmp_path / "x.jsonl")
    assert json.loads((tmp_path / "x.jsonl").read_text().splitlines()[0])["side"] == "right"
    seconds = play_episodes(plan.played(), plan.player.on("memory", None, plan.constants()), 3, tuning.TUNING_SEED).cycles
    assert found.centre == -seconds.mean()
    with pytest.raises(UnknownName, match=r"side 'rigth'.*right"):
        Plan("Keepaway3v2", side="rigth")
    with pytest.raises(UnknownName, match=r"defenders 'Goalie'.*Keepaway3v2"):
        Plan("Goalie", side="right")
    refused = CliRunner().invoke(app, ["tune", "--tracker", "--side", "right"])
    assert refused.exit_code == 2
    assert "--side right: the tracker's own constants" in " ".join(refused.output.split())


def test_what_was_found_is_played_beside_what_was_set_by_hand_in_other_worlds(tmp_path):
    plan = Plan("Keepaway3v2", worlds=3, population=4, elite=1, generations=1)
    same, other = (tuning.check(plan, {**plan.constants().to_dict(), **more}, 4) for more in ({}, {"pressed": 1.0}))
    assert same.found == same.by_hand == other.by_hand
    assert (same.difference, same.low, same.high) == (0.0, 0.0, 0.0)
    assert other.difference == pytest.approx(other.found - other.by_hand)
    assert other.low < other.difference < other.high
    with pytest.raises(ParameterError, match="check: 1 given"):
        tuning.check(plan, {}, 1)
    command = ["tune", "--task", "Keepaway3v2", "--worlds", "3", "--population", "4", "--elite", "1", "--generations", "1", "--check", "2"]
    refused = CliRunner().invoke(app, [*command[:-1], "1", "--journal", str(tmp_path / "y.jsonl")])
    assert "--check 1: at least 2 worlds are needed" in refused.output
    assert not (tmp_path / "y.jsonl").exists()
    said = CliRunner().invoke(app, [*command, "--journal", str(tmp_path / "x.jsonl")])
    assert said.exit_code == 0
    assert "2 other worlds: found " in said.output


def test_keepers_are_judged_by_cycles_and_teams_by_goals():
    plan = Plan("Keepaway3v2", worlds=2)
    kept = play_episodes(plan.played(), plan.player.on("memory", None, plan.constants()), 2, tuning.TUNING_SEED)
    assert plan.score(plan.constants(), 0) == kept.reward.mean() == kept.cycles.mean()
    assert Plan("Soccer5v5").played().max_cycles < 1000


def test_constants_are_refused_outside_their_extent_or_by_another_name():
    with pytest.raises(ParameterError, match=r"haste: 9\.0 given; allowed are numbers from -1 to 3"):
        GoalieConstants(haste=9.0)
    with pytest.raises(ParameterError, match=r"no constant 'hast'.*haste"):
        GoalieConstants.of({"hast": 1.0})
    assert GoalieConstants.of(FIRST.to_dict()) == FIRST


def test_every_constant_stands_in_the_net():
    plain = reckoning_cprm().net
    for name, (low, high) in GoalieConstants.extents().items():
        other = low if getattr(FIRST, name) != low else high
        changed = GoalieConstants.of({name: other})
        assert reckoning_cprm(constants=changed).net != plain, name
    assert goalie_net(RECKONED, 0) == goalie_net(RECKONED, 0, constants=FIRST)


def studied():
    """(side, task, study) of every study of every player."""
    players = [(side, task, p) for side, all_of in (("left", {**PLAYERS, **TEAMS}), ("right", DEFENDERS)) for task, p in all_of.items()]
    return [(side, task, one) for side, task, p in players if p.constants for one in studies(p.study or p.constants.whose)]


def journal(path):
    """Head and generations."""
    head, *generations = (json.loads(line) for line in path.read_text(encoding="utf-8").splitlines())
    return head, generations


def test_every_study_is_whole_and_of_a_tier_and_its_end_is_what_players_play_with():
    assert ("left", "Goalie", "memory") in {(side, task, found.tier) for side, task, found in studied()}
    for side, task, found in studied():
        player, (head, generations) = player_of(task, side), journal(found.path)
        whose = player_of(head["task"], head.get("side", "left"))  # tasks may share a study of one of them
        assert (whose.constants, whose.study, head["tier"]) == (player.constants, player.study, found.tier)
        assert whose is player or player.study
        assert Senses(**head["senses"]) == found.senses
        assert [g["number"] for g in generations] == list(range(len(generations)))
        assert player.numbers(found.tier, found.senses) == player.kind(found.tier).of(generations[-1]["mean"])
        assert player.origin(found.tier, found.senses) == f"study {found.tier}"
    assert tuning.TUNING_SEED > 10_000, "no measurement meets these worlds"


def test_a_tier_without_a_study_plays_with_the_rivals_numbers_and_without_any_by_hand(tmp_path, monkeypatch):
    monkeypatch.setattr("cprm_gym.agents.skills.constants.STUDIES", tmp_path)
    player = Player(lambda task, agent, constants: constants, GoalieConstants)
    assert (player.origin("state"), player.numbers("state")) == ("by hand", FIRST)
    (tmp_path / "goalie").mkdir()
    (tmp_path / "goalie" / "memory.jsonl").write_text('{}\n{"mean": {"haste": 2.0}}\n')
    assert (player.origin("state"), player.numbers("state")) == ("study memory", GoalieConstants(haste=2.0))
    (tmp_path / "goalie" / "deaf").mkdir()
    deaf = Senses(lost=0.8)
    for tier, haste in (("memory", 1.5), ("tracker", 0.5), ("state", 0.25)):
        text = json.dumps({"senses": {"lost": 0.8}}) + f'\n{{"mean": {{"haste": {haste}}}}}\n'
        (tmp_path / "goalie" / "deaf" / f"{tier}.jsonl").write_text(text)
    expected = {
        ("memory", Senses()): ("study memory", 2.0), ("memory", deaf): ("study memory", 1.5),
        ("tracker", deaf): ("study tracker", 0.5), ("belief", deaf): ("study tracker", 0.5), ("bins", deaf): ("study memory", 1.5),
        ("tracker", Senses()): ("study memory", 2.0), ("memory", Senses(lost=0.3)): ("study memory, other senses", 2.0),
        ("tracker", Senses(lost=0.3)): ("study tracker, other senses", 0.5), ("state", Senses()): ("study state", 0.25),
    }  # fmt: skip
    assert {key: (player.origin(*key), player.numbers(*key).haste) for key in expected} == expected
    with pytest.raises(UnknownName, match=r"study of goalie for the tier 'state'.*memory"):
        GoalieConstants.tuned("state")
    assert Player(lambda *_: None).origin("memory") == "none"
    with pytest.raises(UnknownName, match="tracker"):
        Player(lambda *_: None).on("bins")


def test_the_trackers_own_constants_are_those_of_its_study_and_know_the_ball_no_worse_than_by_hand():
    used = Tracker().constants
    assert used == TrackerConstants.of(last_mean(STUDIES / "tracker" / "Goalie.jsonl"))
    for senses in (Senses(), Senses(noise=1.0), Senses(lost=0.3)):
        tuned, by_hand, deaf = (
            error_of("Goalie", 30, 5, senses, c) for c in (used, TrackerConstants(), TrackerConstants(surprise=60.0, live=0.02, near=0.0))
        )
        assert tuned < 1.03 * by_hand
        assert tuned < deaf


def test_a_study_of_the_tracker_goes_on(tmp_path):
    plan = TrackingPlan(worlds=3, population=4, elite=2, generations=2, seed=1)
    whole = list(study(plan))
    next(study(plan, tmp_path / "x.jsonl"))
    assert list(study(plan, tmp_path / "x.jsonl")) == whole
    assert whole[1].best >= whole[1].rate
    with pytest.raises(ParameterError, match="worlds"):
        TrackingPlan(worlds=0)


def test_the_command_tunes_and_goes_on(tmp_path):
    journal = tmp_path / "x.jsonl"
    options = ["tune", "--worlds", "6", "--population", "4", "--elite", "2", "--seed", "1", "--journal", str(journal)]
    first = CliRunner().invoke(app, [*options, "--generations", "1"])
    assert first.exit_code == 0, first.output
    whole = CliRunner().invoke(app, [*options, "--generations", "3"])
    assert "generation 2" in whole.output
    assert last_mean(journal) == list(study(SMALL))[-1].mean
    deaf = tmp_path / "deaf.jsonl"
    CliRunner().invoke(app, [*options[:-1], str(deaf), "--generations", "1", "--senses", "lost .8"])
    assert json.loads(deaf.read_text().splitlines()[0])["senses"]["lost"] == 0.8
    for wrong, word in (
        (["--tier", "memry"], "memory"),
        (["--task", "Goali"], "Goalie"),
        (["--worlds", "0"], "worlds"),
        (["--tracker", "--tier", "tracker"], "leave out"),
        (["--senses", "lost 8"], "lost .8"),
        (["--tracker", "--senses", "wide"], "leave out"),
        (["--task", "KickOffShot2v2", "--others", "medium,mediun"], "medium"),
        (["--tracker", "--others", "hold,weak"], "leave out"),
    ):
        refused = CliRunner().invoke(app, ["tune", *wrong])
        assert refused.exit_code == 2
        assert word in refused.output
