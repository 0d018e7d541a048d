"""Frames as pictures: the pitch, and heat maps."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import CprmError
from ..files import check_place
from ..simulator.gamelog.frames import Frame
from ..simulator.gamelog.statistics import Part
from ..simulator.pitch import CENTRE_RADIUS, HALF_LENGTH, HALF_WIDTH, PENALTY_X, PENALTY_Y
from ..simulator.state import WORLD


def world_of(frame: Frame) -> npt.NDArray[Any]:
    """A `WORLD` array of shape (1,) that stands as the frame shows it, for `envs.rendering`."""
    world: npt.NDArray[Any] = np.zeros(1, WORLD)
    w, rows = world[0], frame.players
    w["time"], w["stoppage"], w["mode"] = frame.time, frame.stoppage, frame.mode
    w["score"] = frame.left.score, frame.right.score
    w["pos"][0], w["vel"][0] = np.nan_to_num(frame.ball[:2]), np.nan_to_num(frame.ball[2:])
    w["pos"][1:], w["vel"][1:] = np.nan_to_num(rows["pos"]), np.nan_to_num(rows["vel"])
    w["body"], w["neck"] = np.radians(np.nan_to_num(rows["body"])), np.radians(np.nan_to_num(rows["neck"]))
    w["enabled"], w["type"] = rows["state"] != 0, np.clip(rows["type"], 0, 17)
    w["goalie"] = (rows["state"].astype(np.int64) & 8) != 0
    for name in ("stamina", "effort", "recovery", "capacity"):
        w[name] = np.nan_to_num(rows[name])
    w["bits"] = w["bits_shown"] = rows["state"]
    w["synchronous"], w["view_quality"] = 1, 1
    w["view_width"] = np.clip(np.nan_to_num(rows["view_width"]) / 60.0, 1, 3).astype(np.int8)
    w["arm_timer"] = 1 << 20
    return world


def save_heat_map(part: Part, teams: tuple[str, str], path: str | os.PathLike[str]) -> None:
    """Draw where ball and teams were into a picture (.png, .svg, .pdf).

    Raises
    ------
    CprmError
        When matplotlib is not installed, or nothing can be written there.
    """
    check_place(path, "--heat")
    try:
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot
        from matplotlib.patches import Circle, Rectangle
    except ImportError:
        raise CprmError("heat maps need matplotlib: pip install 'cprm-gym[render]'") from None
    figure, axes = pyplot.subplots(3, 1, figsize=(7, 13), layout="constrained")
    extent = (-HALF_LENGTH, HALF_LENGTH, HALF_WIDTH, -HALF_WIDTH)
    for axis, heat, name in zip(axes, part.heat, ("ball", teams[0] or "left", teams[1] or "right")):
        share = 100.0 * heat.T / max(heat.sum(), 1.0)
        image = axis.imshow(share, extent=extent, cmap="magma", interpolation="nearest", vmin=0.0, vmax=brightest(share))
        lines = [Rectangle((-HALF_LENGTH, -HALF_WIDTH), 2 * HALF_LENGTH, 2 * HALF_WIDTH), Circle((0, 0), CENTRE_RADIUS)]
        lines += [Rectangle((x, -PENALTY_Y), HALF_LENGTH - PENALTY_X, 2 * PENALTY_Y) for x in (-HALF_LENGTH, PENALTY_X)]
        for line in lines:
            line.set(fill=False, edgecolor="white", linewidth=0.8)
            axis.add_patch(line)
        axis.axvline(0, color="white", linewidth=0.8)
        axis.set_title(f"{name}, {part.name}")
        axis.set_xlabel("m")
        axis.set_ylabel("m")
        figure.colorbar(image, ax=axis, label="% of the time", extend="max")
    try:
        figure.savefig(path, dpi=110)
    except (OSError, ValueError) as error:
        raise CprmError(f"--heat {path}: cannot be written: {error}") from None
    finally:
        pyplot.close(figure)


def brightest(share: np.ndarray) -> float:
    """The value above which a heat map gets no brighter: of cells where anything was, one in a hundred has more.

    Where everybody waits for a kick-off would leave all else in the dark.
    """
    visited = share[share > 0.0]
    return float(np.percentile(visited, 99)) if visited.size else 1.0
