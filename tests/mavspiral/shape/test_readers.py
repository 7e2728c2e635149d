"""Maps: what is read, what is refused, and in which words."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.polygons import contains, cover, crossing
from mavspiral.shape.readers import MapRequest, read_site

LAT, LON = 19.0, -99.0
FRAME = LocalFrame(GeoPoint(LAT, LON, 0.0))


def ring(points_m):
    lat, lon, _ = FRAME.to_geodetic([[x, y, 0.0] for x, y in points_m])
    out = [[float(o), float(a)] for a, o in zip(lat, lon, strict=True)]
    return [*out, out[0]]


def box(x, y, w, d):
    return [(x - w / 2, y - d / 2), (x + w / 2, y - d / 2), (x + w / 2, y + d / 2), (x - w / 2, y + d / 2)]


def feature(points, identity=None, **tags):
    tags = {key.replace("__", ":"): value for key, value in tags.items()} or {
        "building": "yes",
        "height": "10",
    }
    return {
        "type": "Feature",
        "id": identity or "f",
        "properties": tags,
        "geometry": {"type": "Polygon", "coordinates": [ring(points)]},
    }


def write(tmp_path, *features, name="map.geojson"):
    path = tmp_path / name
    path.write_text(json.dumps({"type": "FeatureCollection", "features": list(features)}))
    return path


def read(path, **request):
    return read_site(
        MapRequest(path, request.pop("cell_m", 0.25), request.pop("ground_amsl_m", 100.0), **request)
    )


def refusal(path, **request):
    with pytest.raises(InputError) as caught:
        read(path, **request)
    line = str(caught.value)
    assert "\n" not in line
    assert "Fix" in line
    return line


@pytest.mark.parametrize(
    ("tags", "height_m"),
    [
        ({"building": "yes", "height": "34"}, 34.0),
        ({"building": "yes", "height": "34 m"}, 34.0),
        ({"building": "yes", "height": 34.5}, 34.5),
        ({"building": "yes", "height": "112 ft"}, 112 * 0.3048),
        ({"building": "yes", "height": "7'4\""}, (7 + 4 / 12) * 0.3048),
        ({"building": "yes", "building:levels": "4"}, 12.0),
        ({"building": "yes", "building:levels": "4", "height": "20"}, 20.0),
        ({"building": "yes", "building:levels": "4", "roof:levels": "1"}, 15.0),
        ({"building": "yes", "building:levels": "4", "roof:levels": "2", "roof:height": "4.5 m"}, 16.5),
        ({"building": "yes", "building:levels": "4", "roof:levels": "0"}, 12.0),
    ],
)
def test_heights_as_osm_writes_them(tmp_path, tags, height_m):
    made = feature(box(0, 0, 20, 10))
    made["properties"] = tags
    answer = read(write(tmp_path, made))
    assert answer.site.heights.height_agl_m.max() == pytest.approx(height_m)
    guessed = [told for told in answer.warnings if "guessed from storeys of 3 m" in told]
    assert bool(guessed) == ("height" not in tags)


def test_the_building_is_where_and_as_large_as_it_is(tmp_path):
    site = read(write(tmp_path, feature(box(30, -40, 20, 10)))).site
    middle = FRAME.point_enu_m(site.heights.frame.origin)
    assert np.allclose(middle[:2], [30, -40], atol=0.01)
    assert site.heights.frame.origin.alt_amsl_m == 100.0
    area = site.building.sum() * 0.25**2
    assert 200.0 <= area <= 20.5 * 10.5
    assert site.heights.sample([[9.9, 4.9], [-9.9, -4.9]]).tolist() == [10.0, 10.0]
    assert site.heights.sample([[10.6, 0.0], [0.0, 5.6]]).tolist() == [0.0, 0.0]


def test_parts_give_the_shape_and_the_outline_does_not(tmp_path):
    outline = feature(box(0, 0, 40, 40), "b", building="yes", height="50")
    tower = feature(box(5, 5, 10, 10), "t", building__part="yes", height="50", min_height="12")
    podium = feature(box(0, 0, 40, 40), "p", building__part="yes", height="12")
    site = read(write(tmp_path, outline, tower, podium)).site
    assert site.heights.sample([[5, 5], [-15, -15], [19, 19]]).tolist() == [50.0, 12.0, 12.0]


def test_neighbours_are_obstacles_and_far_ones_are_left_out(tmp_path):
    mine = feature(box(0, 0, 10, 10), "mine", building="yes", height="10")
    near = feature(box(40, 0, 10, 10), "near", building="yes", height="30")
    far = feature(box(900, 0, 10, 10), "far", building="yes", height="30")
    site = read(write(tmp_path, mine, near, far), at=(LAT, LON)).site
    assert site.heights.sample([40.0, 0.0]) == 30.0
    assert site.heights.height_agl_m[~site.building].max() == 30.0
    assert site.building_height_m.max() == 10.0
    assert site.heights.shape[1] * 0.25 < 100.0


def test_a_neighbour_without_a_height_is_taken_to_be_tall_and_said(tmp_path):
    mine = feature(box(0, 0, 10, 10), "mine", building="yes", height="10")
    near = feature(box(30, 0, 10, 10), "near", building="yes")
    answer = read(write(tmp_path, mine, near), id="mine")
    assert answer.site.heights.height_agl_m[~answer.site.building].max() == 10.0
    assert "near" in answer.warnings[0]


def test_parts_without_an_outline_are_one_building_where_they_touch(tmp_path):
    low = feature(box(0, 0, 20, 20), "low", building__part="yes", height="10")
    high = feature(box(12, 0, 4, 10), "high", building__part="yes", height="30")
    away = feature(box(80, 0, 10, 10), "away", building__part="yes", height="50")
    for wanted in ({"at": (LAT, LON)}, {"id": "high"}):
        site = read(write(tmp_path, low, high, away), **wanted).site
        assert site.building_height_m.max() == 30.0
        assert site.heights.height_agl_m[~site.building].max() == 50.0


def test_the_id_of_a_part_means_its_building(tmp_path):
    outline = feature(box(0, 0, 40, 40), "b", building="yes", height="50")
    tower = feature(box(5, 5, 10, 10), "t", building__part="yes", height="50")
    podium = feature(box(0, 0, 40, 40), "p", building__part="yes", height="12")
    site = read(write(tmp_path, outline, tower, podium), id="t").site
    assert site.heights.height_agl_m[~site.building].max() == 0.0
    assert site.building_height_m.max() == 50.0


def test_a_ring_across_the_180th_meridian_is_refused(tmp_path):
    made = feature(box(0, 0, 9, 9))
    ring = [[179.9999, 0], [-179.9999, 0], [-179.9999, 0.001], [179.9999, 0.001]]
    made["geometry"]["coordinates"] = [ring]
    assert "180th meridian" in refusal(write(tmp_path, made))


def test_noise_on_the_ground_is_no_wall(tmp_path):
    height = np.random.default_rng(1).uniform(0.0, 0.3, (60, 80))
    height[20:40, 30:50] = 9.0
    site = read(npz(tmp_path, height_agl_m=height)).site
    assert np.count_nonzero(site.heights.height_agl_m) == 400


def test_a_strip_without_end_is_refused_and_not_allocated(tmp_path):
    assert "2 × 200000 cells" in refusal(npz(tmp_path, height_agl_m=np.full((2, 200_000), 3.0)))


def test_holes_stay_open(tmp_path):
    made = feature(box(0, 0, 40, 40))
    made["geometry"]["coordinates"].append(ring(box(0, 0, 20, 20)))
    site = read(write(tmp_path, made)).site
    assert site.heights.sample([[0.0, 0.0], [15.0, 0.0]]).tolist() == [0.0, 10.0]


def test_refusals_of_footprints(tmp_path):
    house = feature(box(0, 0, 10, 10), "house", building="yes", height="10")
    assert "no such map" in refusal(tmp_path / "none.geojson")
    assert "height" in refusal(write(tmp_path, feature(box(0, 0, 9, 9), "x", building="yes", name="Hut")))
    assert "crosses itself" in refusal(write(tmp_path, feature([(0, 0), (10, 10), (10, 0), (0, 10)])))
    two = write(tmp_path, house, feature(box(50, 0, 10, 10), "other", building="yes", height="9"))
    assert "names none" in refusal(two)
    away = refusal(two, at=(LAT + 0.001, LON))
    assert "no building stands at" in away
    assert "m away" in away
    assert "far away from [building] at" in refusal(two, at=(LAT + 50.0, LON))
    assert "id 'way/7'" in refusal(two, id="way/7")
    assert "roof:levels = 'many'" in refusal(
        write(
            tmp_path, feature(box(0, 0, 9, 9), "x", building="yes", building__levels="2", roof__levels="many")
        )
    )
    assert "-12" in refusal(write(tmp_path, feature(box(0, 0, 9, 9), "x", building="yes", height="-12")))
    assert "none of its 1 features" in refusal(write(tmp_path, feature(box(0, 0, 9, 9), "x", highway="path")))
    swapped = feature(box(0, 0, 9, 9))
    swapped["geometry"]["coordinates"] = [[[19.0, -99.0], [19.1, -99.0], [19.1, -99.1], [19.0, -99.0]]]
    assert "[lon, lat]" in refusal(write(tmp_path, swapped))
    assert "cell_m" in refusal(write(tmp_path, feature(box(0, 0, 9000, 9000))), cell_m=0.25)
    (tmp_path / "broken.geojson").write_text('{"type": "FeatureColl')
    assert "not JSON" in refusal(tmp_path / "broken.geojson")
    (tmp_path / "map.dwg").write_text("x")
    assert ".dwg" in refusal(tmp_path / "map.dwg")


def npz(tmp_path, **overrides):
    height = np.zeros((60, 80))
    height[20:40, 30:50] = 9.0
    content = {"height_agl_m": height, "cell_m": 0.5, "origin": [LAT, LON], **overrides}
    path = tmp_path / "map.npz"
    np.savez(path, **{key: value for key, value in content.items() if value is not None})
    return path


def test_npz_rows_start_in_the_south_and_columns_in_the_west(tmp_path):
    site = read(npz(tmp_path)).site
    middle = FRAME.point_enu_m(site.heights.frame.origin)
    assert np.allclose(middle[:2], [20.0, 15.0], atol=1e-3)
    assert site.heights.cell_m == 0.5
    assert site.building.sum() == 400


def test_npz_says_what_of_it_is_ignored(tmp_path):
    assert read(npz(tmp_path)).warnings == ()
    (told,) = read(npz(tmp_path, crs="EPSG:32614", id=np.array(7))).warnings
    assert "ignored 'crs', 'id'" in told


def test_refusals_of_grids(tmp_path):
    holed = np.zeros((6, 6))
    holed[2, 3] = np.nan
    assert "height_agl_m[2, 3] is nan" in refusal(npz(tmp_path, height_agl_m=holed))
    assert "'cell_m'" in refusal(npz(tmp_path, cell_m=None))
    assert "cell_m is [-1" in refusal(npz(tmp_path, cell_m=-1.0))
    assert "origin" in refusal(npz(tmp_path, origin=[200.0, 3.0]))
    assert "shape" in refusal(npz(tmp_path, height_agl_m=np.zeros(4)))
    assert "nothing in it" in refusal(npz(tmp_path, height_agl_m=np.zeros((4, 4))))
    assert "m away" in refusal(npz(tmp_path), at=(LAT, LON))
    (tmp_path / "torn.npz").write_bytes(npz(tmp_path).read_bytes()[:100])
    assert "not a readable" in refusal(tmp_path / "torn.npz")


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_covered_cells_hold_every_point_of_the_polygon(data):
    corners = data.draw(
        st.lists(st.tuples(st.floats(1, 19), st.floats(1, 19)), min_size=3, max_size=7, unique=True)
    )
    points = np.array(corners)
    if crossing(points) is not None:
        return
    mask = cover((points,), 0.0, 0.0, 0.5, (40, 40))
    for x, y in np.random.default_rng(1).uniform(0, 20, (200, 2)):
        cell = mask[int(y / 0.5), int(x / 0.5)]
        if contains((points,), x, y):
            assert cell
    centres = (np.argwhere(mask) + 0.5) * 0.5
    for y, x in centres:
        near = [(x + dx, y + dy) for dx in np.linspace(-0.26, 0.26, 9) for dy in np.linspace(-0.26, 0.26, 9)]
        side = min(_away(points, x, y), 1.0)
        assert side < 0.36 or any(contains((points,), *p) for p in near)


def _away(points, x, y):
    a, b = points, np.roll(points, -1, axis=0)
    along = np.clip(
        ((np.array([x, y]) - a) * (b - a)).sum(1) / np.maximum(((b - a) ** 2).sum(1), 1e-12), 0, 1
    )
    return np.hypot(*(a + along[:, None] * (b - a) - [x, y]).T).min()


@settings(max_examples=80, deadline=None)
@given(st.binary(max_size=400))
def test_any_bytes_are_refused_in_one_line(tmp_path_factory, content):
    folder = tmp_path_factory.mktemp("fuzz")
    for name in ("x.geojson", "x.npz", "x.json", "x.jsonl"):
        (folder / name).write_bytes(content)
        refusal(folder / name)
