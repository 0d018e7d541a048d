"""What nets can do, what they will do in a modelled world, and what is proved.

One net, four forms of arrays
=============================

======================================  ============================================================================================
`petri.CompiledNet`                     places and arcs of every kind, as the executor runs them: where every analysis begins
`net_arrays.System`                     tokens only: one row per transition, one column per place; time and environment left out.
                                        Needed by all that is structural (invariants, siphons, conservation), by coverability, and
                                        by the untimed state space as its definition
`behaviour.packing` (`PackedNet`)       the same as operations on words of bits, for one layout of the fields. Needed by the untimed
                                        state space alone, for its millions of markings
`timed.system` (`TimedNet`)             tokens, cells of what is observed, clocks, one phase. Needed by the timed state space, and so
                                        by contracts, composition and co-activity
======================================  ============================================================================================

Rooms
=====

==============  ====================================================================================================================
`report`        one report on a net: ``cprm-gym analyze``
`verdicts`      every answer: yes, no or unknown, why, and a run that shows it
`structure`     true for every initial marking: P- and T-invariants, siphons and traps, conservation
`behaviour`     reached from one marking, time left out: reachability, boundedness, deadlocks, liveness, coverability, bisimulation
`timed`         the same with clocks, priorities and any environment, cycle by cycle; which modules may be active together
`modules`       whether a behaviour module keeps the promises of its interface, and whether a net uses its modules well
`markov`        what a chain of states ends in, and when, each number with a bound on its error
`bounded`       the same where chances are known within bounds: the text's unknown state, and nature's optimum
`sampling`      what many runs show: intervals that hold, also while one looks, tests, properties in LTLf and STL
`rare`          outcomes that hardly ever come: what led to them, weighted and split runs
`product`       agent and world as one chain: relational models, learned cells; what is independent
`high_level`    a net of modules from summaries of them: conditions along every way, intervals chained, interference
`logic`         what follows from what: by cells, by boxes, by z3 where it is installed
`certificates`  proofs that a behaviour closes with its goal; Appendix A corrected
==============  ====================================================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...lazy import lazy_face

if TYPE_CHECKING:
    from .behaviour.bisimulation import weakly_bisimilar as weakly_bisimilar
    from .behaviour.coverability import karp_miller as karp_miller
    from .behaviour.properties import Structure as Structure
    from .behaviour.properties import analyze_structure as analyze_structure
    from .bounded.interval_chain import IntervalChain as IntervalChain
    from .bounded.interval_chain import load_interval_chain as load_interval_chain
    from .bounded.learning import intervals_from_counts as intervals_from_counts
    from .bounded.parametric import ParametricChain as ParametricChain
    from .bounded.parametric import parameter_bounds as parameter_bounds
    from .bounded.unknown_state import unknown_state_bounds as unknown_state_bounds
    from .bounded.value_iteration import bounds_over_time as bounds_over_time
    from .bounded.value_iteration import interval_bounds as interval_bounds
    from .bounds import Bounds as Bounds
    from .budget import Budget as Budget
    from .certificates.error_metric import Action as Action
    from .certificates.error_metric import ErrorMetricProof as ErrorMetricProof
    from .certificates.slow_approach import Certificate as Certificate
    from .certificates.slow_approach import SlowParams as SlowParams
    from .high_level.analysis import high_level_analysis as high_level_analysis
    from .high_level.analysis import high_level_concurrent_analysis as high_level_concurrent_analysis
    from .high_level.automatic import Automatic as Automatic
    from .high_level.automatic import automatic_analysis as automatic_analysis
    from .high_level.modules import Outcome as Outcome
    from .high_level.modules import Summary as Summary
    from .high_level.modules import summarise as summarise
    from .high_level.modules import wiring as wiring
    from .logic.implication import Implication as Implication
    from .logic.implication import implies as implies
    from .markov.absorption import Absorption as Absorption
    from .markov.absorption import absorption as absorption
    from .markov.chain import NEVER as NEVER
    from .markov.chain import Certified as Certified
    from .markov.chain import MarkovChain as MarkovChain
    from .markov.files import chain_to_drn as chain_to_drn
    from .markov.files import chain_to_prism as chain_to_prism
    from .markov.files import load_chain as load_chain
    from .markov.files import save_chain as save_chain
    from .markov.lumping import lump as lump
    from .markov.over_time import distribution_at as distribution_at
    from .markov.over_time import outcomes_over_time as outcomes_over_time
    from .modules.composition import CompositionReport as CompositionReport
    from .modules.composition import check_composition as check_composition
    from .modules.contracts import ContractReport as ContractReport
    from .modules.contracts import check_contract as check_contract
    from .product.beliefs import BeliefWorld as BeliefWorld
    from .product.beliefs import TwoStateFilter as TwoStateFilter
    from .product.explore import Product as Product
    from .product.gaussian_beliefs import GaussianBeliefWorld as GaussianBeliefWorld
    from .product.learned_world import LearnedWorld as LearnedWorld
    from .product.learned_world import load_world as load_world
    from .product.prm_world import PRMWorld as PRMWorld
    from .product.regular import regular_bounds as regular_bounds
    from .product.runs import ProductRuns as ProductRuns
    from .product.subdivision import Apart as Apart
    from .product.subdivision import analyze_apart as analyze_apart
    from .product.subdivision import groups as groups
    from .product.worlds import World as World
    from .rare.conditional import Conditional as Conditional
    from .rare.conditional import conditional as conditional
    from .rare.importance import importance_sampling as importance_sampling
    from .rare.importance import learned_h as learned_h
    from .rare.splitting import Splittable as Splittable
    from .rare.splitting import split_chain as split_chain
    from .rare.splitting import split_worlds as split_worlds
    from .report import Report as Report
    from .report import analyze as analyze
    from .sampling.gymnasium_runs import GymnasiumRuns as GymnasiumRuns
    from .sampling.intervals import clopper_pearson as clopper_pearson
    from .sampling.means import mean_interval as mean_interval
    from .sampling.means import mean_sequence as mean_sequence
    from .sampling.numbers import Number as Number
    from .sampling.properties import Property as Property
    from .sampling.runs import ChainRuns as ChainRuns
    from .sampling.runs import Run as Run
    from .sampling.runs import Runs as Runs
    from .sampling.sample import Sample as Sample
    from .sampling.sample import sample as sample
    from .sampling.sequences import confidence_sequence as confidence_sequence
    from .sampling.sequential import ProbabilityRatioTest as ProbabilityRatioTest
    from .structure.conservation import conservative as conservative
    from .structure.invariants import Invariant as Invariant
    from .structure.invariants import flow_basis as flow_basis
    from .structure.invariants import semiflows as semiflows
    from .structure.siphons import minimal_siphons as minimal_siphons
    from .structure.siphons import minimal_traps as minimal_traps
    from .timed.properties import TimedStructure as TimedStructure
    from .timed.properties import analyze_timed as analyze_timed
    from .timed.properties import may_reach as may_reach
    from .verdicts import Step as Step
    from .verdicts import Verdict as Verdict
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "report": "Report analyze",
            "verdicts": "Step Verdict",
            "product.beliefs": "BeliefWorld TwoStateFilter",
            "product.explore": "Product",
            "product.gaussian_beliefs": "GaussianBeliefWorld",
            "product.learned_world": "LearnedWorld load_world",
            "product.prm_world": "PRMWorld",
            "product.regular": "regular_bounds",
            "product.runs": "ProductRuns",
            "product.subdivision": "Apart analyze_apart groups",
            "product.worlds": "World",
            "rare.conditional": "Conditional conditional",
            "rare.importance": "importance_sampling learned_h",
            "rare.splitting": "Splittable split_chain split_worlds",
            "sampling.gymnasium_runs": "GymnasiumRuns",
            "sampling.intervals": "clopper_pearson",
            "sampling.means": "mean_interval mean_sequence",
            "sampling.numbers": "Number",
            "sampling.properties": "Property",
            "sampling.runs": "ChainRuns Run Runs",
            "sampling.sample": "Sample sample",
            "sampling.sequences": "confidence_sequence",
            "sampling.sequential": "ProbabilityRatioTest",
            "structure.conservation": "conservative",
            "certificates.error_metric": "Action ErrorMetricProof",
            "certificates.slow_approach": "Certificate SlowParams",
            "high_level.analysis": "high_level_analysis high_level_concurrent_analysis",
            "high_level.automatic": "Automatic automatic_analysis",
            "high_level.modules": "Outcome Summary summarise wiring",
            "logic.implication": "Implication implies",
            "markov.absorption": "Absorption absorption",
            "markov.chain": "NEVER Certified MarkovChain",
            "markov.files": "chain_to_drn chain_to_prism load_chain save_chain",
            "markov.lumping": "lump",
            "markov.over_time": "distribution_at outcomes_over_time",
            "modules.contracts": "ContractReport check_contract",
            "modules.composition": "CompositionReport check_composition",
            "behaviour.properties": "Structure analyze_structure",
            "bounded.interval_chain": "IntervalChain load_interval_chain",
            "bounded.learning": "intervals_from_counts",
            "bounded.parametric": "ParametricChain parameter_bounds",
            "bounded.unknown_state": "unknown_state_bounds",
            "bounded.value_iteration": "bounds_over_time interval_bounds",
            "bounds": "Bounds",
            "budget": "Budget",
            "behaviour.coverability": "karp_miller",
            "behaviour.bisimulation": "weakly_bisimilar",
            "structure.invariants": "Invariant flow_basis semiflows",
            "structure.siphons": "minimal_siphons minimal_traps",
            "timed.properties": "TimedStructure analyze_timed may_reach",
        },
    )
