"""What the packages offer: every name is there, loaded when it is first used, and seen by type checkers."""

import ast
import importlib
import subprocess
import sys

import pytest
from paths import ROOT

LAZY = sorted(
    ".".join(path.relative_to(ROOT).parent.parts)
    for path in (ROOT / "cprm_gym").rglob("__init__.py")
    if "lazy_face(" in path.read_text(encoding="utf-8")
)


def written_for_type_checkers(package):
    """Names in the ``if TYPE_CHECKING`` block of a package, with their modules."""
    tree = ast.parse((ROOT / package.replace(".", "/") / "__init__.py").read_text(encoding="utf-8"))
    (block,) = [node for node in tree.body if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"]
    names = {}
    for statement in block.body:
        assert isinstance(statement, ast.ImportFrom)
        for alias in statement.names:
            assert alias.asname == alias.name, f"{alias.name} is not offered again"
            names[alias.name] = f"{package}.{statement.module}" if statement.module else package
    return names


def test_there_are_faces():
    assert len(LAZY) == 12


@pytest.mark.parametrize("package", LAZY)
def test_type_checkers_see_what_runs(package):
    module = importlib.import_module(package)
    written = written_for_type_checkers(package)
    assert sorted(name for name in module.__all__ if not name.startswith("__")) == sorted(written)
    for name, home in written.items():
        value = getattr(module, name)
        expected = importlib.import_module(f"{home}.{name}") if home == package else getattr(importlib.import_module(home), name)
        assert value is expected, name
        assert name in dir(module)


@pytest.mark.parametrize("package", LAZY)
def test_a_wrong_name_gets_the_right_one(package):
    module = importlib.import_module(package)
    name = module.__all__[-1]
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute '{name}x'. Did you mean '{name}'"):
        getattr(module, name + "x")


@pytest.mark.parametrize("package", LAZY)
def test_no_face_hides_a_module_of_its_own_behind_a_name(package):
    """Loading the module would put it in the name's place."""
    folder = ROOT / package.replace(".", "/")
    inside = {path.stem for path in folder.iterdir()}
    assert {name for name, home in written_for_type_checkers(package).items() if home != package} & inside == set()


NEEDED = {"cprm_gym.errors", "cprm_gym.lazy", "cprm_gym.envs", "cprm_gym.envs.registration"}
"""Modules that registering the environments needs."""


def loaded_by(statement):
    """Names of the modules that a fresh interpreter holds after a statement."""
    code = f"{statement}; import sys; print(*sys.modules, sep='\\n')"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT).stdout.split())


@pytest.mark.parametrize("package", LAZY)
def test_a_face_loads_nothing_before_it_is_asked(package):
    assert {name for name in loaded_by(f"import {package}") if name.startswith(f"{package}.")} <= NEEDED


def test_the_front_door_offers_what_most_people_need():
    import cprm_gym

    wanted = "CPRM CprmError Executor Filter Model PetriNet Place Transition analyze check_contract load_net make_task soccer_v2"
    assert cprm_gym.__all__ == wanted.split()


def test_nets_and_models_can_be_imported_side_by_side():
    nets, models = (set(importlib.import_module(f"cprm_gym.architecture.{package}").__all__) for package in ("petri", "prm"))
    assert nets & models == set()
    namespace = {}
    exec("from cprm_gym.architecture.petri import *\nfrom cprm_gym.architecture.prm import *", namespace)
    assert nets | models <= set(namespace)


def test_importing_cprm_gym_loads_neither_compiler_nor_simulator():
    loaded = loaded_by("import cprm_gym")
    assert not loaded & {"numba", "scipy", "pandas", "pgmpy", "cprm_gym.simulator", "cprm_gym.architecture", "cprm_gym.agents"}
    assert {name for name in loaded if name.startswith("cprm_gym.")} == NEEDED


@pytest.mark.parametrize("module", ["models", "passer", "seeker", "striker", "outfielder.agent", "outfielder.model"])
def test_agents_of_default_players_are_made_when_they_are_asked_for(module):
    """Their tables take longer than everything else at import."""
    code = (
        f"import cprm_gym.agents.{module} as home\n"
        "made = [name for name, value in vars(home).items() if type(value).__name__ in ('Model', 'CPRM')]\n"
        "assert made == [], made\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_is_made_when_asked_for_is_kept_and_a_wrong_name_gets_the_right_one():
    models = importlib.import_module("cprm_gym.agents.models")
    assert models.BALL_MODEL is models.BALL_MODEL
    assert models.ball_model() == models.BALL_MODEL
    with pytest.raises(AttributeError, match=r"has no attribute 'BALL_MODELL'\. Did you mean 'BALL_MODEL'"):
        models.BALL_MODELL  # noqa: B018
