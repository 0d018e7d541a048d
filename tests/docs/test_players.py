"""Who plays what and how large each is, on the pages: what the registries and the files say."""

import importlib.util
import sys

import pytest
from cprm_baselines.behaviour.maker import FILES, OTHER_SIDE
from paths import ROOT

from cprm_gym.agents import registry
from cprm_gym.envs.tasks import TASKS
from cprm_gym.learning.player import shipped


@pytest.fixture(scope="module")
def page():
    spec = importlib.util.spec_from_file_location("page_of_players", ROOT / "docs" / "players.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def texts(page):
    return {path.name: path.read_text(encoding="utf-8") for path in page.PAGES}


def test_the_pages_say_what_the_registries_and_files_say(page, texts):
    """All but the times: those are of a run, and stand as it has them until the script is run again."""
    for text in texts.values():
        assert page.with_parts(text, without=("times",)) == text
    assert sorted(m[2] for text in texts.values() for m in page.BLOCK.finditer(text)) == sorted(page.MADE)


def test_every_task_is_played_alike_in_its_family_by_the_registries(page):
    """So that asking for the first task of each is enough."""
    learning = [family for family in page.FAMILIES if family.agent.startswith("left") and family.who != "goalie"]
    assert sorted(task for family in learning for task in family.tasks) == sorted(TASKS)
    for family in page.FAMILIES:
        cprm, files = (registry.AGENTS, FILES) if family.agent.startswith("left") else (registry.OTHER_SIDE, OTHER_SIDE)
        assert len({cprm.get(task) for task in family.tasks}) == 1, family
        assert len({files.get(task) for task in family.tasks}) == 1, family
    other = {task for family in page.FAMILIES if family.agent.startswith("right") for task in family.tasks}
    assert other == {*registry.OTHER_SIDE, *OTHER_SIDE}


def test_structures_play_what_their_files_say_and_policies_what_ships(page):
    for family in page.FAMILIES:
        right = family.agent.startswith("right")
        for name in ("fsm", "belief_region"):
            said = family.tasks[0] in (OTHER_SIDE if right else FILES)
            assert (page.cell(name, family) == "yes") == said, (name, family)
    trained = {name.split("-")[0] for name in shipped()}
    told = set()
    for family in page.FAMILIES:
        cell = page.cell("policy", family)
        told |= set(family.tasks) if cell == "yes" else set(cell.split(", ")) - set(page.NOBODY)
    assert told == trained


def test_a_controller_or_a_gap_that_nobody_names_is_refused(page, monkeypatch):
    monkeypatch.setattr(page, "controller_entries", lambda: {"fsm": None, "mine": None})
    with pytest.raises(ValueError, match="mine"):
        page.columns()
    monkeypatch.undo()
    monkeypatch.setattr(page, "WHY", {})
    with pytest.raises(ValueError, match="policy"):
        page.why()
