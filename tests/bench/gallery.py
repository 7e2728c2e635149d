"""Plans every mission in missions/ and draws them all on one picture: `python tests/bench/gallery.py [PNG]`."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

sys.path.insert(0, str(Path(__file__).parents[2]))

from mavspiral import load_mission, plan
from mavspiral.inspection import Inspection
from mavspiral.show.figures import INK, PLANNED, TRANSIT
from mavspiral.show.scene import Scene
from mavspiral.show.skin import Skin

ROOT = Path(__file__).parents[2]
COLUMNS = 4
PANEL_IN = 2.6, 3.0
GRID_S = 0.1


def draw(axes: Axes, inspection: Inspection) -> None:
    states = inspection.trajectory.sampled(GRID_S)
    inspecting = inspection.trajectory.on("inspection", states.t_s)
    # Of the ways from and to home only what lies near enough not to shrink the building.
    places = states.position_enu_m
    low, high = places[inspecting].min(axis=0) - 12.0, places[inspecting].max(axis=0) + 12.0
    near = np.flatnonzero(((places >= low) & (places <= high)).all(axis=1))
    whole = slice(near[0], near[-1] + 1)
    scene = Scene(inspection.site)
    Skin(inspection.site, inspection.coverage, inspection.mission.inspection.roof).draw(axes, scene)
    rgba = np.where(inspecting[whole, None], to_rgba(PLANNED), to_rgba(TRANSIT, 0.8))
    scene.draw_path(axes, places[whole], rgba, 0.9)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0.02)
    axes.set_axis_off()


def main() -> None:
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / ".github" / "gallery.png"
    inspections = [plan(load_mission(path)) for path in sorted((ROOT / "missions").glob("*.toml"))]
    rows = -(-len(inspections) // COLUMNS)
    figure = Figure(figsize=(COLUMNS * PANEL_IN[0], rows * PANEL_IN[1]), dpi=110, facecolor="white")
    FigureCanvasAgg(figure)
    for number, inspection in enumerate(inspections):
        row, column = divmod(number, COLUMNS)
        left, bottom = column / COLUMNS, 1.0 - (row + 1) / rows
        draw(
            figure.add_axes((left + 0.008, bottom + 0.17 / rows, 1 / COLUMNS - 0.016, 0.81 / rows)),
            inspection,
        )
        name, facts = inspection.mission.name, inspection.summary()
        words = f"{facts['length_m'] / 1e3:.1f} km in {facts['duration_s'] / 60:.0f} min, walls {facts['coverage']['walls']:.1%}"
        middle = left + 0.5 / COLUMNS
        figure.text(middle, bottom + 0.10 / rows, name, ha="center", fontsize=9, fontweight="bold", color=INK)
        figure.text(middle, bottom + 0.04 / rows, words, ha="center", fontsize=7.5, color="#5b6b7a")
        print(f"{name:10} {words}")
    figure.savefig(target)
    print(f"wrote {target}")


if __name__ == "__main__":
    main()
