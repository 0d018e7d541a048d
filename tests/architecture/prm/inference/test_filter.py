"""The filter as an object: batches, relations, snapshots, faults, costs."""

from __future__ import annotations

import numpy as np
import pytest
from ball_world import scene as goalie_scene
from inference_cases import Schedule, load
from inference_scene import Active, Scene
from inference_worlds import RandomWorld, table, unrolled_joint

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, Grounds, GroundSlice, GroundVariable
from cprm_gym.architecture.prm.inference.evidence import StateRows
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.architecture.prm.model.domains import Index
from cprm_gym.errors import CostError, EvidenceError, ImpossibleEvidence, ModelError, ParameterError


def umbrella(**options) -> Filter:
    """Rain and umbrella, the relation says whether the chain goes on."""
    return Filter(Schedule(load("d01_umbrella")), **options)


class Fixed(Grounds):
    """Two slices, made by hand."""

    def __init__(self, first: GroundSlice, later: GroundSlice) -> None:
        self.slices = {True: first, False: later}

    def ground(self, relations=(), first=False):
        return relations if isinstance(relations, GroundSlice) else self.slices[first]


def rotation() -> Fixed:
    """A token that goes round four places, each step for certain, and a reading that may be one place off."""
    case = load("d12_impossible")
    schedule = Schedule(case)
    return Fixed(schedule.slices["prior"], schedule.slices["step"])


# ------------------------------------------------------------------------------------------------------ patterns and plans


def test_missing_readings_never_compile_a_new_plan():
    scene = Scene(5, opponents=2)
    filter_ = Filter(scene, batch=3)
    rng = np.random.default_rng(0)
    active = scene.all_attended()
    for _ in range(4):
        filter_.step(scene.readings(rng, 3), relations=active)
    compiled = filter_.engine.compiler.compiled
    for _ in range(20):
        evidence = scene.readings(rng, 3)
        evidence = {n: np.where(rng.random(3) < 0.5, v, -1) if "obs" in n else v for n, v in evidence.items()}
        filter_.step(evidence, relations=active)
    assert filter_.engine.compiler.compiled == compiled


def test_objects_of_the_same_class_run_as_one_batch():
    scene = Scene(4, opponents=11)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    for _ in range(3):
        filter_.step(scene.readings(rng), relations=scene.all_attended())
    costs = filter_.cost(scene.all_attended())
    assert sorted(c.objects for c in costs) == [11, 12, 12]


def test_a_relation_that_was_on_before_needs_no_new_plan():
    scene = Scene(3, opponents=2)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    pattern = [scene.all_attended(), Active(("o1",)), Active(("o1",), "o1")]

    def around():
        for active in pattern:
            for _ in range(3):
                filter_.step(scene.readings(rng), relations=active)

    filter_.step(scene.readings(rng))
    around()
    around()
    compiled, made = filter_.engine.compiler.compiled, len(filter_.engine.compiler.slice_steps)
    around()
    assert filter_.engine.compiler.compiled == compiled
    assert len(filter_.engine.compiler.slice_steps) == made


def test_cost_grows_linearly_with_unattended_opponents():
    totals = []
    for opponents in (5, 10, 20):
        scene = Scene(6, opponents)
        filter_ = Filter(scene)
        rng = np.random.default_rng(0)
        for _ in range(3):
            filter_.step(scene.readings(rng))
        totals.append(sum(c.flops for c in filter_.cost()))
    assert totals[2] - totals[1] == pytest.approx(2 * (totals[1] - totals[0]))


def test_cost_is_known_before_the_step_and_a_step_beyond_the_memory_is_refused():
    scene = Scene(10, opponents=1)
    filter_ = Filter(scene, memory_limit=1e8)
    rng = np.random.default_rng(0)
    held = Active(("o1",), "o1")
    filter_.step(scene.readings(rng))
    for _ in range(2):
        filter_.step(scene.readings(rng), relations=held)
    before = filter_.state
    costs = filter_.cost(Active(("o1",)))
    assert costs[0].largest >= 8e8
    assert costs[0].bytes > 6e9
    with pytest.raises(CostError, match="GiB"):
        filter_.step(scene.readings(rng), relations=Active(("o1",)))
    assert filter_.state.belief is before.belief
    filter_.step(scene.readings(rng), relations=held)


