"""Films, game logs and the command that makes them."""

import gc
import os

import gymnasium
import imageio.v2 as imageio
import numpy as np
import pytest
from typer.testing import CliRunner

from cprm_gym.cli import app
from cprm_gym.envs import SoccerVectorEnv, soccer_v2
from cprm_gym.envs.play import Film, play
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import UnknownName
from cprm_gym.simulator.gamelog.reader import GameLogReader

# imageio leaves the pipes to its encoder to the garbage collector, which complains
leaves_pipes = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning", "ignore::ResourceWarning")


def pictures_of(path):
    with imageio.get_reader(path) as reader:
        pictures = [np.asarray(picture) for picture in reader]
    del reader
    gc.collect()
    return pictures


@leaves_pipes
@pytest.mark.parametrize("ending", [".mp4", ".gif"])
def test_play_records_films(tmp_path, ending):
    path = tmp_path / f"game{ending}"
    result = CliRunner().invoke(app, ["play", "--task", "Keepaway3v2", "--cycles", "8", "--record", str(path)])
    assert result.exit_code == 0, result.output
    pictures = pictures_of(path)
    assert len(pictures) == 9
    assert pictures[0].shape[:2] == (654, 920)
    assert (pictures[0] != pictures[-1]).any()
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_play_records_game_logs(tmp_path):
    path = tmp_path / "game.rcg"
    result = CliRunner().invoke(app, ["play", "--cycles", "30", "--others", "strong,weak", "--record", str(path)])
    assert result.exit_code == 0, result.output
    assert "30 cycles" in result.output
    frames = list(GameLogReader(path))
    assert len(frames) >= 29
    assert np.abs(frames[-1].players["pos"] - frames[0].players["pos"]).max() > 1.0


def test_play_shows_the_pitch_and_refuses_other_names(tmp_path):
    folder = tmp_path / "folder.gif"
    folder.mkdir()
    result = CliRunner().invoke(app, ["play", "--task", "GoToBall", "--controller", "fsm", "--seed", "3"])
    assert result.exit_code == 0, result.output
    assert "GoToBall, seed 3: SUCCESS" in result.output
    for arguments, message in (
        (["--task", "GoToBal"], "Did you mean 'GoToBall'"),
        (["--record", str(tmp_path / "game.avi")], "allowed are files that end in .mp4, .gif, .rcg, .rcg.gz"),
        (["--others", "strongest"], "Did you mean 'strong'"),
        (["--controller", "fsmm"], "Did you mean 'fsm'"),
        (["--cycles", "0"], "cycles: 0 given; allowed is 1 and more"),
        (["--record", str(tmp_path / "nowhere" / "game.rcg")], "there is no folder"),
        (["--record", str(folder)], "that is a folder; give the name of a file"),
    ):
        result = CliRunner().invoke(app, ["play", "--cycles", "1", *arguments])
        assert result.exit_code == 2
        assert message in " ".join(result.output.split())
    assert list(tmp_path.iterdir()) == [folder]


def test_controllers_are_given_what_they_need_to_see():
    result = CliRunner().invoke(app, ["play", "--task", "Goalie", "--controller", "goalie_raw", "--cycles", "3"])
    assert result.exit_code == 0, result.output
    assert "Goalie, seed 0: IN_GAME, 3 cycles" in result.output


def test_a_film_that_fails_leaves_nothing(tmp_path, monkeypatch):
    course = play(make_task("GoToBall"), cycles=3)
    core, _ = next(course)
    film = Film(tmp_path / "a.gif", core)
    film.add()
    film.__exit__(RuntimeError, RuntimeError("enough"), None)
    assert list(tmp_path.iterdir()) == []
    film = Film(tmp_path / "a.gif", core)
    film.add()
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        film.__exit__(None, None, None)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(UnknownName, match=r"record .*a\.webm"):
        Film(tmp_path / "a.webm", core)


@leaves_pipes
@pytest.mark.filterwarnings("ignore::DeprecationWarning:moviepy.*")
def test_gymnasium_records_videos(tmp_path):
    env = gymnasium.make("cprm/GoToBall-v2", render_mode="rgb_array", max_episode_steps=6)
    env = gymnasium.wrappers.RecordVideo(env, str(tmp_path / "videos"), episode_trigger=lambda episode: True, disable_logger=True)
    env.reset(seed=1)
    over = False
    while not over:
        _, _, terminated, truncated, _ = env.step([1, 4, 11, 0])
        over = terminated or truncated
    env.close()
    (video,) = tmp_path.glob("videos/*.mp4")
    assert len(pictures_of(video)) == 7


def watched(env):
    """The wrapped environment, and the pictures that it has given."""
    drawn = []
    draw = env.render

    def render():
        drawn.append(draw())
        return drawn[-1]

    env.render = render
    return env, drawn


def ends_on(video, picture):
    """Whether the last picture of a film is this one, and no other, up to what its compression does."""
    pictures = pictures_of(video)
    gaps = [np.abs(shown.astype(int) - picture).mean() for shown in pictures]
    return int(np.argmin(gaps)) == len(gaps) - 1


@leaves_pipes
@pytest.mark.filterwarnings("ignore::DeprecationWarning:moviepy.*")
def test_films_of_worlds_end_with_the_last_cycle(tmp_path):
    env = gymnasium.make_vec("cprm/GoToBall-v2", num_envs=1, render_mode="rgb_array", max_episode_steps=8)
    env, drawn = watched(env)
    env = gymnasium.wrappers.vector.RecordVideo(env, str(tmp_path / "videos"), episode_trigger=lambda episode: episode == 0)
    env.reset(seed=1)
    for _ in range(8):
        _, _, _, truncated, _ = env.step(np.array([[1, 4, 11, 0]]))
    assert truncated[0]
    last = drawn[8][0]
    for _ in range(2):
        env.step(np.array([[1, 4, 11, 0]]))
    env.close()
    (video,) = tmp_path.glob("videos/*.mp4")
    assert ends_on(video, last)


@leaves_pipes
@pytest.mark.filterwarnings("ignore::DeprecationWarning:moviepy.*")
def test_films_of_pettingzoo_end_with_the_last_cycle(tmp_path):
    from pettingzoo.utils.wrappers import RecordVideoParallel

    env, drawn = watched(soccer_v2.parallel_env(task="HFO2v1", render_mode="rgb_array", max_cycles=8))
    env = RecordVideoParallel(env, str(tmp_path / "videos"), episode_trigger=lambda episode: True, disable_logger=True)
    env.reset(seed=1)
    while env.agents:
        env.step({agent: np.array([1, 4, 11, 0]) for agent in env.agents})
    env.close()
    (video,) = tmp_path.glob("videos/*.mp4")
    assert ends_on(video, drawn[-1])


def test_worlds_are_drawn_each_for_itself():
    env = SoccerVectorEnv(3, "HFO1v1", render_mode="rgb_array")
    env.reset(seed=5)
    pictures = env.render()
    assert len(pictures) == 3
    assert not np.array_equal(pictures[0], pictures[1])
    alone = gymnasium.make("cprm/HFO1v1-v2", render_mode="rgb_array").unwrapped
    alone.core.sim.first_world = 2
    alone.reset(seed=5)
    np.testing.assert_array_equal(pictures[2], alone.render())
    env.close()
    assert SoccerVectorEnv(2).render() is None
    texts = SoccerVectorEnv(2, render_mode="ansi")
    texts.reset(seed=0)
    assert all(isinstance(text, str) for text in texts.render())
    with pytest.raises(UnknownName, match="allowed are rgb_array, ansi or None"):
        SoccerVectorEnv(2, render_mode="human")
