"""The demonstrations, shown: the field, what the nets are doing, what the players believe (``cprm-gym demo``).

`play` yields a `Scene` per cycle; `panel` says one player's part of it in words, `Recorder` writes pictures of it into a film.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..architecture.petri import ObjectPlace, PetriNet, Place, instances
from ..architecture.prm.inference.posterior import Posterior
from ..envs.controller import Controller, check_action
from ..envs.core import SoccerCore, select_agents
from ..envs.observations import SelfFeature
from ..envs.rendering import Viewer
from ..envs.tasks import Status, make_task
from ..errors import CprmError, ModelError, unknown_name
from ..files import hidden_beside
from .knowledge.belief import BeliefTier
from .net_view import NetView
from .play import SoccerAgent, agent_in
from .registry import BINS, make_controller

DEMOS: Mapping[str, str] = {"striker": "KickOffShot", "goalie": "Goalie", "passers": "PassAndAdvance", "eleven": "Soccer11v11"}
"""Demonstration -> task."""
OPTIONS: Mapping[str, Mapping[str, Any]] = {"eleven": {"controlled": "left", "others": "weak", "max_cycles": 600}}
"""How the task differs from its defaults: a minute of a match against the weakest scripted team."""
AGENTS: Mapping[str, Mapping[str, Any]] = {"eleven": {"model": BINS}}
"""How the agents differ from those that play a task by default: the eleven are those with a model of their own."""
SHOWN = 2
"""Most players whose nets and beliefs are shown: those nearest to the ball."""
AFTERWARDS = 15
"""Cycles shown after the end."""
POINTS = 60
"""Most points that show a belief."""
BELIEFS = 5
"""Most beliefs that are told in a panel."""
PANEL = 430
"""Width of the panel beside the field in films, pixels."""
NET_HEIGHT = 460
"""Height of the net beneath the field at most, pixels."""
WORDS: Mapping[str, str] = {"holder": "has the ball", "partner": "partner", "receiver": "receives", "first": "first at the ball",
                            "marked": "marked", "watched": "watched", "watched_1": "watched", "watched_2": "watched"}  # fmt: skip
"""Object place -> what it says of the player whom it holds."""
SIDE = 0.6
"""Weight of a point one standard deviation off the middle of a normal, as a share of the middle's."""
FADE = 20.0
"""Cycles without a sight of the ball after which a reckoned place hardly counts."""


@dataclass(frozen=True)
class Player:
    """One agent of a scene.

    Attributes
    ----------
    name : str
        ``left_1``.
    number : int
        Object number.
    agent : SoccerAgent
    points : (n, 3) array
        x, y (server's frame) and weight of where he believes the ball to be, the likeliest last.
    marks : dict of int to str
        Object number -> in what way he is held by the object places of the net (`WORDS`).
    """

    name: str
    number: int
    agent: SoccerAgent
    points: np.ndarray
    marks: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Scene:
    """One cycle of a demonstration.

    Attributes
    ----------
    cycle : int
    status : str
        Of the task.
    world : record of WORLD
    players : tuple of Player
        The `SHOWN` nearest to the ball.
    success : bool
    """

    cycle: int
    status: str
    world: np.void
    players: tuple[Player, ...]
    success: bool


