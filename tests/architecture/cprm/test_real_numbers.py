"""Belief places over real numbers: what they hold is the Kalman filter's, also where inference is rare and late."""

import numpy as np
import pytest
from scipy.stats import norm

from cprm_gym.architecture.cprm import CPRM, CPRMRunner, Observe, cprm_from_json, cprm_to_json
from cprm_gym.architecture.petri import Belief, Input, Math, PetriNet, Place, Transition
from cprm_gym.architecture.prm.model.cpds import Noise
from cprm_gym.architecture.prm.model.domains import Real
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, PRMClass, prev
from cprm_gym.errors import ModelError

BALL = PRMClass(
    "Ball",
    attributes=(
        Attribute("x", Real("m"), Noise("0.9 * prev.x", sd=0.5), (prev("x"),), initial=Noise("0", sd=4.0)),
        Attribute("seen_x", Real("m"), Noise("x", sd=0.3), ("x",)),
    ),
)
NET = PetriNet(
    "keeper",
    places=(
        Place("ready", capacity=1, tokens=1), Place("done", capacity=1), Input("looked", observes="looked"),
        Belief("x", variable="ball.x"), Belief("near", variable="ball.x", view="probability(..2.5)"),
        Belief("at_most", variable="ball.x", view="quantile(0.9)"), Math("away", "abs(x)"),
    ),
    transitions=(Transition("leap", ("ready",), ("done",), tests={"near": 0.9}),),
)  # fmt: skip
KEEPER = CPRM(
    "keeper",
    net=NET,
    model=Model("ball", (BALL,)),
    objects={"ball": "Ball"},
    observations=(Observe("ball.seen_x", "x_told", when="looked"),),
)
TOLD = np.array([[3.0, np.nan], [np.nan, 2.9], [2.6, np.nan], [2.1, np.nan], [1.7, 5.0]])


def kalman(told):
    """Mean and variance of x after each cycle."""
    mean, var, found = 0.0, 16.0, []
    for k, reading in enumerate(told):
        if k:
            mean, var = 0.9 * mean, 0.81 * var + 0.25
        if not np.isnan(reading):
            gain = var / (var + 0.09)
            mean, var = mean + gain * (reading - mean), (1.0 - gain) * var
        found.append((mean, var))
    return np.array(found)


def percepts(readings):
    return {"x_told": np.nan_to_num(readings), "looked": (~np.isnan(readings)).astype(float)}


@pytest.mark.parametrize("engine", ["mixture", "rao-blackwell"])
def test_belief_places_hold_the_views_of_the_kalman_filter(engine):
    runner = CPRMRunner(cprm_from_json(cprm_to_json(KEEPER)), 2, engine=engine)
    expected = np.stack([kalman(TOLD[:, w]) for w in range(2)], axis=1)
    for told, (mean, var) in zip(TOLD, np.moveaxis(expected, 2, 1)):
        runner.step(percepts(told))
        sd = np.sqrt(var)
        assert runner.executor.read("x") == pytest.approx(mean, abs=1e-9)
        assert runner.executor.read("away") == pytest.approx(np.abs(mean), abs=1e-9)
        assert runner.executor.read("near") == pytest.approx(norm.cdf((2.5 - mean) / sd), abs=1e-9)
        assert runner.executor.read("at_most") == pytest.approx(norm.ppf(0.9, mean, sd), abs=1e-6)
    assert runner.executor.read("done").tolist() == [1.0, 0.0]


def test_a_late_result_is_carried_on_to_now():
    """Inference in every second cycle, a cycle late: what is read is the filter's of the look before, rolled on."""
    runner = CPRMRunner(KEEPER, 2, engine="mixture", t_b=2, latency=1)
    expected = np.stack([kalman(TOLD[:, w]) for w in range(2)], axis=1)
    read = []
    for told in TOLD:
        runner.step(percepts(told))
        read.append(runner.executor.read("x"))
    assert read[3] == pytest.approx(0.9 * expected[2, :, 0], abs=1e-9)
    assert read[4] == pytest.approx(0.81 * expected[2, :, 0], abs=1e-9)


def test_an_engine_of_states_asks_for_bins():
    with pytest.raises(ModelError, match="a Real without bins"):
        CPRMRunner(KEEPER, 2)
