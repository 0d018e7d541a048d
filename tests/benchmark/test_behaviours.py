"""Behaviours of the house in the simulator's world: the methods agree with each other, broken versions are caught."""

import json
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from cprm_gym.agents.worlds.conditions import CONDITIONS
from cprm_gym.agents.worlds.learned import BEHAVIOURS, learn_world, simulate
from cprm_gym.agents.worlds.runs import StageRuns
from cprm_gym.agents.worlds.stage import Stage
from cprm_gym.architecture.analysis import budget
from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.product.explore import product
from cprm_gym.architecture.analysis.product.learned_world import load_world
from cprm_gym.architecture.analysis.rare.conditional import conditional
from cprm_gym.architecture.analysis.sampling.properties import Property
from cprm_gym.architecture.analysis.sampling.sample import sample
from cprm_gym.benchmark.behaviours import report as reports
from cprm_gym.benchmark.behaviours.analysis import METHODS, analyze_behaviour
from cprm_gym.benchmark.behaviours.broken import WRONG, negated, without
from cprm_gym.benchmark.behaviours.films import net_film, pitch_film
from cprm_gym.cli import app
from cprm_gym.errors import ExpressionError, FormatError, ModelError, NetError, UnknownName


def check(report):
    """What every report must keep: the exact value inside the sampled interval and inside the bounds."""
    for outcome in report.product.chain.outcomes:
        exact = report.exact.probability(outcome).value
        assert report.rows.probabilities[outcome].low - 1e-9 <= exact <= report.rows.probabilities[outcome].high + 1e-9
        assert report.text[outcome].low - 1e-9 <= exact <= report.text[outcome].high + 1e-9
        if outcome in report.sampled.outcomes:
            assert report.sampled.intervals()[outcome].holds(exact), outcome
    assert report.rows.probabilities[report.done].width <= report.text[report.done].width + 1e-9
    for outcome, bounds in report.bounds.items():
        assert bounds.holds(report.exact.probability(outcome).value), outcome
        assert not report.simulated[outcome].high < bounds.low
        assert not report.simulated[outcome].low > bounds.high
    assert report.bounds[report.done].width < 0.6
    assert report.failing == []
    assert report.difference()


@pytest.fixture(scope="module")
def seeking():
    return analyze_behaviour("go_to_ball", episodes=300, properties={"one thing at a time": "G (turn -> !dash)"}, require=0.9)


def test_the_methods_agree_on_going_to_the_ball(seeking):
    check(seeking)
    assert seeking.verdict is True
    assert seeking.exact.probability("at_ball").value > 0.98
    assert seeking.sampled.properties["one thing at a time"].true == 300


@pytest.mark.parametrize(("name", "done"), [("approach", "arrived"), ("pass_ball", "passed"), ("pass_and_receive", "received")])
def test_a_world_that_heeds_how_far_the_behaviour_is_comes_nearer_to_the_simulator(name, done):
    """Cells that forget it let a player fail who turns in one direction until he sees the ball, or counts his looks."""
    real, _ = simulate(name, 500, 77)

    def chance(heed):
        net, outcomes, world = learn_world(name, 500, heed=heed)
        return absorption(product(net, world, outcomes).chain).probability(done).value

    aside = {heed: abs(chance(heed) - real[done] / 500) for heed in ("nothing", "all")}
    assert aside["all"] < 0.7 * aside["nothing"]
    assert aside["all"] < 0.006


def test_the_pairs_cycle_is_two_nets_in_one_world():
    net, outcomes, world = learn_world("pass_and_receive", 150)
    assert list(outcomes) == ["received", "failed", "missed"]
    assert {"passer.kick", "receiver.dash"} <= {c for _, commands in world.counts for c in commands}
    made = product(net, world, outcomes)
    run, _ = conditional(made.chain, "received").likeliest_run()
    told = " ".join(made.tell(run))
    assert "passer.kick" in told
    assert "receiver." in told.partition("passer.kick")[2]


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(BEHAVIOURS))
def test_the_methods_agree_on_every_behaviour(name):
    """`pytest -m slow tests/benchmark/test_behaviours.py`."""
    report = analyze_behaviour(name, episodes=2000)
    check(report)
    assert report.bounds[report.done].low > 0.75
    assert set(report.said) >= {"bounded", "rare", "modules", "certificate", "contract"}
    assert all(said.applies or len(said.says) > 20 for said in report.said.values())


