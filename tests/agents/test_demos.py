"""The demonstrations as they are shown: scenes, panels in words, films."""

from itertools import islice

import numpy as np
import pytest
from typer.testing import CliRunner

from cprm_gym.agents.demos import PANEL, Recorder, _object_number, believed_ball, panel, play
from cprm_gym.agents.net_view import NetView
from cprm_gym.agents.striker import STRIKER_NET
from cprm_gym.cli import app
from cprm_gym.envs.rendering import Viewer
from cprm_gym.errors import CprmError, UnknownName


def test_the_striker_is_shown_until_it_has_scored():
    scenes = list(play("striker", seed=0))
    assert scenes[-1].success
    assert scenes[-1].status == "GOAL"
    assert [s.cycle for s in scenes] == list(range(len(scenes)))
    assert not scenes[0].success


def test_the_panel_names_the_modules_at_work_with_what_is_marked_in_them_and_the_commands():
    (scene,) = [s for s in islice(play("striker", seed=0), 0, 90) if s.cycle == 89]
    lines = panel(scene.players[0])
    assert lines[0] == "left_1: striker"
    active = [line for line in lines if "[" in line]
    assert active[0].startswith("  dribble [")
    assert active[1].startswith("    go [") or active[1].startswith("    kick [")
    assert any(line.startswith("  ball at ") for line in lines)
    assert any(line.startswith("  look direction ") for line in lines)


def test_both_passers_are_shown_and_believe_the_ball_near_where_it_is():
    (scene,) = [s for s in islice(play("passers", seed=0), 0, 31) if s.cycle == 30]
    assert [p.name for p in scene.players] == ["left_1", "left_2"]
    for player in scene.players:
        assert np.hypot(*(player.points[-1, :2] - scene.world["pos"][0])) < 2.0


def test_of_the_eleven_the_two_nearest_to_the_ball_are_shown():
    (scene,) = [s for s in islice(play("eleven", seed=0), 0, 16) if s.cycle == 15]
    gaps = np.hypot(*(scene.world["pos"][1:12] - scene.world["pos"][0]).T)
    assert {p.number - 1 for p in scene.players} == set(np.argsort(gaps)[:2].tolist())
    lines = panel(scene.players[0])
    assert lines[0].endswith(": outfielder")
    assert any("rival_x" in line for line in lines)


def test_on_memory_a_striker_reckons_and_on_the_belief_everybody_believes():
    (reckoning,) = next(play("striker", seed=0, tier="memory")).players[:1]
    assert "reckons" in panel(reckoning)
    assert not {"believes", "beliefs"} & set(panel(reckoning))
    for name in ("striker", "goalie"):
        assert "believes" in panel(next(play(name, seed=0)).players[0]), name


def test_who_is_watched_and_who_has_the_ball_is_told_and_shown():
    scenes = list(islice(play("goalie", seed=1, model="bins"), 12))
    assert scenes[-1].players[0].marks == {12: "watched", 13: "watched"}
    assert {"  watched: right 1", "  watched: right 2"} <= set(panel(scenes[-1].players[0]))
    viewer = Viewer("rgb_array")
    plain, marked = (viewer.draw(scenes[-1].world, marks=marks) for marks in (None, scenes[-1].players[0].marks))
    assert (plain != marked).any()
    (scene,) = [s for s in islice(play("passers", seed=0), 0, 31) if s.cycle == 30]
    assert all("partner" in player.marks[number].split(", ") for player, number in zip(scene.players, (2, 1)))


def test_objects_have_the_numbers_of_their_players():
    assert [_object_number(name, 3) for name in ("o2", "t5", "m1", "m3")] == [13, 5, 1, 4]
    assert [_object_number(name, 14) for name in ("o2", "t5", "m1", "m3")] == [2, 16, 12, 15]


def test_the_mode_of_a_belief_lies_above_what_is_less_likely_and_nothing_is_not_seen():
    world = next(play("striker", seed=0)).world
    viewer = Viewer("rgb_array")
    mode = [30.0, 20.0, 1.0]
    pictures = [viewer.draw(world, belief=np.array(points)) for points in ([mode], [mode, [30.0, 20.0, 0.02]], [mode, [-30.0, 20.0, 0.0]])]
    assert (pictures[0] == pictures[1]).all()
    assert (pictures[0] == pictures[2]).all()


def test_the_net_is_drawn_with_its_tokens_its_modules_at_work_and_what_fires():
    pygame = pytest.importorskip("pygame", reason="films need the extra 'render'")
    view = NetView(STRIKER_NET, 1000, 400, pygame)
    empty = view.draw({})
    assert empty.shape[1] == 1000
    for marking, fired in (({"intend": 1.0}, ()), ({"dribble.ongoing": 1.0}, ()), ({}, ("look",))):
        assert (view.draw(marking, fired) != empty).any()
    assert (view.draw({}) == empty).all()


def test_a_place_that_was_not_seen_for_long_fades():
    class Blind:
        controller = None

    def observed(age):
        return {"memory_age": np.full((1, 23), age), "memory": np.zeros((1, 23, 4))}

    weights = [believed_ball(Blind(), observed(age))[0, 2] for age in (0.0, 5.0, 500.0)]
    assert weights[0] == 1.0
    assert weights[0] > weights[1] > weights[2] > 0.0


def test_a_film_appears_when_it_is_finished_and_not_before(tmp_path):
    pytest.importorskip("imageio", reason="films need the extra 'render'")
    path = tmp_path / "striker.gif"
    film = Recorder(path)
    pictures = [film.add(scene) for scene in islice(play("striker", seed=0), 3)]
    assert not path.exists()
    film.close()
    assert path.read_bytes()[:4] == b"GIF8"
    assert [p.name for p in tmp_path.iterdir()] == ["striker.gif"]
    assert pictures[0].shape[1] == 920 + PANEL
    assert pictures[0].shape[0] > 654 + 200, "the net stands beneath the field"
    assert pictures[0].dtype == np.uint8
    given_up = Recorder(tmp_path / "other.gif")
    given_up.discard()
    assert [p.name for p in tmp_path.iterdir()] == ["striker.gif"]


def test_other_films_and_demonstrations_are_refused():
    with pytest.raises(CprmError, match=r"film.avi: allowed are files that end in .mp4 and .gif"):
        Recorder("film.avi")
    with pytest.raises(UnknownName, match=r"unknown demonstration 'stricker'\. Did you mean 'striker'"):
        next(play("stricker"))


def test_the_command_prints_the_field_and_the_nets():
    result = CliRunner().invoke(app, ["demo", "striker", "--every", "60"])
    assert result.exit_code == 0
    assert "striker, seed 0: goal" in result.output
    assert "setup [" in result.output
    assert "dribble [" in result.output
    assert CliRunner().invoke(app, ["demo", "nobody"]).exit_code == 2
