"""Facts of the suite ``chapter5``: concurrency, sizes, tuning, learning."""

import pytest

from cprm_gym.benchmark.chapter5 import Chapter5Plan, play_cell, summarise
from cprm_gym.benchmark.chapter5.cells import FACT
from cprm_gym.benchmark.chapter5.experiments.making import reached
from cprm_gym.benchmark.chapter5.facts.concurrency import FORMS, MOVES, STATES, measure, product
from cprm_gym.benchmark.chapter5.facts.contained import same
from cprm_gym.benchmark.chapter5.facts.sizes import code_lines, own_file, size_of, tuned, written_numbers
from cprm_gym.benchmark.chapter5.pieces import HOLDS
from cprm_gym.benchmark.plan import Block
from cprm_gym.errors import ParameterError


def play(task, key, count=12, first=0, seed=3):
    return play_cell(Block(task, key, first, count, seed))


@pytest.mark.parametrize("k", [1, 2, 3])
def test_all_forms_of_concurrent_skills_send_the_same_and_the_product_is_the_power(k):
    found = {form: measure(k, form, 5) for form in FORMS}
    assert all(fact["alike"] for fact in found.values())
    assert found["product machine"]["states"] == len(STATES) ** k
    assert found["product machine"]["transitions"] == len(MOVES) ** k
    assert found["subsumption"]["states"] == len(STATES) * k
    assert (found["net"]["states"], found["net"]["transitions"]) == (2 * len(STATES) * k, (len(STATES) + len(MOVES)) * k)
    assert all(fact["explored"] == len(STATES) ** k for form, fact in found.items() if form != "net")


def test_a_product_machine_without_a_rule_says_so():
    machine = product(1)
    with pytest.raises(ParameterError, match="no rule of"):
        machine.step((0,), (2,))


@pytest.mark.parametrize("what", ["state machine", "belief regions"])
def test_what_the_architecture_contains_acts_alike(what):
    found = same(what, 1)
    assert found["alike"] == found["cycles"] > 100


def test_lines_are_counted_without_docstrings_comments_and_blanks():
    source = (
        '"""Doc.\n\nmore\n"""\n\nimport os  # why\n\n\n# comment\ndef f(a,\n      b):\n    """Doc."""\n    return (a +\n            b)\n'
    )
    assert code_lines(source) == 5


def test_numbers_are_counted_where_they_are_written_also_within_conditions():
    source = '"""2 of 3."""\nA = 0.5\nB = "x > 2.5 and ball1 < 1"\nC = f"y >= {A} or z > 4"\nD = (0, 1, True)\n'
    assert written_numbers(source) == 3


def test_sizes_are_those_of_the_own_file():
    assert own_file("fsm", "Goalie2v1").as_posix().endswith("cprm_baselines/fsm/goalie.py")
    assert own_file("cprm", "Goalie").as_posix().endswith("cprm_gym/agents/goalie.py")
    assert own_file("scripted", "Goalie").as_posix().endswith("cprm_baselines/scripted.py")
    assert own_file("code", "HFO3v3").as_posix().endswith("cprm_baselines/code/half_field.py")
    assert own_file("code", "Keepaway4v3", "right_1").as_posix().endswith("cprm_baselines/code/taker.py")
    assert own_file("cprm", "HFO3v3").as_posix().endswith("cprm_gym/agents/attacker/agent.py")
    assert own_file("fsm", "GoToBall").as_posix().endswith("cprm_baselines/fsm/go_to_ball.py")
    machine, net = size_of("KickOffShot", "fsm", 0), size_of("KickOffShot", "cprm", 0)
    assert (machine["parts"], machine["what"]) == (13, "states")
    assert machine["rules"] > machine["parts"]
    assert net["apart"][0] < net["parts"]
    parts = {name: size_of("KickOffShot", name, 0)["what"] for name in ("subsumption", "behavior_tree", "code", "belief_region")}
    assert parts == {"subsumption": "layers", "behavior_tree": "nodes", "code": "programs", "belief_region": "regions"}
    assert net["what"] == "places"
    assert net["parts"] > 100
    assert net["modules"] == 7


def test_episodes_of_tuning_are_those_of_the_studies():
    found = tuned("Goalie", "", 0)
    assert found["numbers"] > 5
    assert found["studies"]["memory"] % (24 * 250) == 0
    assert tuned("KickOffShot", "", 0) == {"studies": {}, "numbers": 0}


def test_the_experience_of_a_learner_is_that_of_its_record_and_compared_with_what_the_cprm_does_here():
    found = play("GoToBall", "training/policy", FACT).more
    assert found["algorithm"] == "ppo"
    assert found["weights"] > 1000
    assert found["curve"][-1][0] > 100_000
    assert reached([[10, 0.2, 0.5], [20, 0.9, 0.4], [30, 1.0, 1.0]], 0.6) == 20
    assert reached([[10, 0.2, 0.5]], 0.6) is None
    results = [play("GoToBall", "training/policy", FACT), play("GoToBall", "size/fsm", FACT), play("GoToBall", "default/cprm", 10)]
    (told,) = summarise(Chapter5Plan(("making",)), results).told
    ((task, who, rate, learner, steps, *_),) = told.tables[0].rows
    assert (task, who.split(":")[0], rate.split()[0], learner) == ("GoToBall", "cprm", "100.0", "ppo on discrete actions")
    assert steps == f"{reached(found['curve'], 1.0):,}"
    (learning,) = told.findings
    assert (learning.claim, learning.verdict) == ("learning", HOLDS)
    assert f"GoToBall after {steps} agent-steps" in learning.figure, "and of sizes nothing is said where the CPRM's is not known"
