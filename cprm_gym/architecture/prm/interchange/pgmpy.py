"""Flat nets to and from pgmpy's `DiscreteBayesianNetwork`.

pgmpy is imported when a function is called. Its tables have the child's states as rows and one column per combination of
parents' states; names of variables and states are kept.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..grounding.grounding import SAME, GroundCPD, GroundSlice, GroundVariable
from .bif import need_static


def to_pgmpy(ground: GroundSlice) -> Any:
    """A static net as pgmpy's `DiscreteBayesianNetwork`.

    Parameters
    ----------
    ground : GroundSlice
        Without lags (see `grounding.unroll`). What is given becomes a root with a uniform distribution.

    Returns
    -------
    pgmpy.models.DiscreteBayesianNetwork

    Raises
    ------
    ModelError
        If a parent is in another slice.
    """
    from pgmpy.factors.discrete import TabularCPD
    from pgmpy.models import DiscreteBayesianNetwork

    need_static(ground, "pgmpy's DiscreteBayesianNetwork")
    net = DiscreteBayesianNetwork()
    net.add_nodes_from(ground.variables)
    for cpd in ground.cpds:
        net.add_edges_from((p, cpd.child) for p, _ in cpd.parents)
    for name, variable in ground.variables.items():
        if name in ground.given:
            parents: list[str] = []
            table = np.full(variable.card, 1.0 / variable.card)
        else:
            parents = [p for p, _ in ground.by_child[name].parents]
            table = ground.by_child[name].table
        columns = np.moveaxis(table, -1, 0).reshape(variable.card, -1)
        states = {n: list(ground.variables[n].states) for n in (name, *parents)}
        cards = [ground.variables[p].card for p in parents]
        net.add_cpds(TabularCPD(name, variable.card, columns, parents or None, cards or None, state_names=states))
    return net


def from_pgmpy(net: Any) -> GroundSlice:
    """The flat net of a pgmpy `DiscreteBayesianNetwork`.

    Parameters
    ----------
    net : pgmpy.models.DiscreteBayesianNetwork
        Names and states are turned to text.

    Returns
    -------
    GroundSlice

    Raises
    ------
    ModelError
        If a CPD is missing or not a distribution.
    """
    variables: dict[str, GroundVariable] = {}
    cpds = []
    for given in net.get_cpds():
        child = str(given.variable)
        states = tuple(str(s) for s in given.state_names[given.variable])
        owner, _, attribute = child.rpartition(".")
        variables[child] = GroundVariable(child, states, object_name=owner, attribute=attribute)
        table = np.ascontiguousarray(np.moveaxis(np.asarray(given.values, dtype=float), 0, -1))
        table.flags.writeable = False
        parents = tuple((str(p), SAME) for p in given.variables[1:])
        cpds.append(GroundCPD(child, parents, table, ("pgmpy", child)))
    order = [str(n) for n in net.nodes()]
    known = {n: variables[n] for n in order if n in variables}
    return GroundSlice({**known, **variables}, tuple(cpds))
