"""Pages that are made from the code: every task's columns, the gallery, the index of names and the reference.

``python docs/generate.py`` writes them to ``docs/generated``; the build of the site does so by itself.
"""

from __future__ import annotations

import ast
import dataclasses
import importlib
import importlib.util
import inspect
import re
import shutil
import textwrap
from collections.abc import Iterable, Sequence
from enum import IntEnum
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces as gym_spaces

import cprm_gym  # noqa: F401  (registers the environments)

FACES = (
    "cprm_gym",
    "cprm_gym.architecture",
    "cprm_gym.architecture.petri",
    "cprm_gym.architecture.prm",
    "cprm_gym.architecture.analysis",
    "cprm_gym.envs",
    "cprm_gym.wrappers",
    "cprm_gym.simulator",
    "cprm_gym.server",
    "cprm_gym.agents",
    "cprm_gym.benchmark",
    "cprm_gym.learning",
)
"""The packages whose names are public, from the front door inwards."""


def write_all(folder: Path) -> None:
    """Write every generated page, and the pictures that they show, into `folder`, which is made anew."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    pages = {"tasks.md": tasks_page(), "names.md": names_page(), **reference_pages(), "gallery.md": gallery_page(folder)}
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8")


# ---------------------------------------------------------------------- tables


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table; bars in the cells are kept from ending them."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def member_notes(enumeration: type[IntEnum]) -> dict[str, str]:
    """What the code says under each member of an enumeration."""
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(enumeration))).body
    assert isinstance(definition, ast.ClassDef)
    notes: dict[str, str] = {}
    for member, note in pairwise(definition.body):
        if isinstance(member, ast.Assign) and isinstance(note, ast.Expr) and isinstance(note.value, ast.Constant):
            notes[member.targets[0].id] = " ".join(str(note.value.value).split())  # type: ignore[attr-defined]
    missing = set(enumeration.__members__) - set(notes)
    if missing:
        raise ValueError(f"{enumeration.__name__}: no note under {', '.join(sorted(missing))}")
    return notes


def number(value: Any) -> str:
    """A bound as a reader writes it: multiples of pi by name."""
    value = float(value)
    for factor, text in ((1, "π"), (2, "2π"), (0.5, "π/2")):
        if abs(abs(value) - factor * np.pi) < 1e-5:
            return f"{'−' if value < 0 else ''}{text}"
    return f"{value:g}".replace("-", "−")


def extent(low: Any, high: Any) -> str:
    """``0 to 1``."""
    return f"{number(low)} to {number(high)}"


def columns(enumeration: type[IntEnum], box: gym_spaces.Box) -> str:
    """The columns of an array: index, name, range from the space, meaning and unit from the code."""
    low, high = np.atleast_2d(box.low)[0], np.atleast_2d(box.high)[0]
    notes = member_notes(enumeration)
    rows = [(str(int(m)), f"`{m.name}`", extent(low[m], high[m]), notes[m.name]) for m in enumeration if m < len(low)]
    return table(("column", "name", "range", "meaning and unit"), rows)


# ---------------------------------------------------------------------- tasks


def tasks_page() -> str:
    """Every task with its options, what its agents observe and what they may do."""
    from cprm_gym.envs import actions, observations, presets
    from cprm_gym.envs.tasks import TASKS

    whole = observations.observation_space((), tuple(part for part in observations.INCLUDES if part != "action_mask"))
    parts = [
        "# Tasks, column by column",
        "Made from the code when this site is built. How tasks are made and wrapped: [environments](../environments.md).",
        "## What every agent observes",
        "By default `normalised`: see [below](#the-default-observation-normalised). The presets `raw` and `memory` are a dict of float32 "
        "arrays, `full` the same without noise and limits of sight.",
        space_table(whole),
        "With the macro view, `action_mask` (one int8 for each macro, 1 where it can be done) is in the info, and here too if asked for.",
        "### `body`",
        columns(observations.BodyFeature, whole["body"]),  # type: ignore[arg-type]
        "### `ball`, the rows of `players` and of `landmarks`",
        "`ball` and `landmarks` have the first four columns.",
        columns(observations.ObjectFeature, whole["players"]),  # type: ignore[arg-type]
        "### `self`",
        columns(observations.SelfFeature, whole["self"]),  # type: ignore[arg-type]
        "## What every agent may do",
        *(action_view(name, actions.action_view(name).space) for name in actions.VIEWS if name != actions.MACRO),
        "What 1 means for each entry of `params`, in the server's units (power, degrees, metres):",
        scales(),
        "## The tasks",
    ]
    parts += [task_section(name, make()) for name, make in TASKS.items()]
    parts += [slow_approach()]
    vectors = [(name, preset_of(name)) for name in presets.VECTORS]
    parts += ["## The default observation, `normalised`", *normalised()]
    parts += ["## The vectors of the literature", *(vector_section(name, task, env) for name, (task, env) in vectors)]
    return "\n\n".join(parts) + "\n"


def space_table(space: gym_spaces.Dict) -> str:
    """Key, shape and range of every part of an observation."""
    rows = []
    for key, part in space.spaces.items():
        assert isinstance(part, gym_spaces.Box)
        rows.append((f"`{key}`", "×".join(map(str, part.shape)), extent(part.low.min(), part.high.max())))
    return table(("key", "shape", "range"), rows)


def action_view(name: str, space: gym_spaces.Space[Any]) -> str:
    """One action space, entry by entry."""
    return f"### `{name}`\n\n" + table(("entry", "values"), action_rows(space))


def action_rows(space: gym_spaces.Space[Any]) -> list[tuple[str, str]]:
    """(entry, values) of an action space."""
    from cprm_gym.envs import actions
    from cprm_gym.simulator.state import CommandKind, ViewWidth

    kinds = ", ".join(f"{int(kind)} {kind.name.lower()}" for kind in CommandKind)
    widths = ", ".join(f"{int(width)} {width.name.lower()}" for width in ViewWidth)
    if isinstance(space, gym_spaces.Dict):
        told = {"type": kinds, "view": widths, "say": f"{actions.SAY_LENGTH} characters, 0 ends the message"}
        return [(f"`{key}`", told.get(key) or values_of(part)) for key, part in space.spaces.items()]
    if isinstance(space, gym_spaces.MultiDiscrete):
        kinds_list = [kind.name.lower() for kind in actions.DISCRETE_KINDS]
        lists = (kinds_list, actions.DISCRETE_POWERS, actions.DISCRETE_DIRECTIONS, actions.DISCRETE_NECKS)
        names = ("command", "power", "direction, degrees", "neck, degrees")
        return [(f"{i} {names[i]}", ", ".join(v if isinstance(v, str) else number(v) for v in lists[i])) for i in range(len(space.nvec))]
    names = [f"preference for {kind.name.lower()}" for kind in actions.BOX_KINDS] + ["power", "direction", "neck"]
    assert isinstance(space, gym_spaces.Box)
    return [(f"{i} {names[i]}", extent(space.low[i], space.high[i])) for i in range(space.shape[0])]


def values_of(part: gym_spaces.Space[Any]) -> str:
    """The values of one entry of an action."""
    if isinstance(part, gym_spaces.Discrete):
        return f"0 to {int(part.n) - 1}"
    assert isinstance(part, gym_spaces.Box)
    return f"{'×'.join(map(str, part.shape))}, {extent(part.low.min(), part.high.max())}"


def scales() -> str:
    """`PARAMETER_SCALES`, one row per command."""
    from cprm_gym.envs import actions
    from cprm_gym.simulator.state import CommandKind

    rows = [(kind.name.lower(), *(number(v) for v in actions.PARAMETER_SCALES[kind])) for kind in CommandKind]
    return table(("command", "a", "b", "c", "d"), rows)


def task_section(name: str, task: Any) -> str:
    """A task: who acts, its options with their defaults and extents, what it adds to the observation."""
    parts = [f"### {name}", summary(type(task))]
    parts.append(f"`cprm/{name}-v{version_of(name)}`, {task.left} against {task.right}, `{task.controlled}` acts.")
    options = []
    for field in dataclasses.fields(task):
        if "within" in field.metadata:
            low, high = field.metadata["within"]
            options.append((f"`{field.name}`", number(getattr(task, field.name)), extent(low, high)))
    if options:
        parts.append(table(("option", "default", "range"), options))
    if task.task_features:
        rows = [(str(i), f"`{feature}`", extent(low, high)) for i, (feature, low, high) in enumerate(task.task_features)]
        parts += ["Adds `task` to the observation:", table(("column", "name", "range"), rows)]
    return "\n\n".join(parts)


def version_of(name: str) -> int:
    """The newest registered version of a task."""
    found = [int(match[1]) for env_id in gymnasium.registry if (match := re.fullmatch(rf"cprm/{name}-v(\d+)", env_id))]
    return max(found)


def slow_approach() -> str:
    """The exact little world, whose spaces are its own."""
    env: Any = gymnasium.make(f"cprm/SlowApproach-v{version_of('SlowApproach')}").unwrapped
    observed, done = env.observation_space, env.action_space
    rows = []
    for where, space in (("observation", observed), ("action", done)):
        if isinstance(space, gym_spaces.Box):
            rows += [(where, str(i), extent(low, high)) for i, (low, high) in enumerate(zip(space.low.ravel(), space.high.ravel()))]
        else:
            rows.append((where, "", str(space)))
    return f"### SlowApproach\n\n{summary(type(env))}\n\n" + table(("space", "entry", "range"), rows)


def preset_of(name: str) -> tuple[str, Any]:
    """(task, environment) in which a vector preset is shown."""
    task = "Keepaway3v2" if name == "keepaway" else "HFO2v1"
    return task, gymnasium.make(f"cprm/{task}-v{version_of(task)}", observation=name).unwrapped


def vector_section(name: str, task: str, env: Any) -> str:
    """Names and ranges of the entries of a vector preset."""
    low, high = env.observation_space.low, env.observation_space.high
    rows = [(str(i), f"`{entry}`", extent(low[i], high[i])) for i, entry in enumerate(env.core.preset.names)]
    return f"### `{name}`\n\nAs in {task}.\n\n" + table(("entry", "name", "range"), rows)


def normalised() -> list[str]:
    """The parts and columns of the default observation, and the order of the flat vector of every task."""
    from cprm_gym.envs.tasks import TASKS
    from cprm_gym.envs.vectors import normalised as of

    def described(columns: Sequence[Any]) -> str:
        rows = [(str(i), f"`{c.name}`", extent(c.low, c.high), c.unit, c.meaning) for i, c in enumerate(columns)]
        return table(("column", "name", "range", "1 means", "meaning"), rows)

    parts = [" ".join((of.__doc__ or "").split("\n\n")[1].split())]
    parts += [
        f"### `{name}` of `normalised`\n\n{described(columns)}" for name, columns in (("me", of.ME), ("ball", of.BALL), ("goals", of.GOALS))
    ]
    parts += [f"### A row of `players`\n\n{described(of.PLAYER)}", f"### `known` of `normalised`\n\n{described((of.KNOWN,))}"]
    rows = []
    for name, make in TASKS.items():
        task = make()
        acting = [side for side in ("left", "right") if side in task.controlled or task.controlled == "all"]
        sides = [(task.left, task.right) if side == "left" else (task.right, task.left) for side in acting]
        columns = of.Columns(max(own for own, _ in sides) - 1, max(other for _, other in sides), task.task_features)
        starts, at = [], 0
        for part, (_, entries) in columns.parts.items():
            starts.append(f"`{part}` from {at}")
            at += len(entries)
        rows.append((f"`{name}`", str(columns.mates), str(columns.opponents), str(columns.size), ", ".join(starts)))
    head = ("task", "team-mates", "opponents", "entries of the vector", "parts")
    return [*parts, "### The vector of each task\n\nWith `flatten`, for the agents that act by default.\n\n" + table(head, rows)]


def summary(thing: Any) -> str:
    """The first paragraph of a docstring."""
    return " ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split())


# ---------------------------------------------------------------------- names


def public_names(face: str) -> list[str]:
    """What a face offers, in alphabetical order."""
    return sorted((name for name in importlib.import_module(face).__all__ if not name.startswith("__")), key=str.lower)


def home_faces() -> dict[str, dict[str, str]]:
    """Face -> name -> the innermost face that offers the same thing."""
    offered = {face: {name: getattr(importlib.import_module(face), name) for name in public_names(face)} for face in FACES}
    homes: dict[str, dict[str, str]] = {}
    for face, names in offered.items():
        homes[face] = {}
        for name, thing in names.items():
            deeper = [f for f in FACES if f != face and offered[f].get(name) is thing and len(f) > len(face)]
            homes[face][name] = max([face, *deeper], key=lambda f: f.count("."))
    return homes


def kind_of(thing: Any) -> str:
    """Class, function, module or value."""
    if isinstance(thing, ModuleType):
        return "module"
    if inspect.isclass(thing):
        return "class"
    return "function" if callable(thing) else "value"


def first_line(thing: Any) -> str:
    """What it is, in one line; values speak by their repr."""
    if kind_of(thing) == "value":
        return f"`{textwrap.shorten(repr(thing), 80)}`"
    return summary(thing).replace("``", "`")


def names_page() -> str:
    """Every public name, its package and what it is."""
    rows = []
    for face, names in home_faces().items():
        for name, home in names.items():
            thing = getattr(importlib.import_module(face), name)
            page = f"reference_{home.rpartition('.')[2]}.md"
            rows.append((f"[`{name}`]({page})", f"`{face}`", kind_of(thing), first_line(thing)))
    rows.sort(key=lambda row: row[0].lower())
    intro = "What the packages offer: `from <package> import <name>`. Everything else is inside, and may move."
    return f"# Index of names\n\n{intro}\n\n" + table(("name", "from", "", "what it is"), rows)


def reference_pages() -> dict[str, str]:
    """One page for each face, by file name: its docstring, then what it offers."""
    homes = home_faces()
    return {f"reference_{face.rpartition('.')[2]}.md": reference_page(face, homes[face]) for face in FACES}


def reference_page(face: str, homes: dict[str, str]) -> str:
    """The reference of one package."""
    module = importlib.import_module(face)
    parts = [f"# {face}", "```{eval-rst}\n" + f".. automodule:: {face}\n   :no-members:\n" + "```"]
    elsewhere = [(name, home) for name, home in homes.items() if home != face]
    if elsewhere:
        rows = [(f"`{name}`", f"[`{home}`](reference_{home.rpartition('.')[2]}.md)") for name, home in elsewhere]
        parts += ["## From the packages inside", table(("name", "described at"), rows)]
    for name in (name for name, home in homes.items() if home == face):
        parts.append(described(face, name, getattr(module, name)))
    return "\n\n".join(parts) + "\n"


def described(face: str, name: str, thing: Any) -> str:
    """The directive that documents one name; a value, whose docstring is its type's, gets what the code says under it."""
    kind = kind_of(thing)
    if kind == "module":
        return f"## {name}\n\n{summary(thing)}"
    if kind == "value":
        body = f".. data:: {face}.{name}\n\n" + textwrap.indent(value_note(face, name), "   ")
    elif kind == "class":
        body = f".. autoclass:: {face}.{name}\n   :members:"
    else:
        body = f".. autofunction:: {face}.{name}"
    return f"## {name}\n\n```{{eval-rst}}\n{body}\n```"