def test_a_variable_that_becomes_a_parent_in_time_later_is_brought_back():
    """A hidden chain without readings: at slice 0 nothing says that the next slice will need it."""
    x, y = (GroundVariable(n, ("a", "b")) for n in "xy")
    first = GroundSlice({"x": x}, (GroundCPD("x", (), np.array([0.2, 0.8]), "x0"),))
    move = np.array([[0.9, 0.1], [0.3, 0.7]])
    later = GroundSlice({"x": x, "y": y}, (GroundCPD("x", (("x", 1),), move, "x"), GroundCPD("y", (("x", 0),), move, "y")))
    filter_ = Filter(Fixed(first, later))
    filter_.step()
    result = filter_.step({"y": 1})
    expected = np.array([0.2, 0.8]) @ move * move[:, 1]
    np.testing.assert_allclose(result["x"][0], expected / expected.sum(), atol=1e-12)


def test_an_atemporal_parent_is_learned_about_for_ever():
    rng = np.random.default_rng(3)
    bias = GroundVariable("bias", ("fair", "loaded"))
    coin = GroundVariable("coin", ("heads", "tails"))
    toss = np.array([[0.5, 0.5], [0.8, 0.2]])
    prior = np.array([0.7, 0.3])
    first = GroundSlice({"bias": bias, "coin": coin}, (GroundCPD("bias", (), prior, "b"), GroundCPD("coin", (("bias", 0),), toss, "c0")))
    later = GroundSlice({"coin": coin}, (GroundCPD("coin", (("bias", -1),), toss, "c"),))
    filter_ = Filter(Fixed(first, later), window=6)
    belief = prior
    for coin_state in rng.integers(0, 2, 6):
        result = filter_.step({"coin": int(coin_state)})
        belief = belief * toss[:, coin_state]
        np.testing.assert_allclose(result["bias"][0], belief / belief.sum(), atol=1e-12)
    assert result.log_likelihood[0] == pytest.approx(np.log(belief.sum()), abs=1e-12)
    np.testing.assert_allclose(filter_.smooth()[0]["bias"][0], belief / belief.sum(), atol=1e-12)


