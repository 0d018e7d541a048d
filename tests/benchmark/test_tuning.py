"""Tuning: one seeded procedure, which goes on where it was interrupted, and whose studies are those that the constants come from."""

import json
from pathlib import Path

import pytest

from cprm_gym.agents.goalie import RECKONED, goalie_net, reckoning_cprm
from cprm_gym.agents.skills.constants import FIRST, ON_MEMORY, GoalieConstants
from cprm_gym.benchmark import tuning
from cprm_gym.benchmark.tuning import Plan, result, study
from cprm_gym.errors import CprmError, ParameterError, UnknownName

SMALL = Plan(worlds=6, population=4, elite=2, generations=3, seed=1)


def test_a_study_goes_on_where_it_was_interrupted_and_ends_the_same(tmp_path):
    whole = list(study(SMALL, tmp_path / "whole.jsonl"))
    assert [g.number for g in whole] == [0, 1, 2]
    run = study(SMALL, tmp_path / "cut.jsonl")
    next(run)
    run.close()
    text = (tmp_path / "cut.jsonl").read_text()
    assert len(text.splitlines()) == 2
    (tmp_path / "cut.jsonl").write_text(text + '{"number": 1, "mea')  # killed while it wrote
    assert list(study(SMALL, tmp_path / "cut.jsonl")) == whole
    assert (tmp_path / "cut.jsonl").read_text() == (tmp_path / "whole.jsonl").read_text()
    assert list(study(SMALL)) == whole
    assert result(tmp_path / "whole.jsonl") == GoalieConstants.of(whole[-1].mean)


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
    with pytest.raises(ParameterError, match="elite 9"):
        Plan(population=4, elite=9)
    with pytest.raises(ParameterError, match="worlds"):
        Plan(worlds=0)


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


def test_the_constants_in_use_are_those_that_the_kept_study_ends_with():
    kept = Path(tuning.__file__).parent / "studies" / "goalie_memory.jsonl"
    assert result(kept) == ON_MEMORY
    plan = Plan(worlds=250, population=32, elite=6, generations=9)
    found = list(study(plan, kept))
    assert len(found) == 9
    assert tuning.TUNING_SEED > 10_000, "no measurement meets these worlds"
