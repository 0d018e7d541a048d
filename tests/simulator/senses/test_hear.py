"""Say and hear: range, capacity, attention, ears, order, text and arrays."""

import math

import numpy as np
import pytest
from scipy import stats

from cprm_gym.simulator.kernels.audio import say
from cprm_gym.simulator.kernels.referee.modes import announce
from cprm_gym.simulator.kernels.referee.set_mode import set_mode
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.protocol.message_parser import parse_hear
from cprm_gym.simulator.protocol.messages import broadcast_text, hear_text, referee_text, trainer_text
from cprm_gym.simulator.senses import hear, new_hear
from cprm_gym.simulator.simulator import Simulator, no_commands
from cprm_gym.simulator.state import SAY_QUEUE, Announcement, Count, PlayMode


def field(worlds=1, **changes):
    """Everybody within earshot, in play."""
    sim = Simulator(worlds, **changes)
    sim.world["mode"] = PlayMode.play_on
    sim.world["pos"][:, 1:, 0], sim.world["pos"][:, 1:, 1] = np.arange(22) % 11 * 2.0 - 10, np.arange(22) // 11 * 4.0
    return sim


def speak(sim, words, world=0):
    """Players (object numbers) say something now."""
    for player, text in words.items():
        data = np.frombuffer(text.encode(), np.uint8)
        say(sim.world[world], sim.packed[0], player - 1, data, len(data))


def test_a_message_is_heard_after_the_step_with_the_time_after_it():
    sim = field()
    commands = no_commands(1, 22)
    commands["say"][0, 0, :2], commands["say_length"][0, 0] = np.frombuffer(b"hi", np.uint8), 2
    sim.step(commands)
    assert hear_text(sim, 0, 1) == ['(hear 1 self "hi")']
    assert hear_text(sim, 0, 2) == ['(hear 1 180 our 1 "hi")']
    assert [parse_hear(text).sender for text in hear_text(sim, 0, 13)] == ["opp"]
    assert sim.world["counts"][0, 0, Count.SAY] == 1
    sim.advance()
    assert hear_text(sim, 0, 1) == []
    assert hear_text(sim, 0, 2) == []


@pytest.mark.parametrize(("distance", "heard"), [(50.0, True), (50.001, False)])
def test_the_range_is_inclusive_and_decided_when_it_is_said(distance, heard):
    sim = field()
    w = sim.world[0]
    w["pos"][1], w["pos"][2] = (0.0, 0.0), (0.0, distance)
    speak(sim, {1: "x"})
    w["pos"][2] = 0.0, 30.0 if heard else 10.0
    sim.advance()
    assert bool(hear_text(sim, 0, 2)) is heard


def test_the_direction_is_that_of_the_moment_of_hearing_relative_to_the_body_truncated():
    sim = field()
    w = sim.world[0]
    w["pos"][1], w["pos"][2], w["body"][1], w["body_staged"][1], w["neck"][1] = (30.0, 20.0), (20.0, 20.0), 0.3, 0.3, 0.9
    speak(sim, {1: "x"})
    w["pos"][1] = 30.0, 30.0
    sim.advance()
    assert hear_text(sim, 0, 2) == ['(hear 1 27 our 1 "x")']  # 45 - 17.19 = 27.81
    assert hear_text(sim, 0, 2, 7) == ['(hear 1 28 "x")']
    assert hear_text(sim, 0, 2, 6) == ["(hear 1 27 x)"]
    assert hear(sim.world, sim.packed).direction[0, 1, 0] == pytest.approx(math.radians(27))


@pytest.mark.parametrize(("protocol", "told"), [(7, '(hear 0 28 "x")'), (6, "(hear 0 27 x)"), (3, "(hear 0 27 x)")])
def test_clients_before_version_8_hear_at_once(protocol, told):
    """At the time and from where it is said, one of each team, in the order in which it is said."""
    sim = field()
    w = sim.world[0]
    w["pos"][1], w["pos"][2], w["body"][1], w["body_staged"][1], w["neck"][1] = (30.0, 30.0), (20.0, 20.0), 0.3, 0.3, 0.9
    w["protocol"][1] = protocol
    speak(sim, {1: "x", 3: "y", 2: "own"})
    assert hear_text(sim, 0, 2)[0] == told
    w["pos"][1] = 0.0, -30.0
    sim.advance()
    quote = '"' if protocol == 7 else ""
    assert hear_text(sim, 0, 2) == [told, f"(hear 0 self {quote}own{quote})"]
    assert math.degrees(hear(sim.world, sim.packed).direction[0, 1, 0]) == pytest.approx(28 if protocol == 7 else 27)
    assert [parse_hear(text).message for text in hear_text(sim, 0, 2)] == ["x", "own"]
    speak(sim, {3: "z"})
    assert len(hear_text(sim, 0, 2)) == 1
    sim.advance()
    sim.advance()
    assert hear_text(sim, 0, 2) == []


