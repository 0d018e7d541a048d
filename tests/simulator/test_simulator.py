"""The simulator as an object: what it holds is what its steps use."""

import pytest
from simulator_worlds import put, quiet_world

from cprm_gym.simulator.parameters import Rules
from cprm_gym.simulator.player_types import TypeColumn


@pytest.mark.parametrize("rules", [Rules.NONE, Rules.ALL])
def test_parameters_that_are_put_in_place_are_those_of_the_next_step(rules):
    """Without rules the step has a type of parameters of its own: it is made of the ones that are there."""
    simulator = quiet_world(rules=rules)
    put(simulator, 1, 0.0, 0.0, vx=1.0)
    simulator.packed = simulator.packed.copy()
    simulator.packed["types"][0, :, TypeColumn.PLAYER_DECAY] = 0.5
    simulator.step()
    assert simulator.world["vel"][0, 1, 0] == pytest.approx(0.5)
