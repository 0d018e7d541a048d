"""The suite ``chapter5``: cells, players, slow knowledge, comparisons, facts, reports, interruptions, controllers that fail."""

import json
import re
import shutil
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from typer.testing import CliRunner

from cprm_gym.agents.knowledge import informed
from cprm_gym.benchmark import runner
from cprm_gym.benchmark.chapter5 import Chapter5Plan, play_cell, players, summarise
from cprm_gym.benchmark.chapter5.cells import FACT, FULL, QUICK, Cell, Size, Wanted, blocks_of
from cprm_gym.benchmark.chapter5.claims import CLAIMS
from cprm_gym.benchmark.chapter5.command import Asked, benchmark, plan_of, spoken
from cprm_gym.benchmark.chapter5.comparisons import Pair, compare, interval
from cprm_gym.benchmark.chapter5.conditions import CONDITIONS, MATCHES, SHIFTS, condition, shifts_of
from cprm_gym.benchmark.chapter5.experiments import EXPERIMENTS, slow, table
from cprm_gym.benchmark.chapter5.experiments.making import reached
from cprm_gym.benchmark.chapter5.facts.concurrency import FORMS, MOVES, STATES, measure, product
from cprm_gym.benchmark.chapter5.facts.contained import same
from cprm_gym.benchmark.chapter5.facts.sizes import code_lines, own_file, size_of, tuned, written_numbers
from cprm_gym.benchmark.chapter5.pieces import Curves, Dots, Point, Series, sentence
from cprm_gym.benchmark.chapter5.players import INTERNAL, LATE, NET, ON, REFLEXES, WATCHED, make_player, plays
from cprm_gym.benchmark.chapter5.report import svg
from cprm_gym.benchmark.chapter5.report.merged import merged
from cprm_gym.benchmark.chapter5.results import Results
from cprm_gym.benchmark.chapter5.slow import Slow
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.journal import Journal
from cprm_gym.benchmark.plan import Block, BlockResult
from cprm_gym.cli import app
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.tasks import TASKS, make_task
from cprm_gym.errors import ControllerError, CprmError, ParameterError, UnknownName
from cprm_gym.wrappers.disturbances import DISTURBANCES


def play(task, key, count=12, first=0, seed=3):
    return play_cell(Block(task, key, first, count, seed))


# ---------------------------------------------------------------- cells and plans


def test_every_cell_of_full_and_quick_names_tasks_conditions_and_players_that_there_are():
    for plan in (Chapter5Plan(), Chapter5Plan.quick()):
        wanted = plan.wanted()
        assert set(plan.experiments) == set(EXPERIMENTS)
        for one in wanted:
            if one.episodes == FACT:
                continue
            assert one.cell.task in TASKS
            condition(one.cell.condition).task(one.cell.task)
            make_player(one.cell.player, condition(one.cell.condition))
            assert Cell.of(Block(one.cell.task, one.cell.key, 0, 1, 0)) == one.cell


def test_a_cell_that_several_ask_for_is_played_once_with_the_most_episodes():
    cell = Cell("Goalie", "default", "fsm")
    blocks = blocks_of([Wanted(cell, 20), Wanted(cell, 2400), Wanted(Cell("3", "concurrency", "net"))], seed=4)
    assert [(b.first, b.count) for b in blocks] == [(0, 1000), (1000, 1000), (2000, 400), (0, FACT)]
    plan = Chapter5Plan.quick()
    keys = [(b.task, b.controller, b.first) for b in plan.blocks()]
    assert len(keys) == len(set(keys))
    assert len(plan.wanted()) > len({one.cell for one in plan.wanted()})


def test_floors_and_curves_of_the_full_suite_are_as_large_as_they_have_to_be_and_it_stays_within_four_hours():
    plan = Chapter5Plan()
    assert plan.size == Size(table=2000, curve=300, full=True)
    assert plan.seconds < 4 * 3600
    assert Chapter5Plan.quick().seconds < 360
    assert plan.at_most(100).size == replace(plan.size, table=100, curve=100)


