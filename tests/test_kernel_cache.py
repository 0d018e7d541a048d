"""Kept kernels: read only from where nobody else can write; never in the way of a run."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from cprm_gym import kernel_cache
from cprm_gym.errors import CacheError

PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
import kernels
print(kernels.twice(2.0))
"""
KERNELS = "from cprm_gym.compilation import kernel_group\n\n@kernel_group()\ndef twice(x):\n    return 2.0 * x\n"
root_only = pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give files away")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "kernels.py").write_text(KERNELS)
    return tmp_path


def run(folder, cwd=None, **environment):
    """What a process prints that compiles one kernel or loads it."""
    env = {k: v for k, v in os.environ.items() if k not in ("CPRM_GYM_CACHE", "XDG_CACHE_HOME", "CPRM_GYM_QUIET")} | environment
    return subprocess.run([sys.executable, "-c", PROGRAM, str(folder / "code")], capture_output=True, text=True, env=env, cwd=cwd)


def compiled(cache):
    return sorted(cache.rglob("*.nbc"))


@pytest.fixture
def root():
    """`cache_root` without what it remembers."""
    kernel_cache._root.cache_clear()
    kernel_cache._say_once.cache_clear()
    yield kernel_cache.cache_root
    kernel_cache._root.cache_clear()


def test_a_home_sign_in_the_named_folder_is_expanded(folder):
    assert run(folder, HOME=str(folder), CPRM_GYM_CACHE="~/kept").stdout == "4.0\n"
    assert len(compiled(folder / "kept")) == 1
    assert not Path("~").exists()


def test_the_folder_is_private(folder):
    run(folder, HOME=str(folder))
    cache = folder / ".cache" / "cprm_gym"
    assert cache.stat().st_mode & 0o777 == 0o700
    assert all(path.stat().st_mode & 0o022 == 0 for path in cache.rglob("*"))


@pytest.mark.parametrize("kind", ["file", "written by others", "missing parent is a file"])
def test_a_named_folder_that_cannot_be_used_is_an_error_that_says_why(tmp_path, monkeypatch, root, kind):
    place = tmp_path / "place"
    if kind == "written by others":
        place.mkdir()
        place.chmod(0o777)
    else:
        place.write_text("")
    monkeypatch.setenv("CPRM_GYM_CACHE", str(place / "below" if kind.startswith("missing") else place))
    with pytest.raises(
        CacheError, match=r"CPRM_GYM_CACHE='.*place.*': .*(written by others \(mode 777\)|[Nn]ot a (folder|directory)|File exists)"
    ):
        root()


def test_an_empty_name_names_no_folder(folder):
    assert run(folder, cwd=folder / "code", HOME=str(folder), CPRM_GYM_CACHE="").stdout == "4.0\n"
    assert len(compiled(folder / ".cache" / "cprm_gym")) == 1
    assert not (folder / "code" / "kernels").exists()


