"""CPDs from data: counts tied per class, and expectation-maximisation."""

from __future__ import annotations

import numpy as np
import pytest
from ball_world import scene
from cases import load

from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.architecture.prm.inference.learning import Episode, Observed, count, em
from cprm_gym.architecture.prm.model.cpds import Dense, Prior, Table, Uniform
from cprm_gym.architecture.prm.model.domains import BOOL, Bins, Index, Labels, Real
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, PRMClass, Relation, Replace
from cprm_gym.errors import EvidenceError, ModelError, ParameterError

RNG = np.random.default_rng(11)
INITIAL = RNG.dirichlet(np.ones(3))
MOVE = RNG.dirichlet(np.ones(3), 3)
EMIT = RNG.dirichlet(np.ones(4), 3)


def table_of(model, name, attribute, part="main"):
    rule = getattr(model.checked.classes[name].rules[attribute], part)
    return rule.table


@pytest.mark.parametrize(("answer", "prior"), [("alpha0", 0.0), ("alpha1", 1.0)])
def test_complete_counts_match_the_recorded_ones(answer, prior):
    case = load("l01")
    cards = case["variables"]
    attributes = tuple(
        Attribute(v, Labels(tuple(map(str, range(k)))), Uniform(), parents=tuple(case["structure"][v])) for v, k in cards.items()
    )
    world = Grounding(Model("l01", (PRMClass("Row", attributes),)), {"x": "Row"})
    data = np.array(case["data"])
    step = Observed({f"x.{v}": data[:, k] for k, v in enumerate(cards)})
    fit = count(world, [Episode((step,), batch=len(data))], prior=prior)
    for v in cards:
        recorded = case["cpds"][answer][v]
        parents = case["structure"][v]
        flat = recorded["table"] if parents else recorded
        wanted = np.moveaxis(np.array(flat).reshape([cards[v], *(cards[p] for p in parents)]), 0, -1)
        assert np.abs(table_of(fit.model, "Row", v) - wanted).max() <= 1e-9


def test_real_numbers_are_counted_as_their_bins():
    bins = Bins((0, 1, 2, 4), unit="m")
    told = [[{"a.x": 0.5}], [{"a.x": 3.0}], [{"a.x": 2.5}]]

    def counted(domain):
        thing = PRMClass("Thing", (Attribute("x", domain, Uniform()),))
        return table_of(count(Grounding(Model("m", (thing,)), {"a": "Thing"}), told).model, "Thing", "x").ravel()

    for domain in (bins, Real("m", low=0, high=4, bins=bins)):
        assert counted(domain) == pytest.approx([1 / 3, 0.0, 2 / 3])
    with pytest.raises(ModelError, match="'x': a Real without bins"):
        counted(Real("m", low=0, high=4))


def chain_model(initial=INITIAL, move=MOVE, emit=EMIT):
    hidden, seen = Labels(("a", "b", "c")), Labels(("w", "x", "y", "z"))
    return Model("chain", (PRMClass("Chain", (
        Attribute("h", hidden, Dense(move), parents=("prev.h",), initial=Dense(initial)),
        Attribute("o", seen, Dense(emit), parents=("h",)),
    )),))  # fmt: skip


def baum_welch(sequences, initial, move, emit):
    """One iteration in the textbook form; -1 is a missing reading, which still counts its expected emission."""
    counts = [np.zeros(3), np.zeros((3, 3)), np.zeros((3, 4))]
    total = 0.0
    for o in sequences:
        like = np.array([emit[:, k] if k >= 0 else np.ones(3) for k in o])
        alpha, scale = np.zeros((len(o), 3)), np.zeros(len(o))
        for t in range(len(o)):
            ahead = (initial if t == 0 else alpha[t - 1] @ move) * like[t]
            scale[t] = ahead.sum()
            alpha[t] = ahead / scale[t]
        beta = np.ones((len(o), 3))
        for t in range(len(o) - 2, -1, -1):
            beta[t] = move @ (like[t + 1] * beta[t + 1]) / scale[t + 1]
            counts[1] += alpha[t][:, None] * move * (like[t + 1] * beta[t + 1])[None, :] / scale[t + 1]
        gamma = alpha * beta
        counts[0] += gamma[0]
        for t, k in enumerate(o):
            counts[2] += gamma[t][:, None] * (emit if k < 0 else np.eye(4)[k])
        total += np.log(scale).sum()
    return [c / c.sum(axis=-1, keepdims=True) for c in counts], total


