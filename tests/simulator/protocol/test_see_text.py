"""See messages: recorded ones of a real server must be messages that the simulator could send in the recorded state."""

import re

import numpy as np
import pytest
from senses_recordings import ROW, WIDTHS, cases, load, random_worlds, recording, see_messages, simulator

from cprm_gym.errors import CommandError, ParameterError
from cprm_gym.simulator.kernels.senses import late_messages_due
from cprm_gym.simulator.protocol.commands import command_record, parse_commands
from cprm_gym.simulator.protocol.messages import see_mismatches, see_text
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PlayMode


def test_recorded_see_messages_of_protocol_19_are_possible_to_the_last_character():
    recorded = recording("sight_static")
    sim = simulator(recorded)
    w = sim.world[0]
    compared = 0
    for case in cases(recorded):
        w["view_width"] = [(3, 1, 2)[int(key[1:]) % 3] for key in ROW]
        if case["case"].startswith(("grid", "edge")):
            w["view_width"] = WIDTHS[case["case"].split("_")[1]]
        for step in case["steps"]:
            load(sim, step["state"], step["state"]["t"])
            if case["case"].startswith("edge") and case["case"].endswith("_0"):
                w["vel"][0] = -0.0  # the ball was put onto players: -0.1 times nothing, whose sign JSON has lost
            for key, _, text in see_messages(step):
                assert see_mismatches(sim, 0, ROW[key] + 1, text) == [], (case["case"], step["i"], key)
                compared += 1
    assert compared == 1386


def test_recorded_see_messages_of_protocol_17_are_possible_to_the_last_character():
    recorded = recording("sight_v17")
    sim = simulator(recorded)
    w = sim.world[0]
    for key, row in ROW.items():  # narrow high, narrow low, normal high, ...
        w["view_width"][row] = (int(key[1:]) - 1) % 6 // 2 + 1
        w["view_quality"][row] = (int(key[1:]) - 1) % 2 + 1
    compared = 0
    for case in cases(recorded):
        before = case["init"]
        for step in case["steps"]:
            for key, time, text in see_messages(step):
                load(sim, step["state"] if time == step["state"]["t"] else before, time)
                assert see_mismatches(sim, 0, ROW[key] + 1, text) == [], (case["case"], step["i"], key)
                compared += 1
            before = step["state"]
    assert compared == 480


@pytest.mark.parametrize("seed", [0, 1])
def test_recorded_see_messages_among_random_commands_are_possible_to_the_last_character(seed):
    recorded = recording(f"monkey_sight_{seed}")
    sim = simulator(recorded)
    view = recorded.header["hid_fields"].index("view")
    compared = 0
    for step in cases(recorded)[0]["steps"]:
        load(sim, step["state"], step["state"]["t"])
        for key, hidden in step["hid"].items():
            sim.world["view_width"][0, ROW[key]] = WIDTHS[hidden[view]]
        for key, _, text in see_messages(step):
            assert see_mismatches(sim, 0, ROW[key] + 1, text) == [], (step["i"], key)
            compared += 1
    assert compared > 400


def test_a_wrong_digit_is_a_mismatch():
    sim = random_worlds(1)
    text = see_text(sim, 0, 7)
    assert see_mismatches(sim, 0, 7, text) == []
    wrong = re.sub(r" (-?\d+)\)\)$", lambda found: f" {int(found[1]) + 1}))", text)
    assert len(see_mismatches(sim, 0, 7, wrong)) == 1
    assert len(see_mismatches(sim, 0, 7, text.replace("(see 0", "(see 1"))) == 1
    assert len(see_mismatches(sim, 0, 7, re.sub(r" \(\(l [^()]*\)[^()]*\)\)$", ")", text))) == 1


def test_every_message_is_possible_in_its_own_world():
    sim = random_worlds(20, seed=3)
    sim.world["arm_timer"][:, ::3] = 0
    sim.world["tackle_cycles"][:, ::4] = 3
    sim.world["focus_distance"][:, ::2] = 12.0
    for world in range(20):
        for player in range(1, 23):
            for protocol in (19, 17, 5):
                text = see_text(sim, world, player, protocol)
                assert see_mismatches(sim, world, player, text, protocol) == []


def asynchronous_counts(steps):
    """(step, player) -> numbers of recorded see messages that show the state before and after the step."""
    return {
        (step["i"], key): [sum(1 for k, time, _ in see_messages(step) if k == key and time - step["T"] == new) for new in (0, 1)]
        for step in steps
        for key in step["state"]["pl"]
    }


