"""One report on a net: what ``cprm-gym analyze`` prints."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from ...errors import NetError
from ..petri import CompiledNet, PetriNet, compile_net
from ..petri.files.load import load_net
from ..petri.net.net import MAX_PARTS
from .behaviour.properties import Proofs, Structure, analyze_structure
from .behaviour.state_space import Progress
from .budget import Budget, Clock
from .modules.composition import CompositionReport, check_composition
from .modules.contracts import ContractReport, check_contract
from .net_arrays import System
from .structure.conservation import conservative
from .structure.invariants import Invariants, flow_basis, semiflows, structural_bounds
from .structure.siphons import PlaceSets, minimal_siphons, minimal_traps, siphon_trap
from .timed.environment import closed_system
from .timed.properties import TimedStructure, judge_timed, needs_time
from .timed.state_space import explore_timed
from .timed.system import TimedSystem
from .verdicts import Verdict

PARTS_PER_SECOND = 20_000
"""Places, transitions and modules that flattening and compiling make in a second, at least."""
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
    interrupted : bool
        Whether the user stopped it.
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
    interrupted: bool = False

    @property
    def broken(self) -> bool:
        """Whether a contract is broken, or a module used wrongly."""
        return (self.contract is not None and self.contract.holds is False) or (
            self.composition is not None and self.composition.holds is False
        )

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
            "interrupted": self.interrupted,
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
    exclusive: Sequence[Sequence[str]] = (),
) -> Report:
    """Analyse a net: untimed structure, behaviour with clocks, invariants, siphons, the module contract.

    Parameters
    ----------
    net : PetriNet or path
    budget : Budget, optional
        For all of it, from flattening to the last run that is written out; spent means a partial answer that says so.
    progress : callable, optional
        Called now and then with markings found, expanded, seconds.
    bounds : mapping from place to (least, largest), optional
        What is known about continuous, input, belief and math places.
    minimal : bool
        Also find the minimal invariants without negative weights (can take long).
    contract : bool
        Check the contract of behaviour modules.
    exclusive : sequence of sequences of command names
        Of which one goes out per cycle, as for the executor: pairs that may be sent at once are reported.

    Raises
    ------
    NetError
        For a net that is larger than the budget lets it be flattened or held.
    """
    budget, clock = (budget or Budget()).start()
    net = load_net(net)
    parts = MAX_PARTS if budget.seconds == float("inf") else min(MAX_PARTS, max(1000, int(PARTS_PER_SECOND * clock.left)))
    compiled = compile_net(net, parts)
    ports = compiled.net.ports
    is_module = bool(ports.begin and ports.ongoing and ports.outcomes)
    _check_memory(compiled, budget)
    own = System.from_net(compiled)
    notes: list[str] = []
    limits = budget.part(0.2).start()[1]  # of what is found by cutting cells
    closed = _attempt(lambda: closed_system(compiled, bounds, enough=limits.spent), clock, notes) if needs_time(compiled) else None
    seen = closed.untimed if closed and is_module else own  # a module is looked at with its caller, from where the caller starts
    structural = _structural(seen, minimal, budget.part(0.3), notes)
    untimed = analyze_structure(seen, budget.part(0.3 if closed else 0.9), progress, proofs=structural.proofs)
    space = explore_timed(closed, budget.part(0.4), progress) if closed else None
    timed = judge_timed(compiled, space, exclusive, clock.spent) if space else None
    if timed and timed.bounded.holds is None and untimed.bounded.holds:
        timed = replace(timed, bounded=Verdict(True, "the untimed view is bounded, which holds all that the running net does"))
    checked = contract and is_module and closed
    return Report(
        name=net.name,
        places=len(own.places),
        transitions=len(own.transitions),
        untimed=untimed,
        timed=timed,
        p_invariants=structural.p_flows,
        t_invariants=structural.t_flows,
        conservative=structural.proofs.conservative,
        siphons=structural.siphons,
        traps=structural.traps,
        siphon_trap=structural.proofs.siphon_trap,
        contract=check_contract(net, budget=budget.part(0.8), bounds=bounds) if checked else None,
        composition=check_composition(compiled, space=space) if space and compiled.source.modules else None,
        notes=tuple(notes),
        interrupted=clock.interrupted,
    )


class _Structural(NamedTuple):
    """What is found without exploration."""

    p_flows: Invariants
    t_flows: Invariants
    siphons: PlaceSets | None
    traps: PlaceSets | None
    proofs: Proofs


def _structural(system: System, minimal: bool, budget: Budget, notes: list[str]) -> _Structural:
    """Invariants, conservation, siphons and traps within a budget; what is cut short is noted."""
    _, clock = budget.start()
    enough = clock.spent
    positive = semiflows(system, "P", enough=enough)
    p_flows = positive if minimal else flow_basis(system, "P", enough)
    t_flows = semiflows(system, "T", enough=enough) if minimal else flow_basis(system, "T", enough)
    small = len(system.places) <= SIPHON_PLACES
    siphons = minimal_siphons(system, 500, enough) if small else None
    traps = minimal_traps(system, 500, enough) if small else None
    proofs = Proofs(conservative(system, clock.left), siphon_trap(system, siphons), structural_bounds(system, positive))
    if clock.spent():
        notes.append("invariants, siphons or traps were cut short: the time is over")
    return _Structural(p_flows, t_flows, siphons, traps, proofs)


def _check_memory(c: CompiledNet, budget: Budget) -> None:
    """Refuse a net whose arrays alone need more memory than is granted."""
    needed = 48 * c.n_transitions * c.n_places
    if needed > budget.memory:
        raise NetError(
            f"net {c.net.name!r}: {c.n_places} places and {c.n_transitions} transitions take {needed >> 20} MiB as arrays; "
            f"{budget.memory >> 20} MiB are granted"
        )


def _attempt(make: Callable[[], TimedSystem], clock: Clock, notes: list[str]) -> TimedSystem | None:
    """What `make` returns, or None with a note when the exploration with clocks cannot follow the net, or the time is half over."""
    if clock.spent() or clock.left < 0.5 * clock.granted:  # its arrays take as long as those that there are
        notes.append("not explored cycle by cycle: the time is over")
        return None
    try:
        return make()
    except NetError as error:
        notes.append(f"not explored cycle by cycle: {error}")
        return None


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
    for emission in t.emissions:
        table.add_row("two commands in one cycle", Text(str(emission), style="yellow"), " -> ".join(str(s) for s in emission.run[-8:]))
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
