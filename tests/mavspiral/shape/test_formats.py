"""One building, every format: the same site, within what the format can say."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mavspiral.errors import InputError
from mavspiral.shape.readers import MapRequest, read_site

CELL_M = 0.5


def read(path, stepped, **request):
    request = {"cell_m": CELL_M, "ground_amsl_m": stepped.ground_m, "at": stepped.at, **request}
    return read_site(MapRequest(path, **request))


def on_site(site, stepped, x, y):
    """Heights and building cells of the site at places of the building's own frame."""
    lat, lon, _ = stepped.frame.to_geodetic(np.column_stack([x, y, np.zeros(len(x))]))
    plan = site.heights.frame.to_enu(lat, lon, stepped.ground_m)[:, :2]
    row, col = site.heights.index(plan).T
    rows, cols = site.heights.shape
    inside = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
    building = np.zeros(len(x), dtype=bool)
    building[inside] = site.building[row[inside], col[inside]]
    return site.heights.sample(plan), building


def judge(answer, stepped, reach_m, missing_m=0.0):
    """Right further than `reach_m` from the walls, and nowhere lower than the building further than `missing_m`."""
    site = answer.site
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-40, 60, 6000), rng.uniform(-40, 40, 6000)
    seen, building = on_site(site, stepped, x, y)
    true, edge = stepped.height_m(x, y), stepped.to_edge_m(x, y)
    clear = edge > reach_m
    assert np.abs(seen - true)[clear].max() < 0.06
    assert np.all((seen > true - 0.06)[edge > missing_m])
    assert np.array_equal(building[clear], (true >= 12.0)[clear])
    assert np.allclose(stepped.frame.point_enu_m(site.heights.frame.origin)[:2], 0.0, atol=CELL_M)
    assert site.heights.frame.origin.alt_amsl_m == stepped.ground_m
    assert site.heights.height_agl_m[~site.building].max() == pytest.approx(9.0, abs=0.06)
    assert (
        1200.0
        <= site.building.sum() * site.heights.cell_m**2 + 1e-6
        <= (40 + 2 * reach_m) * (30 + 2 * reach_m)
    )


MESH = {"units": "m", "up": "z"}


@pytest.mark.parametrize(
    ("write", "extra", "module", "reach_m", "missing_m", "keys"),
    [
        ("geojson", None, None, 1.01 * CELL_M, 0.0, {}),
        ("npz", None, None, 1.01 * CELL_M, 0.02, {}),
        ("cityjson", "geo", "pyproj", 1.5 * CELL_M, 0.0, {}),
        ("cityjson_lines", "geo", "pyproj", 1.5 * CELL_M, 0.0, {}),
        ("geotiff", "geo", "rasterio", 1.5 * CELL_M + 0.25, 0.18, {}),
        ("stl", "mesh", "trimesh", 1.5 * CELL_M, 0.0, MESH),
        ("obj", "mesh", "trimesh", 1.5 * CELL_M, 0.0, MESH),
        ("ply", "mesh", "trimesh", 1.5 * CELL_M, 0.0, MESH),
        ("las", "cloud", "laspy", 1.5 * CELL_M, 0.35, {}),
    ],
)
def test_every_format_gives_the_same_site(tmp_path, stepped, write, extra, module, reach_m, missing_m, keys):
    if module:
        pytest.importorskip(module, reason=f"the extra {extra} is not installed")
    judge(read(getattr(stepped, write)(tmp_path), stepped, **keys), stepped, reach_m, missing_m)


def test_cityjson_says_its_level_and_version_1_1_reads_the_same(tmp_path, stepped):
    pytest.importorskip("pyproj", reason="the extra geo is not installed")
    answer = read(stepped.cityjson(tmp_path, version="1.1"), stepped, at=None, id="house")
    judge(answer, stepped, 1.5 * CELL_M)
    assert answer.name == "house"
    assert "LoD 2.2" in answer.warnings[0]


def test_a_geotiff_in_degrees_and_one_of_metre_pixels(tmp_path, stepped):
    degrees = stepped.geotiff(tmp_path, crs="EPSG:4326")
    judge(read(degrees, stepped), stepped, 1.5 * CELL_M + 0.3, 0.2)
    coarse = stepped.geotiff(tmp_path, pixel_m=1.0)
    judge(read(coarse, stepped), stepped, 1.5 * CELL_M + 1.0, 0.71)