def test_a_model_with_classes_is_filtered_and_new_relations_need_no_telling():
    grounding = goalie_scene(bins=4, opponents=2)
    filter_ = Filter(grounding, batch=2, window=4)
    for relations in ((), ("attended(o1)",), ("attended(o1)", "possesses(o1,ball)"), ("attended(o1)",)):
        result = filter_.step({"ball.seen": "yes", "ball.obs_dist": np.array([3.0, 12.0])}, relations=relations)
    assert result.exact
    np.testing.assert_allclose(result["ball.dist"].sum(axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(filter_.smooth()[-1]["o1.dist"], result["o1.dist"], atol=1e-10)


# ------------------------------------------------------------------------------------------------------ agents


@pytest.mark.parametrize("engine", ["exact", "projection"])
def test_agents_that_begin_anew_are_new_filters(engine):
    world = RandomWorld(5, static=False)
    rng = np.random.default_rng(0)
    width = 4
    batch = Filter(world, batch=width, engine=engine)
    alone = [Filter(world) for _ in range(width)]
    for t in range(8):
        active = (int(t % 5),) if t else ()
        evidence = {n: rng.integers(0, v.card, width) for n, v in world.ground().variables.items() if "obs" in n or n in world.given}
        if t in (3, 5):
            mask = rng.random(width) < 0.5
            batch.reset(mask)
            for w in np.flatnonzero(mask):
                alone[w].reset()
        result = batch.step(evidence, relations=active)
        for w, one in enumerate(alone):
            single = one.step({n: int(v[w]) for n, v in evidence.items()}, relations=active)
            assert result.log_likelihood[w] == pytest.approx(single.log_likelihood[0], abs=1e-10)
            for name in result:
                np.testing.assert_allclose(result[name][w], single[name][0], atol=1e-10)
            np.testing.assert_allclose(result.joint("x0.p", "x1.q")[w], single.joint("x0.p", "x1.q")[0], atol=1e-10)


def test_a_snapshot_is_the_whole_state():
    filter_ = umbrella(batch=2, window=3)
    filter_.step(relations="prior")
    filter_.step({"umb": [0, 1]}, relations="step")
    kept = filter_.state
    first = filter_.step({"umb": 1}, relations="step")
    filter_.step({"umb": 0}, relations="step")
    filter_.state = kept
    again = filter_.step({"umb": 1}, relations="step")
    np.testing.assert_array_equal(first["rain"], again["rain"])
    np.testing.assert_array_equal(first.log_likelihood, again.log_likelihood)
    assert again.step == 2


def test_prediction_leaves_the_filter_where_it_is():
    filter_ = umbrella()
    filter_.step(relations="prior")
    filter_.step({"umb": 1}, relations="step")
    belief = filter_.state.belief
    ahead = filter_.predict(50, relations="step")
    np.testing.assert_allclose(ahead["rain"], 0.5, atol=1e-12)
    assert filter_.state.belief is belief
    assert filter_.step_count == 2


# ------------------------------------------------------------------------------------------------------ evidence


def test_a_number_falls_into_its_bin_and_an_angle_goes_round():
    edges = np.array([0.0, 1.0, 3.0, 6.0])
    names = {
        "d": GroundVariable("d", ("a", "b", "c"), edges),
        "a": GroundVariable("a", ("w", "n", "e"), np.array([-3.0, -1.0, 1.0, 3.0]), circular=True),
    }
    uniform = np.full(3, 1 / 3)
    slice_ = GroundSlice(names, (GroundCPD("d", (), uniform, 0), GroundCPD("a", (), uniform, 0)))
    filter_ = Filter(Fixed(slice_, slice_), batch=4)
    result = filter_.step({"d": np.array([0.0, 1.0, 5.9, 6.0]), "a": np.array([3.5, -2.5, 0.0, 8.9])})
    np.testing.assert_array_equal(result["d"].argmax(axis=1), [0, 1, 2, 2])
    np.testing.assert_array_equal(result["a"].argmax(axis=1), [0, 0, 1, 2])
    for wrong, match in ((np.inf, "'d'.*inf is not a finite"), (7, "'d'.*outside"), (7.0, "'d'.*outside"), (-0.1, "'d'.*outside")):
        with pytest.raises(EvidenceError, match=match):
            filter_.step({"d": wrong})
    with pytest.raises(EvidenceError, match="'d'"):
        filter_.step({"d": np.array([0.5, np.nan, 1.0, -1.0])})
    masked = np.ma.masked_array([0.5, np.nan, 1.0, 1.0], mask=[False, True, False, False])
    for unseen in (masked, np.array([0.5, np.nan, 1.0, 1.0]), [0.5, None, 1, 1], Index(np.array([0, -1, 1, 1]))):
        np.testing.assert_allclose(filter_.step({"d": unseen})["d"][1], uniform)


def test_an_integer_given_to_bins_is_a_quantity_and_an_index_says_that_it_is_one():
    """`5` was bin 5 and `5.0` the bin that holds 5 m; -1 was "not observed" where -1.0 was a quantity."""
    edges = np.array([-10.0, 0.0, 1.0, 3.0, 6.0])
    variables = {"d": GroundVariable("d", tuple("abcd"), edges)}
    slice_ = GroundSlice(variables, (GroundCPD("d", (), np.full(4, 0.25), 0),))
    filter_ = Filter(Fixed(slice_, slice_), batch=2)
    for value, bins in (
        (5, [3, 3]),
        (np.int64(5), [3, 3]),
        (-1, [0, 0]),
        (np.array([2, -1]), [2, 0]),
        ([2, -1], [2, 0]),
        (Index(1), [1, 1]),
        (Index(np.array([3, 1])), [3, 1]),
        (StateRows(("d",), np.array([[3, 1]])), [3, 1]),
        (np.array([[3, 1]]), [3, 1]),
    ):
        evidence = value if isinstance(value, StateRows) or np.ndim(value) == 2 else {"d": value}
        assert filter_.step(evidence)["d"].argmax(axis=1).tolist() == bins


@pytest.mark.parametrize("binned", [False, True])
@pytest.mark.parametrize(
    "value",
    [
        [],
        {},
        set(),
        2**80,
        -(2**80),
        [10**5000],
        [2**80],
        1e400,
        [[1, 2], [3]],
        [[0]],
        ["x", 1],
        b"a",
        1j,
        object,
        Index(9),
        Index(np.array([7])),
    ],
)
def test_a_value_that_is_none_is_an_error_of_ours_that_names_the_variable(value, binned):
    variables = {"d": GroundVariable("d", ("a", "b"), np.array([0.0, 1.0, 2.0]) if binned else None)}
    filter_ = Filter(Fixed(*[GroundSlice(variables, (GroundCPD("d", (), np.full(2, 0.5), 0),))] * 2), batch=2)
    with pytest.raises(EvidenceError, match="'d'"):
        filter_.step({"d": value})


def test_evidence_nested_beyond_reason_is_refused():
    deep = []
    for _ in range(100_000):
        deep = [deep]
    with pytest.raises(EvidenceError, match="evidence for 'umb': got a list"):
        umbrella().step({"umb": deep}, relations="prior")


def test_evidence_that_is_no_mapping_is_refused():
    for evidence in ([1], "umb", 3, np.array([0.5])):
        with pytest.raises(EvidenceError, match="evidence"):
            umbrella().step(evidence, relations="prior")
    with pytest.raises(EvidenceError, match="soft evidence"):
        umbrella().step({}, soft=[1.0, 2.0], relations="prior")
    with pytest.raises(EvidenceError, match="soft evidence for 'umb'"):
        umbrella().step({}, soft={"umb": ["a", "b"]}, relations="prior")
    with pytest.raises(EvidenceError, match="an Index is an integer"):
        Index(0.5)


def test_wrong_observations_are_refused_by_name_and_change_nothing():
    filter_ = umbrella(batch=2)
    filter_.step(relations="prior")
    before = filter_.state
    wrong = [
        ({"umb": 2}, "'umb': 2 is no state"),
        ({"umb": -2}, "'umb'"),
        ({"umb": [0, 5]}, "'umb': 5"),
        ({"umb": "wet"}, "'umb': unknown state 'wet'"),
        ({"umbr": 1}, "'umbr'.*umb"),
        ({"umb": [0, 1, 0]}, "'umb' has shape"),
        ({"umb": 0.5}, "'umb'.*names"),
        ({"umb": object()}, "'umb'"),
    ]
    for evidence, match in wrong:
        with pytest.raises(EvidenceError, match=match):
            filter_.step(evidence, relations="step")
    for soft, match in [
        ({"umb": [1.0]}, "shape"),
        ({"umb": [-1.0, 1.0]}, "negative"),
        ({"umb": [np.nan, 1.0]}, "finite"),
        ({"u": [1, 1]}, "'u'"),
    ]:
        with pytest.raises(EvidenceError, match=match):
            filter_.step({}, soft=soft, relations="step")
    assert filter_.state.belief is before.belief
    assert filter_.step_count == 1


def test_evidence_may_be_an_array_in_the_order_of_the_variables():
    one, other = umbrella(batch=3), umbrella(batch=3)
    for filter_ in (one, other):
        filter_.step(relations="prior")
    hard = np.full((2, 3), -1)
    hard[one.variables("step").index("umb")] = [0, 1, -1]
    np.testing.assert_array_equal(one.step(hard, relations="step")["rain"], other.step({"umb": [0, 1, None]}, relations="step")["rain"])
    with pytest.raises(EvidenceError, match="shape"):
        one.step(hard[:1], relations="step")


def test_an_unknown_name_in_a_question_is_answered_with_the_nearest():
    filter_ = umbrella()
    result = filter_.step(relations="prior")
    with pytest.raises(ModelError, match=r"'rian'.*'rain'"):
        result["rian"]
    with pytest.raises(ModelError, match="'um'"):
        result.joint("rain", "um")
    with pytest.raises(ModelError, match="twice"):
        result.joint("rain", "rain")


@pytest.mark.parametrize(
    "wrong", [{"batch": 0}, {"on_impossible": "ignore"}, {"eps": 0.0}, {"engine": "exakt"}, {"particles": 5}, {"threads": 0}]
)
def test_wrong_settings_are_refused(wrong):
    with pytest.raises(ParameterError):
        umbrella(**wrong)


def test_jeffrey_demands_a_posterior_and_pearl_weighs_it():
    filter_ = umbrella(batch=2)
    filter_.step(relations="prior")
    soft = filter_.jeffrey({"rain": [0.3, 0.7]})
    np.testing.assert_allclose(filter_.step({}, soft=soft, relations="step")["rain"], [[0.3, 0.7]] * 2, atol=1e-12)
    pearl = umbrella()
    pearl.step(relations="prior")
    doubled = pearl.step({}, soft={"rain": [0.6, 1.4]}, relations="step")
    np.testing.assert_allclose(doubled["rain"], [[0.3, 0.7]], atol=1e-12)
    assert doubled.increment[0] == pytest.approx(np.log(0.5 * 0.6 + 0.5 * 1.4))


def test_what_is_given_must_be_told():
    case = load("d10_places_observed")
    filter_ = Filter(Schedule(case, given=("pl", "tok")))
    with pytest.raises(EvidenceError, match="'tok' must be given"):
        filter_.step({"pl": 1}, relations="prior")
    with pytest.raises(EvidenceError, match="soft evidence for 'pl'"):
        filter_.step({"pl": 1, "tok": 0}, soft={"pl": [1.0, 2.0]}, relations="prior")


# ------------------------------------------------------------------------------------------------------ impossible evidence


def go_round(filter_: Filter, steps: int = 4) -> None:
    for t in range(steps):
        filter_.step({"pl": 0, "tok": 0, "obs": t} if t else {"pl": 0, "tok": 0})


def test_impossible_evidence_names_a_smallest_conflict_and_leaves_the_belief():
    filter_ = Filter(rotation(), batch=2)
    go_round(filter_)
    before = filter_.state.belief
    with pytest.raises(ImpossibleEvidence, match="obs = 3") as caught:
        filter_.step({"pl": 0, "tok": 0, "obs": [0, 3]})
    assert caught.value.conflict == ("obs",)
    assert caught.value.agents == (1,)
    assert caught.value.step == 4
    assert filter_.state.belief is before
    np.testing.assert_allclose(filter_.step({"pl": 0, "tok": 0, "obs": [0, 1]})["pos"], [[1, 0, 0, 0], [1, 0, 0, 0]])


def test_a_conflict_of_two_readings_names_both():
    x = GroundVariable("x", ("0", "1"))
    names = {"x": x, "a": GroundVariable("a", ("0", "1")), "b": GroundVariable("b", ("0", "1")), "c": GroundVariable("c", ("0", "1"))}
    copy = np.eye(2)
    cpds = (
        GroundCPD("x", (), np.array([0.5, 0.5]), 0),
        *(GroundCPD(n, (("x", 0),), copy if n != "c" else copy * 0 + 0.5, n) for n in "abc"),
    )
    slice_ = GroundSlice(names, cpds)
    with pytest.raises(ImpossibleEvidence) as caught:
        Filter(Fixed(slice_, slice_)).step({"a": 0, "b": 1, "c": 1})
    assert set(caught.value.conflict) == {"a", "b"}


def test_impossible_readings_are_dropped():
    filter_ = Filter(rotation(), batch=3, on_impossible="drop")
    go_round(filter_)
    result = filter_.step({"pl": 0, "tok": 0, "obs": [0, 3, 1]})
    np.testing.assert_allclose(result["pos"], [[1, 0, 0, 0]] * 3)
    np.testing.assert_array_equal(result.impossible, [False, True, False])
    np.testing.assert_array_equal(filter_.impossible_count, [0, 1, 0])
    assert np.isfinite(result.log_likelihood).all()


def test_impossible_readings_are_softened():
    filter_ = Filter(rotation(), batch=2, on_impossible="soften", eps=1e-3)
    go_round(filter_)
    before = filter_.log_likelihood[1]
    result = filter_.step({"pl": 0, "tok": 0, "obs": [0, 3]})
    np.testing.assert_allclose(result["pos"], [[1, 0, 0, 0]] * 2)
    assert result.increment[1] == pytest.approx(np.log(1 / 6 * 1e-3 / 4))
    assert before + result.increment[1] == pytest.approx(result.log_likelihood[1])


def test_impossible_readings_restart_the_agent_from_the_prior():
    filter_ = Filter(rotation(), batch=2, on_impossible="restart")
    go_round(filter_, 2)
    result = filter_.step({"pl": 0, "tok": 0, "obs": [2, 1]})
    fresh = Filter(rotation())
    expected = fresh.step({"pl": 0, "tok": 0, "obs": 1})
    np.testing.assert_allclose(result["pos"], [[0, 0, 1, 0], expected["pos"][0]])
    np.testing.assert_allclose(expected["pos"][0], [1 / 3, 2 / 3, 0, 0])
    follow = filter_.step({"pl": 0, "tok": 0, "obs": [3, 2]})
    np.testing.assert_allclose(follow["pos"], [[0, 0, 0, 1], fresh.step({"pl": 0, "tok": 0, "obs": 2})["pos"][0]])
    assert filter_.impossible_count.tolist() == [0, 1]


def test_a_restart_with_readings_that_even_the_prior_excludes_goes_without_them():
    filter_ = Filter(rotation(), batch=2, on_impossible="restart")
    go_round(filter_)
    result = filter_.step({"pl": 0, "tok": 0, "obs": [0, 3]})
    np.testing.assert_allclose(result["pos"][1], [0.5, 0.5, 0, 0])
    assert np.isfinite(result.log_likelihood).all()


@pytest.mark.parametrize("policy", ["drop", "soften", "restart"])
@pytest.mark.parametrize("seed", range(4))
def test_no_policy_ever_gives_a_nan(policy, seed):
    world = RandomWorld(seed, zeros=0.45)
    rng = np.random.default_rng(seed)
    filter_ = Filter(world, batch=3, on_impossible=policy)
    for t in range(6):
        evidence = {
            n: rng.integers(0, v.card, 3) for n, v in world.ground(first=t == 0).variables.items() if n in world.given or rng.random() < 0.6
        }
        result = filter_.step(evidence)
        assert np.isfinite(result.log_likelihood).all()
        for name in result:
            np.testing.assert_allclose(result[name].sum(axis=1), 1.0, atol=1e-9)


# ------------------------------------------------------------------------------------------------------ for ever


@pytest.mark.slow
def test_a_hundred_thousand_steps_lose_no_mass_and_do_not_slow_down_or_grow():
    import tracemalloc
    from time import process_time

    scene = Scene(10, opponents=0)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    readings = [scene.readings(rng) for _ in range(64)]
    spent, sizes = [], []
    tracemalloc.start()
    for block in range(10):
        begun = process_time()
        for t in range(10_000):
            result = filter_.step(readings[(7 * t + block) % 64])
        spent.append(process_time() - begun)
        sizes.append(tracemalloc.get_traced_memory()[0])
        for name in scene.hidden():
            assert abs(result[name].sum() - 1.0) < 1e-9
    tracemalloc.stop()
    assert sizes[-1] < sizes[1] + 50_000
    assert np.median(spent[-3:]) < 1.5 * np.median(spent[1:4])


def test_what_is_remembered_stays_bounded_when_names_come_and_go():
    card = ("0", "1")
    chain = np.array([[0.9, 0.1], [0.2, 0.8]])

    def slice_of(names, old):
        variables = {n: GroundVariable(n, card) for n in names}
        return GroundSlice(variables, tuple(GroundCPD(n, ((n, 1),) if n in old else (), chain if n in old else chain[0], 0) for n in names))

    filter_ = Filter(Fixed(slice_of(["a"], []), slice_of(["a"], ["a"])))
    filter_.step()
    old = ["a"]
    for t in range(1500):
        new = ["a", f"n{t}", f"n{t - 1}"][: 3 if t else 2]
        result = filter_.step(relations=slice_of(new, old))
        old = new
    assert result["a"].sum() == pytest.approx(1.0)
    compiler = filter_.engine.compiler
    assert len(compiler.slice_steps) <= 512
    assert len(compiler.layouts) <= 512
    assert compiler.compiled < 10


# ------------------------------------------------------------------------------------------------------ windows and beginnings


def test_a_window_does_not_reach_back_over_agents_that_began_anew():
    filter_ = umbrella(batch=2, window=10)
    filter_.step(relations="prior")
    filter_.step({"umb": 1}, relations="step")
    filter_.reset([0])
    filter_.step({"umb": 1}, relations="step")
    with pytest.raises(ParameterError, match="went on"):
        filter_.smooth()
    result = filter_.step({"umb": 0}, relations="step")
    smoothed = filter_.smooth()
    assert len(smoothed) == 1
    np.testing.assert_allclose(smoothed[0]["rain"], result["rain"], atol=1e-12)


def test_the_last_step_is_done_again_with_the_agents_that_began_anew():
    """A variable is found to be needed one step after some agents were reset."""
    world = RandomWorld(3, static=False)
    batch, alone = Filter(world, batch=2), [Filter(world), Filter(world)]
    rng = np.random.default_rng(0)
    names = [n for n in world.ground().variables if "obs" in n or n in world.given]
    for t in range(5):
        evidence = {n: rng.integers(0, 2, 2) for n in names}
        if t == 3:
            batch.reset([1])
            alone[1].reset()
            batch.engine.temporal = frozenset()
            batch.engine.compiler.slice_steps.clear()
            for info in batch.engine.store.infos.values():
                info._statuses.clear()
        result = batch.step(evidence)
        for w, one in enumerate(alone):
            single = one.step({n: int(v[w]) for n, v in evidence.items()})
            np.testing.assert_allclose(result["x1.p"][w], single["x1.p"][0], atol=1e-12)


def test_a_belief_is_projected_on_demand_and_says_what_it_lost():
    case = load("d07_entangle_min")
    filter_ = Filter(Schedule(case))
    for step, relations in list(zip(case["steps"], case["schedule"]))[:5]:
        result = filter_.step(step["evidence"], relations=relations)
    joint = result.joint("A", "B")[0]
    product = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0, keepdims=True)
    loss = filter_.project([("A",), ("B",)])
    assert loss[0] == pytest.approx((joint * np.log(joint / product)).sum(), abs=1e-12)
    result = filter_.step({}, relations="off")
    assert not result.exact
    after = result.joint("A", "B")[0]
    np.testing.assert_allclose(after, after.sum(axis=1, keepdims=True) * after.sum(axis=0, keepdims=True), atol=1e-14)
    with pytest.raises(ModelError, match="'C'"):
        filter_.project([("C",)])


# ------------------------------------------------------------------------------------------------------ what couples what


def test_possession_that_passes_on_entangles_both_players_through_the_ball():
    """p has the ball, then q, then nobody: p and q are dependent, exactly as in the unrolled net."""
    rng = np.random.default_rng(9)
    names = {n: GroundVariable(n, ("0", "1", "2")) for n in ("b", "p", "q", "sb", "sp", "sq")}
    tables = {k: table(rng, shape) for k, shape in {"prior": (3,), "move": (3, 3), "sense": (3, 3), "held": (3, 3, 3)}.items()}

    def slice_of(active, first):
        cpds = []
        for n in "bpq":
            parents = [] if first else [(n, 1)]
            if n == "b" and active and not first:
                parents.append((active, 0))
            key = "prior" if first else "held" if len(parents) == 2 else "move"
            cpds += [GroundCPD(n, tuple(parents), tables[key], key), GroundCPD(f"s{n}", ((n, 0),), tables["sense"], "sense")]
        return GroundSlice(names, tuple(cpds))

    made = {(a, f): slice_of(a, f) for a in ("", "p", "q") for f in (False, True)}

    class Passing(Grounds):
        def ground(self, relations="", first=False):
            return made[relations or "", first]

    filter_ = Filter(Passing())
    slices, hard = [], []
    dependence = []
    for t, active in enumerate(["", "", "p", "p", "q", "", ""]):
        evidence = {f"s{n}": int(rng.integers(0, 3)) for n in "bpq" if rng.random() < 0.6}
        slices.append(made[active, t == 0])
        hard.append(evidence)
        result = filter_.step(evidence, relations=active)
        joint = unrolled_joint(slices, hard, [{}] * 7, [("p", t), ("q", t)])
        np.testing.assert_allclose(result.joint("p", "q")[0], joint / joint.sum(), atol=1e-12)
        pq = joint / joint.sum()
        dependence.append(np.abs(pq - pq.sum(axis=1, keepdims=True) * pq.sum(axis=0, keepdims=True)).max())
    assert max(dependence[:4]) < 1e-12
    assert max(dependence[4:]) > 1e-5


def test_a_flag_that_depends_on_two_quantities_couples_all_four():
    scene = Scene(3, opponents=0, coupled=True)
    filter_ = Filter(scene, batch=2)
    rng = np.random.default_rng(0)
    slices, hard = [], [[], []]
    for t in range(4):
        evidence = scene.readings(rng, 2)
        if t == 2:
            evidence["b.seen"] = np.array([-1, 1])
            evidence["b.obs_dist"] = np.array([2, -1])
        slices.append(scene.ground(first=t == 0))
        for w in range(2):
            hard[w].append({n: int(v[w]) for n, v in evidence.items() if v[w] >= 0})
        result = filter_.step(evidence)
        for w in range(2):
            keep = [(f"b.{x}", t) for x in ("dist", "dir", "vdist", "vdir")]
            joint = unrolled_joint(slices, hard[w], [{}] * 4, keep)
            np.testing.assert_allclose(result.joint("b.dist", "b.dir", "b.vdist", "b.vdir")[w], joint / joint.sum(), atol=1e-12)
    assert filter_.cost()[0].largest >= 81


def test_prediction_without_readings_keeps_apart_what_only_readings_would_couple():
    scene = Scene(10, opponents=0)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    for _ in range(3):
        filter_.step(scene.readings(rng))
    assert max(c.largest for c in filter_.cost(evidence={})) == 100
    filter_.step({})
    assert max(c.largest for c in filter_.cost()) == 100


def test_an_observed_variable_can_be_a_parent_in_the_next_slice():
    """An action is observed now and moves the state later."""
    rng = np.random.default_rng(4)
    names = {n: GroundVariable(n, ("0", "1", "2")) for n in ("x", "a", "y")}
    move, prior, sense = table(rng, (3, 3, 3)), table(rng, (3,)), table(rng, (3, 3))
    common = (GroundCPD("a", (), prior, "a"), GroundCPD("y", (("x", 0),), sense, "y"))
    first = GroundSlice(names, (GroundCPD("x", (), prior, "x0"), *common))
    later = GroundSlice(names, (GroundCPD("x", (("x", 1), ("a", 1)), move, "x"), *common))
    filter_ = Filter(Fixed(first, later), batch=2)
    slices, hard = [], [[], []]
    for t in range(5):
        evidence = {"a": np.array([t % 3, -1 if t == 2 else 1]), "y": rng.integers(0, 3, 2)}
        slices.append(first if t == 0 else later)
        for w in range(2):
            hard[w].append({n: int(v[w]) for n, v in evidence.items() if v[w] >= 0})
        result = filter_.step(evidence)
        for w in range(2):
            joint = unrolled_joint(slices, hard[w], [{}] * 5, [("x", t)])
            np.testing.assert_allclose(result["x"][w], joint / joint.sum(), atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_every_engine_stays_a_distribution_through_beginnings_and_impossible_readings(seed):
    rng = np.random.default_rng(seed)
    width, policy = 3, ("drop", "soften", "restart")[seed % 3]
    world = RandomWorld(seed, static=seed % 2 == 0, zeros=0.2 * (seed % 3))
    engines = [
        {"engine": "exact"},
        {"engine": "projection", "max_flops": 200},
        {"engine": "particles", "particles": 100, "seed": 1},
        {"engine": "anytime", "budget_ms": 1.0, "memory_limit": (300, 3e3, 1e5)[seed % 3], "most": 1000, "seed": 1},
    ]
    filters = [Filter(world, batch=width, on_impossible=policy, **options) for options in engines]
    for t in range(6):
        active = () if t == 0 else tuple(int(k) for k in rng.integers(0, 30, rng.integers(0, 3)))
        evidence = {}
        for name, variable in world.ground(active, first=t == 0).variables.items():
            chance = 0.7 if name.split(".")[-1] in ("obs", "seen") else 0.15
            if name in world.given or rng.random() < chance:
                evidence[name] = np.where((rng.random(width) < 0.8) | (name in world.given), rng.integers(0, variable.card, width), -1)
        mask = rng.random(width) < (0.3 if t else 0.0)
        for filter_ in filters:
            filter_.reset(mask)
            result = filter_.step(evidence, relations=active)
            assert np.isfinite(result.log_likelihood).all()
            for name in result:
                np.testing.assert_allclose(result[name].sum(axis=1), 1.0, atol=1e-9)
                assert (result[name] >= 0).all()


def test_jeffrey_moves_one_variable_after_the_other():
    filter_ = Filter(Schedule(load("d07_entangle_min")))
    for relations in ("prior", "off", "on"):
        filter_.step({"oA": 1}, relations=relations)
    soft = filter_.jeffrey({"A": [0.2, 0.8], "B": [0.6, 0.4]}, relations="on")
    result = filter_.step({}, soft=soft, relations="on")
    np.testing.assert_allclose(result["B"], [[0.6, 0.4]], atol=1e-12)
    assert abs(result["A"][0, 0] - 0.2) > 1e-3
    with pytest.raises(EvidenceError, match="distribution"):
        filter_.jeffrey({"A": [0.2, 0.9]}, relations="on")


def test_plans_of_steps_to_come_can_be_made_beforehand():
    scene = Scene(3, opponents=2)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    path = [Active(("o1",)), Active(("o1",)), Active(("o1",), "o1"), Active(("o1",), "o1")]
    for _ in range(3):
        filter_.step(scene.readings(rng), relations=path[0])
    before = filter_.state
    assert filter_.prepare(path) > 0
    assert filter_.prepare(path) == 0
    assert filter_.state.belief is before.belief
    compiled, made = filter_.engine.compiler.compiled, len(filter_.engine.compiler.slice_steps)
    for active in path:
        filter_.step(scene.readings(rng), relations=active)
    assert filter_.engine.compiler.compiled == compiled
    assert len(filter_.engine.compiler.slice_steps) == made


def test_an_atemporal_variable_that_is_first_used_late_can_be_named():
    names = {"bias": GroundVariable("bias", ("0", "1")), "coin": GroundVariable("coin", ("0", "1"))}
    toss, prior = np.array([[0.5, 0.5], [0.9, 0.1]]), np.array([0.6, 0.4])
    free = GroundCPD("coin", (), np.array([0.5, 0.5]), "free")
    first = GroundSlice(names, (GroundCPD("bias", (), prior, "b"), free))
    quiet = GroundSlice({"coin": names["coin"]}, (free,))
    biased = GroundSlice({"coin": names["coin"]}, (GroundCPD("coin", (("bias", -1),), toss, "c"),))
    filter_ = Filter(Fixed(first, quiet), static=["bias"])
    for slice_ in (first, quiet, quiet):
        filter_.step({"coin": 0}, relations=slice_)
    result = filter_.step({"coin": 0}, relations=biased)
    expected = prior * toss[:, 0]
    np.testing.assert_allclose(result["bias"][0], expected / expected.sum(), atol=1e-12)
    unnamed = Filter(Fixed(first, quiet))
    for slice_ in (first, quiet, quiet):
        unnamed.step({"coin": 0}, relations=slice_)
    with pytest.raises(ModelError, match="bias"):
        unnamed.step({"coin": 0}, relations=biased)


def test_threads_share_the_agents_and_change_nothing():
    scene = Scene(8, opponents=1)
    rng = np.random.default_rng(0)
    one, three = Filter(scene, batch=7), Filter(scene, batch=7, threads=3)
    for active in (Active(), Active(("o1",)), Active(("o1",), "o1"), Active(("o1",), "o1")):
        readings = scene.readings(rng, 7)
        mine, theirs = one.step(readings, relations=active), three.step(readings, relations=active)
        np.testing.assert_array_equal(mine.log_likelihood, theirs.log_likelihood)
        for name in scene.hidden(active):
            np.testing.assert_array_equal(mine[name], theirs[name])
