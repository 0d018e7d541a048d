"""Random nets against enumeration and other engines."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest
from inference_worlds import RandomWorld, table, unrolled_joint

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, GroundSlice, GroundVariable
from cprm_gym.architecture.prm.inference.bayes_net import BayesNet
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.errors import ImpossibleEvidence


def random_net(seed: int, size: int = 8, zeros: float = 0.0) -> GroundSlice:
    """A net of `size` variables with up to three parents each."""
    rng = np.random.default_rng(seed)
    cards = rng.integers(2, 4, size)
    names = [f"v{i}" for i in range(size)]
    cpds = []
    for i, name in enumerate(names):
        parents = sorted(rng.choice(i, min(i, int(rng.integers(0, 4))), replace=False))
        shape = (*(cards[p] for p in parents), cards[i])
        cpds.append(GroundCPD(name, tuple((names[p], 0) for p in parents), table(rng, shape, zeros), name))
    return GroundSlice({n: GroundVariable(n, tuple(map(str, range(c)))) for n, c in zip(names, cards)}, tuple(cpds))


def random_evidence(net: GroundSlice, seed: int) -> tuple[dict[str, int], dict[str, np.ndarray]]:
    """Evidence of a sample of the net, so that it is possible, and a likelihood vector."""
    rng = np.random.default_rng(seed)
    values: dict[str, int] = {}
    for name in net.order():
        row = net.by_child[name].table[tuple(values[p] for p, _ in net.by_child[name].parents)]
        values[name] = int(rng.choice(len(row), p=row))
    observed = list(rng.choice(list(values), 3, replace=False))
    other = next(n for n in values if n not in observed)
    return {n: values[n] for n in observed}, {other: rng.random(net.variables[other].card) + 0.1}


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("zeros", [0.0, 0.4])
def test_static_posteriors_equal_enumeration(seed, zeros):
    net = random_net(seed, zeros=zeros)
    evidence, soft = random_evidence(net, seed)
    answer = BayesNet(net).query(evidence, soft)
    total = unrolled_joint([net], [evidence], [soft], [])
    assert answer.log_evidence[0] == pytest.approx(np.log(total), abs=1e-10)
    names = [n for n in net.variables if n not in evidence]
    for name in names:
        np.testing.assert_allclose(answer[name][0], unrolled_joint([net], [evidence], [soft], [(name, 0)]) / total, atol=1e-10)
    pair = [(names[0], 0), (names[-1], 0)]
    np.testing.assert_allclose(answer.joint(names[0], names[-1])[0], unrolled_joint([net], [evidence], [soft], pair) / total, atol=1e-10)
    asked = BayesNet(net).variable_elimination([names[-1], names[0]], evidence, soft)[0].T
    np.testing.assert_allclose(asked, unrolled_joint([net], [evidence], [soft], pair) / total, atol=1e-10)


@pytest.mark.parametrize("seed", range(6))
def test_most_probable_explanation_equals_enumeration(seed):
    net = random_net(seed, size=7, zeros=0.2)
    evidence, soft = random_evidence(net, seed)
    values, log_value = BayesNet(net).most_probable(evidence, soft)
    hidden = [n for n in net.variables if n not in evidence]
    joint = unrolled_joint([net], [evidence], [soft], [(n, 0) for n in hidden])
    assert log_value[0] == pytest.approx(np.log(joint.max()), abs=1e-10)
    assert joint[tuple(int(values[n].value[0]) for n in hidden)] == pytest.approx(joint.max(), rel=1e-10)


@pytest.mark.parametrize("seed", range(3))
def test_static_posteriors_equal_those_of_pgmpy(seed):
    from pgmpy.factors.discrete import TabularCPD
    from pgmpy.inference import VariableElimination
    from pgmpy.models import DiscreteBayesianNetwork

    net = random_net(seed, size=12)
    evidence, _ = random_evidence(net, seed)
    model = DiscreteBayesianNetwork([(p, c.child) for c in net.cpds for p, _ in c.parents])
    model.add_nodes_from(net.variables)
    for c in net.cpds:
        rows = np.moveaxis(c.table, -1, 0).reshape(c.table.shape[-1], -1)
        model.add_cpds(TabularCPD(c.child, rows.shape[0], rows, [p for p, _ in c.parents], list(c.table.shape[:-1])))
    engine = VariableElimination(model)
    answer = BayesNet(net).query(evidence)
    for name in net.variables:
        if name not in evidence:
            theirs = engine.query([name], evidence=evidence, show_progress=False).values
            np.testing.assert_allclose(answer[name][0], theirs, atol=1e-10)


ASK_PYAGRUM = """
import json, sys
import numpy as np
import pyagrum
answers = []
for net in json.load(sys.stdin):
    model = pyagrum.BayesNet()
    for name, card in net["cards"].items():
        model.add(pyagrum.LabelizedVariable(name, name, card))
    for child, parents, table in net["cpds"]:
        for p in parents:
            model.addArc(p, child)
        names = [*parents, child]
        order = [names.index(n) for n in model.cpt(child).names[::-1]]
        model.cpt(child)[:] = np.ascontiguousarray(np.transpose(np.array(table), order))
    engine = pyagrum.LazyPropagation(model)
    engine.setEvidence({**net["evidence"], **net["soft"]})
    engine.makeInference()
    hidden = [n for n in net["cards"] if n not in net["evidence"]]
    answers.append([engine.evidenceProbability(), {n: engine.posterior(n).toarray().tolist() for n in hidden}])
