"""The figures of a plan and of a flight, as PNG files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.files import write_with
from mavspiral.motion.trajectory import Trajectory, TrajectoryState
from mavspiral.shape.heightmap import Site
from mavspiral.show.scene import Scene

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
    flown: FlownPath | None = None,
) -> Path:
    """`path`, a PNG: the building with the planned and flown path, the same from above, and the profiles."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(
        {"font.size": 8.5, "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": "#9aa5b1"}
    ):
        figure = Figure(figsize=(12.0, 7.2), dpi=140, facecolor="white")
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(
            max(2, len(profiles)),
            2,
            width_ratios=[1.15, 1.0],
            left=0.02,
            right=0.97,
            top=0.9,
            bottom=0.08,
            hspace=0.55,
        )
        states = trajectory.sampled(GRID_S)
        scene = Scene()
        scene.add_site(site)
        spiral = _on_leg(trajectory, states, "inspection")
        _add_paths(scene, states, spiral, flown)
        _title(figure, title, flown)
        view = figure.add_subplot(grid[:, 0])
        scene.draw(view)
        _from_above(view.inset_axes((0.0, 0.0, 0.3, 0.3)), site, states, spiral, flown)
        for row, profile in enumerate(profiles):
            _profile(figure.add_subplot(grid[row, 1]), profile, trajectory, last=row == len(profiles) - 1)
        return write_with(path, lambda file: figure.savefig(file, format="png"))


def _on_leg(trajectory: Trajectory, states: TrajectoryState, name: str) -> FloatArray:
    begin_s, end_s = trajectory.span_s(name)
    mask: FloatArray = (states.t_s >= begin_s) & (states.t_s <= end_s)
    return mask


def _add_paths(scene: Scene, states: TrajectoryState, spiral: FloatArray, flown: FlownPath | None) -> None:
    from matplotlib.colors import to_rgba

    planned = np.where(spiral[:, None], to_rgba(PLANNED, 0.55 if flown else 1.0), to_rgba(TRANSIT, 0.7))
    scene.add_path(states.position_enu_m, planned, 2.4 if flown else 1.6)
    if flown is not None:
        count = max(2, int((flown.t_s[-1] - flown.t_s[0]) / GRID_S))
        index = np.unique(np.linspace(0, len(flown.t_s) - 1, count).astype(np.int64))
        scene.add_path(flown.position_enu_m[index], np.tile(to_rgba(FLOWN), (len(index), 1)), 0.8)


def _title(figure: Figure, title: str, flown: FlownPath | None) -> None:
    figure.text(0.025, 0.945, title, fontsize=14, fontweight="bold")
    figure.text(0.025, 0.915, "planned", color=PLANNED, fontsize=9, fontweight="bold")
    figure.text(0.08, 0.915, "transit", color=TRANSIT, fontsize=9, fontweight="bold")
    if flown is not None:
        figure.text(0.13, 0.915, f"flown ({flown.source})", color=FLOWN, fontsize=9, fontweight="bold")


def _from_above(
    axes: Axes, site: Site, states: TrajectoryState, spiral: FloatArray, flown: FlownPath | None
) -> None:
    heights = site.heights
    west, south, east, north = heights.bounds_enu_m
    shown = np.where(heights.height_agl_m > 0, heights.height_agl_m, np.nan)
    axes.imshow(
        shown, extent=(west, east, south, north), origin="lower", cmap="Greys", vmin=-heights.top_m / 2
    )
    xy = states.position_enu_m[:, :2]
    axes.plot(*xy.T, color=TRANSIT, lw=0.8)
    axes.plot(*np.where(spiral[:, None], xy, np.nan).T, color=PLANNED, lw=1.4)
    if flown is not None:
        axes.plot(*flown.position_enu_m[:, :2].T, color=FLOWN, lw=0.5)
    axes.plot(*xy[0], marker="s", color=INK, ms=3)
    low, high = xy.min(axis=0) - 5, xy.max(axis=0) + 5
    axes.set_xlim(min(low[0], -10), max(high[0], 10))
    axes.set_ylim(min(low[1], -10), max(high[1], 10))
    axes.set_aspect("equal")
    axes.tick_params(labelsize=6, length=2)
    axes.set_title("from above, m east and north", fontsize=7)


def _profile(axes: Axes, profile: Profile, trajectory: Trajectory, *, last: bool) -> None:
    begin_s, end_s = trajectory.span_s("inspection")
    axes.plot(profile.t_s, profile.value, color=profile.colour, lw=0.8)
    axes.axvspan(begin_s, end_s, color=PLANNED, alpha=0.06, lw=0)
    if profile.allowed is not None:
        axes.axhline(profile.allowed, color=LIMIT, lw=0.8, ls=(0, (4, 3)))
    axes.set_title(profile.title, loc="left", fontsize=9)
    axes.set_xlim(0.0, max(float(profile.t_s[-1]), trajectory.duration_s))
    axes.set_ylim(bottom=0.0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelbottom=last, labelsize=7)
    if last:
        axes.set_xlabel("time, s")