@pytest.mark.parametrize(
    ("given", "message"),
    [({"experiments": ()}, "none given"), ({"experiments": ("table", "table")}, "named twice"), ({"seed": -1}, "seed: -1 given"),
     ({"size": replace(QUICK, table=1)}, "episodes: 1 given")],
)  # fmt: skip
def test_plans_that_make_no_sense_are_refused(given, message):
    with pytest.raises(ParameterError, match=message):
        Chapter5Plan(**given)


def test_an_unknown_experiment_is_named_with_those_there_are():
    with pytest.raises(UnknownName, match=r"unknown experiment 'sences'\. Did you mean 'senses'"):
        Chapter5Plan(("sences",))


def test_every_claim_has_an_experiment_that_speaks_of_it():
    assert {claim.experiment for claim in CLAIMS.values()} == set(EXPERIMENTS)


# ---------------------------------------------------------------- players and conditions


def test_players_by_name():
    task, how = make_task("Goalie"), condition("noise 1")
    assert type(make_player("fsm", how)(task, "left_1")).__name__ == "Player"
    assert make_player(f"{NET}{ON}belief", how)(task, "left_1").tier.name == "belief"
    assert isinstance(make_player(f"{NET}{ON}memory{LATE}", how)(task, "left_1"), Slow)
    assert type(make_player(f"fsm{WATCHED}", how)(task, "left_1")).__name__ == "Watchdog"
    assert plays("fsm", "Goalie")
    assert not plays("fsm", "Soccer")
    assert not plays(INTERNAL, "Goalie")
    with pytest.raises(UnknownName, match="unknown controller 'fms'"):
        make_player("fms", how)
    with pytest.raises(UnknownName, match="unknown tier 'beleif'"):
        make_player(f"{NET}{ON}beleif", how)(task, "left_1")


def test_the_cprm_under_another_name_is_not_played_again_and_what_is_weak_on_purpose_is_not_compared():
    assert not {"lesion", "goalie_memory"} & set(players.registered())
    assert set(players.WEAKENED) <= set(players.registered())
    plan = Chapter5Plan(("table",), replace(QUICK, table=2))
    results = [play("Goalie", f"default/{name}", 2) for name in ("cprm", "fsm", "random", "eased", "goalie_raw")]
    (told,) = summarise(plan, results).told
    assert {row[1] for row in told.tables[0].rows} == {"cprm", "fsm", "random", "eased", "goalie_raw"}
    assert [(c.first, c.second) for c in told.comparisons] == [("cprm", "fsm")]


def test_the_short_table_marks_who_is_decidedly_better_or_worse_than_the_net():
    plan = Chapter5Plan(("table",), replace(QUICK, table=60))
    report = summarise(plan, [play("Goalie", f"default/{name}", 60) for name in ("cprm", NET, "fsm", "scripted", "random", "eased")])
    (told,) = report.told
    brief = told.tables[1]
    assert brief.brief
    assert brief.head == ("task", "cprm", NET, "fsm", "scripted", "random")
    ((task, *cells),) = brief.rows
    rates = [row[3].split(" (")[0] for row in told.tables[0].rows]
    assert task == "Goalie"
    assert [cell.split()[0] for cell in cells] == rates[:5]
    assert [cell.endswith("▼") for cell in cells] == [False, False, False, True, False]  # chance is a floor, not a rival
    assert report.advice[0][1] == "what is easiest for you to write: net and fsm"
    assert 'class="fails"' in report.to_html()


def test_seconds_and_rates_are_not_compared_with_one_threshold():
    plan = Chapter5Plan(("table",), replace(QUICK, table=20, full=True))
    told = summarise(plan, [play("Keepaway3v2", f"default/{name}", 20) for name in ("cprm", NET, "code", "belief_region")]).told[0]
    (finding,) = told.findings
    assert finding.verdict == "not decided"
    assert "in 0 of 0 comparisons" in finding.figure
    assert "How long the ball is kept differs decidedly in" in finding.figure