print(json.dumps(answers))
"""


@pytest.mark.skipif(importlib.util.find_spec("pyagrum") is None, reason="pyAgrum is not installed")
def test_static_posteriors_and_evidence_equal_those_of_pyagrum():
    """In a process of its own: its library and torch, which pgmpy loads, do not live together."""
    cases = []
    for seed in range(4):
        net = random_net(seed, size=12, zeros=0.2)
        cases.append((net, *random_evidence(net, seed)))
    asked = [
        {
            "cards": {n: v.card for n, v in net.variables.items()},
            "cpds": [(c.child, [p for p, _ in c.parents], c.table.tolist()) for c in net.cpds],
            "evidence": evidence,
            "soft": {n: v.tolist() for n, v in soft.items()},
        }
        for net, evidence, soft in cases
    ]
    command = [sys.executable, "-W", "ignore", "-c", ASK_PYAGRUM]
    done = subprocess.run(command, input=json.dumps(asked), capture_output=True, text=True, check=True)
    for (net, evidence, soft), (total, posteriors) in zip(cases, json.loads(done.stdout)):
        answer = BayesNet(net).query(evidence, soft)
        assert answer.log_evidence[0] == pytest.approx(np.log(total), abs=1e-9)
        for name, posterior in posteriors.items():
            np.testing.assert_allclose(answer[name][0], posterior, atol=1e-9)


def draw_evidence(ground, rng, width):
    """Readings of which some are missing for some agents, now and then a hidden variable or a likelihood."""
    evidence, soft = {}, {}
    for name, variable in ground.variables.items():
        chance = rng.random()
        if name in ground.given:
            evidence[name] = rng.integers(0, variable.card, width)
        elif (name.endswith("obs") and chance < 0.7) or (name.endswith("seen") and chance < 0.6) or chance < 0.1:
            state = rng.integers(0, variable.card, width)
            evidence[name] = np.where(rng.random(width) < 0.6, state, -1) if rng.random() < 0.5 else state
        elif chance > 0.93:
            soft[name] = rng.random((width, variable.card))
    return evidence, soft


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("zeros", [0.0, 0.3])
def test_filtering_with_relations_that_switch_equals_the_unrolled_net(seed, zeros):
    rng = np.random.default_rng(1000 + seed)
    width, length = 2, 4
    world = RandomWorld(seed, zeros=zeros)
    filter_ = Filter(world, batch=width, window=length)
    slices, hard, soft = [], [[] for _ in range(width)], [[] for _ in range(width)]
    for t in range(length):
        active = () if t == 0 else tuple(int(k) for k in rng.integers(0, 30, rng.integers(0, 3)))
        if seed % 3 == 0 and t in (1, 2):
            active = (*active, ("without" if t == 1 else "enters", "x2"))
        ground = world.ground(active, first=t == 0)
        slices.append(ground)
        evidence, likelihoods = draw_evidence(ground, rng, width)
        for w in range(width):
            hard[w].append({n: int(v[w]) for n, v in evidence.items() if v[w] >= 0})
            soft[w].append({n: v[w] for n, v in likelihoods.items()})
        totals = [unrolled_joint(slices, hard[w], soft[w], [], world.static) for w in range(width)]
        if min(totals) == 0.0:
            with pytest.raises(ImpossibleEvidence) as caught:
                filter_.step(evidence, soft=likelihoods, relations=active)
            assert list(caught.value.agents) == [w for w in range(width) if totals[w] == 0.0]
            return
        result = filter_.step(evidence, soft=likelihoods, relations=active)
        names = [n for n in ground.variables if n not in ground.given]
        pair = [str(n) for n in rng.choice(names, 2, replace=False)]
        for w in range(width):
            total = totals[w]
            assert result.log_likelihood[w] == pytest.approx(np.log(total), abs=1e-9)
            for name in names:
                joint = unrolled_joint(slices, hard[w], soft[w], [(name, t)], world.static)
                np.testing.assert_allclose(result[name][w], joint / total, atol=1e-10)
            joint = unrolled_joint(slices, hard[w], soft[w], [(n, t) for n in pair], world.static)
            np.testing.assert_allclose(result.joint(*pair)[w], joint / total, atol=1e-10)
    smoothed = filter_.smooth()
    for t, ground in enumerate(slices):
        for name in list(ground.variables)[:4]:
            if name not in ground.given:
                joint = unrolled_joint(slices, hard[0], soft[0], [(name, t)], world.static)
                np.testing.assert_allclose(smoothed[t][name][0], joint / joint.sum(), atol=1e-10)
