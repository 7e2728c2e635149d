"""The figures of a plan and of a flight, as PNG files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.files import write_with
from mavspiral.motion.trajectory import Trajectory, TrajectoryState
from mavspiral.shape.heightmap import Site
from mavspiral.show.scene import Scene
from mavspiral.show.skin import UNSEEN_RGB, Skin, gsd_rgb

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["FlownPath", "Profile", "write_figure"]

INK = "#22303c"
PLANNED = "#e08a1e"
FLOWN = "#1565c0"
TRANSIT = "#8b98a5"
LIMIT = "#c62828"
GRID_S = 0.25
MARGIN_M = 5.0
BESIDE_SHARE = 0.3
"""Of the flight's size in plan, what the picture from above goes beyond it for what stands there."""


@dataclass(frozen=True, slots=True, eq=False)
class FlownPath:
    """What was flown, and by whose word: "truth" in simulation, "estimate" on a real vehicle."""

    t_s: FloatArray
    position_enu_m: FloatArray
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """One quantity over time, with the value that it must not cross."""

    title: str
    t_s: FloatArray
    value: FloatArray
    allowed: float | None
    colour: str = INK


def write_figure(
    path: Path,
    *,
    title: str,
    site: Site,
    trajectory: Trajectory,
    profiles: tuple[Profile, ...],
    inspection_s: tuple[tuple[float, float], ...],
    facts: tuple[tuple[str, str], ...],
    skin: Skin,
    flown: FlownPath | None = None,
) -> Path:
    """`path`, a PNG: the building with its paths in space and from above, the facts, and the profiles."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(
        {"font.size": 8.5, "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": "#9aa5b1"}
    ):
        figure = Figure(figsize=(12.4, 7.0), dpi=140, facecolor="white")
        FigureCanvasAgg(figure)
        states = trajectory.sampled(GRID_S)
        on_spiral = trajectory.on("inspection", states.t_s)
        _head(figure, title, flown)
        _in_space(figure.add_axes((0.01, 0.07, 0.40, 0.83)), site, states, on_spiral, skin, flown)
        _gsd_key(figure, skin)
        _from_above(figure.add_axes((0.435, 0.53, 0.19, 0.36)), site, states, on_spiral, flown)
        step = min(0.034, 0.42 / len(facts))
        for row, (name, value) in enumerate(facts):
            figure.text(0.43, 0.45 - step * row, name, color="#5b6b7a", fontsize=8.5)
            figure.text(0.635, 0.45 - step * row, value, ha="right", fontsize=8.5)
        height = 0.86 / len(profiles)
        for row, profile in enumerate(profiles):
            bottom = 0.07 + height * (len(profiles) - 1 - row)
            axes = figure.add_axes((0.685, bottom, 0.295, height - 0.075))
            _profile(axes, profile, inspection_s, last=row == len(profiles) - 1)
        return write_with(path, lambda file: figure.savefig(file, format="png"))


def _head(figure: Figure, title: str, flown: FlownPath | None) -> None:
    figure.text(0.02, 0.945, title, fontsize=14, fontweight="bold")
    words = [("planned spiral", PLANNED), ("transit", TRANSIT)]
    if flown is not None:
        words.append((f"flown ({flown.source})", FLOWN))
    x = 0.02
    for text, colour in words:
        word = figure.text(x, 0.915, text, color=colour, fontsize=9, fontweight="bold")
        x = word.get_window_extent().x1 / figure.bbox.width + 0.015


def _gsd_key(figure: Figure, skin: Skin) -> None:
    axes = figure.add_axes((0.165, 0.035, 0.12, 0.014))
    coarsest_mm = 1e3 * skin.coverage.demand.gsd_max_m
    axes.imshow(gsd_rgb(np.linspace(0.0, 1.0, 256))[None], extent=(0.0, coarsest_mm, 0.0, 1.0), aspect="auto")
    axes.set_yticks([])
    axes.tick_params(labelsize=6, length=2)
    axes.spines[:].set_visible(False)
    figure.text(0.155, 0.037, "finest pixel on the wall, mm", ha="right", fontsize=7.5)
    figure.text(0.315, 0.037, "unseen", color=tuple(UNSEEN_RGB), fontsize=7.5, fontweight="bold")


def _in_space(
    axes: Axes,
    site: Site,
    states: TrajectoryState,
    on_spiral: NDArray[np.bool_],
    skin: Skin,
    flown: FlownPath | None,
) -> None:
    from matplotlib.colors import to_rgba

    scene = Scene(site, azimuth_deg=skin.azimuth_deg())
    skin.draw(axes, scene)
    strength = 0.5 if flown else 1.0
    rgba = np.where(on_spiral[:, None], to_rgba(PLANNED, strength), to_rgba(TRANSIT, 0.8))
    scene.draw_path(axes, states.position_enu_m, rgba, 2.6 if flown else 1.5)
    if flown is not None:
        count = max(2, int((flown.t_s[-1] - flown.t_s[0]) / GRID_S))
        index = np.unique(np.linspace(0, len(flown.t_s) - 1, count).astype(np.int64))
        scene.draw_path(axes, flown.position_enu_m[index], np.tile(to_rgba(FLOWN), (len(index), 1)), 0.8)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()


def _from_above(
    axes: Axes, site: Site, states: TrajectoryState, on_spiral: NDArray[np.bool_], flown: FlownPath | None
) -> None:
    heights = site.heights
    west, south, east, north = heights.bounds_enu_m
    shown = np.where(heights.height_agl_m > 0, heights.height_agl_m, np.nan)
    axes.imshow(
        shown,
        extent=(west, east, south, north),
        origin="lower",
        cmap="Greys",
        vmin=-heights.top_m / 2,
        vmax=1.5 * heights.top_m,
    )
    xy = states.position_enu_m[:, :2]
    axes.plot(*xy.T, color=TRANSIT, lw=0.8)
    axes.plot(*np.where(on_spiral[:, None], xy, np.nan).T, color=PLANNED, lw=1.4)
    if flown is not None:
        axes.plot(*flown.position_enu_m[:, :2].T, color=FLOWN, lw=0.5)
    axes.plot(*xy[0], marker="s", color=INK, ms=3)
    low, high = _shown_m(site, xy)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal", anchor="N")
    axes.tick_params(labelsize=6, length=2)
    axes.set_title("from above: metres east and north", loc="left", fontsize=9)
    axes.spines[:].set_visible(False)


def _shown_m(site: Site, xy: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The south-west and the north-east corner of what is shown: the flight, and what stands beside it whole if it is near."""
    low, high = xy.min(axis=0) - MARGIN_M, xy.max(axis=0) + MARGIN_M
    row, col = np.nonzero(site.heights.height_agl_m > 0.0)
    cells = site.heights.origin_enu_m + np.stack([col, row], axis=1) * site.heights.cell_m
    beside_m = BESIDE_SHARE * float((high - low).max())
    first = np.maximum(cells.min(axis=0) - MARGIN_M, low - beside_m)
    last = np.minimum(cells.max(axis=0) + site.heights.cell_m + MARGIN_M, high + beside_m)
    return np.minimum(low, first), np.maximum(high, last)


def _profile(
    axes: Axes, profile: Profile, inspection_s: tuple[tuple[float, float], ...], *, last: bool
) -> None:
    axes.plot(profile.t_s, profile.value, color=profile.colour, lw=0.8)
    for span_s in inspection_s:
        axes.axvspan(*span_s, color=PLANNED, alpha=0.06, lw=0)
    if profile.allowed is not None:
        axes.axhline(profile.allowed, color=LIMIT, lw=0.8, ls=(0, (4, 3)))
    axes.set_title(profile.title, loc="left", fontsize=9)
    axes.set_xlim(0.0, float(profile.t_s[-1]))
    # A home may lie below the building's ground.
    axes.set_ylim(bottom=None if np.any(profile.value < 0.0) else 0.0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelbottom=last, labelsize=7)
    if last:
        axes.set_xlabel("time, s")
