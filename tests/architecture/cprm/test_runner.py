"""The coupling: variables as places, places as variables, relations that follow objects; nothing here knows soccer."""

import numpy as np
import pytest

from cprm_gym.architecture.cprm import CPRM, Cluster, CPRMRunner, Observe, cprm_from_json, cprm_to_json, load_cprm, save_cprm
from cprm_gym.architecture.cprm.runner import check_options
from cprm_gym.architecture.petri import Belief, Command, Input, Math, ObjectPlace, PetriNet, Place, Selection, Transition
from cprm_gym.architecture.prm.inference.engines.projection import ProjectionEngine
from cprm_gym.architecture.prm.model.cpds import Prior, Table
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, PRMClass, Relation, Replace, prev
from cprm_gym.errors import FormatError, ModelError, NetError, ParameterError

# the umbrella world (Russell and Norvig): rain is hidden, an umbrella is seen
WEATHER = Model(
    "weather",
    classes=(
        PRMClass(
            "Day",
            attributes=(
                Attribute("rain", ("no", "yes"), parents=(prev("rain"),), initial=Table({(): (0.5, 0.5)}),
                          cpd=Table({("no",): (0.7, 0.3), ("yes",): (0.3, 0.7)})),
                Attribute("umbrella", ("no", "yes"), parents=("rain",), cpd=Table({("no",): (0.8, 0.2), ("yes",): (0.1, 0.9)})),
            ),
        ),
    ),
)  # fmt: skip

COAT_NET = PetriNet(
    "coat",
    places=(
        Place("ready", capacity=1, tokens=1), Place("done", capacity=1), Place("worn", capacity=1),
        Input("looked", observes="looked"),
        Belief("rain", variable="day.rain", view="probability", state="yes"),
        Math("certainty", "abs(rain - 0.5)"),
    ),
    transitions=(
        Transition("wear", ("ready",), ("done", "worn"), tests={"rain": 0.8}, inhibitors=("worn",),
                   emits=Command("coat", on=1, sure="certainty")),
        Transition("take_off", ("ready", "worn"), ("done",), inhibitors={"rain": 0.4}, emits=Command("coat", on=0, sure="certainty")),
        Transition("leave_it", ("ready",), ("done",), priority=-1),
        Transition("next", ("done",), ("ready",), delay=1),
    ),
)  # fmt: skip

COAT = CPRM("coat", COAT_NET, WEATHER, {"day": "Day"}, observations=(Observe("day.umbrella", "umbrella", when="looked"),))


def filtered(readings):
    """P(rain) after each reading (None: not looked), by the forward algorithm."""
    p, out = 0.5, []
    for i, reading in enumerate(readings):
        if i:
            p = 0.7 * p + 0.3 * (1 - p)
        if reading is not None:
            like = (0.9, 0.2) if reading else (0.1, 0.8)
            p = p * like[0] / (p * like[0] + (1 - p) * like[1])
        out.append(p)
    return out


def test_a_belief_place_holds_the_filtered_probability():
    readings = [True, True, None, None, False, None, True]
    controller = CPRMRunner(COAT)
    for reading, expected in zip(readings, filtered(readings)):
        controller.step({"looked": float(reading is not None), "umbrella": float(bool(reading))})
        assert controller.executor.read("rain")[0] == pytest.approx(expected, abs=1e-12)
    assert filtered([True, True])[-1] == pytest.approx(0.883, abs=1e-3), "the published value"


def test_the_net_acts_on_the_belief_and_reads_parameters_from_places():
    controller = CPRMRunner(COAT)
    seen = []
    for reading in (True, True, False, False):
        commands = controller.step({"looked": 1.0, "umbrella": float(reading)})
        seen.append({k: round(v, 6) for k, v in commands.of(0)["coat"].items()} if commands.fired["coat"][0] else None)
    expected = filtered([True, True, False, False])
    assert [s and s["on"] for s in seen] == [1, None, 0, None]
    assert seen[0]["sure"] == pytest.approx(abs(expected[0] - 0.5), abs=1e-6)


def test_agents_in_a_batch_are_independent_and_can_begin_anew():
    draws = np.random.default_rng(4)
    readings = draws.integers(0, 2, (30, 5)).astype(float)
    looked = draws.integers(0, 2, (30, 5)).astype(float)
    batch = CPRMRunner(COAT, batch=5)
    alone = [CPRMRunner(COAT) for _ in range(5)]
    for t in range(30):
        if t == 15:
            batch.reset(np.array([False, True, False, False, True]))
            for k in (1, 4):
                alone[k] = CPRMRunner(COAT)
        batch.step({"looked": looked[t], "umbrella": readings[t]})
        for k, one in enumerate(alone):
            one.step({"looked": looked[t, k], "umbrella": readings[t, k]})
            assert one.executor.marking[0] == pytest.approx(batch.executor.marking[k], abs=1e-12)


