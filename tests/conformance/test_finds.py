"""A replay that cannot fail proves nothing: each kind of error, put into a recording, is found."""

import gzip
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from cprm_gym.errors import FormatError
from cprm_gym.simulator.conformance import Report, files_in, replay_scenario, run
from cprm_gym.simulator.conformance.report import Check, Mismatch, Result

DATA = Path(__file__).parent / "data"


def altered(tmp_path: Path, name: str, alter: Callable[[list[dict]], None], cases: int | None = None) -> Result:
    """Replay a recording after `alter` has changed its records; only the first `cases` of them."""
    with gzip.open(DATA / f"{name}.jsonl.gz", "rt") as lines:
        records = [json.loads(line) for line in lines]
    records = records[: None if cases is None else cases + 1]
    for record in records if cases is not None else ():
        record["steps"] = record.get("steps", [])[:6]
    alter(records)
    path = tmp_path / "altered.jsonl"
    path.write_text("\n".join(json.dumps(record) for record in records))
    return replay_scenario(path)


def first_state(records: list[dict]) -> dict:
    return records[1]["steps"][0]["state"]


def set_parameter(name: str, value: float) -> Callable[[list[dict]], None]:
    return lambda records: records[0]["server_param"].update({name: value})


@pytest.mark.parametrize(
    ("name", "alter", "quantity"),
    [
        ("ball_roll", set_parameter("ball_decay", 0.9400001), "vx"),
        ("kick", lambda records: records[0]["player_type"]["0"].update(kick_power_rate=0.0270001), "x"),
        ("turn", lambda records: records[0]["player_type"]["0"].update(inertia_moment=5.0001), "body"),
        ("turn_neck", lambda r: first_state(r)["pl"]["l1"].__setitem__(6, 31.0), "neck"),
        ("dash_default", lambda r: first_state(r)["pl"]["l2"].__setitem__(7, 7945.000001), "stamina"),
        ("hetero", lambda r: first_state(r)["pl"]["l1"].__setitem__(8, 0.5), "effort"),
        ("catch", lambda r: first_state(r).__setitem__("pm", "play_on"), "play mode"),
        ("tackle", lambda r: first_state(r)["ex"].clear(), "marks"),
        ("rules", lambda r: first_state(r).__setitem__("score", [0, 1]), "score"),
        ("collide_ball", lambda r: first_state(r).__setitem__("t", 4), "time"),
        ("view", lambda r: first_state(r).update(ex={"l1": {"fp": [3.0, 0.0]}}), "focus distance"),
        ("audio", lambda r: r[1]["steps"][0]["msgs"].update(l2=['(hear 3 -153 our 1 "other")']), "hear"),
        (
            "kick_repeat",
            lambda r: r[1]["steps"][0]["msgs"].update(l1=[text.replace("(kick 1)", "(kick 2)") for text in r[1]["steps"][1]["msgs"]["l1"]]),
            "sense_body",
        ),
    ],
)
def test_a_wrong_number_is_found(name, alter, quantity, tmp_path):
    result = altered(tmp_path, name, alter, cases=2)
    assert not result.ok
    assert quantity in {mismatch.quantity for mismatch in result.mismatches}, result.text()


def test_a_changed_see_message_is_found(tmp_path):
    def alter(records):
        for step in records[1]["steps"]:
            for key, texts in step["msgs"].items():
                step["msgs"][key] = [text.replace("((f c) ", "((f c) 9") for text in texts]

    result = altered(tmp_path, "sight_static", alter, cases=1)
    assert "see" in {mismatch.quantity for mismatch in result.mismatches}
    assert "(f c)" in result.text()


def test_a_missing_see_message_is_found(tmp_path):
    def alter(records):
        records[1]["steps"][4]["msgs"]["l1"] = []

    result = altered(tmp_path, "view", alter, cases=1)
    assert "see messages" in {mismatch.quantity for mismatch in result.mismatches}


def test_hidden_state_and_flags_of_random_runs_are_compared(tmp_path):
    def alter(records):
        steps = records[1]["steps"] = records[1]["steps"][:6]
        player, bits = next(iter(steps[3]["flags"].items()))
        steps[3]["flags"][player] = hex(int(bits, 16) ^ 2)[2:]
        key = next(iter(steps[4]["hid"]))
        steps[4]["hid"][key][1] += 1

    result = altered(tmp_path, "random/monkey_physics_0", alter)
    assert {mismatch.quantity for mismatch in result.mismatches} == {"state bits", "kick"}
    # the wrong counter is loaded for the next step and found there once more
    assert result.failed == 3


