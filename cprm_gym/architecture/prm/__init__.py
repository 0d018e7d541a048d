"""Dynamic probabilistic relational models: what an agent believes about objects it sees badly or not at all.

    Model --objects--> Skeleton --relations--> GroundSlice --pattern of evidence--> Step (plan) --evidence--> Belief --view--> number

Five arrows, five rooms: ``model`` (classes, CPDs and relations, checked), ``grounding`` (objects and the slices of a net),
``inference/compiled`` (plans), ``inference`` (filters and engines), ``inference/views`` (numbers); ``interchange`` saves, draws and
exports. *Write* a `Model`; *ground* it with the objects of a world (`Grounding`); *filter* what is perceived (`Filter`), with relations
switched on and off at will; *read* the belief as numbers (`View`); *learn* the CPDs (`count`, `em`).

The words of this package
-------------------------
variable
    One attribute of one object in one time slice. Its states are names, or the bins of a number.
CPD
    P(variable | parents). Tables have the parents' axes as declared and the child's axis last; rows sum to 1.
slice
    All variables of one time step. Parents are in the same slice, in the previous one (``prev.``), or static.
relation
    Holds between objects or not, as the agent decides before each step; while active it replaces CPDs or adds parents. It is
    no evidence: what is believed is the posterior in the unrolled net whose slices have the CPDs of their active relations.
belief
    P(variables now | everything observed so far), kept as a set of factors.

References
----------
Dissertation section 2.3. Getoor, Friedman, Koller, Pfeffer 2001; Koller and Friedman 2009; Murphy 2002.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...lazy import lazy_face

if TYPE_CHECKING:
    from .grounding.grounding import Grounding as Grounding
    from .grounding.grounding import GroundSlice as GroundSlice
    from .grounding.grounding import Situation as Situation
    from .grounding.grounding import unroll as unroll
    from .inference.bayes_net import BayesNet as BayesNet
    from .inference.compiled.belief import FactoredBelief as FactoredBelief
    from .inference.deep_filter import DeepFilter as DeepFilter
    from .inference.engines.engine import Engine as Engine
    from .inference.filter import Filter as Filter
    from .inference.filter_bank import FilterBank as FilterBank
    from .inference.filtering import FilterState as FilterState
    from .inference.filtering import advance as advance
    from .inference.learning import Episode as Episode
    from .inference.learning import Observed as Observed
    from .inference.learning import count as count
    from .inference.learning import em as em
    from .inference.links import Link as Link
    from .inference.links import Role as Role
    from .inference.posterior import Posterior as Posterior
    from .inference.views import View as View
    from .inference.views import view as view
    from .interchange.bif import from_bif as from_bif
    from .interchange.bif import load_bif as load_bif
    from .interchange.bif import save_bif as save_bif
    from .interchange.bif import to_bif as to_bif
    from .interchange.drawing import class_diagram_dot as class_diagram_dot
    from .interchange.drawing import class_diagram_svg as class_diagram_svg
    from .interchange.drawing import ground_net_dot as ground_net_dot
    from .interchange.drawing import ground_net_svg as ground_net_svg
    from .interchange.json import load_model as load_model
    from .interchange.json import model_from_json as model_from_json
    from .interchange.json import model_to_json as model_to_json
    from .interchange.json import save_model as save_model
    from .interchange.json import world_from_json as world_from_json
    from .interchange.json import world_to_json as world_to_json
    from .interchange.pgmpy import from_pgmpy as from_pgmpy
    from .interchange.pgmpy import to_pgmpy as to_pgmpy
    from .model.aggregates import All as All
    from .model.aggregates import AnyCause as AnyCause
    from .model.aggregates import Count as Count
    from .model.aggregates import Exists as Exists
    from .model.aggregates import Max as Max
    from .model.aggregates import Mean as Mean
    from .model.aggregates import Min as Min
    from .model.cpds import Chance as Chance
    from .model.cpds import Dense as Dense
    from .model.cpds import Mixture as Mixture
    from .model.cpds import Noise as Noise
    from .model.cpds import NoisyOr as NoisyOr
    from .model.cpds import Prior as Prior
    from .model.cpds import Switch as Switch
    from .model.cpds import Table as Table
    from .model.cpds import Uniform as Uniform
    from .model.diffusion import diffusion_report as diffusion_report
    from .model.domains import BOOL as BOOL
    from .model.domains import Angle as Angle
    from .model.domains import Bins as Bins
    from .model.domains import Index as Index
    from .model.domains import Interval as Interval
    from .model.domains import Labels as Labels
    from .model.domains import Real as Real
    from .model.model import Model as Model
    from .model.schema import Add as Add
    from .model.schema import Attribute as Attribute
    from .model.schema import Given as Given
    from .model.schema import PRMClass as PRMClass
    from .model.schema import Reference as Reference
    from .model.schema import Relation as Relation
    from .model.schema import Replace as Replace
    from .model.schema import prev as prev
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "grounding.grounding": "GroundSlice Grounding Situation unroll",
            "inference.bayes_net": "BayesNet",
            "inference.compiled.belief": "FactoredBelief",
            "inference.deep_filter": "DeepFilter",
            "inference.engines.engine": "Engine",
            "inference.filter": "Filter",
            "inference.filter_bank": "FilterBank",
            "inference.links": "Link Role",
            "inference.filtering": "FilterState advance",
            "inference.learning": "Episode Observed count em",
            "inference.posterior": "Posterior",
            "inference.views": "View view",
            "interchange.bif": "from_bif load_bif save_bif to_bif",
            "interchange.drawing": "class_diagram_dot class_diagram_svg ground_net_dot ground_net_svg",
            "interchange.json": "load_model model_from_json model_to_json save_model world_from_json world_to_json",
            "interchange.pgmpy": "from_pgmpy to_pgmpy",
            "model.aggregates": "All AnyCause Count Exists Max Mean Min",
            "model.cpds": "Chance Dense Mixture Noise NoisyOr Prior Switch Table Uniform",
            "model.diffusion": "diffusion_report",
            "model.domains": "BOOL Angle Bins Index Interval Labels Real",
            "model.model": "Model",
            "model.schema": "Add Attribute Given PRMClass Reference Relation Replace prev",
        },
    )
