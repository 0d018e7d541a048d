"""Beliefs over real numbers in the state: the engine's filter is Kalman's, cells of it say what runs with the exact belief say."""

import numpy as np
import pytest

from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.product.explore import product
from cprm_gym.architecture.analysis.product.gaussian_beliefs import GaussianBeliefWorld
from cprm_gym.architecture.analysis.product.prm_world import PRMWorld
from cprm_gym.architecture.analysis.product.runs import ProductRuns
from cprm_gym.architecture.analysis.sampling.sample import sample
from cprm_gym.architecture.petri import Belief, Command, Input, PetriNet, Place, Transition
from cprm_gym.architecture.prm import BOOL, Attribute, Bins, Dense, Given, Model, Noise, Prior, PRMClass, Real, prev
from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.errors import ModelError

CELLS = 10
"""Metres from 0 to 10, one bin for each: how far off a ball is that comes nearer when he runs."""
SD, DRIFT, SEEN = 1.2, 0.6, 1.5


def normal(mean, sd):
    weights = np.exp(-0.5 * ((np.arange(CELLS) + 0.5 - mean) / sd) ** 2)
    return weights / weights.sum()


def truth():
    """The ball rolls about and is seen with errors; ``step`` brings him half a metre nearer."""
    moves = np.array([[normal(x + 0.5 - push, DRIFT) for push in (0.0, 1.0)] for x in range(CELLS)])
    looks = np.array([normal(x + 0.5, SEEN) for x in range(CELLS)])
    metres = Bins.linear(0.0, CELLS, CELLS, "m", clip=True)
    ball = PRMClass(
        "Ball",
        given=(Given("pushed", BOOL, default="no"),),
        attributes=(
            Attribute("far", metres, Dense(moves), parents=(prev("far"), "pushed"), initial=Prior(tuple(normal(7.0, SD)))),
            Attribute("looks", metres, Dense(looks), parents=("far",)),
        ),
    )
    return PRMWorld(Grounding(Model("truth", (ball,)), {"ball": "Ball"}), {"looks": "ball.looks", "far": "ball.far"},
                    given={"ball.pushed": "step"})  # fmt: skip


def belief_model():
    ball = PRMClass(
        "Ball",
        given=(Given("pushed", Real("m"), default=0.0),),
        attributes=(
            Attribute("far", Real("m"), Noise("prev.far - pushed", sd=DRIFT), ("prev.far", "pushed"), initial=Noise("7", sd=SD)),
            Attribute("looks", Real("m"), Noise("far", sd=SEEN), ("far",)),
        ),
    )
    return Grounding(Model("belief", (ball,)), {"ball": "Ball"})


def world(grain=0.0, **options):
    readings = {"ball.looks": "looks", "ball.pushed": "step"}
    return GaussianBeliefWorld(truth(), belief_model(), readings, {"believed": ("ball.far", "expectation")}, grain=grain, **options)


def reacher(most=4, sees="believed"):
    """Runs until he believes that it is within 5 m, then kicks: well if it is."""
    where = Belief("believed", variable="ball.far") if sees == "believed" else Input("believed", observes="far")
    return PetriNet(
        "reacher",
        places=(
            Place("ready", capacity=1, tokens=1), Place("acted", capacity=1), Place("steps", capacity=most), Place("good", capacity=1),
            Place("lost", capacity=1), Place("tired", capacity=1), where, Input("far", observes="far"),
        ),
        transitions=(
            Transition("kick_air", ("ready",), ("lost",), inhibitors={"believed": 5.0}, tests={"far": 5.6}, priority=5),
            Transition("kick", ("ready",), ("good",), inhibitors={"believed": 5.0}, priority=4),
            Transition("tire", ("ready",), ("tired",), tests={"steps": most}, priority=3),
            Transition("run", ("ready",), ("acted", "steps"), emits=Command("step")),
            Transition("tick", ("acted",), ("ready",), delay=1),
        ),
    )  # fmt: skip


OUTCOMES = {"good": "good", "lost": "lost", "tired": "tired"}


def chances(made):
    found = absorption(made.chain)
    return {o: found.probability(o).value for o in OUTCOMES}


def test_the_belief_is_the_kalman_filters():
    w = world()
    (state, _), *_ = w.start()
    mean, var = 7.0, SD**2
    for cycle in range(4):
        z = w.percepts(state)["looks"]
        if cycle:
            mean, var = mean - 1.0, var + DRIFT**2
        gain = var / (var + SEEN**2)
        mean, var = mean + gain * (z - mean), (1 - gain) * var
        assert w.percepts(state)["believed"] == pytest.approx(mean, abs=1e-9)
        state = w.next(state, ("step",))[cycle].state


@pytest.fixture(scope="module")
def played():
    return sample(ProductRuns(reacher(), world(), OUTCOMES), 400, seed=4, confidence=0.999)


def test_cells_of_beliefs_say_what_runs_with_the_exact_belief_say(played):
    found = chances(product(reacher(), world(0.15), OUTCOMES))
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-9)
    for outcome, interval in played.intervals().items():
        assert interval.holds(found.get(outcome, 0.0)), outcome


def test_finer_grain_changes_less_and_less():
    coarse, middle, fine = (chances(product(reacher(), world(grain), OUTCOMES)) for grain in (0.9, 0.3, 0.15))
    assert abs(middle["good"] - fine["good"]) < 0.7 * abs(coarse["good"] - fine["good"])


def test_acting_as_though_all_were_known_promises_too_much(played):
    known = product(reacher(sees="far"), truth(), OUTCOMES)
    assert chances(known)["lost"] == 0.0
    assert played.interval("lost").low > 0.02


def test_without_a_reading_the_belief_is_carried_on():
    w = world(when={"ball.looks": "looks < 0"})
    (state, _), *_ = w.start()
    assert w.percepts(state)["believed"] == pytest.approx(7.0)
    assert w.percepts(w.next(state, ("step",))[0].state)["believed"] == pytest.approx(6.0)
    assert w.name(state).endswith("believed 7")


def test_unknown_variables_are_named():
    with pytest.raises(ModelError, match=r"unknown variable 'ball.fat'. Did you mean 'ball.far'"):
        GaussianBeliefWorld(truth(), belief_model(), {}, {"believed": ("ball.fat", "expectation")})
    with pytest.raises(ModelError, match="negative"):
        world(-1.0)