def play(name: str, seed: int = 0, **options: Any) -> Iterator[Scene]:
    """Play a demonstration, one scene a cycle.

    Parameters
    ----------
    name : str
    seed : int
    **options
        Of the agents (`registry.make_controller`).

    Raises
    ------
    UnknownName
        Listing the demonstrations.
    ParameterError
        For options that an agent does not take.
    """
    if name not in DEMOS:
        raise unknown_name("demonstration", name, DEMOS)
    task = make_task(DEMOS[name], **OPTIONS.get(name, {}))
    names = select_agents(task.controlled, task.left, task.right)
    agents = [make_controller(task, agent, **{**AGENTS.get(name, {}), **options}) for agent in names]
    playing = [_traced(agent) for agent in agents]
    needs = tuple(dict.fromkeys(("memory", *(part for agent in agents for part in getattr(agent, "needs", ())))))
    core = SoccerCore(task, 1, seed=seed, include=needs)
    observation = core.reset(seed)
    for i, agent in enumerate(agents):
        agent.reset({key: value[:, i] for key, value in observation.items()}, seed)
    status, success, rest = Status.IN_GAME.name, False, AFTERWARDS
    while rest > 0:
        views = [{key: value[:, i] for key, value in observation.items()} for i in range(len(agents))]
        actions = [check_action(core.agents[i], agent.act(views[i]), 1) for i, agent in enumerate(agents)]
        world = core.sim.world[0].copy()
        gaps = np.hypot(*(world["pos"][core.players] - world["pos"][0]).T)
        players = tuple(
            Player(
                name,
                int(core.players[i]),
                playing[i],
                believed_ball(agents[i], views[i]) * [core.sides[i], core.sides[i], 1.0],
                held(playing[i], int(core.players[i])),
            )
            for i, name in enumerate(core.agents)
            if i in np.argsort(gaps, kind="stable")[:SHOWN]
        )
        yield Scene(int(core.cycle[0]), status, world, players, success)
        step = core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
        if rest < AFTERWARDS or step.terminated[0] or step.truncated[0]:
            if rest == AFTERWARDS:
                status, success = Status(int(step.status[0])).name, bool(step.success[0].any())
            rest -= 1


def believed_ball(player: Controller, observation: Mapping[str, np.ndarray]) -> np.ndarray:
    """(n, 3) x, y in the own team's frame and weight: the posterior where the model has the ball's place, else the reckoned place."""
    tier = getattr(player, "tier", None)
    observation = {**observation, **getattr(player, "known", {})}
    if isinstance(tier, BeliefTier) and tier.posterior is not None:
        return _spread(tier.posterior, observation["memory"][0, 0, :2])
    agent = agent_in(player)
    controller = None if agent is None else agent.controller
    bank = controller.bank if controller is not None else None
    if bank is not None and bank.answers and {"ball.x", "ball.y"} <= bank.variables.keys():
        x, y = (bank.variables[name].edges for name in ("ball.x", "ball.y"))
        return _grid(bank.marginal("ball.x"), x, bank.marginal("ball.y"), y)
    if bank is not None and bank.answers and {"ball.dist", "ball.bearing_deg"} <= bank.variables.keys() and "self" in observation:
        dist, bearing = (bank.variables[name].edges for name in ("ball.dist", "ball.bearing_deg"))
        points = _grid(bank.marginal("ball.dist"), dist, bank.marginal("ball.bearing_deg"), bearing)
        way, angle = points[:, 0], np.radians(points[:, 1])
        x, y = observation["self"][0, [SelfFeature.X, SelfFeature.Y]]
        return np.stack([x + way * np.cos(angle), y + way * np.sin(angle), points[:, 2]], axis=1)
    age = float(observation["memory_age"][0, 0])
    return np.array([[*observation["memory"][0, 0, :2], max(0.1, 1.0 - age / FADE)]])


def _spread(posterior: Posterior, expected: np.ndarray) -> np.ndarray:
    """A mixture of normals as points: of each its middle and the ends of its axes, around what is expected, which comes last."""
    points = [[*expected, 1.0]]
    try:
        weights, means, covs = (found[0] for found in posterior.components("ball.x", "ball.y"))
    except ModelError:  # nothing has been seen yet
        return np.array(points)
    for weight, mean, cov in zip(weights, means + (expected - weights @ means), covs):
        lengths, axes = np.linalg.eigh(cov)
        ends = axes * np.sqrt(np.maximum(lengths, 0.0))
        for off, share in ((np.zeros(2), 1.0), *((sign * ends[:, k], SIDE) for k in (0, 1) for sign in (-1.0, 1.0))):
            points.append([*(mean + off), weight * share])
    return np.array(points[:0:-1][:POINTS] + points[:1])