def test_trained_policies_are_taken_to_other_worlds_wherever_one_comes_with_the_project():
    cells = {one.cell for one in EXPERIMENTS["transfer"].wanted(FULL)}
    for task in ("GoToBall", "Goalie", "HFO1v0"):
        assert plays("policy", task)
        assert {cell.condition for cell in cells if (cell.task, cell.player) == (task, "policy")} == {"default", *shifts_of(task)}
    # where nothing was tuned, the net is not played twice
    assert {cell.player for cell in cells if cell.task == "GoToBall"} & {"cprm", NET, players.UNTUNED} == {"cprm"}
    for task in ("Goalie", "HFO1v0"):
        assert {cell.player for cell in cells if cell.task == task} >= {"cprm", NET, players.UNTUNED}


def test_a_controller_without_its_package_is_left_out_and_said_so(monkeypatch):
    def load(name):
        if name == "code":
            missing = ModuleNotFoundError("No module named 'py_trees'", name="py_trees")
            said = ControllerError("trees need py_trees")
            said.__cause__ = missing
            raise ControllerError("cannot be loaded") from said
        return original(name)

    original = players.load_controller
    monkeypatch.setattr(players, "load_controller", load)
    players.plays.cache_clear()
    players.not_installed.cache_clear()
    try:
        assert players.not_installed() == {"code": "py_trees"}
        assert not plays("code", "Hike")
    finally:
        players.plays.cache_clear()
        players.not_installed.cache_clear()


def test_shifts_change_the_task_and_nothing_else_does():
    for task in ("Goalie", "Goalie2v1", "GoToBall", "LostAndFound", "HFO1v0"):
        for name in SHIFTS:
            changed = condition(name).task(task) != make_task(task)
            assert changed == (name in shifts_of(task)), (task, name)
    for name, how in CONDITIONS.items():
        if name not in SHIFTS:
            assert how.task("Goalie") == make_task("Goalie")


def test_the_hiker_who_infers_what_he_is_about_comes_home_and_belief_alone_does_not():
    with_it, without = play("Hike", f"default/{INTERNAL}"), play("Hike", "default/belief_region")
    assert all(with_it.success)
    assert not any(without.success)


# ---------------------------------------------------------------- slow knowledge


class Echo:
    """Keeps what it is told."""

    needs = ("memory",)

    def reset(self, observation, seed, worlds=None):
        self.told = []

    def act(self, observation):
        self.told.append({key: np.array(observation[key]) for key in ("self", "memory", "memory_age", "body", "age")})
        return no_action(len(observation["level"]))


def told(period, latency, reflexes, cycles=12):
    found = []

    def make(task, agent):
        player = Slow(informed(lambda task, agent: Echo(), "memory")(task, agent), period, latency, reflexes)
        found.append(player.player.controller)
        return player

    play_episodes(make_task("Goalie"), make, 3, 5, slots=3, most=cycles)
    return found[0].told


@pytest.mark.parametrize(("period", "latency"), [(1, 0), (1, 3), (4, 0), (3, 2)])
def test_what_is_told_is_what_the_inference_that_has_ended_said(period, latency):
    now, late = told(1, 0, False), told(period, latency, False)
    for t, heard in enumerate(late):
        begun = [c for c in range(0, t - latency + 1) if c % period == 0]
        source = begun[-1] if begun else 0
        np.testing.assert_array_equal(heard["memory"], now[source]["memory"])
        np.testing.assert_array_equal(heard["body"], now[source]["body"])
        np.testing.assert_allclose(heard["memory_age"], np.minimum(now[source]["memory_age"] + t - source, 1000.0))


def test_reflexes_are_told_of_this_cycle_where_the_ball_is_seen():
    now, late = told(1, 0, False), told(1, 4, True)
    for t in range(5, len(now)):
        np.testing.assert_array_equal(late[t]["body"], now[t]["body"])
        seen = now[t]["memory_age"][:, 0] == 0
        np.testing.assert_array_equal(late[t]["memory"][seen, 0], now[t]["memory"][seen, 0])
        np.testing.assert_array_equal(late[t]["memory"][:, 1:], now[t - 4]["memory"][:, 1:])


