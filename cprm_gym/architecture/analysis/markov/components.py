"""Strongly connected components of a chain, in the order in which they are solved."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels import graph
from .chain import MarkovChain


class Components(NamedTuple):
    """States by component, each component after those that it leads to."""

    component: NDArray[np.int32]  # (n,)
    start: NDArray[np.int64]  # (C + 1,) where each begins in `nodes`
    nodes: NDArray[np.int32]  # (n,)
    targets: NDArray[np.int32]  # (m,) those of the chain, -1 from absorbing states


def components(chain: MarkovChain) -> Components:
    """Tarjan's components; absorbing states lead nowhere, and edges of probability zero are none."""
    n = chain.n
    cut = np.repeat(chain.absorbing, np.diff(chain.offsets)) | (chain.chances == 0.0)
    targets = np.where(cut, np.int32(-1), chain.targets) if cut.any() else chain.targets
    component = np.empty(n, np.int32)
    scratch = [np.empty(n, np.int32) for _ in range(3)]
    count = int(graph.strong_components(chain.offsets, targets, component, *scratch, np.empty(n, np.int64)))
    start, nodes = np.zeros(count + 1, np.int64), np.empty(n, np.int32)
    graph.group_nodes(component, start, nodes)
    return Components(component, start, nodes, targets)