def _grid(px: np.ndarray, x_edges: Any, py: np.ndarray, y_edges: Any) -> np.ndarray:
    """The likeliest cells of two marginals, the likeliest last and with weight 1."""
    x, y = (0.5 * (np.asarray(e[:-1]) + np.asarray(e[1:])) for e in (x_edges, y_edges))
    weight = np.outer(px, py)
    best = np.argsort(weight, axis=None)[-POINTS:]
    i, j = np.unravel_index(best, weight.shape)
    return np.stack([x[i], y[j], weight[i, j] / weight.max()], axis=1)


def held(agent: SoccerAgent, number: int) -> dict[int, str]:
    """Object number -> what the object places of an agent's net say of him.

    Parameters
    ----------
    agent : SoccerAgent
    number : int
        His own object number.
    """
    marks: dict[int, str] = {}
    if agent.controller is None:
        return marks
    for place in agent.cprm.net.places:
        if isinstance(place, ObjectPlace):
            index = int(agent.controller.executor.holds(place.name)[0])
            if index >= 0:
                objects = [name for name, kind in agent.cprm.objects.items() if kind == place.class_name]
                whom = _object_number(objects[index], number)
                words = [*marks.get(whom, "").split(", "), WORDS.get(place.name, place.name.replace("_", " "))]
                marks[whom] = ", ".join(dict.fromkeys(word for word in words if word))
    return marks


def _object_number(name: str, own: int) -> int:
    """Number of an object as the agents call them: ``o3`` opponent 3, ``t3`` number 3 of the own team, ``m3`` the third but himself."""
    kind, k = name[0], int(name[1:])
    first, unum = (0, own) if own <= 11 else (11, own - 11)
    return (11 - first) + k if kind == "o" else first + k + (kind == "m" and k >= unum)


def _traced(player: Controller) -> SoccerAgent:
    """Who plays with a net in a player; he keeps what fired."""
    agent = agent_in(player)
    assert agent is not None
    agent.options["trace"] = True
    return agent


def panel(player: Player) -> list[str]:
    """What a player's net and beliefs are, in lines: active modules by depth, other marked places, beliefs, commands."""
    controller = player.agent.controller
    if controller is None:
        return [player.name]
    net, executor = player.agent.cprm.net, controller.executor
    marked = {name for name, tokens in zip(executor.net.place_names, executor.marking[0]) if tokens > 0}
    lines = [f"{player.name}: {net.name}", "net"]
    lines += _active(net, executor, marked)
    own = [p.name for p in net.places if p.name in marked and isinstance(p, Place)]
    lines.append("  marked: " + (", ".join(own) or "-"))
    if player.marks:
        lines.append("objects")
        lines += [f"  {text}: {'left' if number <= 11 else 'right'} {(number - 1) % 11 + 1}" for number, text in player.marks.items()]
    x, y, _ = player.points[-1]
    lines += ["reckons" if player.agent.cprm.model is None and len(player.points) == 1 else "believes", f"  ball at {x:.1f}, {y:.1f}"]
    lines += [f"  {p.name} {executor.read(p.name)[0]:.2f}" for p in executor.belief_places[:BELIEFS]]
    lines.append("commands")
    for name, values in executor._commands.of(0).items():
        lines.append(f"  {name} " + ", ".join(f"{key} {value:.0f}" for key, value in values.items()))
    return lines


def _active(net: PetriNet, executor: Any, marked: set[str]) -> list[str]:
    """The modules at work, indented by depth, each with its marked inner places."""
    lines = []
    for path, instance in instances(net).items():
        ongoing = instance.net.ports.ongoing
        if path and ongoing and instance.places[ongoing] in marked:
            inside = [p.name for p in instance.net.places if type(p).__name__ == "Place" and instance.places[p.name] in marked]
            inside = [p for p in inside if p != ongoing]
            lines.append(f"{'  ' * (path.count('.') + 1)}{path.rpartition('.')[2]} [{', '.join(inside)}]")
    return lines


