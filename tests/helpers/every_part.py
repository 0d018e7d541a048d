"""A model with one of each kind of thing that a model can hold."""

from __future__ import annotations

import math

import numpy as np

from cprm_gym.architecture.prm.model.aggregates import AnyCause, Count, Mean
from cprm_gym.architecture.prm.model.cpds import Chance, Dense, Mixture, Noise, NoisyOr, Prior, Switch, Table, Uniform
from cprm_gym.architecture.prm.model.domains import BOOL, Bins, Labels
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Add, Attribute, Given, PRMClass, Reference, Relation


def everything() -> Model:
    """One of each kind of thing that a model can hold."""
    rng = np.random.default_rng(3)
    bins = Bins((0.0, 0.1, 1 / 3, math.pi), "m", clip=True)
    rows = rng.dirichlet(np.ones(3), 2)
    a = PRMClass(
        "A",
        (
            Attribute("flag", BOOL, (0.3, 0.7), static=True),
            Attribute("x", bins, Dense(rows, (BOOL.stamp, bins.stamp)), parents=("flag",)),
            Attribute(
                "y",
                bins,
                Mixture((0.25, Noise("prev.y + act", "0.1 + 0.1 * abs(act)", "uniform", 1e-5, 7)), (0.75, Uniform())),
                parents=("prev.y", "act"),
                initial=Prior((0.5, 0.25, 0.25)),
            ),
            Attribute("z", BOOL, Switch("flag", {"yes": Chance("x / 4", 0.01, 9), "*": (0.5, 0.5)}), parents=("flag", "x")),
            Attribute("n", BOOL, NoisyOr((0.5,), 0.1), parents=("flag",)),
        ),
        (Reference("peers", "B", many=True),),
        (Given("act", Bins.linear(-1, 1, 3), default=0.0), Given("mode", ("go", "stop"), default="go")),
    )
    count = Attribute("c", Labels(("few", "many")), Table({"0": (1.0, 0.0), "*": (0.1, 0.9)}), parents=(Count("peers.n", "yes", 2),))
    any_cause = Attribute(
        "d",
        BOOL,
        Table({("yes", "*"): (0.1, 0.9), ("*", "*"): (0.8, 0.2)}),
        parents=(AnyCause("prev.peers.n", "yes", 0.5, 0.1), Mean("peers.x", "0..0.1")),
        initial=Uniform(),
    )
    b = PRMClass("B", (count, any_cause), extends="A")
    relation = Relation(
        "r",
        {"a": "A", "b": "B"},
        (Add("b.n", ("a.n",), NoisyOr((0.5, 0.25))),),
        (Attribute("s", BOOL),),
        "mixture",
        3,
        (("a.x", "b.x"),),
    )
    return Model("everything", (a, b), (relation,))
