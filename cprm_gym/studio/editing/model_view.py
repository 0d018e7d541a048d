"""What an editor of models shows: tables of CPDs, the ground net as a graph, answers to queries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import islice, product
from typing import Any

import numpy as np

from ...architecture.petri.drawing.layout import Edge, Node, arrange
from ...architecture.prm import Filter, Grounding, GroundSlice, Model
from ...architecture.prm.grounding.grounding import PREVIOUS, SAME
from ...architecture.prm.model.domains import Domain, is_continuous
from ...architecture.prm.model.resolved import Rule, Rules
from ...errors import CprmError, ModelError, unknown_name

ROWS = 600
"""Most rows of a table that are shown."""
TUPLES = 120
"""Most tuples of objects that are offered for one relation."""
GAP = 40.0
"""Between parts of a graph that no edge joins, pixels."""
VARIABLES = 1500
"""Most variables of a graph that is drawn."""


def rules_of(model: Model, kind: str, owner: str, label: str) -> Rules:
    """The resolved rule of an attribute or a change.

    Parameters
    ----------
    model : Model
    kind : {"class", "relation", "change"}
    owner : str
        Name of the class or relation.
    label : str
        Attribute, or ``role.attribute`` of a change.

    Raises
    ------
    UnknownName
    """
    checked = model.checked
    if kind == "class":
        holder: Mapping[str, Any] = checked.classes
    elif kind in ("relation", "change"):
        holder = checked.relations
    else:
        raise unknown_name("kind of part", kind, ("class", "relation", "change"))
    if owner not in holder:
        raise unknown_name(kind if kind == "class" else "relation", owner, holder)
    rules: Mapping[str, Rules] = holder[owner].changes if kind == "change" else holder[owner].rules
    if label not in rules:
        raise unknown_name("attribute", label, rules)
    return rules[label]


def cpd_table(model: Model, kind: str, owner: str, label: str, part: str = "cpd") -> dict[str, Any]:
    """A CPD as a table: which parents, their states, one row of probabilities for each combination.

    Parameters
    ----------
    part : {"cpd", "initial"}
        The second for the slice in which something has no previous value.

    Returns
    -------
    dict
        ``parents`` with name and states, ``states``, ``values`` of the child's states (middles of bins), ``rows`` as
        ``[states of the parents, probabilities]``, ``left`` for the number of rows that are not shown, and ``note``.
    """
    note = ""
    rules = rules_of(model, kind, owner, label)
    chosen = rules.main if part == "cpd" else rules.initial
    if chosen is None:
        raise ModelError(f"{owner}.{label} has no initial CPD of its own")
    if chosen.density is not None:
        try:
            model = model.binned()
        except CprmError as error:
            return {"parents": _parents(chosen), "states": [], "values": [], "rows": [], "left": 0, "note": f"a density; {error}"}
        rules = rules_of(model, kind, owner, label)
        chosen = rules.main if part == "cpd" else rules.initial
        assert chosen is not None
        note = "a density, shown over the bins of its real numbers"
    shape = chosen.table.shape[:-1]
    total = int(np.prod(shape)) if shape else 1
    rows = []
    for index in islice(np.ndindex(*shape), ROWS):
        states = [slot.domain.states[k] for slot, k in zip(chosen.parents, index)]
        rows.append([states, [round(float(p), 6) for p in chosen.table[index]]])
    return {
        "parents": _parents(chosen),
        "states": list(chosen.domain.states),
        "values": [v if isinstance(v, str) else round(float(v), 4) for v in chosen.domain.values],
        "rows": rows,
        "left": total - len(rows),
        "note": note,
    }


def _parents(rule: Rule) -> list[dict[str, Any]]:
    return [{"name": slot.text, "states": _states(slot.domain)} for slot in rule.parents]


def _states(domain: Domain) -> list[str]:
    return [] if is_continuous(domain) else list(domain.states)


def tuples(grounding: Grounding) -> list[str]:
    """Relations with objects of the right classes, ``possesses(o3,ball)``: what can be in force."""
    found = []
    for relation in grounding.model.relations:
        members = [grounding.members[c] for _, c in relation.roles]
        made = (objects for objects in product(*members) if len(set(objects)) == len(objects))
        found += [f"{relation.name}({','.join(objects)})" for objects in islice(made, TUPLES)]
    return found


def graph(grounding: Grounding, relations: Sequence[str] = (), first: bool = False) -> dict[str, Any]:
    """A ground slice as a graph: variables with their place, edges with their lag.

    Returns
    -------
    dict
        ``nodes`` (key, object, label, given, states, x, y, width), ``edges`` (source, target, lag 0 or 1, what is in force that made
        it), ``width``, ``height``.

    Raises
    ------
    CprmError
        When it cannot be grounded, or has too many variables.
    """
    ground = grounding.ground(relations, first=first)
    if len(ground.variables) > VARIABLES:
        raise ModelError(f"{len(ground.variables)} variables; up to {VARIABLES} are drawn")
    plain = {(c.child, p, lag) for c in grounding.ground((), first=first).cpds for p, lag in c.parents} if relations else None
    nodes, edges = [], []
    at: dict[str, Node] = {}
    for name in ground.order():
        width = 6.6 * len(name) + 24
        at[name] = Node(name, width / 2, width / 2, 46.0)
    lines = []
    for cpd in ground.cpds:
        for parent, lag in cpd.parents:
            if parent in at and cpd.child in at:
                changed = plain is not None and (cpd.child, parent, lag) not in plain
                edges.append({"source": parent, "target": cpd.child, "lag": 0 if lag == SAME else 1 if lag == PREVIOUS else 2,
                              "changed": changed})  # fmt: skip
                if lag != PREVIOUS and parent != cpd.child:
                    lines.append(Edge(parent, cpd.child))
    width, height = _shelves(list(at.values()), lines)
    for name, node in at.items():
        variable = ground.variables[name]
        states = [] if variable.quantity is not None else list(variable.states)
        nodes.append(
            {"key": name, "object": variable.object_name, "label": name, "given": name in ground.given, "states": states,
             "x": round(node.x, 1), "y": round(node.y, 1), "width": round(2 * node.left, 1)}
        )  # fmt: skip
    return {"nodes": nodes, "edges": edges, "width": round(width, 1), "height": round(height, 1), "relations": list(ground.relations)}


def _shelves(nodes: list[Node], edges: list[Edge]) -> tuple[float, float]:
    """Arrange each connected part by itself, and put the parts beside and below each other; returns width and height of the whole."""
    group = {node.key: node.key for node in nodes}

    def root(key: str) -> str:
        while group[key] != key:
            group[key] = group[group[key]]
            key = group[key]
        return key

    for edge in edges:
        group[root(edge.source)] = root(edge.target)
    parts: dict[str, list[Node]] = {}
    for node in nodes:
        parts.setdefault(root(node.key), []).append(node)
    sized = [(part, *arrange(part, [e for e in edges if root(e.source) == key])) for key, part in parts.items()]
    widest = max([1.6 * sum((w + GAP) * (h + GAP) for _, w, h in sized) ** 0.5, *(w for _, w, _ in sized)], default=0.0)
    x = y = tall = width = 0.0
    for part, w, h in sized:
        if x and x + w > widest:
            x, y, tall = 0.0, y + tall + GAP, 0.0
        for node in part:
            node.x, node.y = node.x + x, node.y + y
        x, tall, width = x + w + GAP, max(tall, h), max(width, x + w)
    return width, y + tall


def query(grounding: Grounding, slices: Sequence[Mapping[str, Any]], engine: str = "exact") -> dict[str, Any]:
    """What is believed after some slices.

    Parameters
    ----------
    grounding : Grounding
    slices : sequence of dict
        Each with ``evidence`` (variable -> state or number) and ``relations``.
    engine : str
        As for `Filter`.

    Returns
    -------
    dict
        ``beliefs``: variable -> probabilities of its states, or mean and deviation of a real number; ``log_likelihood``.

    Raises
    ------
    CprmError
        For evidence that does not fit or is impossible, or a query that would take too much.
    """
    if not slices:
        raise ModelError("a query is about one slice or more")
    options: dict[str, Any] = {"particles": 4000} if engine in ("particles", "rao-blackwell") else {}
    if grounding.model.continuous and engine in ("exact", "projection"):
        grounding = grounding.binned()
    made = Filter(grounding, engine=engine, seed=0, **options)
    for given in slices:
        posterior = made.step(given.get("evidence") or {}, tuple(given.get("relations") or ()))
    beliefs: dict[str, Any] = {}
    ground: GroundSlice = posterior.slice
    for name, variable in ground.variables.items():
        if name in ground.given:
            continue
        if variable.quantity is not None:
            spread = float(posterior.read(name, "variance")[0])
            beliefs[name] = {"mean": float(posterior.read(name, "expectation")[0]), "deviation": spread**0.5}
        else:
            beliefs[name] = [round(float(p), 6) for p in np.asarray(posterior[name])[0]]
    return {"beliefs": beliefs, "log_likelihood": float(made.log_likelihood[0]), "exact": bool(made.exact)}