@pytest.mark.parametrize(
    ("name", "alter"),
    [
        ("noise_move", set_parameter("player_rand", 0.11)),
        ("noise_ball", set_parameter("ball_rand", 0.06)),
        ("noise_ball_kickonly", lambda records: records[0]["player_type"]["0"].update(kick_rand=0.12)),
        ("sight_gauss", lambda records: [kind.update(dist_noise_rate=0.008) for kind in records[0]["player_type"].values()]),
        ("catch_stretch", lambda records: records[0]["server_param"].update(catchable_area_l=1.3)),
        ("noise_foul", lambda records: [kind.update(foul_detect_probability=0.9) for kind in records[0]["player_type"].values()]),
        ("sight_prob", lambda records: [kind.update(unum_far_length=25) for kind in records[0]["player_type"].values()]),
        ("noise_hear", lambda records: records[1]["heard_full"].update(two=53, three=140)),
        ("sight_point", lambda records: records[1].update(rows=[[d, t, s if s % 2 else t] for d, t, s in records[1]["rows"]])),
    ],
)
def test_another_distribution_is_rejected(name, alter, tmp_path):
    assert not altered(tmp_path, name, alter).ok


def test_noise_beyond_its_bound_is_found(tmp_path):
    result = altered(
        tmp_path,
        "random/monkey_noise_0",
        lambda records: (set_parameter("player_rand", 0.02)(records), records[1].update(steps=records[1]["steps"][:20])),
    )
    found = {mismatch.quantity for mismatch in result.mismatches}
    assert "position outside its bounds" in found
    assert "velocity outside its bounds" in found


def test_the_report_names_case_cycle_object_expected_and_got(tmp_path):
    result = altered(tmp_path, "ball_roll", lambda r: r[2]["steps"][0]["state"]["ball"].__setitem__(0, 7.0), cases=2)
    text = Report([result]).text()
    assert "FAIL" in text
    assert "roll1 step 0" in text
    assert "ball: x expected 7" in text
    assert "1 file differs" in text
    content = json.loads(Report([result]).to_json())
    assert content["ok"] is False
    found = content["files"][0]["mismatches"][0]
    assert (found["object"], found["quantity"], found["expected"]) == ("ball", "x", 7.0)
    assert content["files"][0]["cycles"] == result.cycles


def test_numbers_that_are_not_finite_are_mismatches_and_do_not_break_the_json():
    result = Result("x", "y")
    assert not result.number("case", 1, "ball", "x", 1.0, float("nan"), 1.0)
    assert not Check("p", float("nan"), 0.001).passed
    result.checks.append(Check("p", float("nan"), 0.001))
    assert json.loads(Report([result]).to_json())["files"][0]["errors"]["x"] == "nan"
    assert "nan" in str(Mismatch("c", 1, "ball", "x", 1.0, float("nan")))


def test_run_takes_files_and_directories(tmp_path):
    (tmp_path / "some").mkdir()
    (tmp_path / "some" / "kick.jsonl.gz").write_bytes((DATA / "stamina_lowcap.jsonl.gz").read_bytes())
    report = run([tmp_path])
    assert report.ok
    assert len(report.results) == 1
    assert "all as recorded" in report.text()


def test_what_cannot_be_replayed_is_refused(tmp_path):
    with pytest.raises(FormatError, match="no such file"):
        files_in([tmp_path / "nothing"])
    with pytest.raises(FormatError, match="no recordings"):
        files_in([tmp_path])
    (tmp_path / "a.txt").write_text("")
    with pytest.raises(FormatError, match="not a recording"):
        files_in([tmp_path / "a.txt"])
    broken = tmp_path / "broken.jsonl"
    for content, message in (
        ("", "line 1: a recording begins"),
        ("{", "line 1: not JSON"),
        ('{"rec": "header"}', "line 1: the header has no 'server_param'"),
    ):
        broken.write_text(content)
        with pytest.raises(FormatError, match=message):
            replay_scenario(broken)