def value_note(face: str, name: str) -> str:
    """The string under the assignment of `name` in the module from which the face takes it, or nothing."""
    for module, taken in imports_of(face):
        if taken != name:
            continue
        body = ast.parse(Path(inspect.getfile(importlib.import_module(module))).read_text(encoding="utf-8")).body
        for statement, note in pairwise(body):
            targets = statement.targets if isinstance(statement, ast.Assign) else [getattr(statement, "target", None)]
            if any(getattr(target, "id", None) == name for target in targets) and isinstance(note, ast.Expr):
                return inspect.cleandoc(str(ast.literal_eval(note.value)))
        return next((value_note(module, name) for origin, again in imports_of(module) if again == name), "")
    return ""


def imports_of(module: str) -> list[tuple[str, str]]:
    """(module, name) of everything that a module imports by name."""
    loaded = importlib.import_module(module)
    package = module if hasattr(loaded, "__path__") else module.rpartition(".")[0]
    tree = ast.parse(Path(inspect.getfile(loaded)).read_text(encoding="utf-8"))
    found = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    return [
        (importlib.util.resolve_name("." * node.level + str(node.module), package), alias.asname or alias.name)
        for node in found
        for alias in node.names
    ]


# ---------------------------------------------------------------------- gallery

NETS = (
    ("go_to_ball", 0, "The skill go_to_ball"),
    ("seeker", 1, "The seeker: one module, started again"),
    ("pass_ball", 0, "The skill pass_ball"),
)
"""(net that ships, levels unfolded, caption)."""
BELIEF_CYCLE = 8
"""Of the demonstration: the shot is on its way."""


