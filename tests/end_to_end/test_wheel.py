"""The wheel stands beside another project that owns a top-level package `baselines`."""

import subprocess
import sys
import venv
import zipfile

import pytest
from paths import ROOT

NEIGHBOUR = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "neighbour"
version = "1.0"

[tool.hatch.build.targets.wheel]
packages = ["baselines"]
"""


def run(*command, cwd):
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def build(source, target):
    """The wheel of a project, built with what is installed here."""
    options = ("--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir")
    run(sys.executable, "-m", "pip", "wheel", *options, str(target), str(source), cwd=target)
    (wheel,) = target.glob("*.whl")
    return wheel


@pytest.fixture(scope="module")
def wheels(tmp_path_factory):
    """(ours, the neighbour's)."""
    neighbour = tmp_path_factory.mktemp("neighbour")
    (neighbour / "pyproject.toml").write_text(NEIGHBOUR)
    (neighbour / "baselines").mkdir()
    (neighbour / "baselines" / "__init__.py").write_text("WHOSE = 'neighbour'\n")
    (neighbour / "baselines" / "fsm.py").write_text("WHOSE = 'neighbour'\n")
    return build(ROOT, tmp_path_factory.mktemp("ours")), build(neighbour, tmp_path_factory.mktemp("theirs"))


@pytest.fixture
def install(wheels, tmp_path):
    """A fresh environment with both wheels and nothing else: (pip, files below site-packages)."""
    venv.create(tmp_path / "env", with_pip=False)
    (site,) = (tmp_path / "env").glob("lib/*/site-packages")
    python = tmp_path / "env" / "bin" / "python"

    def pip(*arguments):
        run(sys.executable, "-m", "pip", "--python", str(python), *arguments, cwd=tmp_path)

    def files(package):
        return {
            str(path.relative_to(site)): path.read_bytes()
            for path in (site / package).rglob("*")
            if path.suffix != ".pyc" and path.is_file()
        }

    for wheel in wheels:
        pip("install", "--quiet", "--no-deps", "--no-index", "--no-compile", str(wheel))
    return pip, files


@pytest.mark.slow
def test_the_wheel_owns_two_packages_and_none_is_called_baselines(wheels):
    names = zipfile.ZipFile(wheels[0]).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == {"cprm_gym", "cprm_baselines"}
    assert "cprm_baselines/fsm/go_to_ball.py" in names
    assert "cprm_gym/py.typed" in names
    assert not [name for name in names if name.endswith((".nbi", ".nbc", ".pkl", ".pyc"))], "what numba keeps is made where it is used"


@pytest.mark.slow
def test_uninstalling_cprm_gym_leaves_the_neighbour_whole(install):
    pip, files = install
    before = files("baselines")
    assert sorted(before) == ["baselines/__init__.py", "baselines/fsm.py"]
    assert "cprm_baselines/scripted.py" in files("cprm_baselines")
    pip("uninstall", "--quiet", "--yes", "cprm-gym")
    assert files("baselines") == before
    assert files("cprm_baselines") == files("cprm_gym") == {}


@pytest.mark.slow
def test_uninstalling_the_neighbour_leaves_cprm_gym_whole(install):
    pip, files = install
    before = files("cprm_baselines") | files("cprm_gym")
    assert len(before) > 250
    pip("uninstall", "--quiet", "--yes", "neighbour")
    assert files("cprm_baselines") | files("cprm_gym") == before
    assert files("baselines") == {}
