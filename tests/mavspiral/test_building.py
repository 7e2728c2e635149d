"""Whole buildings at random: every part is flown, and the slow truth about distances agrees."""

import json
import re

import numpy as np
import pytest
from numba import njit

from mavspiral import load_mission, plan
from mavspiral.errors import InputError, LimitError

MISSION = """
schema = 1
name = "random"
[building]
map = "random.npz"
cell_m = {cell_m}
map_error_m = 0.3
[camera]
focal_length_mm = 8.8
sensor_mm = [13.2, 8.8]
min_interval_s = 0.7
[inspection]
standoff_m = {standoff_m}
{inspection}
[limits]
speed_mps = {speed_mps}
clearance_m = {clearance_m}
ceiling_m = 150
[vehicle]
endurance_s = 20000
"""


@njit
def _nearest(points, west, south, cell, heights, reach):
    """Box by box, nothing clever; distances beyond `reach` are `reach`."""
    out = np.full(points.shape[0], reach)
    cells = int(reach / cell) + 2
    for i in range(points.shape[0]):
        row, col = int((points[i, 1] - south) // cell), int((points[i, 0] - west) // cell)
        best = reach * reach
        for r in range(max(0, row - cells), min(heights.shape[0], row + cells + 1)):
            for c in range(max(0, col - cells), min(heights.shape[1], col + cells + 1)):
                if heights[r, c] <= 0.0:
                    continue
                x, y = west + c * cell, south + r * cell
                dx = max(0.0, x - points[i, 0], points[i, 0] - x - cell)
                dy = max(0.0, y - points[i, 1], points[i, 1] - y - cell)
                dz = max(0.0, points[i, 2] - heights[r, c])
                best = min(best, dx * dx + dy * dy + dz * dz)
        out[i] = np.sqrt(best)
    return out


def nearest_m(site, points, reach_m):
    heights = site.heights
    west, south = heights.origin_enu_m
    return _nearest(np.ascontiguousarray(points), west, south, heights.cell_m, heights.height_agl_m, reach_m)


def towers(rng):
    """A podium, or several blocks, with towers far enough apart for spirals of their own, and roof steps."""
    cell_m = float(rng.choice([0.5, 1.0]))
    x, y = np.meshgrid(*[(np.arange(int(110 / cell_m)) + 0.5) * cell_m - 55.0] * 2)
    angle = rng.choice([0.0, rng.uniform(0.0, np.pi / 2)])
    u, v = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    heights = np.zeros_like(x)
    podium_m = rng.uniform(4.0, 12.0)
    if rng.uniform() < 0.7:
        heights[(abs(u) < rng.uniform(30, 38)) & (abs(v) < rng.uniform(12, 30))] = podium_m
    for side in rng.permutation([-1.0, 0.0, 1.0])[: rng.integers(2, 4)]:
        east, north = side * rng.uniform(26, 30), rng.uniform(-6, 6)
        half = rng.uniform(2.0, 6.0, 2)
        heights[(abs(u - east) < half[0]) & (abs(v - north) < half[1])] = rng.uniform(10.0, 45.0)
        heights[(abs(u - east) < half[0] / 2) & (abs(v - north) < half[1] / 2)] = rng.uniform(10.0, 60.0)
    return heights, cell_m


@pytest.fixture
def planned_at_random(tmp_path):
    def make(seed, inspection=""):
        rng = np.random.default_rng(seed)
        heights, cell_m = towers(rng)
        np.savez(
            tmp_path / "random.npz",
            height_agl_m=heights.astype(np.float32),
            cell_m=cell_m,
            origin=[40.05, -1.93],
        )
        standoff_m = float(rng.uniform(5.0, 9.0))
        clearance_m = float(rng.uniform(2.0, 3.5))
        text = MISSION.format(
            cell_m=cell_m,
            standoff_m=standoff_m,
            clearance_m=clearance_m,
            speed_mps=float(rng.uniform(2.0, 6.0)),
            inspection=inspection,
        )
        (tmp_path / "random.toml").write_text(text)
        return plan(load_mission(tmp_path / "random.toml"))

    return make


@pytest.mark.parametrize("seed", [0, 2, 4, 7, 12, 17, 25, 54])
def test_every_part_is_flown_and_nothing_comes_closer_than_it_may(seed, planned_at_random):
    inspection = planned_at_random(seed)
    required_m, trajectory = inspection.clearance_required_m, inspection.trajectory
    states = trajectory.sampled(0.1)
    assert nearest_m(inspection.site, states.position_enu_m, 1.5 * required_m).min() >= required_m - 1e-6
    steps_m = np.linalg.norm(np.diff(trajectory.sampled(0.01).position_enu_m, axis=0), axis=1)
    assert steps_m.max() <= 0.01 * inspection.mission.limits.speed_mps * 1.0001
    assert len(inspection.passes) >= 2
    assert len({part.name for part in inspection.passes}) == len(inspection.passes)
    assert trajectory.on("inspection", inspection.shots.t_s).all()
    assert inspection.coverage.walls > 0.88
    assert all(figure.ok for figure in inspection.certificate.figures)


def block_with_court(tmp_path, width_m, inspection="courtyards = true", gate_m=0.0):
    heights = np.zeros((120, 120))
    heights[10:110, 10:110] = 11.0
    half = int(width_m)
    heights[60 - half : 60 + half, 60 - half : 60 + half] = 0.0
    heights[60:, 60 - int(gate_m) : 60 + int(gate_m)] = 0.0
    np.savez(tmp_path / "random.npz", height_agl_m=heights, cell_m=0.5, origin=[40.05, -1.93])
    text = MISSION.format(cell_m=0.5, standoff_m=7.0, clearance_m=3.0, speed_mps=4.0, inspection=inspection)
    (tmp_path / "random.toml").write_text(text)
    return plan(load_mission(tmp_path / "random.toml"))


def kinds_but_fills(inspection):
    """The kinds of the passes, without the lines that fill their gaps."""
    return [part.kind for part in inspection.passes if part.kind != "fill"]


@pytest.mark.parametrize("width_m", [11.0, 20.0, 32.0])
def test_a_court_that_is_wide_enough_is_flown_inside_and_its_walls_are_seen(width_m, tmp_path):
    inspection = block_with_court(tmp_path, width_m)
    assert sorted(kinds_but_fills(inspection)) == ["courtyard", "spiral"]
    assert inspection.coverage.walls > 0.985
    required_m = inspection.clearance_required_m
    place = inspection.trajectory.sampled(0.1).position_enu_m
    assert nearest_m(inspection.site, place, 1.5 * required_m).min() >= required_m - 1e-6


def test_a_court_that_is_too_narrow_is_told_of_with_its_place_and_both_widths(tmp_path):
    inspection = block_with_court(tmp_path, 9.0)
    assert kinds_but_fills(inspection) == ["spiral"]
    (line,) = [line for line in inspection.warnings if line.startswith("courtyard")]
    assert "lat 40.05" in line and "lon -1.92" in line
    assert "is 9.0 m wide, 10.8 m are needed" in line


@pytest.mark.parametrize("gate_m", [3.0, 8.0])
def test_a_court_behind_a_gate_is_flown_from_above(gate_m, tmp_path):
    inspection = block_with_court(tmp_path, 28.0, gate_m=gate_m)
    assert sorted(kinds_but_fills(inspection)) == ["courtyard", "spiral"]
    (court,) = [part for part in inspection.passes if part.kind == "courtyard"]
    place = court.path(np.linspace(0.0, court.path.u_end_rad, 2000))
    assert np.abs(place[:, :2] - place[:, :2].mean(axis=0)).max() < 14.0 - 3.0
    place = inspection.trajectory.sampled(0.1).position_enu_m
    required_m = inspection.clearance_required_m
    assert nearest_m(inspection.site, place, 1.5 * required_m).min() >= required_m - 1e-6
    assert inspection.coverage.walls > 0.85


def test_a_narrow_court_behind_a_gate_is_told_of(tmp_path):
    inspection = block_with_court(tmp_path, 9.0, gate_m=2.0)
    assert kinds_but_fills(inspection) == ["spiral"]
    (line,) = [line for line in inspection.warnings if line.startswith("courtyard")]
    assert "lat 40.05" in line and "m wide, 10.8 m are needed" in line


def test_a_spiral_that_comes_too_near_is_refused_with_its_place_and_what_may_help(tmp_path, monkeypatch):
    monkeypatch.setattr("mavspiral.curve.spiral.harmonics_needed", lambda *_args, **_numbers: 1)
    monkeypatch.setattr("mavspiral.curve.spiral.ATTEMPTS", 1)
    with pytest.raises(
        LimitError,
        match=r"lat 40\.05.*, lon -1\.9.*, [\d.]+ m up, and 6\.70 m.*Fix: a lower \[limits\] speed",
    ):
        block_with_court(tmp_path, 9.0)


def test_a_home_without_room_is_told_of_a_place_that_has_it(tmp_path):
    block_with_court(tmp_path, 9.0)
    text = (tmp_path / "random.toml").read_text()

    def planned(lat, lon):
        home = f"[vehicle]\nhome = [{lat:.6f}, {lon:.6f}]\nhome_height_m = -3"
        (tmp_path / "random.toml").write_text(text.replace("[vehicle]", home))
        return plan(load_mission(tmp_path / "random.toml"))

    # In the court, which is 9 m wide; 3 m of 4.5 are free.
    lat, lon = 40.05 + 30 / 111_035, -1.93 + 30 / 85_386
    planned_home = planned(lat, -1.93)  # 5 m west of the block
    assert planned_home.trajectory.duration_s > 0
    with pytest.raises(
        InputError, match=r"is \d\.\d\d m from the building.*Fix: home = \[40\.05.*m away, is the near"
    ) as told:
        planned(lat, -1.93 + 3.5 / 85_386)
    fix = re.search(r"Fix: home = \[([\d.]+), (-[\d.]+)\]", str(told.value))
    assert planned(float(fix[1]), float(fix[2])).certificate.ok
    with pytest.raises(
        InputError, match=r"3\.0 m below the building's ground, is inside something 11\.0 m high"
    ):
        planned(lat, lon + 8 / 85_386)


def test_nobody_flies_into_a_court_unasked(tmp_path):
    inspection = block_with_court(tmp_path, 20.0, inspection="courtyards = false")
    assert [part.name for part in inspection.passes] == ["building"]
    assert not any(line.startswith("courtyard") for line in inspection.warnings)


def between_neighbours(tmp_path, west_m, east_m, north_m=None, *, tall_m=15.0, inspection=""):
    """A house of 20 × 12 × 15 m with blocks of `tall_m` so far off its sides; 0 is a party wall, None is nothing."""
    origin = (40.05, -1.93)
    corners = {"house": (0, 0, 20, 12, 15.0)}
    if west_m is not None:
        corners["west"] = (-25, -2, -west_m, 14, tall_m)
    if east_m is not None:
        corners["east"] = (20 + east_m, -2, 45, 14, tall_m)
    if north_m is not None:
        corners["north"] = (-25, 12 + north_m, 45, 30 + north_m, tall_m)
        corners["south"] = (-25, -20 - north_m, 45, -north_m, tall_m)
    features = []
    for name, (west, south, east, north, height) in corners.items():
        ring = [(west, south), (east, south), (east, north), (west, north), (west, south)]
        ring = [[origin[1] + x / 85_386.0, origin[0] + y / 111_035.0] for x, y in ring]
        features.append(
            {
                "type": "Feature",
                "id": name,
                "properties": {"building": "yes", "height": str(height)},
                "geometry": {"type": "Polygon", "coordinates": [ring]},
            }
        )
    (tmp_path / "street.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    text = MISSION.format(cell_m=0.5, standoff_m=7.0, clearance_m=3.0, speed_mps=3.0, inspection=inspection)
    text = text.replace('map = "random.npz"', 'map = "street.geojson"\nid = "house"')
    (tmp_path / "street.toml").write_text(text)
    return plan(load_mission(tmp_path / "street.toml"))


@pytest.mark.parametrize(
    ("gaps_m", "kinds"),
    [
        ((0.0, 0.0), ["facade", "facade"]),  # between party walls: front and back
        ((0.0, None), ["facade"]),  # the end of a terrace: one arc round three sides
        ((4.0, 9.0), ["facade"]),  # too narrow on one side, just wide enough on the other
        ((9.0, 9.0), ["facade"]),  # nearer than the stand-off on both, but all round
        ((16.0, 16.0), ["spiral"]),  # far enough
    ],
)
def test_walls_next_to_neighbours_are_flown_where_that_is_safe(gaps_m, kinds, tmp_path):
    inspection = between_neighbours(tmp_path, *gaps_m)
    assert kinds_but_fills(inspection) == kinds
    required_m = inspection.clearance_required_m
    place = inspection.trajectory.sampled(0.1).position_enu_m
    assert nearest_m(inspection.site, place, 1.5 * required_m).min() >= required_m - 1e-6
    told = [line for line in inspection.warnings if line.startswith("no drone can pass")]
    blocked = [gap for gap in gaps_m if gap is not None and gap < 7.2]
    assert all(gap == 0.0 for gap in blocked) or len(told) >= len(blocked)
    if not blocked:
        assert told == [] and inspection.coverage.walls > 0.97
    else:
        assert all("side for" in line and "lat 40.05" in line and "m up" in line for line in told)


def test_above_lower_neighbours_the_full_turn_goes_on(tmp_path):
    inspection = between_neighbours(tmp_path, 3.0, 3.0, tall_m=5.0)
    kinds = [part.kind for part in inspection.passes]
    assert kinds.count("spiral") == 1 and kinds.count("facade") == 2
    assert inspection.coverage.walls > 0.85


def test_a_house_that_nobody_can_fly_along_is_refused_with_the_place_and_what_would_fit(tmp_path):
    with pytest.raises(
        LimitError, match=r"most room is 2\..* lat 40\.05.*3\.8 m are needed.*Fix: .*clearance_m = 1\.2 and"
    ):
        between_neighbours(tmp_path, 4.0, 4.0, 4.0, inspection="top_m = 6")


@pytest.mark.parametrize("gap_m", [None, 30.0])
def test_a_band_so_high_that_no_turn_is_left_is_refused_with_the_height_that_would_do(gap_m, tmp_path):
    with pytest.raises(
        LimitError, match=r"lowest turn at 21\.9 m .*too high above .*ends at 15 m.*bottom_m = 15 or"
    ):
        between_neighbours(tmp_path, gap_m, gap_m, inspection="bottom_m = 21.9\ntop_m = 21.95")


@pytest.mark.parametrize("seed", range(8))
def test_between_neighbours_at_random_nothing_comes_too_near(seed, tmp_path):
    rng = np.random.default_rng(seed)
    gaps_m = [float(rng.choice([0.0, rng.uniform(1.0, 14.0)])) for _ in range(2)]
    north_m = None if rng.uniform() < 0.5 else float(rng.uniform(8.0, 14.0))
    inspection = between_neighbours(tmp_path, *gaps_m, north_m, tall_m=float(rng.uniform(4.0, 20.0)))
    required_m = inspection.clearance_required_m
    place = inspection.trajectory.sampled(0.1).position_enu_m
    assert nearest_m(inspection.site, place, 1.5 * required_m).min() >= required_m - 1e-6
    assert all(figure.ok for figure in inspection.certificate.figures)


@pytest.mark.parametrize("seed", [2, 54])
def test_every_pass_keeps_to_the_band_that_is_asked_for(seed, planned_at_random):
    inspection = planned_at_random(seed, inspection="bottom_m = 6\ntop_m = 19")
    assert len(inspection.passes) > 2
    for part in inspection.passes:
        height_m = part.path(np.linspace(0.0, part.path.u_end_rad, 500))[:, 2]
        assert height_m.min() >= 6.0 - 1e-9 and height_m.max() <= 19.0 + 1e-9


def test_a_court_and_a_facade_keep_to_the_band_too(tmp_path):
    for inspection in (
        block_with_court(tmp_path, 20.0, inspection="courtyards = true\nbottom_m = 5\ntop_m = 7"),
        between_neighbours(tmp_path, 0.0, 4.0, inspection="bottom_m = 5\ntop_m = 7"),
    ):
        for part in inspection.passes:
            height_m = part.path(np.linspace(0.0, part.path.u_end_rad, 500))[:, 2]
            assert height_m.min() >= 5.0 - 1e-3 and height_m.max() <= 7.0 + 1e-3