def test_one_message_of_each_team_is_heard_per_cycle():
    sim = field()
    for _ in range(3):
        speak(sim, {player: f"m{player}" for player in range(1, 23)})
        sim.advance()
        for player in (1, 15):
            heard = [parse_hear(text) for text in hear_text(sim, 0, player)]
            assert heard[0].sender == "self"
            assert heard[0].message == f"m{player}"
            assert sorted(message.sender for message in heard[1:]) == ["opp", "our"]
            assert all(message.unum is None for message in heard if message.sender == "opp")


def test_capacity_counts_by_the_servers_parameters():
    """hear_inc 1, hear_decay 2, hear_max 2: every second cycle, as the manual has it."""
    sim = field(parameters=ServerParameters(hear_max=2, hear_inc=1, hear_decay=2))
    heard = []
    for _ in range(6):
        speak(sim, {1: "x"})
        sim.advance()
        heard.append(len(hear_text(sim, 0, 2)))
    assert heard == [1, 0, 1, 0, 1, 0]


def test_the_attention_target_is_heard_first():
    sim = field(worlds=50)
    sim.world["attention"][:, 0] = 7
    for world in range(50):
        speak(sim, {player: f"m{player}" for player in (2, 3, 7, 14, 16)}, world)
    sim.advance()
    for world in range(50):
        heard = [parse_hear(text) for text in hear_text(sim, world, 1)]
        assert heard[0].unum == 7
        assert [message.sender for message in heard] == ["our", "opp"]


def test_a_partial_ear_hears_that_somebody_spoke():
    sim = field()
    w = sim.world[0]
    w["ear"][0] = 3
    speak(sim, {2: "a", 3: "b", 14: "c", 15: "d"})
    sim.advance()
    heard = [parse_hear(text) for text in hear_text(sim, 0, 1)]
    assert sorted((message.sender, message.message is not None) for message in heard) == [
        ("opp", False), ("opp", True), ("our", False), ("our", True)
    ]  # fmt: skip
    assert {message.unum for message in heard if message.sender == "our"} == {2, 3}
    assert all(message.direction is None for message in heard if message.message is None)
    assert len(hear_text(sim, 0, 1, 7)) == 2  # old clients are not told
    w["ear"][0] = 2  # nothing but partial: as recorded, nothing is told while there is capacity, which nothing uses up
    speak(sim, {2: "a", 3: "b"})
    sim.advance()
    assert hear_text(sim, 0, 1) == []
    w["hear_capacity"][0] = -10
    speak(sim, {2: "a"})
    sim.advance()
    assert hear_text(sim, 0, 1) == ["(hear 3 our 2)"]


def test_old_clients_have_no_ears_to_close():
    """As recorded: up to protocol 7 `ear` changes nothing."""
    sim = field()
    w = sim.world[0]
    w["ear"][0], w["ear"][1] = 0, 0
    w["protocol"][0], w["protocol"][1] = 7, 8
    speak(sim, {3: "a", 14: "b"})
    assert w["heard_count"][0] == 2
    sim.advance()
    assert len(hear_text(sim, 0, 1, 7)) == 2
    assert hear_text(sim, 0, 2) == []


def test_a_closed_ear_hears_nothing_of_that_side():
    sim = field()
    sim.world["ear"][0, 0] = 1, 0
    speak(sim, {2: "a", 14: "c"})
    sim.advance()
    assert [parse_hear(text).sender for text in hear_text(sim, 0, 1)] == ["our"]


def test_too_long_messages_are_dropped_and_not_counted():
    sim = field()
    speak(sim, {1: "0123456789", 2: "0123456789a"})
    sim.advance()
    assert hear_text(sim, 0, 1) == ['(hear 1 self "0123456789")']
    assert hear_text(sim, 0, 2)[-1].endswith('our 1 "0123456789")')
    assert sim.world["counts"][0, :2, Count.SAY].tolist() == [1, 0]