@pytest.mark.parametrize(
    ("write", "module", "reach_m", "missing_m"),
    [
        ("cityjson", "pyproj", 1.5 * CELL_M, 0.0),
        ("geotiff", "rasterio", 1.5 * CELL_M + 0.25, 0.18),
        ("las", "laspy", 1.5 * CELL_M, 0.35),
    ],
)
def test_a_map_that_lacks_its_system_takes_the_missions(tmp_path, stepped, write, module, reach_m, missing_m):
    pytest.importorskip(module, reason="the extra is not installed")
    path = without_crs(write, tmp_path, stepped)
    with pytest.raises(InputError, match=r"no coordinate reference system.*\[building\] crs"):
        read(path, stepped)
    answer = read(path, stepped, crs="EPSG:32614")
    judge(answer, stepped, reach_m, missing_m)
    assert not any("crs" in warning for warning in answer.warnings)
    both = read(getattr(stepped, write)(tmp_path), stepped, crs="EPSG:3857")
    judge(both, stepped, reach_m, missing_m)
    assert any("crs = EPSG:3857 is not used" in warning for warning in both.warnings)


def without_crs(write, folder, stepped):
    """The same map, but it does not name its coordinate reference system."""
    if write == "las":
        return stepped.las(folder, name="nocrs.las", crs=None)
    path = getattr(stepped, write)(folder)
    if write == "cityjson":
        document = json.loads(path.read_text())
        del document["metadata"]
        path = folder / "nocrs.city.json"
        path.write_text(json.dumps(document))
        return path
    rasterio = pytest.importorskip("rasterio", reason="the extra geo is not installed")
    with rasterio.open(path) as source:
        profile, band = source.profile, source.read()
    profile.pop("crs")
    path = folder / "nocrs.tif"
    with rasterio.open(path, "w", **profile) as out:
        out.write(band)
    return path


def test_geojson_has_one_system_and_takes_no_other(tmp_path, stepped):
    with pytest.raises(InputError, match="crs means nothing to"):
        read(stepped.geojson(tmp_path), stepped, crs="EPSG:32614")


def test_a_sloping_site_needs_its_terrain_or_its_rim(tmp_path, stepped):
    surface = stepped.geotiff(tmp_path, slope=0.05)
    terrain = stepped.geotiff(tmp_path, name="terrain.tif", slope=0.05, bare=True, pixel_m=1.0)
    by_rim = read(surface, stepped).site
    by_terrain = read(surface, stepped, dtm=terrain).site
    for site in (by_rim, by_terrain):
        assert site.building.sum() * CELL_M**2 == pytest.approx(1200.0, rel=0.08)
        assert site.building_height_m.max() == pytest.approx(30.0 + 16.0 * 0.05, abs=0.1)
    assert np.mean(by_rim.building != by_terrain.building) < 0.001


def test_heights_above_ground_are_recognised(tmp_path, stepped):
    answer = read(stepped.geotiff(tmp_path, ground_m=0.0), stepped)
    assert answer.site.building_height_m.max() == pytest.approx(30.0)
    assert any("above ground already" in warning for warning in answer.warnings)


def test_a_cloud_without_classes_and_a_compressed_one(tmp_path, stepped):
    plain = read(stepped.las(tmp_path, classified=False), stepped)
    judge(plain, stepped, 1.5 * CELL_M, 0.35)
    assert any("(6)" in warning for warning in plain.warnings)
    pytest.importorskip("lazrs", reason="the extra cloud is not installed")
    judge(read(stepped.las(tmp_path, name="stepped.laz"), stepped), stepped, 1.5 * CELL_M, 0.35)


@pytest.mark.parametrize("but", [lambda x, y: x < -5.0, lambda x, y: (abs(x) > 18) | (abs(y) > 13)])
def test_a_building_that_is_classified_only_partly_is_one_building(tmp_path, stepped, but):
    answer = read(stepped.las(tmp_path, but=but), stepped)
    judge(answer, stepped, 1.5 * CELL_M, 0.35)
    assert any("are unclassified: they are taken to be of the building" in told for told in answer.warnings)


@pytest.mark.parametrize(("units", "factor"), [("mm", 1000.0), ("ft", 1 / 0.3048)])
def test_a_mesh_lying_on_its_side_in_other_units_and_turned(tmp_path, stepped, units, factor):
    pytest.importorskip("trimesh", reason="the extra mesh is not installed")
    turn = np.radians(30.0)  # the mesh's north points 30° east of north
    x, y, z = np.moveaxis(stepped.triangles_m(), -1, 0)
    x, y = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
    lying = np.stack([x, z, -y], axis=-1) * factor
    answer = read(stepped.obj(tmp_path, lying), stepped, units=units, up="y", heading_deg=30.0)
    judge(answer, stepped, 1.5 * CELL_M)
