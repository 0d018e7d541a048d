"""Inference that comes rarely and late, against the forward algorithm by hand."""

from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.architecture.cprm import CPRM, Cluster, CPRMRunner, Event, Observe
from cprm_gym.architecture.petri import Belief, Input, ObjectPlace, PetriNet, Place, Selection, Transition
from cprm_gym.architecture.prm.model.cpds import Table
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, Given, PRMClass, Relation, Replace, prev
from cprm_gym.errors import ParameterError

STAYS = {("no", "no"): (0.9, 0.1), ("yes", "no"): (0.3, 0.7), ("no", "yes"): (0.1, 0.9), ("yes", "yes"): (0.8, 0.2)}
"""The light after (the light before, whether the switch was pressed)."""
SEEN = {"no": (0.8, 0.2), "yes": (0.1, 0.9)}
LAMP = PRMClass(
    "Lamp",
    given=(Given("pressed", ("no", "yes"), default="no"),),
    attributes=(
        Attribute("on", ("no", "yes"), parents=(prev("on"), "pressed"), initial=Table({(): (0.6, 0.4)}), cpd=Table(STAYS)),
        Attribute("seen", ("no", "yes"), parents=("on",), cpd=Table(SEEN)),
    ),
)  # fmt: skip
HELD = Relation("held", roles=(("l", "Lamp"),), changes=(Replace("l.on", (prev("l.on"),), Table({"no": (1.0, 0.0), "yes": (0.0, 1.0)})),))
ROOM = Model("room", classes=(LAMP,), relations=(HELD,))
NET = PetriNet(
    "room",
    places=(
        Input("looked", observes="looked"), Input("worried", observes="worried"), Place("idle", capacity=1, tokens=1),
        Place("asking", capacity=1), Belief("on", variable="lamp.on", view="probability", state="yes"),
    ),
    transitions=(
        Transition("ask", ("idle",), ("asking",), tests={"worried": 1}),
        Transition("rest", ("asking",), ("idle",), inhibitors={"worried": 1}),
    ),
)  # fmt: skip
READ = (Observe("lamp.seen", "seen", when="looked"), Observe("lamp.pressed", "pressed"))
LAMPS = CPRM("room", NET, ROOM, {"lamp": "Lamp"}, observations=READ)
SEPARATE = replace(LAMPS, net=replace(NET, places=(*NET.places[:-1], replace(NET.places[-1], variable="lit", state="yes"))),
                   events=(Event("lit", {"lamp.on": "yes"}),))  # fmt: skip


def percepts(count, agents, seed=5):
    draws = np.random.default_rng(seed)
    names = ("looked", "seen", "pressed", "worried")
    return [dict(zip(names, (draws.random((4, agents)) < 0.4).astype(float))) for _ in range(count)]


def believed(told, agent, inferred, now, period=1):
    """P(on) now, by the forward algorithm: readings up to the cycle `inferred`, and from then on only what was pressed."""
    p = None
    for cycle in range(0, now + 1, period):
        row = {name: bool(values[agent]) for name, values in told[cycle].items()}
        pressed = "yes" if row["pressed"] else "no"
        p = 0.4 if p is None else p * STAYS["yes", pressed][1] + (1 - p) * STAYS["no", pressed][1]
        if cycle <= inferred and row["looked"]:
            like = [SEEN[state][int(row["seen"])] for state in ("yes", "no")]
            p = p * like[0] / (p * like[0] + (1 - p) * like[1])
    return p


@pytest.mark.parametrize("cprm", [LAMPS, SEPARATE], ids=["bank", "separate"])
@pytest.mark.parametrize(("t_b", "latency"), [(1, 0), (1, 3), (2, 0), (3, 1), (2, 5), (5, 5), (10, 10)])
def test_what_is_believed_is_the_last_inference_that_has_come_carried_on_to_now(cprm, t_b, latency):
    told = percepts(26, 3)
    runner = CPRMRunner(cprm, 3, t_b=t_b, latency=latency)
    for now, row in enumerate(told):
        runner.step(row)
        inferred = (now - latency) // t_b * t_b if now >= latency else -1
        expected = [believed(told, k, inferred, now) for k in range(3)]
        assert runner.executor.read("on") == pytest.approx(expected, abs=1e-9), now