def gallery_page(folder: Path) -> str:
    """Films, nets and beliefs, made by the code that the page names."""
    nets = [draw_net(folder, *entry) for entry in NETS]
    return (
        "\n\n".join(
            [
                "# Gallery",
                "Made by the project's own code when this site is built.",
                "## A film",
                film(folder),
                "## Nets",
                *nets,
                "## A belief and its model",
                belief(folder),
                model(folder),
            ]
        )
        + "\n"
    )


def film(folder: Path) -> str:
    """The seeker reaches the ball."""
    from cprm_gym.agents.seeker import make_controller
    from cprm_gym.envs.play import Film, play
    from cprm_gym.envs.tasks import make_task

    scenes = play(make_task("GoToBall", near=15.0, far=25.0), make_controller, seed=2, cycles=60)
    core, _ = next(scenes)
    with Film(folder / "go_to_ball.gif", core) as record:
        record.add()
        for _ in scenes:
            record.add()
    command = "cprm-gym play --task GoToBall --controller cprm --record game.gif"
    return f"![the seeker goes to the ball](go_to_ball.gif)\n\n`{command}`; the cone is what the player sees."


def draw_net(folder: Path, name: str, unfold: int, caption: str) -> str:
    """One net that ships."""
    from cprm_gym.agents.catalogue import shipped_net
    from cprm_gym.architecture.petri import save_drawing

    save_drawing(shipped_net(name), folder / f"net_{name}.svg", unfold=unfold)
    return f'{caption}: `save_drawing(net, "{name}.svg"{f", unfold={unfold}" if unfold else ""})`\n\n![{caption}](net_{name}.svg)'


