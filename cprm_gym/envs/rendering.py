"""The pitch as a window, an RGB array or text.

pygame-ce is imported when a picture is first drawn, and only its display and font modules are started: no sound, no joystick.
"""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from ..errors import CprmError
from ..simulator.parameters import ServerParameters
from ..simulator.pitch import (
    CENTRE_RADIUS,
    GOAL_AREA_LENGTH,
    GOAL_AREA_Y,
    GOAL_DEPTH,
    HALF_LENGTH,
    HALF_WIDTH,
    PENALTY_AREA_LENGTH,
    PENALTY_Y,
    PITCH_LENGTH,
    PITCH_MARGIN,
    PITCH_WIDTH,
    post_centre,
)
from ..simulator.state import PlayMode

LENGTH, WIDTH, MARGIN = PITCH_LENGTH, PITCH_WIDTH, PITCH_MARGIN
FPS = 10
"""Cycles of 100 ms."""
SCALE = 8
"""Pixels per metre."""
SMOOTH = 2
"""Everything is drawn this many times larger and then reduced, which smooths the edges: the pitch once, then only where something moves."""
BOARD = 30
"""Height of the score board, pixels."""
TRAIL = 20
"""Ball positions kept for the trail."""
SPOT = HALF_LENGTH - 11.0
"""|x| of the penalty spots, m."""
DISC = 1.05
"""Radius at which players are drawn, m; larger than they are."""
CONE = {1: math.radians(60), 2: math.radians(120), 3: math.radians(180)}

APRON = 4.0
"""Metres shown around a region that is smaller than the pitch."""
PITCH = (LENGTH / 2, WIDTH / 2)

_GRASS, _GRASS_2, _LINE = (52, 126, 62), (57, 134, 67), (235, 242, 235)
_LEFT, _RIGHT = (246, 205, 70), (225, 72, 66)
_LEFT_KEEPER, _RIGHT_KEEPER = (84, 196, 130), (160, 90, 210)
_DARK, _BALL, _BOARD_COLOUR = (24, 28, 26), (255, 255, 255), (20, 34, 26)
_REGION, _OUTSIDE = (250, 214, 120), (8, 26, 14, 105)


def zoom_to(region: tuple[float, float]) -> float:
    """How many times larger than the pitch a region (half length, half width, m) around the centre is drawn."""
    if region[0] >= PITCH[0] or region[1] >= PITCH[1]:
        return 1.0
    return min((PITCH[0] + MARGIN) / (region[0] + APRON), (PITCH[1] + MARGIN) / (region[1] + APRON))


