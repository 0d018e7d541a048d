"""What nets can do (structure, module contracts), what they will do in a modelled world, and what is proved.

Structural analysis, for all environments:

=================  ======================================================================================================
`report`           one report on a net: ``cprm-gym analyze``
`structure`        reachability, boundedness, deadlocks, liveness, home markings, soundness of the untimed view
`timed`            the same with clocks, priorities and the environment, cycle by cycle; which modules may be active together
`contracts`        whether a behaviour module keeps the promises of its interface; `composition`: whether a net uses them well
`coverability`     unbounded nets (Karp and Miller)
`invariants`       P- and T-invariants; `siphons`: siphons and traps
`state_space`      the markings themselves, bit-packed; `cycles`: the steps of a timed net; `system`: a net as arrays
=================  ======================================================================================================

Every answer is yes, no or unknown, with the reason; a "no" comes with a run that shows it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...lazy import lazy_face

if TYPE_CHECKING:
    from .behaviour.bisimulation import weakly_bisimilar as weakly_bisimilar
    from .behaviour.coverability import karp_miller as karp_miller
    from .behaviour.properties import Structure as Structure
    from .behaviour.properties import analyze_structure as analyze_structure
    from .behaviour.state_space import Budget as Budget
    from .modules.composition import CompositionReport as CompositionReport
    from .modules.composition import check_composition as check_composition
    from .modules.contracts import ContractReport as ContractReport
    from .modules.contracts import check_contract as check_contract
    from .report import Report as Report
    from .report import analyze as analyze
    from .structure.invariants import Invariant as Invariant
    from .structure.invariants import flow_basis as flow_basis
    from .structure.invariants import semiflows as semiflows
    from .structure.siphons import minimal_siphons as minimal_siphons
    from .structure.siphons import minimal_traps as minimal_traps
    from .timed.properties import TimedStructure as TimedStructure
    from .timed.properties import analyze_cycles as analyze_cycles
    from .timed.properties import may_reach as may_reach
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "report": "Report analyze",
            "modules.contracts": "ContractReport check_contract",
            "modules.composition": "CompositionReport check_composition",
            "behaviour.properties": "Structure analyze_structure",
            "behaviour.state_space": "Budget",
            "behaviour.coverability": "karp_miller",
            "behaviour.bisimulation": "weakly_bisimilar",
            "structure.invariants": "Invariant flow_basis semiflows",
            "structure.siphons": "minimal_siphons minimal_traps",
            "timed.properties": "TimedStructure analyze_cycles may_reach",
        },
    )
