"""A timed net with its outside as arrays."""

import random

import numpy as np
from module_random_nets import random_module

from cprm_gym.architecture.analysis.timed.environment import caller
from cprm_gym.architecture.analysis.timed.system import timed_system
from cprm_gym.architecture.petri import compile_net


def test_other_moves_of_the_outside_make_the_same_system_as_from_the_beginning():
    for seed in range(12):
        compiled = compile_net(random_module(random.Random(seed), interrupts=True))
        (few, books), (many, _) = (caller(compiled.net, idle_interrupts) for idle_interrupts in (False, True))
        assert len(many) > len(few)
        whole, other = timed_system(compiled, many, books), timed_system(compiled, few, books).with_outside(many)
        assert (other.labels, other.places, other.transitions) == (whole.labels, whole.places, whole.transitions)
        for field in whole.net._fields:
            np.testing.assert_array_equal(getattr(other.net, field), getattr(whole.net, field), field)
        for field in ("pre", "post", "need", "inhibit", "sets", "capacity", "marking"):
            np.testing.assert_array_equal(getattr(other.untimed, field), getattr(whole.untimed, field), field)
