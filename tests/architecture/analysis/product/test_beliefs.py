"""Beliefs in the state: bounds over cells hold for the agent's true belief, and narrow with the cells."""

import numpy as np
import pytest

from cprm_gym.architecture.analysis.bounded.value_iteration import interval_bounds
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.product.beliefs import BeliefWorld, TwoStateFilter
from cprm_gym.architecture.analysis.product.explore import product
from cprm_gym.architecture.analysis.product.prm_world import PRMWorld
from cprm_gym.architecture.analysis.product.runs import ProductRuns
from cprm_gym.architecture.analysis.sampling.sample import sample
from cprm_gym.architecture.petri import Belief, Input, PetriNet, Place, Transition
from cprm_gym.architecture.prm import BOOL, Attribute, Model, Prior, PRMClass, Table, prev
from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.errors import ImpossibleEvidence, ModelError

STAYS = (0.95, 0.1)
SEES = {1.0: (0.8, 0.3), 0.0: (0.2, 0.7)}


def free_world():
    """Whether a team-mate is free, which is seen with errors."""
    moves = Table({"no": (1 - STAYS[1], STAYS[1]), "yes": (1 - STAYS[0], STAYS[0])})
    looks = Table({"no": (SEES[0.0][1], SEES[1.0][1]), "yes": (SEES[0.0][0], SEES[1.0][0])})
    mate = PRMClass(
        "Mate",
        attributes=(
            Attribute("free", BOOL, moves, parents=(prev("free"),), initial=Prior((0.6, 0.4))),
            Attribute("looks", BOOL, looks, parents=("free",)),
        ),
    )
    return PRMWorld(Grounding(Model("mate", (mate,)), {"mate": "Mate"}), {"mate.looks": "mate.looks", "truth": "mate.free"})


def passer(most=6):
    """Passes when he believes it with 0.85, gives up after so many looks; whether it was right is seen afterwards."""
    return PetriNet(
        "passer",
        places=(
            Place("ready", capacity=1, tokens=1), Place("looked", capacity=1), Place("looks", capacity=most),
            Place("good", capacity=1), Place("lost", capacity=1), Place("kept", capacity=1),
            Belief("sure", variable="mate.free", view="probability", state="yes"), Input("truth", observes="truth"),
        ),
        transitions=(
            Transition("pass_well", ("ready",), ("good",), tests={"sure": 0.85, "truth": 1}, priority=5),
            Transition("pass_badly", ("ready",), ("lost",), tests={"sure": 0.85}, inhibitors={"truth": 1}, priority=5),
            Transition("keep", ("ready",), ("kept",), tests={"looks": most}, priority=4),
            Transition("look", ("ready",), ("looked", "looks"), inhibitors={"sure": 0.85, "looks": most}),
            Transition("tick", ("looked",), ("ready",), delay=1),
        ),
    )  # fmt: skip


OUTCOMES = {"good": "good", "lost": "lost", "kept": "kept"}
FILTER = TwoStateFilter("mate.looks", SEES, STAYS, prior=0.4)


def bounds(cells):
    cuts = tuple(sorted({*np.round(np.linspace(0, 1, cells + 1)[1:-1], 12).tolist(), 0.85}))
    found = product(passer(), BeliefWorld(free_world(), "sure", FILTER, cuts), OUTCOMES)
    assert found.complete
    return interval_bounds(found.bounded).probabilities


@pytest.fixture(scope="module")
def truth():
    """Exact beliefs: finitely many looks make finitely many of them."""
    found = product(passer(), BeliefWorld(free_world(), "sure", FILTER), OUTCOMES)
    assert found.complete
    return {name: absorption(found.chain).probability(name).value for name in OUTCOMES}


def test_bounds_over_cells_hold_for_the_true_belief_and_narrow_with_them(truth):
    coarse, fine = bounds(4), bounds(160)
    for name, p in truth.items():
        assert coarse[name].low - 1e-9 <= p <= coarse[name].high + 1e-9
        assert fine[name].low - 1e-9 <= p <= fine[name].high + 1e-9
        assert fine[name].width <= coarse[name].width + 1e-9
    assert fine["good"].width < 0.5 * coarse["good"].width


def test_runs_with_the_exact_belief_agree(truth):
    found = sample(ProductRuns(passer(), BeliefWorld(free_world(), "sure", FILTER), OUTCOMES), 1500, seed=3)
    for name, interval in found.intervals().items():
        assert interval.holds(truth.get(name, 0.0))


def test_acting_as_if_all_were_known_promises_too_much(truth):
    """The text's first way: he never passes to one who is not free."""

    class Known(PRMWorld):
        def percepts(self, state):
            values = super().percepts(state)
            return {**values, "sure": values["truth"]}

    world = free_world()
    known = product(passer(), Known(world.grounding, world.percepts_), OUTCOMES)
    assert absorption(known.chain).probability("lost").value == 0.0
    assert truth["lost"] > 0.02


def test_the_filter_is_bayes_rule():
    b = FILTER.updated(0.5, (), 1.0)
    prior = 0.5 * STAYS[0] + 0.5 * STAYS[1]
    assert b == pytest.approx(prior * 0.8 / (prior * 0.8 + (1 - prior) * 0.3))
    turned = TwoStateFilter("x", SEES, STAYS, {"turn": (0.0, 1.0)})
    assert turned.updated(1.0, ("turn",), 1.0) == 0.0


def test_what_makes_no_sense_is_refused():
    with pytest.raises(ModelError, match="no likelihood of the reading 2"):
        FILTER.corrected(0.5, 2.0)
    with pytest.raises(ImpossibleEvidence):
        TwoStateFilter("x", {1.0: (1.0, 0.0)}).corrected(0.0, 1.0)
    with pytest.raises(ModelError, match="cuts increase"):
        BeliefWorld(free_world(), "sure", FILTER, (0.5, 0.4))
    with pytest.raises(ModelError, match="between 0 and 1"):
        TwoStateFilter("x", {1.0: (1.2, 0.0)})