def sequences(lengths, missing=0.2):
    rng = np.random.default_rng(5)
    out = []
    for n in lengths:
        h = rng.choice(3, p=[0.6, 0.3, 0.1])
        row = []
        for _ in range(n):
            row.append(-1 if rng.random() < missing else int(rng.choice(4, p=np.roll([0.7, 0.1, 0.1, 0.1], h))))
            h = rng.choice(3, p=np.roll([0.8, 0.15, 0.05], h))
        out.append(row)
    return out


@pytest.mark.parametrize("iterations", [1, 2, 5, 20])
def test_em_equals_baum_welch_after_the_same_number_of_iterations(iterations):
    data = sequences([6, 9, 1, 12])
    world = Grounding(chain_model(), {"c": "Chain"})
    fit = em(world, [[{"c.o": k} for k in row] for row in data], iterations=iterations)
    tables, likelihoods = [INITIAL, MOVE, EMIT], []
    for _ in range(iterations):
        tables, total = baum_welch(data, *tables)
        likelihoods.append(total)
    made = [table_of(fit.model, "Chain", "h", "initial"), table_of(fit.model, "Chain", "h"), table_of(fit.model, "Chain", "o")]
    assert np.allclose(fit.log_likelihoods, likelihoods, atol=1e-9)
    for ours, theirs in zip(made, tables):
        assert np.abs(ours - theirs).max() < 1e-9


def test_em_never_lowers_the_likelihood():
    world = Grounding(chain_model(), {"c": "Chain"})
    fit = em(world, [[{"c.o": k} for k in row] for row in sequences([30, 30])], iterations=12)
    assert np.diff(fit.log_likelihoods).min() > -1e-9


def test_em_stops_when_it_gains_less_than_the_tolerance():
    world = Grounding(chain_model(), {"c": "Chain"})
    data = [[{"c.o": k} for k in row] for row in sequences([20])]
    fit = em(world, data, iterations=50, tolerance=0.5)
    assert len(fit.log_likelihoods) < 50
    assert fit.log_likelihoods[-1] - fit.log_likelihoods[-2] < 0.5


def test_objects_of_a_class_teach_one_table():
    """Two objects tracked together give the counts of two separate runs."""
    rows = sequences([8, 8])
    together = Grounding(chain_model(), {"c": "Chain", "d": "Chain"})
    both = em(together, [[{"c.o": a, "d.o": b} for a, b in zip(*rows)]], iterations=3)
    alone = em(Grounding(chain_model(), {"c": "Chain"}), [[{"c.o": k} for k in row] for row in rows], iterations=3)
    assert np.allclose(table_of(both.model, "Chain", "h"), table_of(alone.model, "Chain", "h"), atol=1e-12)


def test_a_batch_of_runs_gives_the_counts_of_its_runs():
    rows = sequences([8, 8, 8])
    world = Grounding(chain_model(), {"c": "Chain"})
    batch = em(world, [Episode(tuple(Observed({"c.o": np.array(o)}) for o in zip(*rows)), batch=3)], iterations=2)
    each = em(world, [[{"c.o": k} for k in row] for row in rows], iterations=2)
    assert batch.log_likelihoods == pytest.approx(each.log_likelihoods)
    assert np.allclose(table_of(batch.model, "Chain", "o"), table_of(each.model, "Chain", "o"), atol=1e-12)


def test_em_on_complete_data_is_counting():
    rng = np.random.default_rng(2)
    rows = [[{"c.h": int(rng.integers(3)), "c.o": int(rng.integers(4))} for _ in range(20)] for _ in range(5)]
    world = Grounding(chain_model(), {"c": "Chain"})
    counted, expected = count(world, rows), em(world, rows, iterations=1)
    for attribute in ("h", "o"):
        assert np.allclose(table_of(counted.model, "Chain", attribute), table_of(expected.model, "Chain", attribute), atol=1e-12)
    assert sum(t.sum() for t in counted.counts.values()) == pytest.approx(200)


