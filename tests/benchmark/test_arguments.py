"""What is asked for wrongly is refused in one line, before anything is played."""

import importlib

import pytest

WRONG = {
    "ball_error": (["--worlds", "0"], ["--seed", "-1"]),
    "scene.error": (["--worlds", "0"], ["--seed", "x"], ["--task", "Goaly"], ["--senses", "default,norrow"]),
    "demonstrations.story": (["a.svg", "--worlds", "0"],),
    "demonstrations.learning": (["shooter", "--worlds", "0"], ["shooter", "--held-out", "-1"]),
    "demonstrations.tuning": (["A", "model", "--generations", "0"],),
}


@pytest.mark.parametrize(("module", "given"), [(module, given) for module, all_given in WRONG.items() for given in all_given])
def test_commands_that_measure_refuse_it(module, given, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", [module, *given])
    with pytest.raises(SystemExit) as stopped:
        importlib.import_module(f"cprm_gym.benchmark.{module}").main()
    assert stopped.value.code == 2
    assert "error: " in capsys.readouterr().err.splitlines()[-1]
