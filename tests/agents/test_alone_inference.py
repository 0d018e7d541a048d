"""Inference of one agent runs all plans of a slice in one call: the same numbers, bit by bit, as for an agent among others."""

import numpy as np
import pytest

from cprm_gym.agents.models import goalie_model, passer_model
from cprm_gym.agents.outfielder.model import outfield_model
from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.architecture.prm.inference.evidence import StateRows
from cprm_gym.architecture.prm.inference.filter import Filter

AGENTS, STEPS = 9, 12


@pytest.mark.parametrize("make", [goalie_model, passer_model, outfield_model])
def test_an_agent_alone_believes_bit_by_bit_what_he_believes_among_others(make):
    model, rng = make(), np.random.default_rng(0)
    many = Filter(Grounding(model, {"ball": "Ball"}), batch=AGENTS)
    alone = [Filter(Grounding(model, {"ball": "Ball"}), batch=1) for _ in range(AGENTS)]
    variables, given = many.grounding.ground((), first=False).variables, many.grounding.ground((), first=False).given
    names = tuple(n for n in variables if ".seen" in n or n in given)
    cards = np.array([variables[n].card for n in names])[:, None]
    for step in range(STEPS):
        states = (0.35 * cards + 0.3 * cards * rng.random((len(names), AGENTS))).astype(np.int64)
        if step % 2:
            states[[".seen" in n for n in names]] = -1
        together = many.step(StateRows(names, states))
        for k, one in enumerate(alone):
            own = one.step(StateRows(names, states[:, k : k + 1]))
            assert own.result.alone is not None
            assert own.increment[0] == together.increment[k]
            for name in own.variables:
                np.testing.assert_array_equal(own[name][0], together[name][k], err_msg=name)