def test_inference_every_second_cycle_leaves_the_belief_in_between():
    from dataclasses import replace

    slow = CPRMRunner(replace(COAT, period=2))
    beliefs = []
    for _ in range(6):
        slow.step({"looked": 1.0, "umbrella": 1.0})
        beliefs.append(slow.executor.read("rain")[0])
    assert beliefs[0::2] == pytest.approx(filtered([True] * 3))
    assert beliefs[1::2] == beliefs[0::2]


def test_of_two_observations_of_one_variable_the_one_that_sees_counts():
    """The second one wiped out what the first had seen, where it saw nothing itself."""
    from dataclasses import replace

    both = (Observe("day.umbrella", "umbrella", when="looked"), Observe("day.umbrella", "1 - umbrella", when="not looked"))
    runner = CPRMRunner(replace(COAT, observations=both), batch=2)
    runner.step({"looked": np.array([1.0, 0.0]), "umbrella": np.array([1.0, 0.0])})
    assert runner.executor.read("rain") == pytest.approx(filtered([True]) * 2)


def test_a_decision_can_be_explained():
    controller = CPRMRunner(COAT, trace=True)
    controller.step({"looked": 1.0, "umbrella": 1.0})
    decision = controller.explain()
    assert decision.percepts == {"looked": 1.0, "umbrella": 1.0}
    assert decision.evidence == {"day.umbrella": 1.0}
    assert decision.beliefs["rain"] == pytest.approx(filtered([True])[0])
    assert decision.fired == ("wear",)
    assert "leave_it" in decision.enabled
    assert decision.commands["coat"]["on"] == 1
    controller.step({"looked": 0.0, "umbrella": 1.0})
    assert controller.explain().evidence == {"day.umbrella": None}
    assert controller.explain().fired == ("next", "leave_it")


# ---------------------------------------------------------------------- objects and relations

# doors that are usually shut; a watched door is seen, and while it is watched its state carries over from slice to slice
DOORS = Model(
    "doors",
    classes=(
        PRMClass(
            "Door",
            attributes=(
                Attribute("open", ("no", "yes"), cpd=Prior((0.9, 0.1))),
                Attribute("light", ("no", "yes"), parents=("open",), cpd=Table({("no",): (0.8, 0.2), ("yes",): (0.3, 0.7)})),
            ),
        ),
    ),
    relations=(
        Relation(
            "watched", {"d": "Door"},
            changes=(Replace("d.open", parents=("prev.d.open",), cpd=Table({("no",): (0.95, 0.05), ("yes",): (0.05, 0.95)})),),
        ),
    ),
)  # fmt: skip

GUARD_NET = PetriNet(
    "guard",
    places=(
        ObjectPlace("target", "Door", select=Selection("Door", best="door.importance")),
        Belief("target_open", variable="target.open", view="probability", state="yes"),
    ),
)

GUARD = CPRM(
    "guard", GUARD_NET, DOORS, {"north": "Door", "south": "Door"},
    observations=(Observe("north.light", "north"), Observe("south.light", "south")),
    clusters=(Cluster("watched", ("target",)),),
)  # fmt: skip


