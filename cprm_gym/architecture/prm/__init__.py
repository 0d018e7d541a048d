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

from .grounding.grounding import Grounding, GroundSlice, Situation, unroll
from .inference.bayes_net import BayesNet
from .inference.deep_filter import DeepFilter
from .inference.filter import Filter
from .inference.filter_bank import FilterBank, Link, Role
from .inference.learning import Episode, Observed, count, em
from .inference.posterior import Posterior
from .inference.views import View, view
from .interchange.json import load_model, model_from_json, model_to_json, save_model
from .model.aggregates import All, AnyCause, Count, Exists, Max, Mean, Min
from .model.cpds import Chance, Dense, Mixture, Noise, NoisyOr, Prior, Switch, Table, Uniform
from .model.diffusion import diffusion_report
from .model.domains import BOOL, Bins, Index, Labels
from .model.model import Model
from .model.schema import Add, Attribute, Given, PRMClass, Reference, Relation, Replace, prev

__all__ = [
    "BOOL",
    "Add",
    "All",
    "AnyCause",
    "Attribute",
    "BayesNet",
    "Bins",
    "Chance",
    "Count",
    "DeepFilter",
    "Dense",
    "Episode",
    "Exists",
    "Filter",
    "FilterBank",
    "Given",
    "GroundSlice",
    "Grounding",
    "Index",
    "Labels",
    "Link",
    "Max",
    "Mean",
    "Min",
    "Mixture",
    "Model",
    "Noise",
    "NoisyOr",
    "Observed",
    "PRMClass",
    "Posterior",
    "Prior",
    "Reference",
    "Relation",
    "Replace",
    "Role",
    "Situation",
    "Switch",
    "Table",
    "Uniform",
    "View",
    "count",
    "diffusion_report",
    "em",
    "load_model",
    "model_from_json",
    "model_to_json",
    "prev",
    "save_model",
    "unroll",
    "view",
]