def belief(folder: Path) -> str:
    """What the goalie believes about the ball, over the pitch."""
    from imageio.v2 import imwrite

    from cprm_gym.agents.demos import play
    from cprm_gym.envs.rendering import Viewer

    scene = next(scene for scene in play("goalie", seed=3, model="bins") if scene.cycle == BELIEF_CYCLE)
    picture = Viewer("rgb_array").draw(scene.world, (scene.players[0].number,), scene.players[0].points)
    imwrite(folder / "belief.png", np.asarray(picture)[:, :420])
    caption = f"Where the goalie believes the ball to be, {BELIEF_CYCLE} cycles after the start, and what he sees"
    return f"{caption}: `cprm-gym demo goalie --model bins --seed 3`\n\n![the goalie's belief](belief.png)"


def model(folder: Path) -> str:
    """The classes of the model behind that belief."""
    from cprm_gym.agents.models import BALL_MODEL
    from cprm_gym.architecture.prm.interchange.drawing import class_diagram_svg

    (folder / "model.svg").write_text(class_diagram_svg(BALL_MODEL), encoding="utf-8")
    return "The model of the ball: `class_diagram_svg(model)`\n\n![classes of the ball model](model.svg)"


if __name__ == "__main__":
    write_all(Path(__file__).resolve().parent / "generated")
