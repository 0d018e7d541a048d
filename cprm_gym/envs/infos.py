"""What every face tells beside observation and reward: numbers and arrays of fixed shape, under the same names in all of them.

================== ============================================================================================
``status``         int, a `Status`: how the episode stands or has ended
``is_success``     bool: it has ended as this agent wishes
``cycle``          int: cycles of the episode
``reward_<term>``  float: the named parts of the reward; their sum is the reward
``action_mask``    (macros,) int8: what can be done now; the macro view alone
``truth``          (23, 2) float: true places of ball and players; with ``debug_info`` alone
================== ============================================================================================

They are there from the reset on. A vector environment has arrays of them, (W, ...), each followed by Gymnasium's ``_<name>``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from .core import SoccerCore, Step


def of_agents(core: SoccerCore, step: Step | None, debug_info: bool) -> list[dict[str, Any]]:
    """The info of each agent of world 0 after `step`, or after a reset."""
    status, cycle = 0 if step is None else int(step.status[0]), int(core.cycle[0])
    if step is not None and len(core.agents) == 1:
        infos: list[dict[str, Any]] = [{"status": status, "is_success": bool(step.success[0, 0]), "cycle": cycle}]
        for term, key in core.term_keys:
            infos[0][key] = float(step.terms[term][0, 0])
        return _with_now(core, infos, debug_info)
    if step is None:
        infos = [{"status": status, "is_success": False, "cycle": cycle} for _ in core.agents]
    else:
        infos = [{"status": status, "is_success": won, "cycle": cycle} for won in step.success[0].tolist()]
    for term, key in core.term_keys:
        if step is None:
            for info in infos:
                info[key] = 0.0
        else:
            for info, value in zip(infos, step.terms[term][0].tolist()):
                info[key] = value
    return _with_now(core, infos, debug_info)


def _with_now(core: SoccerCore, infos: list[dict[str, Any]], debug_info: bool) -> list[dict[str, Any]]:
    """The infos with what belongs to the observation."""
    mask = core.action_mask
    if mask is not None:
        for info, row in zip(infos, mask[0].astype(np.int8)):
            info["action_mask"] = row
    if debug_info:
        for info in infos:
            info["truth"] = core.sim.world["pos"][0].copy()
    return infos


def of_worlds(core: SoccerCore, step: Step | None, debug_info: bool, copy: bool = True) -> dict[str, np.ndarray]:
    """The infos of the first agent of all worlds, arrays with the worlds first."""
    worlds = core.worlds
    if step is None:
        infos: dict[str, np.ndarray] = {"status": np.zeros(worlds, np.int64), "is_success": np.zeros(worlds, bool)}
    else:
        infos = {"status": step.status.copy(), "is_success": step.success[:, 0].copy()}
    infos["cycle"] = core.cycle.copy()
    for term, key in core.term_keys:
        infos[key] = np.zeros(worlds) if step is None else step.terms[term][:, 0].copy()
    return infos | now_of_worlds(core, debug_info, copy)


def now_of_worlds(core: SoccerCore, debug_info: bool, copy: bool = True) -> dict[str, np.ndarray]:
    """The part of the infos that belongs to the observation: what can be done now, and the truth."""
    infos: dict[str, np.ndarray] = {}
    mask = core.action_mask
    if mask is not None:
        infos["action_mask"] = mask[:, 0].astype(np.int8) if copy else mask[:, 0].view(np.int8)
    if debug_info:
        infos["truth"] = core.sim.world["pos"].copy()
    return infos
