"""What the table of the suite ``chapter5`` tells, and how it is drawn."""

import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from cprm_gym.benchmark.chapter5 import Chapter5Plan, play_cell, players, summarise
from cprm_gym.benchmark.chapter5.cells import QUICK, Cell, Size
from cprm_gym.benchmark.chapter5.conditions import MATCHES, condition
from cprm_gym.benchmark.chapter5.experiments import table
from cprm_gym.benchmark.chapter5.pieces import Curves, Dots, Point, Series
from cprm_gym.benchmark.chapter5.players import NET
from cprm_gym.benchmark.chapter5.report import svg
from cprm_gym.benchmark.plan import Block, BlockResult
from cprm_gym.envs.tasks import make_task


def play(task, key, count=12, first=0, seed=3):
    return play_cell(Block(task, key, first, count, seed))


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