def test_asynchronous_messages_come_at_the_recorded_moments():
    """With one phase of the 300 ms period for all, and for each player one count of sub-ticks at the beginning."""
    recorded = recording("view_v17")
    case = cases(recorded)[0]
    told = asynchronous_counts(case["steps"])
    sim = Simulator(24)
    w = sim.world
    w["mode"], w["protocol"], w["synchronous"] = PlayMode.play_on, 17, 0
    w["steps"], w["see_counter"] = np.arange(24) // 8, np.arange(24)[:, None] % 8
    possible = {key: set(range(24)) for key in recorded.header["client_versions"]}
    for step in case["steps"]:
        for key, text in step.get("cmd", {}).items():
            record = command_record(parse_commands(text).commands[0])
            for world in range(24):
                sim.command_phase(world, ROW[key] + 1, record)
        for world in range(24):
            late_messages_due(w[world])
        late = w["saw"] >> 2 & 1
        sim.advance()
        early = (w["saw"] & 1) + (w["saw"] >> 1 & 1)
        for key, worlds in possible.items():
            row = ROW[key]
            worlds &= {k for k in worlds if [late[k, row], early[k, row]] == told[step["i"], key]}
    phases = [{world // 8 for world in worlds} for worlds in possible.values()]
    assert len(set.intersection(*phases)) == 1
    assert sum(map(sum, told.values())) == 289


def test_width_is_not_a_reset_of_the_see_counter():
    """Narrowing from normal to narrow brings a message at the next opportunity (specification/simulator.md 6.1.1)."""
    sim = Simulator(1)
    w = sim.world[0]
    w["mode"] = PlayMode.play_on
    due = []
    for cycle in range(8):
        if cycle == 4:
            w["view_width"][0] = 1
        sim.advance()
        due.append(int(w["saw"][0]))
    assert due == [0, 1, 0, 1, 1, 1, 1, 1]


def test_old_protocols_have_long_names_truncated_directions_and_no_outer_flags():
    sim = random_worlds(40, seed=5)
    sim.team_names = ("Ours", "Theirs")
    short, long, oldest = (" ".join(see_text(sim, k, 3, version) for k in range(40)) for version in (7, 5, 3))
    assert '((p "Theirs" ' in short
    assert "((player Theirs " in long
    assert "((f " in short
    assert "((flag " in long
    assert "((l " in short
    assert "((line " in long
    assert "((b) " in short
    assert "((ball) " in long
    assert "((flag t l 10)" in long
    assert "((flag t l 10)" not in oldest
    rounded, cut = (re.findall(r"\(\((?:f|flag) c\) [\d.]+ (-?\d+)", see_text_all(sim, version)) for version in (7, 6))
    differences = np.abs(np.array(rounded, int)) - np.abs(np.array(cut, int))
    assert set(differences) == {0, 1}


def see_text_all(sim, version):
    return " ".join(see_text(sim, k, 3, version) for k in range(sim.worlds))


def players_told(sim, version):
    """Trailing values of numbered players without marks in one message."""
    pattern = r'\(\((?:p|player) "?(?:Left|Right)"? \d+(?: goalie)?\) ([^()]*)\)'
    return [told.split() for told in re.findall(pattern, see_text_all(sim, version))]


def test_body_head_and_marks_come_with_their_versions():
    sim = random_worlds(30, seed=7, spread=0.2)
    assert {len(values) for values in players_told(sim, 3)} == {4}
    assert {len(values) for values in players_told(sim, 4)} == {5}
    assert {len(values) for values in players_told(sim, 5)} == {6}
    sim.world["kick_cycles"] = 0
    assert all(values[-1] != "k" for values in players_told(sim, 12))
    assert all(values[-1] == "k" for values in players_told(sim, 13))
    sim.world["tackle_cycles"] = 5
    assert all(values[-1] != "t" for values in players_told(sim, 7))
    assert all(values[-1] == "t" for values in players_told(sim, 8))
    sim.world["arm_timer"] = 0
    assert {len(values) for values in players_told(sim, 7)} == {6}
    assert {len(values) for values in players_told(sim, 8)} == {8}


def test_goalie_is_marked_only_together_with_the_number():
    sim = random_worlds(60, seed=9)
    text = see_text_all(sim, 19)
    assert re.search(r'\(p "Right" 1 goalie\)', text)
    assert not re.search(r'\(p "Right" 1\)', text)
    assert not re.search(r'"(?:Left|Right)" goalie', text)
    assert not re.search(r"\(p \"Right\" [2-9] goalie", text)


@pytest.mark.parametrize("protocol", [3, 4, 5])
def test_goalie_is_not_marked_before_version_6(protocol):
    text = see_text_all(random_worlds(60, seed=9), protocol)
    assert re.search(r"\(player Right 1\)", text)
    assert "goalie" not in text


def test_opponents_are_not_told_of_a_promoted_goalie():
    sim = random_worlds(60, seed=9)
    sim.world["goalie"] = 0
    sim.world["goalie"][:, 3] = 2
    assert '(p "Left" 4 goalie)' in see_text_all(sim, 19)
    assert "goalie" not in " ".join(see_text(sim, k, 14) for k in range(60))


def test_opponents_are_told_the_fixed_team_name():
    import dataclasses

    sim = random_worlds(20, seed=9)
    sim.parameters = dataclasses.replace(sim.parameters, fixed_teamname_r="Masked")
    assert '"Masked"' in see_text_all(sim, 19)
    assert '"Right"' not in see_text_all(sim, 19)
    theirs = " ".join(see_text(sim, k, 14) for k in range(20))
    assert '"Right"' in theirs
    assert '"Masked"' not in theirs


def test_nobody_there_is_a_message_with_the_time_only():
    sim = Simulator(1, left=1, right=0, goalies=(0, 0))
    w = sim.world[0]
    w["pos"][0], w["pos"][1], w["body"][0], w["view_width"][0], w["time"] = (0, 0), (2000, 0), 0.0, 1, 17
    assert see_text(sim, 0, 1) == "(see 17)"
    assert see_mismatches(sim, 0, 1, "(see 17)") == []


@pytest.mark.parametrize("player", [0, 23, True, 1.5])
def test_unknown_player_is_refused(player):
    with pytest.raises(CommandError, match="object number from 1 to 22"):
        see_text(Simulator(1), 0, player)


def test_unknown_world_and_protocol_are_refused():
    with pytest.raises(CommandError, match="`world` takes a number from 0 to 0, got 3"):
        see_text(Simulator(1), 3, 1)
    with pytest.raises(ParameterError, match="version from 3 to 19, got 20"):
        see_text(Simulator(1), 0, 1, 20)
