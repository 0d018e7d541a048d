"""The pictures: the pitch, and the region in which a task plays."""

import numpy as np
import pytest

pytest.importorskip("pygame")

import cprm_gym  # noqa: F401
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.rendering import BOARD, Viewer, text_picture, zoom_to
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import CprmError


def picture(name, region):
    core = SoccerCore(make_task(name), 1)
    core.reset(1)
    return Viewer("rgb_array", region=region).draw(core.sim.world[0]), core


def test_the_square_of_keepaway_has_a_border_and_lies_in_the_light():
    plain, core = picture("Keepaway3v2", (52.5, 34.0))
    framed, _ = picture("Keepaway3v2", core.task.region)
    assert framed.shape == plain.shape
    height, width = framed.shape[0] - BOARD, framed.shape[1]
    middle = BOARD + height // 2
    zoom = zoom_to(core.task.region)
    edge = width // 2 - round(10.0 * 8 * zoom)
    border = framed[middle + 40, edge - 3 : edge + 4].astype(int)
    assert (border[:, 0] > 180).any(), "a bright line where the square ends"
    outside, inside = framed[middle + 40, edge - 60].astype(int), framed[middle + 40, edge + 25].astype(int)
    assert inside.sum() > 1.2 * outside.sum()
    assert zoom > 2.0


def test_a_region_as_large_as_the_pitch_changes_nothing():
    whole, _ = picture("Soccer11v11", (52.5, 34.0))
    core = SoccerCore(make_task("Soccer11v11"), 1)
    core.reset(1)
    assert np.array_equal(whole, Viewer("rgb_array").draw(core.sim.world[0]))
    assert zoom_to(core.task.region) == 1.0


def test_the_environment_draws_the_square_of_its_task():
    import gymnasium

    env = gymnasium.make("cprm/Keepaway3v2-v2", render_mode="rgb_array")
    env.reset(seed=1)
    core = env.unwrapped.core
    assert np.array_equal(env.render(), Viewer("rgb_array", region=core.task.region).draw(core.sim.world[0]))
    env.close()


def test_the_text_shows_the_square_and_everybody_in_it():
    core = SoccerCore(make_task("Keepaway3v2"), 1)
    core.reset(1)
    text = text_picture(core.sim.world[0], region=core.task.region)
    lines = text.splitlines()
    assert text.count(".") > 100
    for mark in "123abo":
        assert sum(line.count(mark) for line in lines[2:-1]) == 1
    assert "." not in text_picture(core.sim.world[0])


def test_a_window_without_a_display_is_refused(monkeypatch):
    import pygame

    viewer = Viewer("human")
    core = SoccerCore(make_task("GoToBall"), 1, seed=0)
    core.reset(0)
    monkeypatch.delenv("SDL_VIDEODRIVER", raising=False)
    monkeypatch.setattr(pygame.display, "get_driver", lambda: "offscreen")
    with pytest.raises(CprmError, match="no display for a window; use the mode 'rgb_array'"):
        viewer.draw(core.sim.world[0])


class Enlarged(Viewer):
    """Draws everything on one enlarged picture and reduces that: the oracle of patches."""

    def _patch(self, surface, points, margin, paint):
        if self.whole is None:
            self.whole = self._background()
        paint(self.whole)


def test_patches_of_the_picture_are_those_of_the_whole_drawn_enlarged():
    import pygame

    core = SoccerCore(make_task("Soccer11v11"), 1)
    core.reset(4)
    rng = np.random.default_rng(1)
    world = core.sim.world[0]
    world["pos"][1:] = rng.uniform((-54, -36), (54, 36), (22, 2))
    world["body"], world["neck"] = rng.uniform(-3, 3, (2, 22))
    world["tackle_cycles"][4] = 3
    whole = Enlarged("rgb_array")
    whole.whole = None
    whole.draw(world, marks={3: "waits"})
    expected = pygame.surfarray.array3d(pygame.transform.smoothscale(whole.whole, whole.size)).transpose(1, 0, 2)
    drawn = Viewer("rgb_array").draw(world, marks={3: "waits"})
    off = np.abs(drawn.astype(int) - expected).max(axis=2)
    assert (off > 8).mean() < 1e-4
    empty = Viewer("rgb_array")
    world["enabled"] = 0
    assert (empty.draw(world) != drawn).any(axis=2).mean() > 0.005, "so much of it is players"


def test_a_picture_belongs_to_who_asked_for_it():
    core = SoccerCore(make_task("GoToBall"), 1, seed=0)
    core.reset(1)
    viewer = Viewer("rgb_array")
    first = viewer.draw(core.sim.world[0])
    kept = first.copy()
    first[...] = 0
    np.testing.assert_array_equal(viewer.draw(core.sim.world[0]), kept)
