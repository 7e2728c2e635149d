"""Plans every mission in missions/, prints what each sees and keeps, and draws them: `python tests/bench/gallery.py [PNG]`.

*of seeable*: of what any safe pose could see. *limits*: the worst of all limits on a 100 Hz grid against what is allowed, with
its name; a minimum the other way round. *fills*: how many of the passes are lines that fill gaps.
"""

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
    skin = Skin(inspection.site, inspection.coverage, inspection.mission.inspection.roof)
    scene = Scene(inspection.site, azimuth_deg=skin.azimuth_deg())
    skin.draw(axes, scene)
    rgba = np.where(inspecting[whole, None], to_rgba(PLANNED), to_rgba(TRANSIT, 0.8))
    scene.draw_path(axes, places[whole], rgba, 0.9)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0.02)
    axes.set_axis_off()


HEAD = (
    f"{'':10}{'walls':>8}{'of seeable':>12}{'roofs':>8}{'of seeable':>12}{'clearance':>11}{'required':>10}"
    f"{'limits':>8}  {'':18}{'duration':>9}{'parts':>7}{'fills':>7}"
)


def row(inspection: Inspection) -> str:
    facts = inspection.summary()
    seen = facts["coverage"]
    worst, name = max(
        (figure.allowed / figure.worst if figure.at_least else figure.worst / figure.allowed, figure.name)
        for figure in inspection.certificate.figures
    )
    shares = [
        "" if seen["roof_of_seeable"] is None and kind.startswith("roof") else f"{100 * seen[kind]:.2f} %"
        for kind in ("walls", "walls_of_seeable", "roof", "roof_of_seeable")
    ]
    fills = sum(part.kind == "fill" for part in inspection.passes)
    return (
        f"{facts['name']:10}{shares[0]:>8}{shares[1]:>12}{shares[2]:>8}{shares[3]:>12}"
        f"{facts['clearance_min_m']:9.2f} m{facts['clearance_required_m']:8.2f} m{worst:8.4f}  {name:18}"
        f"{facts['duration_s']:7.0f} s{facts['parts']:7d}{fills:7d}"
    )


def main() -> None:
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / ".github" / "gallery.png"
    inspections = [plan(load_mission(path)) for path in sorted((ROOT / "missions").glob("*.toml"))]
    print(HEAD)
    rows = -(-len(inspections) // COLUMNS)
    figure = Figure(figsize=(COLUMNS * PANEL_IN[0], rows * PANEL_IN[1]), dpi=110, facecolor="white")
    FigureCanvasAgg(figure)
    for number, inspection in enumerate(inspections):
        down, across = divmod(number, COLUMNS)
        left, bottom = across / COLUMNS, 1.0 - (down + 1) / rows
        draw(
            figure.add_axes((left + 0.008, bottom + 0.17 / rows, 1 / COLUMNS - 0.016, 0.81 / rows)),
            inspection,
        )
        name, facts = inspection.mission.name, inspection.summary()
        words = f"{facts['length_m'] / 1e3:.1f} km in {facts['duration_s'] / 60:.0f} min, walls {facts['coverage']['walls']:.1%}"
        middle = left + 0.5 / COLUMNS
        figure.text(middle, bottom + 0.10 / rows, name, ha="center", fontsize=9, fontweight="bold", color=INK)
        figure.text(middle, bottom + 0.04 / rows, words, ha="center", fontsize=7.5, color="#5b6b7a")
        print(row(inspection))
    figure.savefig(target)
    print(f"wrote {target}")


if __name__ == "__main__":
    main()