def test_counting_says_which_variable_is_hidden():
    world = Grounding(chain_model(), {"c": "Chain"})
    with pytest.raises(EvidenceError, match=r"step 1, run 0: 'c.h' is not observed; use `em`"):
        count(world, [[{"c.h": 0, "c.o": 1}, {"c.o": 1}]])


def test_a_row_that_was_never_seen_is_uniform_when_counted_and_stays_under_em():
    world = Grounding(chain_model(), {"c": "Chain"})
    data = [[{"c.h": 0, "c.o": 1}, {"c.h": 0, "c.o": 1}]]
    assert table_of(count(world, data).model, "Chain", "h")[1].tolist() == [1 / 3] * 3
    assert np.array_equal(table_of(em(world, data, iterations=1).model, "Chain", "h")[1], MOVE[1])


def test_only_the_wanted_cpds_are_learned():
    world = Grounding(chain_model(), {"c": "Chain"})
    fit = em(world, [[{"c.o": k} for k in row] for row in sequences([10])], iterations=2, only=[("class", "Chain", "o")])
    assert np.array_equal(table_of(fit.model, "Chain", "h"), MOVE)
    assert not np.array_equal(table_of(fit.model, "Chain", "o"), EMIT)
    assert ("class", "Chain", "h", "cpd") in fit.kept
    with pytest.raises(ModelError, match="no CPD begins with"):
        em(world, [[{"c.o": 0}]], only=[("class", "Chian")])


def possession(conflict="exclusive"):
    ball = PRMClass("Ball", (Attribute("x", BOOL, (0.5, 0.5)),))
    player = PRMClass("Player", (Attribute("y", BOOL, (0.5, 0.5)),))
    has = Relation("has", {"p": "Player", "b": "Ball"}, (Replace("b.x", ("p.y",), Uniform()),), conflict=conflict)
    return Grounding(Model("m", (ball, player), (has,)), {"ball": "Ball", "p": "Player", "q": "Player"})


def test_a_relation_learns_from_the_slices_in_which_it_is_active():
    steps = [
        Observed({"ball.x": 1, "p.y": 1, "q.y": 0}, ("has(p,ball)",)),
        Observed({"ball.x": 1, "p.y": 0, "q.y": 1}, ("has(q,ball)",)),
        Observed({"ball.x": 0, "p.y": 0, "q.y": 0}),
    ]
    fit = count(possession(), [steps])
    rules = fit.model.checked
    assert rules.relations["has"].changes["b.x"].main.table.tolist() == [[0.5, 0.5], [0.0, 1.0]]
    assert rules.classes["Ball"].rules["x"].main.table.tolist() == [1.0, 0.0]
    assert rules.classes["Player"].rules["y"].main.table.tolist() == [4 / 6, 2 / 6]


def test_a_mixture_teaches_the_tuple_that_its_selector_names():
    """Selector posteriors weigh the counts: with the first tuple certain, only its parents are counted."""
    active = ("has(p,ball)", "has(q,ball)")
    step = Observed({"ball.x": 1, "p.y": 1, "q.y": 0, "ball.selector": 0}, active)
    fit = em(possession("mixture"), [[step]], iterations=1)
    assert fit.counts["relation", "has", "b.x", "cpd"].tolist() == [[0.0, 0.0], [0.0, 1.0]]
    step = Observed({"ball.x": 1, "p.y": 1, "q.y": 0}, active)
    fit = em(possession("mixture"), [[step]], iterations=1)
    assert fit.counts["relation", "has", "b.x", "cpd"] == pytest.approx(np.array([[0.0, 0.5], [0.0, 0.5]]))


def test_a_parent_reached_twice_counts_on_the_diagonal():
    model = Model(
        "m",
        (PRMClass("A", (Attribute("x", BOOL),)), PRMClass("B", (Attribute("z", BOOL),))),
        (Relation("r", {"p": "A", "q": "A", "b": "B"}, (Replace("b.z", ("p.x", "q.x"), Uniform()),)),),
    )
    world = Grounding(model, {"a": "A", "b": "B"})
    fit = count(world, [[Observed({"a.x": 1, "b.z": 1}, ("r(a,a,b)",))]])
    assert fit.counts["relation", "r", "b.z", "cpd"][1, 1].tolist() == [0.0, 1.0]


