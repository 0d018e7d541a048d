"""One report on a net: what ``cprm-gym analyze`` prints."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from ...errors import NetError
from ..petri import CompiledNet, PetriNet, compile_net
from ..petri.files.load import load_net
from .behaviour.properties import Structure, analyze_structure
from .behaviour.state_space import Budget, Progress
from .modules.composition import CompositionReport, check_composition
from .modules.contracts import ContractReport, check_contract
from .net_arrays import System, selected_places
from .structure.conservation import conservative
from .structure.invariants import Invariants, flow_basis, semiflows, structural_bounds
from .structure.siphons import PlaceSets, minimal_siphons, minimal_traps, siphon_trap
from .timed.environment import closed_system
from .timed.properties import TimedStructure, judge_timed
from .timed.state_space import explore_timed
from .timed.system import TimedSystem
from .verdicts import Verdict

SIPHON_PLACES = 200
"""Siphons and traps are listed for nets of at most so many places."""


@dataclass(frozen=True)
class Report:
    """Everything the analysis says about a net.

    Attributes
    ----------
    name : str
    places, transitions : int
    untimed : Structure
        Every transition may fire whenever its tokens are there.
    timed : TimedStructure or None
        With clocks, priorities and the environment, for nets that have them.
    p_invariants, t_invariants : Invariants
        Integer bases; minimal semiflows where they were asked for.
    conservative : Verdict
        Whether some positive weighting of all places never changes.
    siphons, traps : PlaceSets or None
    siphon_trap : Verdict
        Commoner's condition for ordinary nets.
    contract : ContractReport or None
        For behaviour modules.
    composition : CompositionReport or None
        For nets with modules: whether it uses them as their contracts assume.
    notes : tuple of str
        What could not be looked at, and why.
    """

    name: str
    places: int
    transitions: int
    untimed: Structure
    timed: TimedStructure | None
    p_invariants: Invariants
    t_invariants: Invariants
    conservative: Verdict
    siphons: PlaceSets | None
    traps: PlaceSets | None
    siphon_trap: Verdict
    contract: ContractReport | None
    composition: CompositionReport | None = None
    notes: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """As plain values, ready for ``json.dumps``."""
        return {
            "name": self.name,
            "places": self.places,
            "transitions": self.transitions,
            "untimed": self.untimed.to_json(),
            "timed": self.timed.to_json() if self.timed else None,
            "p_invariants": _invariants(self.p_invariants),
            "t_invariants": _invariants(self.t_invariants),
            "conservative": self.conservative.to_json(),
            "siphons": _sets(self.siphons),
            "traps": _sets(self.traps),
            "siphon_trap": self.siphon_trap.to_json(),
            "contract": self.contract.to_json() if self.contract else None,
            "composition": self.composition.to_json() if self.composition else None,
            "notes": list(self.notes),
        }

    def text(self) -> str:
        """As JSON text."""
        return json.dumps(self.to_json(), indent=1)

    def render(self) -> RenderableType:
        """For a terminal (``rich.print``)."""
        parts: list[RenderableType] = [Text(f"net {self.name}: {self.places} places, {self.transitions} transitions", style="bold")]
        parts.append(_untimed_table(self))
        if self.timed:
            parts.append(_timed_table(self.timed))
        parts.append(_invariant_table(self))
        if self.contract:
            parts.append(Text(str(self.contract)))
        if self.composition:
            parts.append(Text(str(self.composition)))
        parts += [Text(f"note: {note}", style="yellow") for note in self.notes]
        return Group(*parts)


def analyze(
    net: PetriNet | str | Path,
    *,
    budget: Budget | None = None,
    progress: Progress | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    minimal: bool = False,
    contract: bool = True,
) -> Report:
    """Analyse a net: untimed structure, behaviour with clocks, invariants, siphons, the module contract.

    Parameters
    ----------
    net : PetriNet or path
    budget : Budget, optional
        For each exploration; spent means a partial answer that says so.
    progress : callable, optional
        Called now and then with markings found, expanded, seconds.
    bounds : mapping from place to (least, largest), optional
        What is known about continuous, input, belief and math places.
    minimal : bool
        Also find the minimal invariants without negative weights (can take long).
    contract : bool
        Check the contract of behaviour modules.
    """
    net = load_net(net)
    compiled = compile_net(net)
    ports = compiled.net.ports
    is_module = bool(ports.begin and ports.ongoing and ports.outcomes)
    own = System.from_net(compiled)
    notes: list[str] = []
    closed = _attempt(lambda: closed_system(compiled, bounds), notes) if is_module or _needs_timed(compiled) else None
    seen = closed.untimed if closed and is_module else own  # a module is looked at with its caller, from where the caller starts
    p_flows, t_flows = (semiflows(seen, "P"), semiflows(seen, "T")) if minimal else (flow_basis(seen, "P"), flow_basis(seen, "T"))
    space = explore_timed(closed, budget, progress) if closed else None
    small = len(seen.places) <= SIPHON_PLACES
    siphons = minimal_siphons(seen, 500) if small else None
    return Report(
        name=net.name,
        places=len(own.places),
        transitions=len(own.transitions),
        untimed=analyze_structure(seen, budget, progress),
        timed=judge_timed(compiled, space) if space else None,
        p_invariants=p_flows,
        t_invariants=t_flows,
        conservative=conservative(seen),
        siphons=siphons,
        traps=minimal_traps(seen, 500) if small else None,
        siphon_trap=siphon_trap(seen, siphons),
        contract=check_contract(net, budget=budget, bounds=bounds) if contract and is_module and closed else None,
        composition=check_composition(compiled, space=space) if space and compiled.source.modules else None,
        notes=tuple(notes),
    )


def _attempt(make: Callable[[], TimedSystem], notes: list[str]) -> TimedSystem | None:
    """What `make` returns, or None with a note when the exploration with clocks cannot follow the net."""
    try:
        return make()
    except NetError as error:
        notes.append(f"not explored cycle by cycle: {error}")
        return None


def _needs_timed(c: CompiledNet) -> bool:
    """Whether clocks, priorities, the environment or modules make the running net differ from its untimed view."""
    priorities = bool(c.priority.any()) and len(set(c.priority.tolist())) > 1
    chosen = bool(selected_places(c).any()) or not c.moved.all()
    return bool(c.delay.any()) or priorities or chosen or bool(c.source.modules)


def _invariants(found: Invariants) -> dict[str, Any]:
    vectors = [{"weights": v.weights, "value": v.value} if found.kind == "P" else {"weights": v.weights} for v in found.vectors]
    return {"complete": found.complete, "count": len(found.vectors), "vectors": vectors}


def _sets(found: PlaceSets | None) -> dict[str, Any] | None:
    return None if found is None else {"complete": found.complete, "sets": [sorted(s) for s in found.sets]}


def _verdict_rows(table: Table, rows: list[tuple[str, Verdict]], timed: bool) -> None:
    colour = {True: "green", False: "red", None: "yellow"}
    for name, verdict in rows:
        shown = tuple(str(s) for s in verdict.run) if timed else verdict.firings
        tail = " -> ".join(shown[:12]) + (f" ... ({len(shown)} steps)" if len(shown) > 12 else "")
        table.add_row(name, Text(str(verdict), style=colour[verdict.holds]), tail)


def _untimed_table(report: Report) -> Table:
    s = report.untimed
    table = Table(title="untimed: every transition fires whenever its tokens are there", title_justify="left")
    table.add_column("property")
    table.add_column("answer")
    table.add_column("shown by", overflow="fold")
    table.add_row("markings", f"{s.states:,}" + ("" if s.complete else f" and more ({s.reason})"), f"{s.edges:,} firings")
    table.add_row("most tokens", f"{s.max_tokens_in_place} in a place", f"{s.max_tokens_in_marking} in a marking")
    if s.sccs >= 0:
        table.add_row("components", f"{s.sccs:,} strongly connected", f"{s.bottom_sccs:,} of them never left")
        table.add_row("home markings", f"{s.home_markings:,}", "")
    rows: list[tuple[str, Verdict]] = [
        ("bounded", s.bounded),
        ("one-safe", s.one_safe),
        ("deadlock-free", s.deadlock_free),
        ("every transition can fire", s.quasi_live),
        ("live", s.live),
        ("reversible", s.reversible),
        ("conservative", report.conservative),
        ("siphons hold marked traps", report.siphon_trap),
    ]
    if s.soundness:
        rows += [
            (f"sound: option to complete ({s.soundness.source} to {s.soundness.sink})", s.soundness.option_to_complete),
            ("sound: proper completion", s.soundness.proper_completion),
        ]
    _verdict_rows(table, rows, timed=False)
    return table


def _timed_table(t: TimedStructure) -> Table:
    table = Table(title="running: clocks, priorities, any environment", title_justify="left")
    table.add_column("property")
    table.add_column("answer")
    table.add_column("shown by", overflow="fold")
    table.add_row("states", f"{t.states:,}" + ("" if t.complete else f" and more ({t.reason})"), f"{t.nodes:,} steps")
    _verdict_rows(
        table,
        [
            ("bounded", t.bounded),
            ("never comes to a standstill", t.never_stops),
            ("always finds back to the start", t.reversible),
            ("becomes quiet in every instant", t.becomes_quiet),
            ("deterministic given its inputs", t.deterministic),
        ],
        timed=True,
    )
    if t.dead_transitions:
        table.add_row("never fire", ", ".join(t.dead_transitions), "")
    for pair, verdict in t.modules.together.items() if t.modules else ():
        why = t.modules.invariants.get(pair, verdict.why) if t.modules else ""
        answer = {True: "together", False: "never together", None: "unknown"}[verdict.holds]
        table.add_row(" and ".join(pair), answer, why)
    return table


def _invariant_table(report: Report) -> Table:
    table = Table(title="invariants", title_justify="left")
    table.add_column("kind")
    table.add_column("invariant", overflow="fold")
    for found in (report.p_invariants, report.t_invariants):
        for v in found.vectors[:12]:
            table.add_row(found.kind, f"{v} = {v.value}" if found.kind == "P" else str(v))
        if len(found.vectors) > 12:
            table.add_row(found.kind, f"... and {len(found.vectors) - 12} more")
    return table


def place_bounds(system: System) -> dict[str, int]:
    """Most tokens per place that P-invariants prove."""
    return structural_bounds(system, semiflows(system, "P"))