def test_a_switch_pressed_between_inferences_is_not_lost():
    told = [{"looked": np.zeros(1), "seen": np.zeros(1), "pressed": np.array([float(k == 2)]), "worried": np.zeros(1)} for k in range(9)]
    found = {}
    for name, timing in {"at once": {}, "slow": {"t_b": 4, "latency": 2}}.items():
        runner = CPRMRunner(LAMPS, **timing)
        for row in told:
            runner.step(row)
        found[name] = runner.executor.read("on")[0]
    assert found["slow"] == pytest.approx(found["at once"], abs=1e-12)
    assert found["at once"] != pytest.approx(believed([{**row, "pressed": np.zeros(1)} for row in told], 0, -1, 8), abs=1e-3)


@pytest.mark.parametrize("cprm", [LAMPS, SEPARATE], ids=["bank", "separate"])
def test_agents_that_begin_anew_have_a_beat_of_their_own(cprm):
    told = percepts(24, 3)
    batch = CPRMRunner(cprm, 3, t_b=3, latency=2)
    alone = [CPRMRunner(cprm, 1, t_b=3, latency=2) for _ in range(3)]
    for t, row in enumerate(told):
        if t in (4, 11):
            batch.reset(np.array([False, True, t == 11]))
            for k in (1, 2)[: 2 if t == 11 else 1]:
                alone[k].reset()
        batch.step(row)
        for k, one in enumerate(alone):
            one.step({name: values[k : k + 1] for name, values in row.items()})
            assert one.executor.read("on")[0] == pytest.approx(batch.executor.read("on")[k], abs=1e-12)


def test_a_transition_demands_an_inference_by_a_token():
    told = percepts(20, 2)
    runner = CPRMRunner(LAMPS, 2, t_b=8, latency=1, demand="asking")
    begun = [[], []]
    for now, row in enumerate(told):
        for k in range(2):
            if now % 8 == 0 or runner.executor.read("asking")[k] > 0:
                begun[k].append(now)
        runner.step(row)
        inferred = [max((b for b in begun[k] if b <= now - 1), default=-1) for k in range(2)]
        assert runner.executor.read("on") == pytest.approx([believed(told, k, inferred[k], now) for k in range(2)], abs=1e-9)
    assert all(any(b % 8 for b in own) for own in begun)


def test_slices_of_several_cycles_are_inferred_whole():
    told = percepts(23, 2)
    runner = CPRMRunner(replace(LAMPS, period=2), 2, t_b=4, latency=3)
    for now, row in enumerate(told):
        runner.step(row)
        inferred = (now - 3) // 4 * 4 if now >= 3 else -1
        assert runner.executor.read("on") == pytest.approx([believed(told, k, inferred, now, 2) for k in range(2)], abs=1e-9)


def test_relations_hold_in_the_slices_in_which_they_were_asked_for():
    held = ObjectPlace("kept", "Lamp", Selection("Lamp", best="lamp.worth", where="lamp.worth > 0"))
    cprm = replace(LAMPS, net=replace(NET, places=(*NET.places, held)), clusters=(Cluster("held", ("kept",)),))
    told = percepts(14, 2)
    worth = (np.random.default_rng(2).random((14, 2, 1)) < 0.5).astype(float)
    slow, quick = CPRMRunner(cprm, 2, t_b=3, latency=0), CPRMRunner(cprm, 2)
    for now, row in enumerate(told):
        slow.step(row, {"Lamp": {"worth": worth[now]}})
        quick.step(row, {"Lamp": {"worth": worth[now]}})
        if now % 3 == 0:
            assert slow.executor.read("on") == pytest.approx(quick.executor.read("on"), abs=1e-9)


@pytest.mark.parametrize(
    ("cprm", "options", "message"),
    [
        (LAMPS, {"t_b": 0}, "t_b: 0 given, a whole number of cycles of at least 1"),
        (LAMPS, {"latency": -1}, "latency: -1 given"),
        (LAMPS, {"latency": 1.5}, "latency: 1.5 given"),
        (replace(LAMPS, period=2), {"t_b": 3}, "t_b: 3 given, a multiple of the model's slice, 2 cycles"),
        (CPRM("bare", PetriNet("bare", places=(Place("p"),))), {"latency": 2}, "it has no model"),
    ],
)
def test_timing_that_makes_no_sense_is_refused(cprm, options, message):
    with pytest.raises(ParameterError, match=message):
        CPRMRunner(cprm, **options)