def test_objects_that_enter_teach_their_initial_cpd():
    world = Grounding(chain_model(), {"c": "Chain", "d": "Chain"})
    steps = [
        Observed({"c.h": 0, "c.o": 0}, objects=("c",)),
        Observed({"c.h": 1, "c.o": 0, "d.h": 2, "d.o": 0}, objects=("c", "d")),
    ]
    fit = count(world, [steps])
    assert fit.counts["class", "Chain", "h", "initial"].tolist() == [1.0, 0.0, 1.0]
    assert fit.counts["class", "Chain", "h", "cpd"].sum() == 1.0


def test_learning_recovers_the_motion_that_made_the_data():
    """The dynamics of a sampled ball, learned by counting, are near the ones it was sampled from."""
    world = scene(4, 0)
    rng = np.random.default_rng(3)
    ground, first = world.ground(), world.ground(first=True)
    runs = 4000
    values, steps = {}, []
    for t in range(3):
        now = first if t == 0 else ground
        new = {"ball.turn": np.full(runs, 2)}
        for name in now.order():
            if name in now.by_child:
                cpd = now.by_child[name]
                rows = cpd.table[tuple((values if lag else new)[p] for p, lag in cpd.parents)]
                cumulative = np.cumsum(np.broadcast_to(rows, (runs, rows.shape[-1])), axis=1)
                new[name] = (rng.random((runs, 1)) > cumulative[:, :-1]).sum(axis=1)
        steps.append(Observed({n: Index(k) for n, k in new.items()}))
        values = new
    fit = count(world, [Episode(tuple(steps), batch=runs)])
    truth = table_of(world.model, "Ball", "dist")
    counts = fit.counts["class", "Ball", "dist", "cpd"]
    seen = counts.sum(axis=-1) > 300
    assert seen.sum() >= 8
    error = np.abs(table_of(fit.model, "Ball", "dist") - truth)[seen]
    assert error.max() < 4 * 0.5 / np.sqrt(300)


def test_a_learned_model_refuses_other_bins():
    world = Grounding(Model("m", (PRMClass("C", (Attribute("x", Bins((0.0, 1.0, 2.0))),)),)), {"c": "C"})
    learned = count(world, [[{"c.x": 0.5}], [{"c.x": 1.5}], [{"c.x": 1.5}]]).model
    cpd = learned.classes[0].attributes[0].cpd
    assert cpd == Dense([1 / 3, 2 / 3], [("0.0", "1.0", "2.0")])
    with pytest.raises(ModelError, match="axis 0 was made for"):
        Model("m", (PRMClass("C", (Attribute("x", Bins((0.0, 1.5, 2.0)), cpd),)),))


@pytest.mark.parametrize(("options", "message"), [({"prior": -1.0}, "at least 0"), ({"iterations": 0}, "at least 1")])
def test_wrong_options_are_refused(options, message):
    world = Grounding(chain_model(), {"c": "Chain"})
    with pytest.raises(ParameterError, match=message):
        em(world, [[{"c.o": 0}]], **options)


def test_hidden_attention_data_improves_a_relational_cpd():
    """EM through a relation's hidden variable: `shoot` is never seen, the ball's reaction is."""
    shoot = Attribute("shoot", BOOL, Prior((0.5, 0.5)))
    ball = PRMClass("Ball", (Attribute("fast", BOOL, (0.9, 0.1)),))
    kick = Relation("has", {"b": "Ball"}, (Replace("b.fast", ("shoot",), Table({"no": (0.9, 0.1), "yes": (0.2, 0.8)})),), (shoot,))
    world = Grounding(Model("m", (ball,), (kick,)), {"ball": "Ball"})
    fast = np.array([1] * 45 + [0] * 55)
    data = [Episode((Observed({"ball.fast": fast}, ("has(ball)",)),), batch=100)]
    fit = em(world, data, iterations=300, only=[("relation", "has", "shoot")])
    learned = fit.model.checked.relations["has"].rules["shoot"].main.table
    assert learned[1] == pytest.approx(0.5, abs=1e-6)
    assert 0.1 + 0.7 * learned[1] == pytest.approx(0.45, abs=1e-6)
