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
from mavspiral.show.scene import OBSTACLE_RGB, Scene
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
BUILDING_FROM_ABOVE_RGB = np.array([[0.82, 0.80, 0.76], [0.40, 0.37, 0.33]])
OBSTACLE_FROM_ABOVE_RGB = np.array([[0.85, 0.89, 0.93], [0.50, 0.60, 0.70]])
"""From the lowest to the highest."""
FAR = 4.0
"""Times the greatest clearance while inspecting: what is farther away, as at a home far off, is cut off the profile."""


@dataclass(frozen=True, slots=True, eq=False)
class FlownPath:
    """What was flown, and by whose word: "truth" in simulation, "estimate" on a real vehicle."""

    t_s: FloatArray
    position_enu_m: FloatArray
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """One quantity over time, with the value that it must not cross, in `words`; `inspecting` if only while it inspects."""

    title: str
    t_s: FloatArray
    value: FloatArray
    allowed: float | None = None
    words: str = "at most"
    inspecting: bool = False


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
        figure.text(0.43, 0.915, "from above, metres east and north; darker is higher", fontsize=8.5)
        step = min(0.034, 0.42 / len(facts))
        for row, (name, value) in enumerate(facts):
            figure.text(0.43, 0.45 - step * row, name, color="#5b6b7a", fontsize=8.5)
            figure.text(0.635, 0.45 - step * row, value, ha="right", fontsize=8.5)
        height, end_s = 0.86 / len(profiles), max(float(profile.t_s[-1]) for profile in profiles)
        for row, profile in enumerate(profiles):
            bottom = 0.07 + height * (len(profiles) - 1 - row)
            axes = figure.add_axes((0.685, bottom, 0.295, height - 0.075))
            _profile(axes, profile, inspection_s, end_s, last=row == len(profiles) - 1)
        return write_with(path, lambda file: figure.savefig(file, format="png"))


def _head(figure: Figure, title: str, flown: FlownPath | None) -> None:
    figure.text(0.02, 0.945, title, fontsize=14, fontweight="bold")
    words = [("planned inspection", PLANNED), ("transit", TRANSIT)]
    if flown is not None:
        words.append((f"flown ({flown.source})", FLOWN))
    _words(figure, 0.02, 0.915, words, 9.0)


def _words(figure: Figure, x: float, y: float, words: list[tuple[str, str]], size: float) -> None:
    """The words in a row, each in the colour that it explains."""
    for text, colour in words:
        word = figure.text(x, y, text, color=colour, fontsize=size, fontweight="bold")
        x = word.get_window_extent().x1 / figure.bbox.width + 0.015


def _gsd_key(figure: Figure, skin: Skin) -> None:
    from matplotlib.colors import to_hex

    axes = figure.add_axes((0.165, 0.035, 0.12, 0.014))
    coarsest_mm = 1e3 * skin.coverage.demand.gsd_max_m
    axes.imshow(gsd_rgb(np.linspace(0.0, 1.0, 256))[None], extent=(0.0, coarsest_mm, 0.0, 1.0), aspect="auto")
    axes.set_yticks([])
    axes.tick_params(labelsize=6, length=2)
    axes.spines[:].set_visible(False)
    figure.text(0.155, 0.037, "finest pixel on the wall, mm", ha="right", fontsize=7.5)
    words = [("unseen", to_hex(UNSEEN_RGB))]
    if np.any((skin.site.heights.height_agl_m > 0.0) & ~skin.site.building):
        words.append(("obstacle", to_hex(0.75 * OBSTACLE_RGB)))
    _words(figure, 0.305, 0.037, words, 7.5)


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
    west, south, east, north = site.heights.bounds_enu_m
    axes.imshow(_plan_rgba(site), extent=(west, east, south, north), origin="lower")
    xy = states.position_enu_m[:, :2]
    axes.plot(*xy.T, color=TRANSIT, lw=0.8)
    axes.plot(*np.where(on_spiral[:, None], xy, np.nan).T, color=PLANNED, lw=1.4)
    if flown is not None:
        axes.plot(*flown.position_enu_m[:, :2].T, color=FLOWN, lw=0.5)
    axes.plot(*xy[0], marker="s", color=INK, ms=3)
    axes.annotate("home", xy[0], xytext=(0, -8), textcoords="offset points", ha="center", fontsize=6.5)
    low, high = _shown_m(site, xy)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal", anchor="N")
    axes.tick_params(labelsize=6, length=2)
    axes.spines[:].set_visible(False)


def _plan_rgba(site: Site) -> FloatArray:
    """What stands there from above `(rows, cols, 4)`: the higher the darker, the building and what else there is in two hues."""
    height_agl_m = site.heights.height_agl_m
    share = height_agl_m / max(site.heights.top_m, 1e-9)
    stops = np.where(site.building[..., None, None], BUILDING_FROM_ABOVE_RGB, OBSTACLE_FROM_ABOVE_RGB)
    rgb = stops[..., 0, :] + share[..., None] * (stops[..., 1, :] - stops[..., 0, :])
    rgba: FloatArray = np.concatenate([rgb, (height_agl_m > 0.0)[..., None]], axis=-1)
    return rgba


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
    axes: Axes, profile: Profile, inspection_s: tuple[tuple[float, float], ...], end_s: float, *, last: bool
) -> None:
    counts = np.zeros(len(profile.t_s), dtype=np.bool_)
    for first_s, last_s in inspection_s:
        axes.axvspan(first_s, last_s, color=PLANNED, alpha=0.06, lw=0)
        counts |= (profile.t_s >= first_s) & (profile.t_s <= last_s)
    axes.plot(profile.t_s, profile.value, color=TRANSIT if profile.inspecting else INK, lw=0.8)
    if profile.inspecting:
        axes.plot(profile.t_s, np.where(counts, profile.value, np.nan), color=INK, lw=0.8)
    # A home may lie below the building's ground.
    axes.set_ylim(bottom=None if np.any(profile.value < 0.0) else 0.0)
    if profile.allowed is not None:
        spans_s = inspection_s if profile.inspecting else ((0.0, end_s),)
        for first_s, last_s in spans_s:
            axes.hlines(profile.allowed, first_s, last_s, color=LIMIT, lw=0.8, ls=(0, (4, 3)))
        axes.set_title(f"{profile.words} {profile.allowed:g}", loc="right", fontsize=7.5, color=LIMIT)
    if profile.words == "at least" and counts.any():
        axes.set_ylim(top=min(axes.get_ylim()[1], FAR * float(profile.value[counts].max())))
    axes.set_title(profile.title, loc="left", fontsize=9)
    axes.set_xlim(0.0, end_s)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelbottom=last, labelsize=7)
    if last:
        axes.set_xlabel("time, s (shaded: while it inspects)")