def test_a_relation_follows_the_object_in_its_place():
    guard = CPRMRunner(GUARD, batch=2)
    importance = {"Door": {"importance": np.array([[1.0, 2.0], [5.0, 2.0]])}}
    lights = {"north": np.array([1.0, 1.0]), "south": np.array([1.0, 1.0])}
    guard.step(lights, importance)
    assert guard.executor.holds("target").tolist() == [1, 0], "the most important door is selected"
    for _ in range(4):
        guard.step(lights, importance)
    assert guard.relations(0) == ("watched(south)",)
    assert guard.relations(1) == ("watched(north)",)
    # watched: a state that persists, lit five times, is almost surely open; unwatched doors stay at prior x light
    unwatched = 0.1 * 0.7 / (0.1 * 0.7 + 0.9 * 0.2)
    for copy, watched, other in ((0, "south", "north"), (1, "north", "south")):
        result = guard.bank.alone(copy).predict(1)
        assert set(result) >= {"north.open", "south.open"}
        assert guard.executor.read("target_open")[copy] > 0.9
        posterior = guard.bank.alone(copy).step({"north.light": 1, "south.light": 1}, relations=(f"watched({watched})",))
        assert posterior[f"{other}.open"][0, 1] == pytest.approx(unwatched, abs=1e-12)


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"observations": (Observe("day.umbrela", "x"),)}, ModelError, r"unknown variable 'day.umbrela'. Did you mean 'day.umbrella'\?"),
        ({"objects": {"day": "Night"}}, ModelError, "unknown class 'Night'"),
        ({"period": 0}, ModelError, "`period` is a number of cycles from 1, got 0"),
        ({"model": None, "observations": ()}, ModelError, "need a model, and there is none"),
        ({"clusters": (Cluster("holds", ("worn",)),)}, ModelError, "cluster of unknown relation 'holds'"),
    ],
)
def test_links_to_what_is_not_there_are_refused(changes, error, message):
    parts = {"name": "coat", "net": COAT_NET, "model": WEATHER, "objects": {"day": "Day"}, "observations": COAT.observations}
    with pytest.raises(error, match=message):
        CPRM(**{**parts, **changes})


def test_a_cluster_needs_object_places():
    with pytest.raises(NetError, match="names 'goal', which is not an object place"):
        CPRM("guard", GUARD_NET, DOORS, {"north": "Door"}, clusters=(Cluster("watched", ("goal",)),))
    with pytest.raises(ModelError, match="has 1 roles, its cluster names 2 places"):
        CPRM("guard", GUARD_NET, DOORS, {"north": "Door"}, clusters=(Cluster("watched", ("target", "target")),))
    with pytest.raises(ModelError, match="takes a tuple, got the string 'target'"):
        Cluster("watched", "target")


def test_a_missing_percept_is_named():
    with pytest.raises(NetError, match="observes 'looked'; the percepts are umbrella"):
        CPRMRunner(COAT).step({"umbrella": 1.0})
    with pytest.raises(NetError, match="'umbrella' is neither a percept nor a place"):
        CPRMRunner(COAT).step({"looked": 1.0})


def test_nothing_can_be_explained_before_the_first_cycle():
    with pytest.raises(NetError, match="no decision of agent 0"):
        CPRMRunner(COAT).explain()


@pytest.mark.parametrize("cprm", [COAT, GUARD], ids=["coat", "guard"])
def test_json_gives_an_equal_value_back(cprm):
    again = cprm_from_json(cprm_to_json(cprm))
    assert again == cprm
    assert cprm_to_json(again) == cprm_to_json(cprm)


def test_a_cprm_is_written_to_a_file_and_read_back(tmp_path):
    save_cprm(GUARD, tmp_path / "guard.json")
    assert load_cprm(tmp_path / "guard.json") == GUARD
    with pytest.raises(FormatError, match=r"none\.json: cannot be read"):
        load_cprm(tmp_path / "none.json")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "file: not JSON"),
        ("[" * 200_000, "file: nested too deeply"),
        ("[]", "not a document of the format 'cprm_gym cprm'"),
        ('{"format": "cprm_gym cprm", "version": 9}', "version 9 is not known; known is 1"),
        ('{"format": "cprm_gym cprm", "version": 1, "name": "x"}', "a part is missing"),
    ],
)
def test_other_texts_are_refused(text, message):
    with pytest.raises(FormatError, match=message):
        cprm_from_json(text, "file")


def test_the_faces_of_nets_and_models_have_no_name_in_common():
    import cprm_gym.architecture.petri as petri
    import cprm_gym.architecture.prm as prm

    assert not set(petri.__all__) & set(prm.__all__)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"engine": "exakt"}, r"unknown engine 'exakt'\. Did you mean 'exact'"),
        ({"engine": 5}, "unknown engine 5"),
        ({"engine": None}, "unknown engine None"),
        ({"deep": "exakt"}, "unknown engine 'exakt'"),
        ({"on_impossible": "restrat"}, "Did you mean 'restart'"),
        ({"engin": "exact"}, r"no option 'engin'\. Did you mean 'engine'"),
        ({"seed": 3}, "no option 'seed'"),
    ],
)
def test_options_that_there_are_not_are_refused_before_a_runner_is_made(options, message):
    with pytest.raises(ParameterError, match=message):
        check_options(options, taken=("seed",))


def test_options_that_there_are_are_taken():
    check_options({"engine": "projection", "deep": None, "every": 3, "trace": True, "on_impossible": "drop"})
    check_options({"engine": ProjectionEngine(), "deep": "exact"})