class Viewer:
    """Draws one world.

    Parameters
    ----------
    mode : str
        ``human``, ``rgb_array`` or ``ansi``.
    fps : int
        Pictures per second of the window.
    region : (float, float)
        Half length and half width of where the game takes place, m (`Task.region`). If it is smaller than the pitch, the picture shows
        it from nearby and what is outside lies in the shade.
    goal_width : float
        Of the server, m.

    Raises
    ------
    CprmError
        When pygame-ce is needed and not installed.
    """

    def __init__(
        self, mode: str, fps: int = 10, region: tuple[float, float] = PITCH, goal_width: float = ServerParameters().goal_width
    ) -> None:
        self.mode = mode
        self.goal_width = goal_width
        self.region = region
        zoom = zoom_to(region)
        self._scale = SCALE * SMOOTH * zoom
        # players and ball grow less than the pitch: far away they are drawn larger than they are
        self._unit = SCALE * SMOOTH * zoom**0.4
        self.fps = fps
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL)
        self._last_time = -1
        self._window: Any = None
        self._clock: Any = None
        self._pitch: Any = None
        self._corner = (0.0, 0.0)
        self._fonts: dict[int, Any] = {}
        self._pygame: Any = None
        if mode != "ansi":
            os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
            try:
                import pygame
            except ImportError:
                message = f"render_mode {mode!r} needs pygame-ce: pip install 'cprm-gym[render]' (or use render_mode 'ansi')"
                raise CprmError(message) from None
            pygame.font.init()
            self._pygame = pygame

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture, pixels."""
        return int((LENGTH + 2 * MARGIN) * SCALE), int((WIDTH + 2 * MARGIN) * SCALE) + BOARD

    def draw(
        self,
        world: np.void,
        cones: tuple[int, ...] = (),
        belief: np.ndarray | None = None,
        marks: Mapping[int, str] | None = None,
    ) -> np.ndarray | str | None:
        """The picture of a world.

        Parameters
        ----------
        world : record of `WORLD`
        cones : tuple of int
            Object numbers of the players whose view cone is shown.
        belief : (n, 3) array, optional
            Points x, y and weight in [0, 1]: where somebody believes the ball to be. The likelier lie above, and 0 is not seen.
        marks : mapping of int to str, optional
            Object number -> what is said of him, beside a ring around him.

        Returns
        -------
        (H, W, 3) uint8 array, str or None
            For ``rgb_array``, ``ansi`` and ``human``.
        """
        if self.mode == "ansi":
            return text_picture(world, region=self.region)
        pygame = self._pygame
        steps = int(world["steps"])
        if steps < self._last_time or steps > self._last_time + TRAIL:
            self.trail.clear()
        if steps != self._last_time:
            self.trail.append((float(world["pos"][0, 0]), float(world["pos"][0, 1])))
            self._last_time = steps
        surface = self._picture(world, cones, belief, marks or {})
        if self.mode == "rgb_array":
            # one pass over the pixels; `surfarray` gives columns first, which would have to be turned
            return np.frombuffer(bytearray(pygame.image.tobytes(surface, "RGB")), np.uint8).reshape(*surface.get_size()[::-1], 3)
        if self._window is None:
            pygame.display.init()
            driver = pygame.display.get_driver()
            if driver in ("dummy", "offscreen") and not os.environ.get("SDL_VIDEODRIVER"):
                pygame.display.quit()
                raise CprmError("no display for a window; use the mode 'rgb_array' or 'ansi', or set SDL_VIDEODRIVER to draw unseen")
            self._window = pygame.display.set_mode(self.size)
            pygame.display.set_caption("cprm_gym")
            self._clock = pygame.time.Clock()
        pygame.event.pump()
        self._window.blit(surface, (0, 0))
        pygame.display.flip()
        self._clock.tick(self.fps)
        return None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._pygame.display.quit()
            self._window = None

    # ------------------------------------------------------------------ parts of the picture

    def _at(self, x: float, y: float) -> tuple[float, float]:
        """Where a place of the pitch is on the enlarged surface that is being drawn on."""
        k, (left, top) = SCALE * SMOOTH, self._corner
        return x * self._scale + (LENGTH / 2 + MARGIN) * k - left, y * self._scale + (WIDTH / 2 + MARGIN) * k + BOARD * SMOOTH - top

    def _patch(self, surface: Any, points: Any, margin: float, paint: Callable[[Any], None]) -> None:
        """Let `paint` draw on an enlarged, clear part of the picture, then reduce it and lay it on.

        Parameters
        ----------
        surface : pygame.Surface
        points : (n, 2) array
            Pixels of the enlarged picture, around which the part reaches.
        margin : float
            How far beyond them, in such pixels.
        """
        pygame = self._pygame
        low, high = np.min(points, axis=0) - margin, np.max(points, axis=0) + margin
        left, top, right, bottom = (int(v) for v in (*np.floor(low / SMOOTH), *np.ceil(high / SMOOTH)))
        box = pygame.Rect(left, top, right - left, bottom - top).clip(surface.get_rect())
        if not box.width or not box.height:
            return
        part = pygame.Surface((box.width * SMOOTH, box.height * SMOOTH), pygame.SRCALPHA)
        self._corner = box.left * SMOOTH, box.top * SMOOTH
        paint(part)
        self._corner = 0.0, 0.0
        # colours times opacity: reducing would mix the black of what is clear into the edges otherwise
        surface.blit(pygame.transform.smoothscale(part.premul_alpha(), box.size), box, special_flags=pygame.BLEND_PREMULTIPLIED)

    def _font(self, height: int) -> Any:
        if height not in self._fonts:
            self._fonts[height] = self._pygame.font.Font(None, height)
        return self._fonts[height]

    def _background(self) -> Any:
        """Grass, lines and goals, drawn once."""
        pygame, k = self._pygame, self._scale
        surface = pygame.Surface((self.size[0] * SMOOTH, self.size[1] * SMOOTH))
        surface.fill(_GRASS)
        for i in range(-1, 11):
            if i % 2:
                left = self._at(-LENGTH / 2 + i * LENGTH / 10, -WIDTH / 2 - MARGIN)
                pygame.draw.rect(surface, _GRASS_2, (*left, LENGTH / 10 * k, (WIDTH + 2 * MARGIN) * k))
        line = max(2, int(0.14 * self._unit))

        post_x, post_y = post_centre(ServerParameters(goal_width=self.goal_width))

        def box(x: float, y: float, width: float, height: float) -> None:
            pygame.draw.rect(surface, _LINE, (*self._at(x, y), width * k + line, height * k + line), line)

        box(-HALF_LENGTH, -HALF_WIDTH, LENGTH, WIDTH)
        pygame.draw.line(surface, _LINE, self._at(0, -HALF_WIDTH), self._at(0, HALF_WIDTH), line)
        pygame.draw.circle(surface, _LINE, self._at(0, 0), CENTRE_RADIUS * k, line)
        pygame.draw.circle(surface, _LINE, self._at(0, 0), 0.3 * k)
        for side in (-1, 1):
            for depth, half in ((PENALTY_AREA_LENGTH, PENALTY_Y), (GOAL_AREA_LENGTH, GOAL_AREA_Y)):
                box(-HALF_LENGTH if side < 0 else HALF_LENGTH - depth, -half, depth, 2 * half)
            spot = self._at(side * SPOT, 0)
            pygame.draw.circle(surface, _LINE, spot, 0.3 * k)
            arc = math.acos((SPOT - (HALF_LENGTH - PENALTY_AREA_LENGTH)) / CENTRE_RADIUS)
            turns = np.linspace(-arc, arc, 24)
            points = [self._at(side * (SPOT - CENTRE_RADIUS * math.cos(a)), CENTRE_RADIUS * math.sin(a)) for a in turns]
            pygame.draw.lines(surface, _LINE, False, points, line)
            goal = self._at(-HALF_LENGTH - GOAL_DEPTH if side < 0 else HALF_LENGTH, -self.goal_width / 2)
            pygame.draw.rect(surface, (205, 215, 208), (*goal, GOAL_DEPTH * k, self.goal_width * k))
            pygame.draw.rect(surface, _DARK, (*goal, GOAL_DEPTH * k, self.goal_width * k), line)
            for x in (-HALF_WIDTH, HALF_WIDTH):
                for post in (self._at(side * post_x, post_y), self._at(side * post_x, -post_y)):
                    pygame.draw.circle(surface, _DARK, post, 0.25 * k)
                corner = self._at(side * HALF_LENGTH, x)
                start = {(-1, -1): 270, (-1, 1): 0, (1, -1): 180, (1, 1): 90}[(side, 1 if x > 0 else -1)]
                rect = pygame.Rect(0, 0, 2 * k, 2 * k)
                rect.center = (int(corner[0]), int(corner[1]))
                pygame.draw.arc(surface, _LINE, rect, math.radians(start), math.radians(start + 90), line)
        if zoom_to(self.region) > 1.0:
            self._frame(surface, line)
        return surface

    def _frame(self, surface: Any, line: int) -> None:
        """The region: its surroundings in the shade, its border, its corners."""
        pygame, (a, b) = self._pygame, self.region
        left, top = self._at(-a, -b)
        inside = pygame.Rect(round(left), round(top), round(2 * a * self._scale), round(2 * b * self._scale))
        shade = pygame.Surface(surface.get_size(), pygame.SRCALPHA)
        shade.fill(_OUTSIDE)
        shade.fill((0, 0, 0, 0), inside)
        surface.blit(shade, (0, 0))
        pygame.draw.rect(surface, _REGION, inside.inflate(2 * line, 2 * line), line)
        for x in (-a, a):
            for y in (-b, b):
                pygame.draw.circle(surface, _DARK, self._at(x, y), 0.5 * self._unit)
                pygame.draw.circle(surface, _REGION, self._at(x, y), 0.36 * self._unit)

    def _picture(self, world: np.void, cones: tuple[int, ...], belief: np.ndarray | None, marks: Mapping[int, str]) -> Any:
        pygame, k = self._pygame, self._unit
        if self._pitch is None:
            self._pitch = pygame.transform.smoothscale(self._background(), self.size)
        surface = self._pitch.copy()
        places = [self._at(float(x), float(y)) for x, y in world["pos"]]
        if belief is not None and len(belief):
            self._cloud(surface, belief)
        if cones:
            self._cones(surface, world, cones)
        self._tail(surface)
        for player in range(1, 23):
            if world["enabled"][player - 1]:
                self._patch(surface, [places[player]], 2.2 * k, partial(self._player, world=world, player=player))
        for player, text in marks.items():
            self._mark(surface, places[player], text)
        self._patch(surface, [places[0]], 0.6 * k, partial(self._ball, world=world))
        self._patch(surface, [(0, 0), (self.size[0] * SMOOTH, BOARD * SMOOTH)], 0, partial(self._board, world=world))
        return surface

    def _ball(self, surface: Any, world: np.void) -> None:
        place = self._at(float(world["pos"][0, 0]), float(world["pos"][0, 1]))
        self._pygame.draw.circle(surface, _DARK, place, 0.52 * self._unit)
        self._pygame.draw.circle(surface, _BALL, place, 0.42 * self._unit)

    def _tail(self, surface: Any) -> None:
        """Where the ball has been, the brighter the later."""

        def paint(part: Any) -> None:
            for i, (x, y) in enumerate(self.trail):
                self._pygame.draw.circle(part, (255, 255, 255, int(10 + 130 * i / TRAIL)), self._at(x, y), 0.32 * self._unit)

        self._patch(surface, [self._at(x, y) for x, y in self.trail], 0.4 * self._unit, paint)

    def _cloud(self, surface: Any, belief: np.ndarray) -> None:
        """Points of a belief: a circle replaces what it covers on its part, so that the likelier come last."""
        points = np.asarray(belief, float).reshape(-1, 3)

        def paint(part: Any) -> None:
            for x, y, weight in points[np.argsort(points[:, 2], kind="stable")]:
                opacity = int(230 * min(1.0, max(0.0, weight)))
                if opacity > 0:
                    self._pygame.draw.circle(part, (60, 120, 255, opacity), self._at(x, y), 0.8 * self._unit)

        self._patch(surface, [self._at(x, y) for x, y, _ in points], self._unit, paint)

    def _mark(self, surface: Any, at: tuple[float, float], text: str) -> None:
        """A ring, and what is said of him who stands in it."""
        label = self._font(int(15 * SMOOTH)).render(text, True, _REGION)
        half, below = label.get_width() / 2, 1.9 * self._unit

        def paint(part: Any) -> None:
            x, y = at[0] - self._corner[0], at[1] - self._corner[1]
            self._pygame.draw.circle(part, _REGION, (x, y), 1.75 * self._unit, max(2, int(0.2 * self._unit)))
            part.blit(label, (x - half, y + below))

        corners = [(at[0] - half, at[1]), (at[0] + half, at[1] + below + label.get_height())]
        self._patch(surface, [at, *corners], 1.9 * self._unit, paint)

    def _cones(self, surface: Any, world: np.void, players: tuple[int, ...]) -> None:
        """View cones, all on one part: where they overlap it is no brighter."""
        polygons = []
        for player in players:
            i = player - 1
            face = float(world["body"][i] + world["neck"][i])
            half = CONE.get(int(world["view_width"][i]), CONE[2]) / 2
            x, y = (float(v) for v in world["pos"][player])
            polygons.append([(x, y), *((x + 40 * math.cos(face + a), y + 40 * math.sin(face + a)) for a in np.linspace(-half, half, 32))])

        def paint(part: Any) -> None:
            for polygon in polygons:
                self._pygame.draw.polygon(part, (255, 255, 255, 36), [self._at(*corner) for corner in polygon])

        self._patch(surface, [self._at(*corner) for polygon in polygons for corner in polygon], 1.0, paint)

    def _player(self, surface: Any, world: np.void, player: int) -> None:
        pygame, k, i = self._pygame, self._unit, player - 1
        x, y = (float(v) for v in world["pos"][player])
        body, face = float(world["body"][i]), float(world["body"][i] + world["neck"][i])
        goalie = bool(world["goalie"][i])
        colour = (_LEFT_KEEPER if goalie else _LEFT) if player <= 11 else (_RIGHT_KEEPER if goalie else _RIGHT)
        if world["tackle_cycles"][i] > 0 or world["foul_cycles"][i] > 0:
            colour = (int(0.55 * colour[0]), int(0.55 * colour[1]), int(0.55 * colour[2]))
        radius, metre = DISC, k / self._scale
        look = self._at(x + 1.9 * metre * math.cos(face), y + 1.9 * metre * math.sin(face))
        pygame.draw.line(surface, _LINE, self._at(x, y), look, max(2, int(0.16 * k)))
        pygame.draw.circle(surface, _DARK, self._at(x, y), radius * k)
        pygame.draw.circle(surface, colour, self._at(x, y), (radius - 0.16) * k)
        corners = ((1.5 * metre, 0.0), (0.95 * metre, 0.5), (0.95 * metre, -0.5))
        nose = [self._at(x + r * math.cos(body + a), y + r * math.sin(body + a)) for r, a in corners]
        pygame.draw.polygon(surface, _DARK, nose)
        text = self._font(int(1.7 * k)).render(str(player if player <= 11 else player - 11), True, _DARK)
        surface.blit(text, text.get_rect(center=self._at(x, y)))

    def _board(self, surface: Any, world: np.void) -> None:
        pygame = self._pygame
        width, height = surface.get_width(), BOARD * SMOOTH
        pygame.draw.rect(surface, _BOARD_COLOUR, (0, 0, width, height))
        font = self._font(int(0.8 * height))
        middle = font.render(f"{int(world['score'][0])} : {int(world['score'][1])}", True, _LINE)
        surface.blit(middle, middle.get_rect(center=(width / 2, height / 2)))
        left = font.render("left", True, _LEFT)
        surface.blit(left, left.get_rect(midright=(width / 2 - height * 1.3, height / 2)))
        right = font.render("right", True, _RIGHT)
        surface.blit(right, right.get_rect(midleft=(width / 2 + height * 1.3, height / 2)))
        small = self._font(int(0.62 * height))
        mode = small.render(mode_name(world).replace("_", " "), True, (190, 205, 195))
        surface.blit(mode, mode.get_rect(midleft=(height * 0.6, height / 2)))
        clock = small.render(f"cycle {int(world['time'])}", True, (190, 205, 195))
        surface.blit(clock, clock.get_rect(midright=(width - height * 0.6, height / 2)))


def mode_name(world: np.void) -> str:
    """Name of the play mode."""
    return PlayMode(int(world["mode"])).name


def text_picture(world: np.void, columns: int = 106, rows: int = 35, region: tuple[float, float] = PITCH) -> str:
    """The pitch in characters: ``o`` the ball, ``1``-``9``, ``A``, ``B`` left players, ``a``-``k`` right players, ``.`` a region."""
    grid = [[" "] * columns for _ in range(rows)]
    zoom = zoom_to(region)

    def put(x: float, y: float, mark: str) -> None:
        column = round((zoom * x / LENGTH + 0.5) * (columns - 1))
        row = round((zoom * y / WIDTH + 0.5) * (rows - 1))
        if 0 <= column < columns and 0 <= row < rows:
            grid[row][column] = mark

    for row in range(rows):
        grid[row][columns // 2] = ":"
    if zoom > 1.0:
        for share in np.linspace(-1.0, 1.0, 2 * (columns + rows)):
            for x, y in ((share, -1.0), (share, 1.0), (-1.0, share), (1.0, share)):
                put(region[0] * x, region[1] * y, ".")
    for player in range(1, 23):
        if world["enabled"][player - 1]:
            mark = "123456789AB"[player - 1] if player <= 11 else "abcdefghijk"[player - 12]
            put(float(world["pos"][player, 0]), float(world["pos"][player, 1]), mark)
    put(float(world["pos"][0, 0]), float(world["pos"][0, 1]), "o")
    head = f"{mode_name(world)}  cycle {int(world['time'])}  {int(world['score'][0])} : {int(world['score'][1])}"
    border = "+" + "-" * columns + "+"
    return "\n".join([head, border, *("|" + "".join(line) + "|" for line in grid), border])


class Pictured:
    """A face of one world that draws it; the base of the Gymnasium and the PettingZoo environment."""

    core: Any
    render_mode: str | None
    _viewer: Any = None

    def render(self) -> Any:
        """The pitch: a window (``human``), an RGB array (``rgb_array``) or text (``ansi``); None without a render mode."""
        if self.render_mode is None:
            return None
        if self._viewer is None:
            self._viewer = Viewer(self.render_mode, fps=FPS, region=self.core.task.region, goal_width=self.core.parameters.goal_width)
        return self._viewer.draw(self.core.sim.world[0])

    def _show(self) -> None:
        """Bring the window up to date, if there is one."""
        if self.render_mode == "human":
            self.render()

    def close(self) -> None:
        """Close the window, if there is one, and leave the server, if it is played on one."""
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None
        self.core.close()