def test_a_player_who_turns_the_wrong_way_is_caught_with_a_run():
    broken = analyze_behaviour("go_to_ball", episodes=200, methods=("exact", "simulator"), require=0.9, change=negated("moment"))
    assert broken.verdict is False
    assert broken.simulated["at_ball"].high < 0.9
    assert broken.worst == "unfinished"
    assert sum("turn" in line.partition("->")[2] for line in broken.witness("unfinished")) > 10
    assert "property, a turn brings a ball that is off axis nearer to it: FAILS" in broken.failing[0]
    why, number = broken.shown()
    assert why.endswith("a turn brings a ball that is off axis nearer to it")
    assert "F (ends.at_ball & true.promised)" in json.dumps(broken.to_json()["conditions"])
    run = StageRuns("go_to_ball", negated("moment")).play([number], 1_000_003, True)[0]
    assert not Property(CONDITIONS["go_to_ball"][1].formula).holds(run.signals)
    page = reports.to_html(broken)
    assert "An episode of the simulator that breaks" in page
    assert page.count("<svg") == 2


def test_a_clause_of_the_contract_that_is_broken_is_named_with_a_run():
    broken = analyze_behaviour("go_to_ball", episodes=20, methods=("contract",), change=without("ignore"))
    assert broken.broken
    assert "contract broken: go_to_ball_reflex: idle interrupt" in broken.failing[0]
    assert any("caller" in line for line in broken.said["contract"].lines)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(WRONG))
def test_a_broken_version_of_every_behaviour_is_caught(name):
    """`pytest -m slow tests/benchmark/test_behaviours.py`."""
    good = analyze_behaviour(name, episodes=500, methods=("simulator",))
    floor = good.simulated[good.done].low
    assert good.failing == []
    broken = analyze_behaviour(name, episodes=500, methods=("exact", "simulator"), require=floor, change=negated(WRONG[name]))
    assert broken.verdict is False
    assert broken.failing
    assert broken.film().number == next(j.first for j in broken.judged if j.holds is False)


def test_the_report_is_written_in_all_forms(seeking, tmp_path):
    written = {path.name for path in reports.write(seeking, tmp_path)}
    assert {"report.md", "report.html", "report.json", "world.json"} <= written
    text = (tmp_path / "report.md").read_text()
    assert "| at_ball |" in text
    assert "within the simulator's" in text or "the simulator [" in text
    assert json.loads((tmp_path / "report.json").read_text())["verdict"] is True
    page = (tmp_path / "report.html").read_text()
    assert "<script" not in page
    assert page.count("<svg") == 2
    assert "A run of the simulator to at_ball" in page


def test_a_film_shows_the_run_that_failed_and_what_the_net_did():
    broken = analyze_behaviour("go_to_ball", episodes=60, methods=("simulator",), change=negated("moment"))
    shown = broken.film()
    assert shown.outcome != broken.done
    again = StageRuns("go_to_ball", negated("moment")).play([shown.number], 1_000_003, False)[0]
    assert again.outcome == shown.outcome
    assert len(shown.places) == len(shown.marked) == len(shown.commands)
    pitch, net = pitch_film(shown), net_film(shown)
    for text in (pitch, net):
        ElementTree.fromstring(text)  # well formed
    assert pitch.count("animateTransform") >= 3
    assert net.count('fill="#c36f2b"') == sum(len(c) for c in shown.commands)
    assert "skill.acted" in net


def test_episodes_of_the_simulator_are_runs_like_others():
    runs = StageRuns("pass_and_receive")
    found = sample(runs, 40, seed=3, properties_={"far at first": "true.distance < 1.5", "kicks once": "F passer.kick"}, block=25)
    assert found.runs == 40
    assert found.properties["kicks once"].true == 40
    assert found.properties["far at first"].true == 40
    one = runs.play([31], 3, True)[0]
    same = runs.play(range(25, 40), 3, True)[6]
    assert (one.outcome, one.cycles) == (same.outcome, same.cycles)
    assert (one.signals["true.ball_x"] == same.signals["true.ball_x"]).all()