class Recorder:
    """Writes scenes into a film, ``.mp4`` or ``.gif``, which appears when it is closed.

    Raises
    ------
    CprmError
        For another kind of file, or when what writes films is not installed.
    """

    def __init__(self, path: str | Path, fps: int = 10) -> None:
        self.path = Path(path)
        if self.path.suffix not in (".mp4", ".gif"):
            raise CprmError(f"--record {self.path}: allowed are files that end in .mp4 and .gif")
        try:
            imageio = import_module("imageio.v2")
        except ImportError:
            raise CprmError("films need imageio: pip install 'cprm-gym[render]'") from None
        self.viewer = Viewer("rgb_array")
        self._shown: int | None = None
        self._temporary = hidden_beside(self.path, self.path.suffix)
        options = {"fps": fps, "macro_block_size": 2} if self.path.suffix == ".mp4" else {"duration": 1000 / fps, "loop": 0}
        try:
            self._writer = imageio.get_writer(self._temporary, **options)
        except OSError as error:
            raise CprmError(f"--record {self.path}: cannot be written: {error.strerror or error}") from None

    def add(self, scene: Scene) -> np.ndarray:
        """One picture: the field with view cones, beliefs and who is watched, the panels beside it, the net of the first beneath.

        Also returned, (H, W, 3) uint8.
        """
        belief = np.concatenate([player.points for player in scene.players])
        marks = {number: text for player in scene.players for number, text in player.marks.items()}
        pitch = self.viewer.draw(scene.world, tuple(player.number for player in scene.players), belief, marks)
        assert isinstance(pitch, np.ndarray)
        above = np.concatenate([pitch, self._panel(scene, pitch.shape[0])], axis=1)
        picture = np.concatenate([above, self._net(scene, above.shape[1])], axis=0)
        picture = picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2]
        self._writer.append_data(picture)
        return picture

    def _panel(self, scene: Scene, height: int) -> np.ndarray:
        pygame = self.viewer._pygame
        surface = pygame.Surface((PANEL, height))
        surface.fill((20, 34, 26))
        y = 12
        for player in scene.players:
            for k, line in enumerate(panel(player)):
                heading = k == 0 or not line.startswith(" ")
                font = self.viewer._font(26 if k == 0 else 21)
                text = font.render(line, True, (246, 205, 70) if k == 0 else (150, 190, 165) if heading else (235, 242, 235))
                surface.blit(text, (14, y))
                y += 24 if k == 0 else 18
            y += 14
        end = self.viewer._font(26).render(scene.status.replace("_", " ").lower(), True, (246, 205, 70))
        surface.blit(end, (PANEL - end.get_width() - 14, 12))
        return np.transpose(pygame.surfarray.array3d(surface), (1, 0, 2)).copy()

    def _net(self, scene: Scene, width: int) -> np.ndarray:
        """The net of the first player of the film, with its marking and what has just fired."""
        if self._shown is None:
            self._shown = scene.players[0].number
            self._net_view = NetView(scene.players[0].agent.cprm.net, width, NET_HEIGHT, self.viewer._pygame)
        player = next((p for p in scene.players if p.number == self._shown), scene.players[0])
        controller = player.agent.controller
        if controller is None or player.agent.cprm.net != self._net_view.net:
            return self._net_view.draw({})
        executor = controller.executor
        marking = dict(zip(executor.net.place_names, executor.marking[0]))
        for place in self._net_view.net.places:
            if isinstance(place, ObjectPlace):
                marking[place.name] = float(executor.holds(place.name)[0] >= 0)
        return self._net_view.draw(marking, controller.explain().fired)

    def close(self) -> None:
        """Finish the film; when that is interrupted nothing is left behind."""
        try:
            self._writer.close()
            os.replace(self._temporary, self.path)
        finally:
            self._temporary.unlink(missing_ok=True)

    def discard(self) -> None:
        """Give up; nothing is left behind."""
        self._writer.close()
        self._temporary.unlink(missing_ok=True)