@pytest.mark.parametrize("command", [("analyze", "go_to_ball"), ("benchmark", "--episodes", "1"), ("play",), ("demo", "striker")])
def test_commands_say_plainly_that_the_named_folder_cannot_be_used(tmp_path, command):
    place = tmp_path / "place"
    place.write_text("")
    env = {**os.environ, "CPRM_GYM_CACHE": str(place)}
    done = subprocess.run([sys.executable, "-m", "cprm_gym", *command], capture_output=True, text=True, env=env, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: CPRM_GYM_CACHE=")
    assert "Traceback" not in done.stderr


@root_only
@pytest.mark.parametrize("which", ["cprm_gym", "cprm_gym/kernels"])
def test_a_folder_of_another_user_is_not_read(folder, which, monkeypatch, root):
    cache = folder / ".cache" / "cprm_gym"
    (cache / "kernels").mkdir(parents=True, mode=0o700)
    os.chown(folder / ".cache" / which, 12345, 12345)
    monkeypatch.delenv("CPRM_GYM_CACHE", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(folder))
    monkeypatch.setattr(kernel_cache.tempfile, "gettempdir", lambda: str(folder))
    assert root() == folder / f"cprm_gym-{os.getuid()}"


def test_a_planted_index_is_never_unpickled(folder):
    """What another user put where the temporary directory once served, predictable and with any mode, is not opened."""
    proof = folder / "proof"
    evil = b"cposix\nsystem\n(S'touch " + str(proof).encode() + b"'\ntR."
    run(folder, HOME=str(folder), CPRM_GYM_CACHE=str(folder / "mine"))
    index = next((folder / "mine").rglob("*.nbi"))
    planted = folder / "temporary" / "cprm_gym_cache" / index.relative_to(folder / "mine")
    planted.parent.mkdir(parents=True)
    planted.write_bytes(evil)
    for path in (folder / "temporary").rglob("*"):
        path.chmod(0o777)
    os.symlink(folder / "temporary" / "cprm_gym_cache", folder / "temporary" / f"cprm_gym-{os.getuid()}")
    (folder / "home").write_text("")
    result = run(folder, HOME=str(folder / "home"), TMPDIR=str(folder / "temporary"))
    assert result.stdout == "4.0\n"
    assert not proof.exists()
    assert "compiled kernels are not kept, every process compiles them anew" in result.stderr
    assert "can be written by others (mode 777)" in result.stderr


def test_a_filled_folder_that_can_only_be_read_is_used_as_it_is(folder):
    cache = folder / "cache"
    run(folder, CPRM_GYM_CACHE=str(cache))
    before = {path: path.stat().st_mtime_ns for path in compiled(cache)}
    for path in [*cache.rglob("*"), cache]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    for path in [folder / "code", folder, *folder.parents]:  # the other user finds the way to them
        if path.stat().st_uid == os.getuid() and path != Path(path.anchor):
            path.chmod(path.stat().st_mode | 0o055)
    become_another = "import os, numba, cprm_gym.compilation\nnumba.njit(lambda x: x)(1.0)\n" + "os.setuid(12345)\n" * (os.getuid() == 0)
    program = become_another + PROGRAM + "print(sum(kernels.twice.stats.cache_hits.values()))\nkernels.twice(1)\n"  # the last is not kept
    env = {**os.environ, "CPRM_GYM_CACHE": str(cache)}
    result = subprocess.run([sys.executable, "-B", "-c", program, str(folder / "code")], capture_output=True, text=True, env=env)
    assert (result.returncode, result.stdout) == (0, "4.0\n1\n"), result.stderr
    assert {path: path.stat().st_mtime_ns for path in compiled(cache)} == before


@pytest.mark.parametrize(
    ("ending", "damage"),
    [
        (".nbi", lambda content: content[: len(content) // 2]),
        (".nbi", lambda content: b"x" * len(content)),
        (".nbc", lambda content: b""),
        (".nbc", lambda content: content[:-40] + bytes(40)),
    ],
)
def test_a_damaged_file_costs_a_compilation_and_is_mended(folder, ending, damage):
    cache = folder / "cache"
    run(folder, CPRM_GYM_CACHE=str(cache))
    (path,) = cache.rglob("*" + ending)
    path.write_bytes(damage(path.read_bytes()))
    again = run(folder, CPRM_GYM_CACHE=str(cache))
    assert (again.returncode, again.stdout) == (0, "4.0\n"), again.stderr
    assert "compiling kernels" not in run(folder, CPRM_GYM_CACHE=str(cache)).stderr


def test_a_full_disk_costs_the_keeping_and_not_the_run(folder):
    code = (
        "import cprm_gym.kernel_cache as k, errno, contextlib\n"
        "def full(self, path):\n    raise OSError(errno.ENOSPC, 'No space left on device')\n"
        "k._Files._open_for_write = full\n" + PROGRAM
    )
    env = {**os.environ, "CPRM_GYM_CACHE": str(folder / "cache")}
    env.pop("CPRM_GYM_QUIET", None)
    result = subprocess.run([sys.executable, "-c", code, str(folder / "code")], capture_output=True, text=True, env=env)
    assert result.stdout == "4.0\n", result.stderr
    assert "compiled kernels cannot be kept: No space left on device" in result.stderr


def test_two_copies_of_the_same_code_share_what_is_kept(folder):
    cache = folder / "cache"
    run(folder, CPRM_GYM_CACHE=str(cache))
    (folder / "code").rename(folder / "elsewhere")
    (folder / "code").symlink_to(folder / "elsewhere")
    before = compiled(cache)
    assert run(folder, CPRM_GYM_CACHE=str(cache)).stdout == "4.0\n"
    assert compiled(cache) == before
