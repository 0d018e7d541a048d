"""Kernels compiled ahead are there when they are needed; those that nobody uses go."""

import os
import subprocess
import sys
import time

import pytest
from typer.testing import CliRunner

from cprm_gym import compile_ahead, kernel_cache
from cprm_gym.cli import app
from cprm_gym.errors import CprmError, UnknownName

FIRST_STEP = """
import gymnasium, cprm_gym
env = gymnasium.make("cprm/GoToBall-v2")
env.reset(seed=1)
env.step(env.action_space.sample())
"""


def test_after_compiling_drills_the_first_step_compiles_nothing(monkeypatch):
    monkeypatch.delenv("CPRM_GYM_QUIET", raising=False)
    said = []
    root = compile_ahead.compile_ahead(["drills"], 1, said.append)
    assert [line.split(":")[0] for line in said] == ["step", "senses", "drills"]
    assert root == kernel_cache.cache_root()
    first = subprocess.run([sys.executable, "-c", FIRST_STEP], capture_output=True, text=True, env=dict(os.environ))
    assert (first.returncode, first.stderr) == (0, "")


def test_every_job_is_part_of_something_and_has_its_stage():
    staged = [job for stage in compile_ahead.STAGES for job in stage]
    assert sorted(staged) == sorted(compile_ahead.JOBS)
    assert set(compile_ahead.PARTS["all"]) == set(staged)


def test_wrong_parts_and_numbers_are_refused():
    with pytest.raises(UnknownName, match="unknown part 'drill'"):
        compile_ahead.compile_ahead(["drill"], 1, print)
    with pytest.raises(CprmError, match="--jobs 0"):
        compile_ahead.compile_ahead(["drills"], 0, print)
    refused = CliRunner().invoke(app, ["compile", "drill"])
    assert refused.exit_code == 2


def test_folders_that_nobody_has_used_for_a_month_are_removed(tmp_path):
    for name, days in (("old", 31), ("young", 29)):
        folder = tmp_path / "kernels" / name
        folder.mkdir(parents=True)
        (folder / "kernel.nbc").write_bytes(b"")
        then = time.time() - 86400 * days
        os.utime(folder, (then, then))
    (tmp_path / "kept").mkdir()
    (tmp_path / "kernels" / "link").symlink_to(tmp_path / "kept")
    assert kernel_cache.remove_stale(tmp_path) == 1
    assert sorted(path.name for path in (tmp_path / "kernels").iterdir()) == ["link", "young"]
    assert (tmp_path / "kept").exists()


def test_using_a_folder_keeps_it(tmp_path):
    folder = tmp_path / "kernels" / "used"
    folder.mkdir(parents=True)
    os.utime(folder, (0, 0))
    kernel_cache._used(folder)
    assert kernel_cache.remove_stale(tmp_path) == 0