def test_knowledge_that_is_not_late_changes_nothing():
    plain, slow = play("Goalie", f"default/{NET}{ON}memory"), play("Goalie", f"default/fsm{ON}memory{LATE}")
    same_one = play("Goalie", f"default/fsm{ON}memory")
    assert (slow.success, slow.cycles) == (same_one.success, same_one.cycles)
    assert plain.more["asked"] == play("Goalie", f"default/{NET}{ON}memory").more["asked"]


def test_regions_that_see_are_compared_with_those_that_infer_alone():
    conditions = ("default", "inference 10 late")
    names = (slow.SEEING, slow.REGIONS)
    results = [play("Goalie", f"{where}/{name}", 40) for where in conditions for name in names]
    (told,) = summarise(Chapter5Plan(("slow",)), results).told
    assert [(c.condition, c.first, c.second) for c in told.comparisons] == [(where, *names) for where in conditions]
    late = told.comparisons[1]
    assert late.better == slow.SEEING
    (finding,) = told.findings
    assert finding.verdict == "holds"
    assert "Reflexes put belief regions ahead in 1 of 1 kinds of slowness" in finding.figure


def test_periods_and_latencies_that_there_are_not_are_refused():
    with pytest.raises(ParameterError, match="period 0 and latency 0"):
        Slow(None, 0, 0)


def test_late_knowledge_answers_later_and_saves_less():
    key = f"inference 5 late/{NET}{ON}memory"
    late, quick = play("Goalie", key + LATE, 60), play("Goalie", key + REFLEXES, 60)
    assert sum(late.success) + 10 < sum(quick.success)
    medians = [np.median([a for a in r.more["answer"] if a is not None]) for r in (late, quick)]
    assert medians[0] >= medians[1] + 2


# ---------------------------------------------------------------- disturbances


def test_the_strike_of_an_episode_is_the_same_in_any_slots_and_blocks():
    whole = play("KickOffShot", "ball displaced/fsm", 60)
    part = play("KickOffShot", "ball displaced/fsm", 5, first=52)
    for name in ("success", "cycles"):
        assert getattr(whole, name)[52:57] == getattr(part, name)
    for name in ("struck", "again"):
        assert whole.more[name][52:57] == part.more[name]
    assert sum(whole.more["struck"]) > 20
    assert set(DISTURBANCES) <= set(CONDITIONS)


def test_the_goalie_is_struck_before_the_shot_is_over():
    conditions = {one.cell.condition for one in EXPERIMENTS["disturbances"].wanted(FULL) if one.cell.task == "Goalie"}
    assert conditions == {"default", *(name + " early" for name in DISTURBANCES)}
    late, early = play("Goalie", "player displaced/fsm", 60), play("Goalie", "player displaced early/fsm", 60)
    assert sum(late.more["struck"]) < 6
    assert sum(early.more["struck"]) > 50
    assert sum(early.success) < sum(late.success)


def test_structures_of_the_goalie_are_compared_with_the_net_that_knows_what_they_know():
    results = [play("Goalie", f"blind spell early/{name}", 4) for name in ("cprm", NET, "fsm", "policy", "scripted")]
    (told,) = summarise(Chapter5Plan(("disturbances",)), results).told
    assert [(c.first, c.second) for c in told.comparisons] == [("cprm", NET), (NET, "fsm"), ("cprm", "policy"), ("cprm", "scripted")]


# ---------------------------------------------------------------- comparisons


def rates(a, b, n, task="t"):
    """Pairs in which the first alone succeeds `a` times and the second alone `b` times."""
    ones, others = np.zeros(n, bool), np.zeros(n, bool)
    ones[:a], others[a : a + b] = True, True
    return Pair(task, "default", "one", "other", "success", ones, others)


def test_one_comparison_is_mcnemars_and_bonett_and_prices():
    (c,) = compare([rates(30, 10, 100)])
    assert c.p == pytest.approx(0.00222, abs=1e-4)
    assert c.difference == pytest.approx(0.2)
    assert (c.low, c.high) == pytest.approx((0.07751, 0.31465), abs=1e-4)
    assert c.effect == pytest.approx(2 * np.arcsin(np.sqrt(0.3)) - 2 * np.arcsin(np.sqrt(0.1)))
    assert c.better == "one"
    assert sentence(c).startswith("one > other in t: +20.0 points (+7.8, +31.5)")


