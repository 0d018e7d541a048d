"""The kernel cache: never stale, announced once."""

import ast
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

import cprm_gym
from cprm_gym import compilation
from cprm_gym.compilation import content_key, import_closure, kernel_group

PROGRAM = textwrap.dedent(
    """
    import sys, importlib.util
    from pathlib import Path
    folder = Path(sys.argv[1])
    sys.path.insert(0, str(folder))
    import outer
    import lonely
    print(outer.outer(1.0), lonely.alone(1.0))
    """
)


HEAD = "from cprm_gym.compilation import kernel_group\nkernel = kernel_group()\n\n@kernel\n"


def write_kernels(folder, factor):
    (folder / "inner.py").write_text(f"{HEAD}def inner(x):\n    return {factor} * x\n")
    (folder / "lonely.py").write_text(f"{HEAD}def alone(x):\n    return -x\n")
    (folder / "outer.py").write_text("from inner import inner, kernel\n\n@kernel\ndef outer(x):\n    return inner(x) + 1.0\n")


def run(folder, cache):
    env = {**os.environ, "CPRM_GYM_CACHE": str(cache)}
    return subprocess.run([sys.executable, "-c", PROGRAM, str(folder)], capture_output=True, text=True, check=True, env=env).stdout


def test_editing_a_kernel_in_another_file_is_noticed(tmp_path):
    folder, cache = tmp_path / "kernels", tmp_path / "cache"
    folder.mkdir()
    write_kernels(folder, 2.0)
    assert run(folder, cache) == "3.0 -1.0\n"
    before = {d.name for d in (cache / "kernels").iterdir()}
    # the file of `outer` stays as it is; only the function that it calls changes
    write_kernels(folder, 5.0)
    assert run(folder, cache) == "6.0 -1.0\n"
    after = {d.name for d in (cache / "kernels").iterdir()}
    assert len(before) == 3
    assert len(after - before) == 2, "only the edited kernel and the one that calls it are compiled again"


def test_imports_are_followed_through_the_package_and_no_further(tmp_path):
    inside = {
        "__init__.py": "", "other.py": "", "numbers.py": "from .deep.more import x",
        "deep/__init__.py": "", "deep/more.py": "import math",
        "deep/kernels.py": "import numba\nfrom ..numbers import LIMIT\nfrom . import more",
    }  # fmt: skip
    for name, text in {**{f"package/{name}": text for name, text in inside.items()}, "numba.py": ""}.items():
        (tmp_path / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / name).write_text(text)
    found = import_closure(tmp_path / "package/deep/kernels.py")
    assert {str(file.relative_to(tmp_path / "package")) for file in found} == {"deep/kernels.py", "numbers.py", "deep/more.py"}


def test_imports_read_from_the_text_are_those_of_the_parsed_file(tmp_path):
    def parsed(file):
        top = next(folder for folder in file.parents if not (folder / "__init__.py").exists())
        found = set()
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom):
                base = (file.parents[node.level - 1] if node.level else top).joinpath(*(node.module or "").split("."))
                wanted = [(base / alias.name, base) for alias in node.names]
            elif isinstance(node, ast.Import):
                wanted = [(top.joinpath(*alias.name.split(".")),) for alias in node.names]
            else:
                continue
            for places in wanted:
                files = ({p for p in (at.with_name(at.name + ".py"), at / "__init__.py") if p.is_file()} for at in places)
                found |= next((some for some in files if some), set())
        return {path for path in found if path.is_relative_to(top / file.relative_to(top).parts[0])}

    files = [file for file in Path(cprm_gym.__file__).parent.rglob("*.py") if "kernels" in str(file) or file.stat().st_size % 5 == 0]
    assert len(files) > 100
    for file in files:
        assert parsed(file) <= compilation.imports(file), file

    (tmp_path / "other.py").write_text("")
    (tmp_path / "more.py").write_text("")
    for text in ("import other as o, math, more\n", "if True:\n    from other import (  # why\n        a,\n    )\n    import more; x = 1\n",
                 "from . import other\nfrom .more import *\n", "def f():\n\timport more, other\n"):  # fmt: skip
        (tmp_path / "who.py").write_text(text)
        compilation.imports.cache_clear()
        assert {path.name for path in compilation.imports(tmp_path / "who.py")} == {"other.py", "more.py"}, text


def test_constants_of_another_room_belong_to_the_key():
    root = Path(cprm_gym.__file__).parent
    assert root / "simulator/state.py" in import_closure(root / "envs/kernels/actions.py")


def test_compiling_is_announced_once_and_only_when_it_happens(tmp_path):
    program = "import gymnasium, cprm_gym; gymnasium.make('cprm/GoToBall-v2').reset(seed=1)"
    env = {**os.environ, "CPRM_GYM_CACHE": str(tmp_path)}
    env.pop("CPRM_GYM_QUIET", None)
    first = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=env).stderr
    again = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=env).stderr
    assert first.count("compiling kernels, once") == 1
    assert "compiling" not in again


def test_fastmath_is_refused():
    with pytest.raises(ValueError, match="fastmath"):
        kernel_group(fastmath=True)


def test_content_key_depends_on_every_file(tmp_path):
    a, b = tmp_path / "a.py", tmp_path / "b.py"
    a.write_text("1")
    b.write_text("2")
    first = content_key([a, b])
    assert first == content_key([b, a])
    b.write_text("3")
    assert content_key([a, b]) != first


@pytest.mark.skipif(compilation.config.DISABLE_JIT, reason="nothing is compiled")
def test_neighbouring_instructions_are_asked_for_while_such_a_kernel_is_compiled_and_not_after(monkeypatch):
    def three_times(x, y):
        y[0], y[1], y[2], y[3] = x[0] * 3.0, x[1] * 3.0, x[2] * 3.0, x[3] * 3.0

    monkeypatch.setattr(compilation, "cache_root", lambda: None)  # compiled here, not loaded
    before = compilation.config.SLP_VECTORIZE
    for side_by_side in (True, False):
        kernel = compilation.kernel_group(side_by_side=side_by_side)(three_times)
        seen = []
        as_it_is = kernel._compiler.compile
        kernel._compiler.compile = lambda *args: (seen.append(compilation.config.SLP_VECTORIZE), as_it_is(*args))[1]  # noqa: B023
        x, y = np.array([0.1, 0.2, 0.3, 0.4]), np.zeros(4)
        kernel(x, y)
        assert (y == x * 3.0).all()
        assert seen == [1 if side_by_side else before]
    assert before == compilation.config.SLP_VECTORIZE
