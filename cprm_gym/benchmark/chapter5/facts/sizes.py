"""What a controller is made of: lines of its own for a task, states or places, and the episodes in which its numbers were tuned."""

from __future__ import annotations

import ast
import importlib.util
import io
import json
import re
import tokenize
from pathlib import Path
from typing import Any

from ....agents.knowledge.players import PLAYERS
from ....agents.play import SoccerAgent, agent_in
from ....agents.registry import AGENTS
from ....agents.skills.constants import STUDIES
from ....architecture.petri import compile_net
from ....envs.tasks import make_task
from ..conditions import Condition
from ..players import make_player

PARTS = {"states": "states", "layers": "layers", "nodes": "nodes", "programs": "programs", "body": "regions"}
"""Attributes of a structure that count what it is made of, where it has them, and what they are."""

NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?!\w)")
"""A number within a text."""
EMPTY = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
"""Tokens that are no code."""


def code_lines(source: str) -> int:
    """Lines of Python that hold code: no blank lines, comments or docstrings."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    held = {line for t in tokens if t.type not in EMPTY for line in range(t.start[0], t.end[0] + 1)}
    texts = {
        line
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    return len(held - texts)


def written_numbers(source: str) -> int:
    """Numbers written in Python, those in conditions and formulas within its texts included; 0 and 1, and docstrings, do not count."""
    tree = ast.parse(source)
    told = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    count = 0
    for node in ast.walk(tree):
        if not isinstance(node, ast.Constant) or id(node) in told or isinstance(node.value, (bool, bytes)):
            continue
        if isinstance(node.value, (int, float)):
            count += node.value not in (0, 1)
        elif isinstance(node.value, str):
            count += sum(float(text) not in (0.0, 1.0) for text in NUMBER.findall(node.value))
    return count


def own_file(controller: str, task: str, agent: str = "left_1") -> Path | None:
    """The file in which a registered controller is written for a task and an agent."""
    return _file_of(make_player(controller, Condition())(make_task(task), agent), task)


def _file_of(made: Any, task: str) -> Path | None:
    """That which a player names, else that of his class, or of his task where all agents share the class."""
    name = getattr(made, "written", None) or type(agent_in(made) or made).__module__
    if name == SoccerAgent.__module__:
        name = f"cprm_gym.agents.{AGENTS[task]}"
    spec = importlib.util.find_spec(name)
    return None if spec is None or spec.origin is None else Path(spec.origin)


def size_of(task: str, controller: str, seed: int, agent: str = "left_1") -> dict[str, Any]:
    """Lines, parts and places of a controller for a task.

    Returns
    -------
    dict
        ``lines`` of its own file and ``written``, the numbers in it (`written_numbers`); ``parts`` and what they are; of a net ``places``,
        ``transitions`` and ``modules`` with all modules embedded, ``apart`` places and transitions without them; ``rules`` that lead from
        one state to another; None for what it has not.
    """
    made: Any = make_player(controller, Condition())(make_task(task), agent)
    file = _file_of(made, task)
    source = "" if file is None else file.read_text(encoding="utf-8")
    found: dict[str, Any] = {
        "lines": code_lines(source) if source else None, "written": written_numbers(source) if source else None,
        "parts": None, "what": "", "transitions": None, "modules": None, "variables": None, "apart": None, "rules": None,
    }  # fmt: skip
    player = agent_in(made)
    if player is not None:
        net, own = compile_net(player.cprm.net).net, player.cprm.net
        models = (player.cprm.model,) if player.cprm.model is not None else getattr(getattr(made, "tier", None), "models", ())
        return {
            **found, "parts": len(net.places), "what": "places", "transitions": len(net.transitions), "modules": len(own.modules),
            "variables": sum(len(c.attributes) for model in models for c in model.classes),
            "apart": [len(own.places), len(own.transitions)],
        }  # fmt: skip
    structure = getattr(made, "structure", made)
    for name, what in PARTS.items():
        value = getattr(structure, name, None)
        if value is not None and hasattr(value, "__len__"):
            rules = sum(len(state.moves) + len(state.on) for state in value.values()) if isinstance(value, dict) else None
            return {**found, "parts": len(value), "what": what, "rules": rules}
    return found


def tuned(task: str, _: str, seed: int) -> dict[str, Any]:
    """Episodes that the studies of a task's player took, and how many numbers they set.

    Returns
    -------
    dict
        ``studies`` (tier -> episodes) and ``numbers``.
    """
    player = PLAYERS.get(task)
    if player is None or player.constants is None:
        return {"studies": {}, "numbers": 0}
    episodes = {}
    for path in sorted((STUDIES / (player.study or player.constants.whose)).glob("*.jsonl")):
        head, *generations = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        episodes[path.stem] = int(head["population"]) * int(head["worlds"]) * len(generations)
    return {"studies": episodes, "numbers": len(player.constants.extents())}