def test_holm_multiplies_the_smallest_by_the_number_the_next_by_one_less_and_never_falls():
    pairs = [rates(30, 10, 100), rates(26, 14, 100), rates(40, 5, 100)]
    alone = [compare([pair])[0] for pair in pairs]
    together = compare(pairs)
    assert together[2].p == pytest.approx(min(1, 3 * alone[2].p))
    assert together[0].p == pytest.approx(2 * alone[0].p)
    assert together[1].p == pytest.approx(max(2 * alone[0].p, alone[1].p))
    assert [bool(c.better) for c in together] == [True, False, True]
    for one, many in zip(alone[:1] + alone[2:], together[:1] + together[2:]):
        assert many.low < one.low < one.high < many.high
    assert interval(pairs[2], 0.05 / 3)[1:] == (together[2].low, together[2].high)


def test_what_is_not_decided_has_no_better_and_the_worse_is_named_when_it_is_the_first():
    assert compare([rates(12, 10, 100)])[0].better == ""
    assert compare([rates(0, 0, 50)])[0].p == 1.0
    (worse,) = compare([rates(2, 30, 100)])
    assert worse.better == "other"
    assert worse.difference < 0
    assert sentence(worse).startswith("other > one in t: +28.0 points (+1")
    means = Pair("t", "default", "a", "b", "cycles", np.arange(20.0), np.arange(20.0) + np.tile([1.0, 2.0], 10))
    (c,) = compare([means])
    assert (c.better, c.difference, c.effect < -2) == ("b", -1.5, True)
    with pytest.raises(ValueError, match="needs two of one length"):
        compare([replace(means, others=np.arange(3.0))])


def test_many_comparisons_of_equals_are_seldom_decided():
    rng = np.random.default_rng(0)
    wrong = 0
    for _ in range(60):
        pairs = [Pair("t", "c", "a", "b", "success", rng.random(200) < 0.8, rng.random(200) < 0.8) for _ in range(10)]
        wrong += any(c.better for c in compare(pairs))
    assert wrong <= 8


# ---------------------------------------------------------------- facts


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
    assert f"GoToBall after {steps} agent-steps" in told.findings[0].figure


# ---------------------------------------------------------------- runs and reports


@pytest.fixture(scope="module")
def hike(tmp_path_factory):
    """The smallest experiment, run by the command."""
    out = tmp_path_factory.mktemp("run")
    result = CliRunner().invoke(
        app, ["benchmark", "--suite", "chapter5", "--quick", "--only", "memory", "--episodes", "8", "--output", str(out)]
    )
    assert result.exit_code == 0, result.output
    (folder,) = out.iterdir()
    return folder, result.output


def test_a_run_writes_a_page_a_table_and_both_forms_of_json(hike):
    folder, output = hike
    data = json.loads((folder / "report.json").read_text())
    assert data["complete"]
    assert data["plan"]["size"]["table"] == 8
    assert data["claims"]["intention"]["verdict"] == "holds"
    assert data["claims"]["recovery"]["verdict"] == "not yet measured"
    assert {cell["player"] for cell in data["cells"]} >= {"cprm", "belief_region", INTERNAL}
    runs = json.loads((folder / "marl_eval.json").read_text())["cprm_gym"]["Hike"]["cprm"]["seed_0"]
    assert runs["absolute_metrics"]["success"] == [1.0] * 8
    assert "| belief_region | 8 | 0.0" in (folder / "report.md").read_text()
    assert "holds" in output


def test_a_packed_run_is_read_as_the_run_itself_and_taken_up_from(hike, tmp_path):
    folder, _ = hike
    journal = Journal(folder / "episodes.jsonl")
    journal.pack(tmp_path / "episodes.jsonl.xz")
    shutil.copyfile(folder / "plan.json", tmp_path / "plan.json")
    packed = Journal(tmp_path / "episodes.jsonl")
    assert packed.read() == journal.read() != {}
    assert merged([tmp_path]).results.cells.keys() == merged([folder]).results.cells.keys()
    (tmp_path / "episodes.jsonl.xz").write_bytes((tmp_path / "episodes.jsonl.xz").read_bytes()[:-20])
    with pytest.raises(CprmError, match="not a packed journal"):
        packed.read()
    journal.pack(tmp_path / "episodes.jsonl.xz")
    packed.cut_torn_line()
    assert (tmp_path / "episodes.jsonl").read_text() == (folder / "episodes.jsonl").read_text()


