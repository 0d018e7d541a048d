"""The pages made from the code name all that there is, with units and ranges that are the spaces' own."""

import importlib.util
import re
import sys
from enum import IntEnum

import pytest
from paths import ROOT

from cprm_gym.envs.observations import BodyFeature, ObjectFeature, SelfFeature
from cprm_gym.envs.tasks import TASKS


@pytest.fixture(scope="module")
def generate():
    spec = importlib.util.spec_from_file_location("generate_pages", ROOT / "docs" / "generate.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def tasks(generate):
    return generate.tasks_page()


def test_the_index_has_every_name_of_every_face(generate):
    page = generate.names_page()
    for face in generate.FACES:
        for name in generate.public_names(face):
            assert re.search(rf"^\| \[`{name}`\]\([\w.]+\) \| `{re.escape(face)}` \|", page, re.MULTILINE), (face, name)


def test_every_name_is_described_once(generate):
    pages = generate.reference_pages()
    described = re.findall(r"^\.\. (?:autoclass|autofunction|data):: ([\w.]+)$", "\n".join(pages.values()), re.MULTILINE)
    assert len(described) == len(set(described)) > 100
    assert {name.rpartition(".")[2] for name in described} >= {
        "PetriNet",
        "Model",
        "Filter",
        "CPRM",
        "analyze",
        "check_contract",
        "load_net",
    }


def test_every_package_with_a_lazy_face_is_on_the_site(generate):
    lazy = {
        ".".join(path.parent.relative_to(ROOT).parts)
        for path in (ROOT / "cprm_gym").rglob("__init__.py")
        if "lazy_face(" in path.read_text("utf-8")
    }
    assert lazy == set(generate.FACES)
    listed = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert all(f"generated/reference_{face.rpartition('.')[2]}\n" in listed for face in generate.FACES)


def test_every_task_and_every_column_has_a_row(tasks):
    for name in TASKS:
        assert f"### {name}\n" in tasks
    for enumeration in (BodyFeature, ObjectFeature, SelfFeature):
        for member in enumeration:
            assert f"| {int(member)} | `{member.name}` | " in tasks


def test_ranges_are_those_of_the_space(tasks):
    assert "| 4 | `SPEED_DIRECTION` | −π to π | Direction of the own velocity relative to the face, radians. |" in tasks
    assert "| 14 | `UNUM` | 0 to 11 |" in tasks


def test_a_column_without_a_note_is_refused(generate):
    with pytest.raises(ValueError, match="BodyColumns: no note under SILENT"):
        generate.member_notes(BodyColumns)


class BodyColumns(IntEnum):
    """Columns of an array."""

    TOLD = 0
    """m"""
    SILENT = 1