def test_the_command_says_it_and_a_learned_world_can_be_used_again(seeking, tmp_path):
    reports.write(seeking, tmp_path)
    runner = CliRunner()
    arguments = ["analyze", "go_to_ball", "--in", str(tmp_path / "world.json"), "--method", "exact", "--json"]
    found = runner.invoke(app, arguments)
    assert found.exit_code == 0, found.output
    answer = json.loads(found.stdout)
    exact = seeking.exact.probability("at_ball").value
    assert answer["outcomes"]["at_ball"]["exact"]["value"] == pytest.approx(exact, abs=1e-9)
    assert answer["verdict"] is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["go_to_bal", "--in", "simulator"], "Did you mean 'go_to_ball'"),
        (["go_to_ball", "--in", "simulator", "--method", "exakt"], "Did you mean 'exact'"),
        (["go_to_ball", "--in", "nowhere.json"], "nowhere.json"),
        (["go_to_ball", "--in", "simulator", "--require", "1.5"], "a probability"),
        (["go_to_ball", "--in", "simulator", "--memory", "100", "--deadlocks"], "--memory, --deadlocks: of the net alone"),
        (["go_to_ball", "--in", "simulator", "--reach", "done"], "--reach: of the net alone"),
        (["go_to_ball", "--in", "simulator", "--graph", "x.dot"], "--graph: of the net alone"),
        (["go_to_ball", "--in", "simulator", "--seed", "-1"], "must not be negative"),
        (["go_to_ball", "--in", "simulator", "--output", __file__], "is a file, a folder is needed"),
        (["go_to_ball", "--in", "simulator", "--output", f"{__file__}/deeper"], "is a file, a folder is needed"),
    ],
)
def test_mistakes_are_said_plainly(arguments, message):
    found = CliRunner().invoke(app, ["analyze", *arguments])
    assert found.exit_code == 2
    assert message in " ".join(found.output.split())


DAMAGE = {
    "count": lambda data: data["counts"][0][2][0].__setitem__(1, 0),
    "enormous count": lambda data: data["counts"][0][2][0].__setitem__(1, 10**30),
    "begins": lambda data: data["begins"][0].__setitem__(1, -1),
    "confidence": lambda data: data.__setitem__("confidence", 1.5),
    "edges": lambda data: data["edges"].__setitem__(next(iter(data["edges"])), []),
    "edges that fall": lambda data: data["edges"].__setitem__(next(iter(data["edges"])), [2.0, 1.0]),
    "cell": lambda data: data["readings"][0][0].__setitem__(0, 999),
    "short cell": lambda data: data["readings"][0][0].pop(),
    "reading": lambda data: data["readings"][0][1].__setitem__("ball.age", float("nan")),
}


@pytest.mark.parametrize("what", DAMAGE)
def test_a_learned_world_of_a_stranger_that_makes_no_sense_is_refused(seeking, tmp_path, what):
    data = json.loads(json.dumps(seeking.world.to_json()))
    DAMAGE[what](data)
    (tmp_path / "world.json").write_text(json.dumps(data))
    with pytest.raises(FormatError, match=r"world\.json: "):
        load_world(tmp_path / "world.json")


def test_a_budget_ends_the_learning_and_what_was_learned_is_kept(monkeypatch):
    now, play = [0.0], Stage.play

    def slow(stage, *arguments):
        for played in play(stage, *arguments):
            now[0] += 0.1
            yield played

    monkeypatch.setattr(Stage, "play", slow)
    monkeypatch.setattr(budget.time, "monotonic", lambda: now[0])
    short = analyze_behaviour("go_to_ball", episodes=200, methods=("exact",), budget=Budget(seconds=2.0))
    assert any("ended before their time" in note for note in short.notes)
    assert sum(short.world.begins.values()) == 200
    assert 8 * 200 < sum(n for row in short.world.counts.values() for n in row.values()) < 12 * 200


def test_an_interruption_while_it_learns_keeps_the_world(monkeypatch):
    play = Stage.play

    def stopped(stage, *arguments):
        for cycle, played in enumerate(play(stage, *arguments)):
            if cycle == 8:
                raise KeyboardInterrupt
            yield played

    monkeypatch.setattr(Stage, "play", stopped)
    found = analyze_behaviour("go_to_ball", episodes=20)
    assert found.interrupted
    assert sum(found.world.begins.values()) == 20
    assert sum(n for row in found.world.counts.values() for n in row.values()) == 7 * 20
    with pytest.raises(KeyboardInterrupt):
        learn_world("go_to_ball", 20)