def test_of_a_run_that_is_put_together_only_what_it_played_has_to_have_the_numbers_of_then(hike, tmp_path):
    folder, _ = hike
    shutil.copytree(folder, tmp_path / "run")
    path = tmp_path / "run" / "plan.json"
    noted = json.loads(path.read_text())
    noted["constants"]["Goalie"]["run"] = 0.6
    path.write_text(json.dumps(noted))
    assert merged([tmp_path / "run"]).results.cells
    with pytest.raises(CprmError, match="others by now"):
        Chapter5Plan.read(tmp_path / "run")
    noted["constants"]["Hike"] = {"run": 0.6}
    path.write_text(json.dumps(noted))
    with pytest.raises(CprmError, match="others by now"):
        merged([tmp_path / "run"])


def test_the_page_stands_alone_and_says_how_it_was_made(hike):
    folder, _ = hike
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert not re.search(r'(src|href)\s*=\s*["\']?(?!#)\w', text)
    for drawn in re.findall(r"<svg.*?</svg>", text, re.DOTALL):
        ET.fromstring(drawn)
    for said in ("cprm-gym benchmark --suite chapter5 --quick --only memory --episodes 8", "numpy", "Seed 0", "Which to take when"):
        assert said in text


def test_an_interrupted_run_is_taken_up_and_nothing_is_played_twice(tmp_path, monkeypatch):
    plan = Chapter5Plan(("memory",), replace(QUICK, table=4))
    played = []

    def stop_at_the_third(block, timeout):
        played.append(block)
        if len(played) == 3:
            raise KeyboardInterrupt
        return play_cell(block, timeout)

    plan.write(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        list(runner.run(plan, journal=tmp_path / "episodes.jsonl", play=stop_at_the_third))
    result = CliRunner().invoke(app, ["benchmark", "--suite", "chapter5", "--resume", str(tmp_path)])
    assert result.exit_code == 0, result.output
    lines = (tmp_path / "episodes.jsonl").read_text().splitlines()
    assert len(lines) == len(plan.blocks())
    once = summarise(plan, [play_cell(block) for block in plan.blocks()])
    again = summarise(plan, [BlockResult.from_json(line) for line in lines])
    assert [c.success.tolist() for c in once.results.cells.values()] == [c.success.tolist() for c in again.results.cells.values()]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "sences"], "Did you mean 'senses'?"),
        (["--tasks", "Goalie"], "--tasks does not go with --suite chapter5"),
        (["--controllers", "fsm"], "--controllers does not go with --suite chapter5"),
        (["--t-b", "3"], "--t-b does not go with --suite chapter5"),
        (["--episodes", "0"], "episodes: 0 given"),
        (["--workers", "0"], "workers: 0 given"),
        (["--timeout", "0"], "--timeout 0"),
        (["--resume", "nowhere"], "plan.json: not the plan of a run of the suite 'chapter5'"),
        (["--resume", "nowhere", "--quick"], "leave --quick and what is to be played out"),
    ],
)
def test_the_command_refuses_nonsense_in_one_line(tmp_path, arguments, message):
    result = CliRunner().invoke(app, ["benchmark", "--suite", "chapter5", *arguments, "--output", str(tmp_path)])
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == []


def test_only_is_refused_without_the_suite(tmp_path):
    result = CliRunner().invoke(app, ["benchmark", "--only", "table", "--output", str(tmp_path)])
    assert result.exit_code == 2
    assert "--only goes with --suite chapter5" in result.output


def test_the_command_that_is_told_makes_the_same_plan():
    asked = Asked(True, ("table", "memory"), 12, 7)
    assert spoken(asked, 2) == "cprm-gym benchmark --suite chapter5 --quick --only table --only memory --episodes 12 --seed 7 --workers 2"
    assert plan_of(asked) == Chapter5Plan(("table", "memory"), replace(QUICK, table=12, curve=12), 7)