def test_one_player_may_say_several_things_and_a_full_queue_drops_the_rest():
    sim = field()
    for k in range(SAY_QUEUE + 5):
        speak(sim, {1: f"{k}"})
    sim.advance()
    assert hear_text(sim, 0, 1) == [f'(hear 1 self "{k}")' for k in range(SAY_QUEUE)]
    assert sim.world["counts"][0, 0, Count.SAY] == SAY_QUEUE + 5


def test_arrays_and_texts_tell_the_same():
    sim = field(worlds=20, seed=3)
    sim.world["ear"][:, ::3] = 3
    for world in range(20):
        speak(sim, {player: f"w{player}" for player in range(1, 23, 1 + world % 3)}, world)
    sim.advance()
    out = new_hear(20, slots=12)
    for array in out:
        array[...] = 1
    hear(sim.world, sim.packed, out)
    for world in range(20):
        for row in range(22):
            told = [parse_hear(text) for text in hear_text(sim, world, row + 1)]
            told = [message for message in told if message.sender != "self"]
            assert out.heard[world, row] == len(told)
            for slot in range(12):
                sender, level = out.sender[world, row, slot], out.level[world, row, slot]
                if slot >= len(told):
                    assert sender == level == 0
                    assert not out.text[world, row, slot].any()
                    continue
                message = told[slot]
                assert sender == (1 if message.sender == "our" else 2)
                assert level == (1 if message.message is None else 2)
                assert out.unum[world, row, slot] == (message.unum or 0)
                text = bytes(out.text[world, row, slot][: out.length[world, row, slot]]).decode()
                assert text == (message.message or "")
                assert math.degrees(out.direction[world, row, slot]) == pytest.approx(message.direction or 0)


def test_messages_without_a_slot_are_counted():
    sim = field()
    sim.world["ear"][0, 0] = 3
    speak(sim, dict.fromkeys(range(2, 12), "x"))
    sim.advance()
    out = hear(sim.world, sim.packed, new_hear(1, slots=2))
    assert out.heard[0, 0] == 10
    assert (out.level[0, 0] > 0).all()


def test_who_is_heard_has_the_recorded_frequencies():
    """Seven speakers, none or one of them attended to: two-sample test against the counts of the real server."""
    from senses_recordings import recording

    names = {"two": 2, "three": 3, "four": 4, "five": 5, "r1": 12, "r2": 13, "r3": 14}
    targets = {None: 0, "(attentionto our 4)": 4, "(attentionto opp 2)": 13}
    n = 1000
    for record in recording("noise_hear").records:
        sim = field(worlds=n, seed=targets[record["attention"]])
        sim.world["attention"][:, 0] = targets[record["attention"]]
        for world in range(n):
            speak(sim, {player: name for name, player in names.items()}, world)
        sim.advance()
        heard = [parse_hear(text).message for world in range(n) for text in hear_text(sim, world, 1)]
        for team in (("two", "three", "four", "five"), ("r1", "r2", "r3")):
            chosen = [name for name in team if name in record["heard_full"]]
            counts = np.array([[record["heard_full"][name] for name in chosen], [heard.count(name) for name in chosen]])
            assert counts.sum(axis=1).tolist() == [record["n"], n]
            assert len(chosen) == 1 or stats.chi2_contingency(counts).pvalue > 1e-3


def test_the_referee_and_the_trainer_are_heard_without_ears():
    sim = Simulator(1)
    sim.world["ear"] = 0
    set_mode(sim.world[0], sim.packed[0], int(PlayMode.kick_in_l))
    assert referee_text(sim, 0) == ["(hear 0 referee kick_in_l)"]
    assert trainer_text(103, "hi_all") == '(hear 103 coach "hi_all")'
    assert trainer_text(103, "hi_all", 6) == "(hear 103 referee hi_all)"


def test_changed_players_are_told_to_each_team_as_it_may_know():
    sim = Simulator(1)
    w = sim.world[0]
    announce(w, int(Announcement.CHANGE_PLAYER_TYPE), -1, 3, 7)
    announce(w, int(Announcement.PROMOTE_GOALIE), 1, 5, 0)
    assert referee_text(sim, 0) == []
    assert broadcast_text(sim, 0, 13) == ["(change_player_type 3 7)", "(change_player_type l 5 goalie)"]
    assert broadcast_text(sim, 0, 2) == ["(change_player_type 3)", "(change_player_type l 5 goalie)"]
    assert broadcast_text(sim, 0, 2, 15) == ["(change_player_type 3)"]
    assert broadcast_text(sim, 0, 2, 6) == []