def test_what_is_required_is_decided_by_the_simulator_alone(seeking):
    found = analyze_behaviour("go_to_ball", methods=("exact",), require=0.9, learned=seeking.world)
    assert found.verdict is None
    assert "they were not played" in " ".join(reports.sentences(found))


def test_wrong_names_are_refused():
    with pytest.raises(ModelError, match="methods: none"):
        analyze_behaviour("go_to_ball", methods=())
    with pytest.raises(ExpressionError):
        analyze_behaviour("go_to_ball", methods=("exact",), properties=["G ("])
    with pytest.raises(UnknownName, match="Known: approach"):
        analyze_behaviour("fly")
    with pytest.raises(ModelError, match="two episodes"):
        analyze_behaviour("go_to_ball", episodes=1)
    with pytest.raises(NetError, match="no math place 'momet'"):
        analyze_behaviour("go_to_ball", episodes=2, change=negated("momet"))
    assert METHODS[0] == "exact"


def test_every_method_says_why_where_it_does_not_apply(seeking):
    assert set(seeking.said) == {"bounded", "rare", "modules", "certificate", "contract"}
    assert not seeking.said["modules"].applies
    assert "has no modules" in seeking.said["modules"].says
    assert "no error metric is stated for go_to_ball" in seeking.said["certificate"].says
    assert "at most 0.0" in seeking.said["rare"].says
    text = " ".join(reports.sentences(seeking))
    assert "modules does not apply: " in text
    assert "'unseen' is what was never seen to follow" in text
    assert "None" not in text
    assert "which were held out" not in text
    assert set(seeking.to_json()["methods"]) == set(seeking.said)


def test_the_approach_is_taken_to_pieces_proved_and_its_failures_drawn():
    found = analyze_behaviour("approach", episodes=400, methods=("exact", "bounded", "rare", "modules", "certificate", "contract"))
    assert all(said.applies for said in found.said.values())
    exact = found.exact.probability("arrived").value
    low, high = found.said["modules"].data["outcomes"]["arrived"]
    assert low - 1e-9 <= exact <= high + 1e-9
    rare = found.said["rare"].data
    assert rare["exact"] == pytest.approx(found.exact.probability(rare["outcome"]).value)
    assert rare["importance"]["trusted"]
    assert rare["importance"]["interval"][0] <= rare["exact"] <= rare["importance"]["interval"][1]
    assert found.said["certificate"].holds is True
    assert found.said["contract"].holds is True
    assert found.bounds["arrived"].holds(exact)
    low, high = found.regular.over_time["arrived"]
    curve = found.over_time.by("arrived")
    assert (low <= curve + 1e-9).all()
    assert (curve <= high + 1e-9).all()


def test_modules_of_two_players_work_at_once():
    found = analyze_behaviour("pass_and_receive", episodes=40, methods=("modules", "contract"))
    assert "work at once" in found.said["modules"].says
    assert found.said["contract"].holds is True
    assert set(found.said["contract"].data["reports"]) == {"passer.skill", "receiver.skill"}


@pytest.mark.parametrize("name", sorted(set(BEHAVIOURS) - {"catch_ball"}))
def test_what_a_behaviour_is_said_to_keep_it_keeps(name):
    found = analyze_behaviour(name, episodes=120, methods=("simulator",))
    assert [j.condition.name for j in found.judged] == [c.name for c in CONDITIONS[name]]
    assert found.failing == []
    assert all(j.holds for j in found.judged if j.condition.kind == "precondition")


def test_a_spent_budget_is_said_of_every_method_that_it_did_not_reach():
    found = analyze_behaviour("go_to_ball", episodes=100, budget=Budget(seconds=0.01))
    assert "the budget ended before it" in {said.says for said in found.said.values()}


def test_confidence_one_is_refused():
    with pytest.raises(ModelError, match=r"confidence 1\.0"):
        analyze_behaviour("go_to_ball", episodes=2, confidence=1.0)
    with pytest.raises(ModelError, match=r"confidence 1\.0"):
        sample(StageRuns("go_to_ball"), 2, confidence=1.0)
    with pytest.raises(ModelError, match="confidence 1"):
        learn_world("go_to_ball", 2, confidence=1)