def test_a_plan_of_other_numbers_is_not_taken_up(tmp_path):
    Chapter5Plan.quick().write(tmp_path)
    assert Chapter5Plan.read(tmp_path) == Chapter5Plan.quick()
    data = json.loads((tmp_path / "plan.json").read_text())
    data["constants"]["Goalie"]["run"] += 0.01
    (tmp_path / "plan.json").write_text(json.dumps(data))
    with pytest.raises(CprmError, match="the constants of the players are others by now"):
        Chapter5Plan.read(tmp_path)


class Bad:
    needs = ()

    def __init__(self, how):
        self.how = how

    def reset(self, observation, seed, worlds=None):
        self.worlds = len(observation["level"])

    def act(self, observation):
        return self.how(self.worlds)


def _nan(n):
    return {**no_action(n), "params": np.full((n, 4), np.nan)}


def _shape(n):
    return {**no_action(n), "params": np.zeros((n, 3))}


def _exit(n):
    raise SystemExit(0)


def _raise(n):
    raise ZeroDivisionError("by nothing")


def _slow(n):
    import time

    time.sleep(0.3)
    return no_action(n)


@pytest.mark.parametrize(
    ("how", "message"),
    [(_nan, "'params' holds what is no finite number, in world 0"), (_shape, "'params' has shape"), (_exit, "SystemExit: 0"),
     (_raise, "ZeroDivisionError: by nothing"), (_slow, "a decision took longer than 0.1 s")],
)  # fmt: skip
def test_a_controller_that_fails_is_named_and_the_rest_stands(how, message, monkeypatch):
    from cprm_gym.benchmark.chapter5 import playing

    original = players.load_controller
    monkeypatch.setattr(players, "load_controller", lambda name: (lambda task, agent: Bad(how)) if name == "scripted" else original(name))
    monkeypatch.setattr(playing, "COMPILING", 0.0 if how is _slow else 600.0)
    plan = Chapter5Plan(("table",), replace(QUICK, table=3))
    blocks = [b for b in plan.blocks() if b.task == "Hike" and b.controller.endswith(("/scripted", "/fsm", "/cprm"))]
    timeout = 0.1 if how is _slow else 60.0
    results = [play_cell(b, timeout if b.controller.endswith("scripted") else 60.0) for b in blocks]
    report = summarise(plan, results)
    ((who, error),) = report.errors
    assert who == "scripted on Hike, default"
    assert message in error
    assert not report.complete
    assert report.results.played("Hike", "default", "fsm").n == 3
    assert f"{who}: " in report.to_html()
    assert {row[1] for row in report.told[0].tables[0].rows} == {"fsm", "cprm"}


def test_nothing_played_gives_a_report_that_says_so():
    plan = Chapter5Plan.quick()
    report = summarise(plan, [])
    assert not report.complete
    assert {verdict for verdict, _ in report.verdicts().values()} == {"not yet measured"}
    assert "not everything that was planned was played" in report.to_html()
    assert report.advice == ()
    assert Results([]).cells == {}


def test_one_player_has_one_colour_and_labels_do_not_cover_each_other():
    assert svg.colour("cprm") == svg.colour("cprm without recovery") != svg.colour("fsm")
    assert len({svg.colour(name) for name in players.FIRST}) == len(players.FIRST)
    placed = svg._apart([(50.0, "a", ""), (51.0, "b", ""), (99.0, "c", ""), (100.0, "d", "")], 13.0, 10.0, 100.0)
    heights = [y for y, _, _ in placed]
    assert all(b - a >= 13 - 1e-9 for a, b in pairwise(heights))
    assert max(heights) <= 100
    assert [svg._end(v) for v in (0.0, 0.3, 1.0, 21.1, 95.0, 101.0)] == pytest.approx([1.0, 0.3, 1.0, 30.0, 100.0, 200.0])
    panel = Curves("t", (Series("a < b", (Point(0, 1, 0, 2), Point(1, 3, 2, 4))),), ((0.0, "0"), (1.0, "1")), "x")
    assert "a &lt; b" in svg.curves(panel)
    for drawn in (svg.curves(panel), svg.curves(replace(panel, log=True)), svg.dots(Dots("t", (("cprm", 5.0, 4.0, 6.0),), "s", 0.0))):
        ET.fromstring(drawn)


