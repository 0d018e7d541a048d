"""One source for each number: what is the server's is not typed again where behaviours and environments are written."""

import ast
import dataclasses
import re

import pytest
from paths import ROOT

from cprm_gym.simulator import pitch
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import PlayerType

ROOMS = ("cprm_gym/agents", "baselines/cprm_baselines", "cprm_gym/envs", "cprm_gym/wrappers")
TEAM, PICTURE = "cprm_gym/envs/players/kernels/team.py", "cprm_gym/envs/rendering.py"
NAMES = {f.name for cls in (ServerParameters, PlayerType) for f in dataclasses.fields(cls)}
USUAL = {"stamina_max": 8000.0, "dash_power_rate": 0.006, "1 - ball_decay": 0.06, "-log(ball_decay)": 0.0619, "reach of the leg": 1.085,
         "player_size + ball_size": 0.385, "half of goal_width": 7.01, "reach of the leg, less an error": 0.98}  # fmt: skip
"""Numbers that follow from the defaults, and those of one digit that tell all the same."""
COMMON = {0.75, 2.5, 5.5}
"""Defaults that anybody writes for other reasons; what they stand for decides nothing in these rooms."""
MODELS = "cprm_gym/agents/models.py"
ALLOWED = {
    (MODELS, "1.05"): "an edge of bins",
    (MODELS, "1.2"): "the eye's error in degrees",
    (MODELS, "36"): "bins of a circle",
    (MODELS, "0.98"): "a probability: of seeing what is in view",
    (MODELS, "0.94"): "a probability: an opponent goes on facing the goal",
    (MODELS, "0.06"): "a probability: a team-mate turns to him",
    ("cprm_gym/agents/outfielder/model.py", "0.06"): "an edge of bins",
    ("cprm_gym/agents/kernels/outfield.py", "1.2"): "m / cycle of a ball that he drives, as its way is judged",
    ("cprm_gym/agents/attacker/constants.py", "1.2"): "how much an opponent who must turn loses",
    ("cprm_gym/agents/demos.py", "34"): "a colour",
    ("cprm_gym/agents/net_view.py", "34"): "a colour",
    (TEAM, "34"): "metres of a long pass",
    (TEAM, "1.2"): "speed of a push and of a pass that arrives",
    (TEAM, "0.06"): "how much nearer to the middle a farther pass goes",
    ("cprm_gym/envs/players/scripted.py", "36"): "a place in the formation",
    ("cprm_gym/envs/players/scripted.py", "34"): "a place in the formation",
    (PICTURE, "1.05"): "metres of a player as drawn",
    (PICTURE, "34"): "a colour",
    (PICTURE, "105"): "a colour",
    (PICTURE, "36"): "a colour",
    ("cprm_gym/envs/tasks/goalie.py", "36"): "metres from the goal line at which the ball counts as kept out",
}
"""(file, literal) -> why it stands there: equal by chance."""


def telling():
    """Value -> what it is: defaults of at least two digits, which nobody writes by chance; no whole numbers but the pitch's."""
    found = {value: name for name, value in USUAL.items()}
    for cls in (ServerParameters, PlayerType):
        for f in dataclasses.fields(cls):
            value = f.default
            if isinstance(value, float) and len(f"{value:g}".replace(".", "").strip("0")) > 1 and value != round(value):
                found.setdefault(value, f.name)
    found |= {v: k for k, v in vars(pitch).items() if isinstance(v, float) and (v != round(v) or v in (105.0, 68.0, 34.0, 36.0))}
    return {value: name for value, name in found.items() if value not in COMMON}


TELLING = telling()


def literals(tree):
    """(line, number) of all literals, those within text that is computed with too; docstrings are not."""
    prose = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if not isinstance(node, ast.Constant) or id(node) in prose:
            continue
        if isinstance(node.value, float) or (isinstance(node.value, int) and not isinstance(node.value, bool)):
            yield node.lineno, float(node.value)
        elif isinstance(node.value, str):
            for match in re.finditer(r"(?<![\w.])\d+(?:\.\d+)?(?![\w.])", node.value):
                yield node.lineno, float(match[0])


def inertia(tree):
    """Lines with "1 + 5 * speed", in code or in text."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and re.search(r"\b1(\.0)? \+ 5(\.0)? \*", node.value):
            yield node.lineno
        if isinstance(node, ast.BinOp) and re.match(r"1(\.0)? \+ 5(\.0)? \*", ast.unparse(node)):
            yield node.lineno


def renamed(tree):
    """(line, name) of constants that are called as a parameter is, and are numbers."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant | ast.Tuple):
            values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            names = [n.id for t in node.targets for n in (t.elts if isinstance(t, ast.Tuple) else [t]) if isinstance(n, ast.Name)]
            if all(isinstance(v, ast.Constant) and isinstance(v.value, float | int) for v in values):
                yield from ((node.lineno, name) for name in names if name.lower() in NAMES)


def typed_again(source, path):
    """What of the server's stands in a file, in words."""
    tree = ast.parse(source)
    found = [f"{path}:{line}: {value:g} is {TELLING[value]}" for line, value in literals(tree) if value in TELLING
             and (path, f"{value:g}") not in ALLOWED]  # fmt: skip
    found += [f"{path}:{line}: the default inertia_moment" for line in inertia(tree)]
    return found + [f"{path}:{line}: {name} is a parameter of the server" for line, name in renamed(tree)]


@pytest.mark.parametrize("room", ROOMS)
def test_no_number_of_the_servers_is_typed_again(room):
    files = sorted((ROOT / room).rglob("*.py"))
    assert len(files) > 5
    assert [line for file in files for line in typed_again(file.read_text(), str(file.relative_to(ROOT)))] == []


@pytest.mark.parametrize(
    "source",
    ["REACH = 1.085", 'Math("speed", f"arriving + 0.06 * way")', 'Math("moment", "bearing * (1 + 5 * speed)")', "INERTIA_MOMENT = 5.0",
     "turn * (1.0 + 5.0 * speed)", "x = 52.5 - y", "a = (0.7, 0.3), 0.94", "BALL_SPEED_MAX = 3"],
)  # fmt: skip
def test_a_number_typed_again_is_found(source):
    assert typed_again(source, "somewhere.py")


def test_prose_and_numbers_of_other_kinds_are_let_be():
    assert not typed_again('"""The ball keeps 0.94 of its speed."""\nLOOKS = 2\nAHEAD = 12.0\nHALF = 0.5 * x', "somewhere.py")


def test_what_is_allowed_stands_there():
    for path, literal in ALLOWED:
        assert literal in {f"{value:g}" for _, value in literals(ast.parse((ROOT / path).read_text()))}, (path, literal)
