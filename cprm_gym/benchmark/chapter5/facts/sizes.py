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
from ....agents.play import agent_in
from ....agents.registry import AGENTS
from ....agents.skills.constants import STUDIES
from ....architecture.petri import compile_net
from ....envs.others.registry import controller_entries
from ....envs.tasks import make_task
from ..conditions import Condition
from ..players import make_player

PARTS = {"states": "states", "layers": "layers", "body": "regions"}
"""Attributes of a structure that count what it is made of, where it has them, and what they are."""


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


def own_file(controller: str, task: str) -> Path | None:
    """The file in which a registered controller is written for a task: its package's of the task's name, else the one registered."""
    if controller == "cprm" and task in AGENTS:
        name = f"cprm_gym.agents.{AGENTS[task]}"
    else:
        entry = controller_entries().get(controller)
        if entry is None:
            return None
        name = entry.module
        stem = re.sub(r"_?\d+v\d+$", "", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", task).lower())
        package = importlib.util.find_spec(name)
        if package is not None and package.submodule_search_locations and importlib.util.find_spec(f"{name}.{stem}") is not None:
            name = f"{name}.{stem}"
    spec = importlib.util.find_spec(name)
    return None if spec is None or spec.origin is None else Path(spec.origin)


def size_of(task: str, controller: str, seed: int) -> dict[str, Any]:
    """Lines, parts and places of a controller for a task.

    Returns
    -------
    dict
        ``lines`` of its own file; ``parts`` and what they are; of a net ``places``, ``transitions`` and ``modules``; None for what it has
        not.
    """
    made = make_player(controller, Condition())(make_task(task), "left_1")
    file = own_file(controller, task)
    found: dict[str, Any] = {"lines": None if file is None else code_lines(file.read_text(encoding="utf-8"))}
    agent = agent_in(made)
    if agent is not None:
        net = compile_net(agent.cprm.net).net
        models = (agent.cprm.model,) if agent.cprm.model is not None else getattr(getattr(made, "tier", None), "models", ())
        return {
            **found, "parts": len(net.places), "what": "places", "transitions": len(net.transitions),
            "modules": len(agent.cprm.net.modules), "variables": sum(len(c.attributes) for model in models for c in model.classes),
        }  # fmt: skip
    structure = getattr(made, "structure", None)
    for name, what in PARTS.items():
        value = getattr(structure, name, None)
        if value is not None and hasattr(value, "__len__"):
            return {**found, "parts": len(value), "what": what, "transitions": None, "modules": None, "variables": None}
    return {**found, "parts": None, "what": "", "transitions": None, "modules": None, "variables": None}


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
