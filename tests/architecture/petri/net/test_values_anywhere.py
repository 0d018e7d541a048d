"""Values put where they do not belong, at random: a part of a net or an error of ours, never anything else."""

import copy
import inspect
import random

import numpy as np
import pytest
from net_mutations import VALUES

from cprm_gym.architecture.petri import (
    Belief,
    Command,
    Continuous,
    Input,
    Math,
    ObjectPlace,
    PetriNet,
    Place,
    Ports,
    Selection,
    Semantics,
    Transition,
)
from cprm_gym.errors import CprmError

PARTS = (
    Place("p"), Transition("t"), (Place("p"),), [Transition("t")], PetriNet("m"), {"x": PetriNet("m")}, Ports(), Semantics(), Command("c"),
    Selection("Ball", "ball.x"), np.float64(2), np.int64(3), np.zeros(3), b"x", {1, 2}, 3j, len, 10**5000, [10**5000], range(3), ("p",),
)  # fmt: skip
NEEDED = {"name": "n", "class_name": "Ball", "best": "ball.x", "expression": "x", "variable": "v"}


def check(cls, seed):
    """Make one part with values from anywhere; returns whether it was accepted."""
    rng = random.Random(seed)
    names = list(inspect.signature(cls).parameters)
    given = {name: NEEDED[name] for name in names if name in NEEDED and rng.random() < 0.9}
    given |= {name: copy.deepcopy(rng.choice((*VALUES, *PARTS))) for name in names if name not in given and rng.random() < 0.3}
    given |= {name: NEEDED[name] for name in names if name in NEEDED and name not in given}
    try:
        part = cls(**given)
    except CprmError:
        return False
    assert part == copy.copy(part)
    assert hash(part) == hash(copy.copy(part))
    assert repr(part)
    return True


@pytest.mark.parametrize("cls", [Place, Continuous, Input, Belief, Math, ObjectPlace, Selection, Transition, Ports, Semantics, PetriNet])
def test_a_part_is_made_or_refused_in_our_own_words(cls):
    for seed in range(1000):
        try:
            check(cls, seed)
        except Exception as error:
            raise AssertionError(f"seed {seed}: {type(error).__name__}: {error}") from error
