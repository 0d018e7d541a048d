"""Fouls and cards (specification/simulator.md 7.10)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from referee_scenes import QUIET, Scene, player
from scipy.stats import fisher_exact

from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import CommandKind, PlayMode


def duel(**parameters: Any) -> Scene:
    """l2 behind r2, who has the ball in front of him; nobody has dashed lately."""
    scene = Scene(**{"use_offside": False, **parameters}).step()
    return scene.put("l2", 0.0, 0.0, body=0.0).put("r2", 0.9, 0.0, body=0.0).put_ball(1.6, 0.0)


def force(scene: Scene, name: str, tackle: int = 1, foul: int = 0, card: int = 0) -> Scene:
    row = player(name) - 1
    scene.world["forced_tackle"][row], scene.world["forced_foul"][row], scene.world["forced_card"][row] = tackle, foul, card
    return scene


def test_detected_foul_on_a_running_player_is_called_at_the_tacklers_place():
    scene = force(duel(), "l2", foul=1).dash("r2", 1.0).tackle("l2")
    assert scene.mode == "foul_charge_l"
    assert scene.ball == (0.0, 0.0)
    assert scene.steps_until("free_kick_r") == 31


def test_fair_tackle_and_undetected_foul_are_not_called():
    assert force(duel(), "l2", foul=1).tackle("l2").mode == "play_on"  # he does not run
    assert force(duel(), "l2", foul=-1).dash("r2", 1.0).tackle("l2").mode == "play_on"


def test_player_who_ran_in_the_previous_cycle_can_still_be_fouled():
    scene = duel().dash("r2", 1.0).step()
    assert force(scene, "l2", foul=1).tackle("l2").mode == "foul_charge_l"
    scene = duel().dash("r2", 1.0).step(2)
    assert force(scene, "l2", foul=1).tackle("l2").mode == "play_on"


def test_player_who_faces_the_tackler_is_not_fouled():
    scene = duel().put("r2", 0.9, 0.0, body=math.pi).dash("r2", 1.0)
    assert force(scene, "l2", foul=1).tackle("l2").mode == "play_on"


def test_intentional_foul_freezes_the_victim_and_not_the_tackler():
    scene = force(duel(), "l2", foul=-1).tackle("l2", foul=True)
    row = player("r2") - 1
    assert scene.world["foul_cycles"][row] == 5
    assert scene.world["tackle_cycles"][player("l2") - 1] == 0
    scene.step().do("r2", CommandKind.TURN, 90.0)
    assert scene.world["counts"][row, 2] == 0
    scene.step(4).do("r2", CommandKind.TURN, 90.0)
    assert scene.world["counts"][row, 2] == 1


def test_intentional_foul_draws_a_yellow_card_and_the_second_one_sends_off():
    scene = force(duel(), "l2", foul=1).dash("r2", 1.0).tackle("l2", foul=True)
    scene.listen()
    assert scene.said == ["foul_charge_l", "yellow_card_l_2"]
    assert scene.world["card_count"][player("l2") - 1] == 1
    scene.sim.trainer.change_mode("play_on")
    scene.said.clear()
    scene.listen()
    scene.put("l2", 0.0, 0.0, body=0.0, velocity=(0.0, 0.0)).put("r2", 0.9, 0.0, body=0.0).put_ball(1.6, 0.0)
    scene.step(6).put("l2", 0.0, 0.0, body=0.0).put("r2", 0.9, 0.0, body=0.0).put_ball(1.6, 0.0)
    scene.said.clear()
    scene.dash("r2", 1.0).tackle("l2", foul=True)
    scene.listen()
    assert scene.said == ["foul_charge_l", "yellow_card_l_2", "red_card_l_2"]
    assert not scene.world["enabled"][player("l2") - 1]
    assert scene.world["bits"][player("l2") - 1] & 0x080100 == 0x080100


def test_red_card_at_once_when_its_probability_is_one():
    scene = force(duel(red_card_probability=1.0), "l2", foul=1).dash("r2", 1.0).tackle("l2", foul=True)
    scene.listen()
    assert scene.said == ["foul_charge_l", "red_card_l_2"]


def test_foul_in_the_own_penalty_area_gives_an_indirect_free_kick_there():
    scene = force(duel(), "l2", foul=1)
    scene.put("l2", -42.0, 10.0, body=0.0).put("r2", -41.1, 10.0, body=0.0).put_ball(-40.4, 10.0)
    scene.dash("r2", 1.0).tackle("l2")
    assert scene.mode == "foul_charge_l"
    assert scene.ball == (-42.0, 10.0)
    assert scene.steps_until("indirect_free_kick_r") == 31


def test_foul_in_the_opponents_penalty_area_is_moved_to_its_corner():
    scene = force(duel(), "l2", foul=1)
    scene.put("l2", 42.0, 10.0, body=0.0).put("r2", 42.9, 10.0, body=0.0).put_ball(43.6, 10.0)
    scene.dash("r2", 1.0).tackle("l2")
    assert scene.ball == (pytest.approx(36.0), pytest.approx(20.16))


def test_fouls_are_counted():
    scene = force(duel(), "l2", foul=1).dash("r2", 1.0).tackle("l2")
    assert scene.world["counts"][player("l2") - 1, 10] == 1


RECORDED = {
    # (intentional, victim dashed): successful tackles, fouls called, yellow cards, in the recording noise_foul
    (True, True): (43, 19, 19),
    (False, True): (208, 102, 0),
    (False, False): (251, 0, 0),
}


@pytest.mark.parametrize(("intentional", "dashed"), list(RECORDED))
def test_fouls_are_detected_as_often_as_by_the_server(intentional, dashed):
    worlds = 600
    sim = Simulator(worlds, ServerParameters(**{**QUIET, "use_offside": False}), seed=5, left=2, right=2)
    for number, x, y in ((1, -40.0, 0.0), (2, 0.0, 0.0), (12, 40.0, 0.0), (13, 0.9, 0.0)):
        sim.trainer.place_player(number, x, y, body=0.0)
    sim.trainer.place_ball(1.6, 0.0)
    sim.trainer.change_mode("play_on")
    sim.advance()
    sim.world["forced_tackle"][:, 1] = 1
    if dashed:
        sim.commands["kind"][:, 12], sim.commands["a"][:, 12], sim.commands["b"][:, 12] = CommandKind.DASH, 1.0, 0.0
    sim.commands["kind"][:, 1], sim.commands["a"][:, 1], sim.commands["b"][:, 1] = CommandKind.TACKLE, 0.0, float(intentional)
    dash = sim.commands.copy()
    dash["kind"][:, 1] = CommandKind.NONE
    sim.step(dash)  # so that he has dashed before the tackle, whatever the order of the commands
    sim.trainer.place_player(2, 0.0, 0.0, body=0.0, velocity=(0.0, 0.0))
    sim.trainer.place_player(13, 0.9, 0.0, body=0.0, velocity=(0.0, 0.0))
    sim.trainer.place_ball(1.6, 0.0)
    sim.step()
    fouls = int((sim.world["mode"] == PlayMode.foul_charge_l).sum())
    cards = int((sim.world["card_count"][:, 1] == 1).sum())
    trials, recorded_fouls, recorded_cards = RECORDED[intentional, dashed]
    for count, recorded in ((fouls, recorded_fouls), (cards, recorded_cards)):
        table = [[count, worlds - count], [recorded, trials - recorded]]
        assert fisher_exact(table).pvalue > 0.001, table
    if not dashed:
        assert fouls == 0
    assert np.array_equal(sim.world["card_count"][:, 1] == 1, (sim.world["mode"] == PlayMode.foul_charge_l) & intentional)