def test_a_new_folder_is_made_only_for_a_new_run(tmp_path):
    with pytest.raises(CprmError, match="as it was planned"):
        benchmark(Asked(quick=True), tmp_path, lambda: pytest.fail("made"), 1, 60.0, None, str)


def test_in_the_table_all_of_a_task_have_the_same_worlds():
    plan = Chapter5Plan(("table",), replace(QUICK, table=4))
    report = summarise(plan, [play("Hike", "default/fsm", 6), play("Hike", "default/code", 4)])
    assert [row[2] for row in report.told[0].tables[0].rows] == ["4", "4"]
    assert report.results.played("Hike", "default", "fsm").n == 6
    assert "10 episodes, 4 to 6 in a cell" in report.episodes()
    planned = len({one.cell for one in plan.wanted()})
    assert report.told[0].notes[-1].startswith(f"{planned - 2} of {planned} cells planned were not played, in GoToBall, Goalie,")


def test_where_the_metric_is_the_duration_seconds_are_told_and_cycles_compared():
    plan = Chapter5Plan(("table",), replace(QUICK, table=4, full=True))
    results = [play("Keepaway3v2", f"default/{name}", 4) for name in ("scripted", "random")]
    report = summarise(plan, results)
    rows = {row[1]: row for row in report.told[0].tables[0].rows}
    assert set(rows) == {"scripted", "random"}
    mean = 0.1 * np.mean(results[0].cycles)
    assert rows["scripted"][3].startswith(f"{mean:.1f} s (")
    (panel,) = report.told[0].panels
    assert (panel.x, panel.most) == ("seconds", 0.0)
    pair = report.results.pair("Keepaway3v2", "default", "scripted", "random")
    assert pair.metric == "cycles"
    np.testing.assert_array_equal(pair.ones, results[0].cycles)


def test_of_matches_half_a_minute_is_played_and_goals_are_told_and_compared():
    assert set(MATCHES) == {"Soccer5v5", "Soccer11v11"} <= set(table.tasks(Size()))
    assert "Soccer" not in table.tasks(Size()), "it is Soccer11v11"
    assert make_task("Soccer") == replace(make_task("Soccer11v11"), name="Soccer")
    played = Cell("Soccer5v5", "default", "scripted")
    task = condition(played.condition).task(played.task)
    assert (task.max_cycles, task.controlled, task.others) == (300, "left", "strong")
    results = [BlockResult(Block("Soccer5v5", f"default/{name}", 0, 4, 0), [False] * 4, [300] * 4, goals, decisions=1, played=1200)
               for name, goals in (("scripted", [1.0, 0.0, 0.0, 0.0]), ("random", [-1.0, 0.0, -2.0, 0.0]))]  # fmt: skip
    report = summarise(Chapter5Plan(("table",), replace(QUICK, table=4, full=True)), results)
    rows = {row[1]: row[3] for row in report.told[0].tables[0].rows}
    assert rows["scripted"].startswith("+0.25 goals (-")
    assert rows["random"].startswith("-0.75 goals (-")
    (panel,) = report.told[0].panels
    assert panel.x == "goals ahead"
    drawn = svg.dots(panel)
    assert ">-2<" in drawn, "the axis begins below the least of the intervals"
    assert report.results.pair("Soccer5v5", "default", "scripted", "random").ones.tolist() == [1.0, 0.0, 0.0, 0.0]
    assert any("against the strong scripted team" in note for note in report.told[0].notes)


def test_what_the_architecture_contains_plays_as_such_and_as_its_net():
    for what in ("state machine", "belief regions"):
        one, other = (play("GoToBall", f"default/{name}", 3) for name in (what, f"{what} as a net"))
        assert not one.error
        assert one.success == [True] * 3
        assert (one.cycles, one.reward) == (other.cycles, other.reward)
    assert not plays("state machine", "Goalie")
