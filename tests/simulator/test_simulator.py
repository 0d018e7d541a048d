"""The simulator as an object: what it holds is what its steps use."""

import pytest

from cprm_gym.simulator.parameters import Rules, ServerParameters
from cprm_gym.simulator.player_types import TypeColumn
from cprm_gym.simulator.simulator import Simulator


@pytest.mark.parametrize("rules", [Rules.NONE, Rules.ALL])
def test_parameters_that_are_put_in_place_are_those_of_the_next_step(rules):
    """Without rules the step has a type of parameters of its own: it is made of the ones that are there."""
    simulator = Simulator(left=1, right=0, goalies=(0, 0), rules=rules, parameters=ServerParameters(player_rand=0.0))
    simulator.world["vel"][0, 1] = 1.0, 0.0
    simulator.packed = simulator.packed.copy()
    simulator.packed["types"][0, :, TypeColumn.PLAYER_DECAY] = 0.5
    simulator.step()
    assert simulator.world["vel"][0, 1, 0] == pytest.approx(0.5)
