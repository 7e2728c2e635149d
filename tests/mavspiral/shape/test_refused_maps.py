"""What each reader says of a map that it does not believe."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

from mavspiral.errors import InputError
from mavspiral.shape.readers import MapRequest, read_site

MESH = {"units": "m", "up": "z"}


def read(path, stepped, **request):
    request = {"cell_m": 0.5, "ground_amsl_m": stepped.ground_m, "at": stepped.at, **request}
    return read_site(MapRequest(path, **request))


def refusal(path, stepped, **request):
    with pytest.raises(InputError) as caught:
        read(path, stepped, **request)
    line = str(caught.value)
    assert "\n" not in line
    assert "Fix: " in line
    return line


@pytest.mark.parametrize(
    ("name", "key", "value"),
    [
        ("x.geojson", "units", "m"),
        ("x.npz", "id", "way/1"),
        ("x.las", "up", "z"),
        ("x.tif", "heading_deg", 3.0),
        ("x.stl", "dtm", "terrain.tif"),
    ],
)
def test_keys_that_mean_nothing_to_a_format(tmp_path, stepped, name, key, value):
    (tmp_path / name).write_bytes(b"")
    line = refusal(tmp_path / name, stepped, **{key: value})
    assert f"[building] {key} means nothing to a" in line
    assert "leave it out" in line


@pytest.mark.parametrize(
    ("name", "module", "extra"),
    [
        ("x.tif", "rasterio", "geo"),
        ("x.stl", "trimesh", "mesh"),
        ("x.las", "laspy", "cloud"),
        ("x.city.json", "pyproj", "geo"),
    ],
)
def test_a_missing_extra_is_named(tmp_path, stepped, monkeypatch, name, module, extra):
    monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / name).write_text(json.dumps({**CITY, "metadata": {"referenceSystem": "EPSG:32614"}}))
    assert f"pip install 'mavspiral[{extra}]'" in refusal(
        tmp_path / name, stepped, **(MESH if extra == "mesh" else {})
    )


CITY = {
    "type": "CityJSON",
    "version": "2.0",
    "transform": {"scale": [1, 1, 1], "translate": [0, 0, 0]},
    "CityObjects": {
        "a": {
            "type": "Building",
            "geometry": [{"type": "MultiSurface", "lod": "2", "boundaries": [[[0, 1, 2]]]}],
        }
    },
    "vertices": [[678_494, 2_145_987, 109], [678_534, 2_145_987, 109], [678_494, 2_145_947, 109]],
}


def city(tmp_path, stepped, change):
    pytest.importorskip("pyproj", reason="the extra geo is not installed")
    document = stepped.city_document()
    change(document)
    path = tmp_path / "x.city.json"
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d.update(version="1.0"), "CityJSON 1.0 is not read"),
        (lambda d: d.pop("metadata"), "referenceSystem"),
        (lambda d: d["metadata"].update(referenceSystem="EPSG:999999"), "not known"),
        (lambda d: d["metadata"].update(referenceSystem="EPSG:4326"), "degrees"),
        (lambda d: d["metadata"].update(referenceSystem="EPSG:28992"), "correct the map's CRS"),
        (lambda d: d.update(CityObjects={}), "no building"),
        (lambda d: d["vertices"].append([1, 2, float("nan")]), "not finite"),
        (lambda d: d.update(vertices=d["vertices"][:5]), "not among the 5 vertices"),
        (lambda d: d["CityObjects"]["podium"]["geometry"].pop(), "LoD 0"),
        (
            lambda d: d["CityObjects"]["podium"]["geometry"][1]["boundaries"][0][1].__setitem__(
                0, [4, 6, 5, 7]
            ),
            "crosses itself",
        ),
        (lambda d: d.pop("transform"), "transform"),
    ],
)
def test_refusals_of_city_models(tmp_path, stepped, change, words):
    def only_the_podium(document):
        document["CityObjects"]["podium"].pop("parents")
        document["CityObjects"] = {"podium": {**document["CityObjects"]["podium"], "type": "Building"}}
        change(document)

    line = refusal(city(tmp_path, stepped, only_the_podium), stepped)
    assert words in line


def test_the_ground_of_the_map_and_of_the_mission(tmp_path, stepped):
    pytest.importorskip("pyproj", reason="the extra geo is not installed")
    path = stepped.cityjson(tmp_path)
    near = read(path, stepped, ground_amsl_m=104.0)
    assert near.site.building_height_m.max() == pytest.approx(26.0)
    assert any("100.00 m" in w and "ground_amsl_m = 104" in w and "4.0 m below" in w for w in near.warnings)
    far = refusal(path, stepped, ground_amsl_m=2240.0)
    assert "100.00 m" in far
    assert "ground_amsl_m = 2240" in far
    assert "set ground_amsl_m = 100.0" in far
    assert "feet" in refusal(stepped.cityjson(tmp_path, ground_m=328.0), stepped)


def test_a_crossing_neighbour_is_taken_to_be_larger(tmp_path, stepped):
    def cross(document):
        document["CityObjects"]["neighbour"]["geometry"][1]["boundaries"][0][1] = [[20, 22, 21, 23]]

    answer = read(city(tmp_path, stepped, cross), stepped)
    assert any("crosses itself" in w for w in answer.warnings)
    site = answer.site
    assert (site.heights.height_agl_m[~site.building] > 8.9).sum() * 0.25 >= 64.0


def test_a_taller_neighbour_at_a_party_wall_does_not_raise_the_building(tmp_path, stepped):
    def against(document):
        for index in range(16, 24):
            document["vertices"][index][0] -= 25_000
            document["vertices"][index][2] *= 1 if index < 20 else 2

    site = read(city(tmp_path, stepped, against), stepped).site
    assert site.building_height_m.max() == pytest.approx(30.0)
    assert site.heights.height_agl_m[~site.building].max() > 100.0


def test_refusals_of_surface_models(tmp_path, stepped):
    rasterio = pytest.importorskip("rasterio", reason="the extra geo is not installed")
    path = stepped.geotiff(tmp_path)
    lat, lon = stepped.at
    assert "is not on the map" in refusal(path, stepped, at=(lat + 0.1, lon))
    assert "is not on the map" in refusal(path, stepped, at=(lon, lat))
    assert "m away" in refusal(path, stepped, at=(lat + 0.0003, lon))
    assert "ground_amsl_m = 100.0" in refusal(path, stepped, ground_amsl_m=2240.0)
    assert "set [building] cell_m" in refusal(path, stepped, at=None, cell_m=0.02)
    assert "coordinate reference system" in refusal(_without_crs(rasterio, path, tmp_path), stepped)
    assert "gdal_edit.py -a_nodata -9999" in refusal(
        stepped.geotiff(tmp_path, name="nodata.tif", nodata=None), stepped
    )
    assert "only nodata" in refusal(_filled(rasterio, path, tmp_path / "void.tif", -9999.0), stepped)
    assert "stands more than" in refusal(_filled(rasterio, path, tmp_path / "flat.tif", 100.0), stepped)
    assert "inf" in refusal(_filled(rasterio, path, tmp_path / "inf.tif", np.inf), stepped)
    elsewhere = _moved(rasterio, path, tmp_path / "elsewhere.tif")
    assert "elsewhere.tif: [building] at" in refusal(path, stepped, dtm=elsewhere)
    assert "no such map" in refusal(path, stepped, dtm=tmp_path / "none.tif")


def _without_crs(rasterio, path, folder):
    with rasterio.open(path) as src:
        profile, data = src.profile, src.read()
    profile.pop("crs")
    with rasterio.open(folder / "nocrs.tif", "w", **profile) as out:
        out.write(data)
    return folder / "nocrs.tif"


def _filled(rasterio, path, target, value):
    with rasterio.open(path) as src:
        profile, data = src.profile, src.read()
    with rasterio.open(target, "w", **profile) as out:
        out.write(np.full_like(data, value))
    return target


def _moved(rasterio, path, target):
    with rasterio.open(path) as src:
        profile, data = src.profile, src.read()
    profile["transform"] = rasterio.Affine(0.25, 0, 700_000, 0, -0.25, 2_200_000)
    with rasterio.open(target, "w", **profile) as out:
        out.write(data)
    return target


def test_refusals_of_meshes(tmp_path, stepped):
    pytest.importorskip("trimesh", reason="the extra mesh is not installed")
    path = stepped.stl(tmp_path)
    assert "does not say its units" in refusal(path, stepped, up="z")
    assert "does not say its up" in refusal(path, stepped, units="m")
    assert "where the mesh's origin stands" in refusal(path, stepped, **MESH, at=None)
    assert "check [building] units and up" in refusal(path, stepped, units="mm", up="z")
    triangles = stepped.triangles_m()
    assert "or check units" in refusal(stepped.stl(tmp_path, triangles * 1000), stepped, **MESH, cell_m=10.0)
    assert "subtract its survey coordinates" in refusal(
        stepped.obj(tmp_path, triangles + np.array([678_494, 2_145_987, 0])), stepped, **MESH
    )
    assert "100.0 m above its own zero" in refusal(
        stepped.stl(tmp_path, triangles + np.array([0, 0, 100])), stepped, **MESH
    )
    sunk = read(stepped.stl(tmp_path, triangles - [0, 0, 3]), stepped, **MESH)
    assert sunk.site.building_height_m.max() == pytest.approx(27.0)
    assert any("3.0 m below its zero" in w for w in sunk.warnings)
    triangles[3, 1, 0] = np.inf
    assert "triangle 4" in refusal(stepped.stl(tmp_path, triangles), stepped, **MESH)


def test_refusals_of_point_clouds(tmp_path, stepped):
    pytest.importorskip("laspy", reason="the extra cloud is not installed")
    path = stepped.las(tmp_path)
    assert "is not on the map" in refusal(path, stepped, at=(20.0, -97.3))
    assert "0.27 m apart" in refusal(path, stepped, cell_m=0.1)
    assert "cell_m = 0.5" in refusal(path, stepped, cell_m=0.1)
    assert "ground_amsl_m = 100" in refusal(path, stepped, ground_amsl_m=2240.0)
    assert "-epsg" in refusal(stepped.las(tmp_path, name="nocrs.las", crs=None), stepped)


def test_heights_in_feet_or_millimetres_are_suspected(tmp_path, stepped):
    path = stepped.npz(tmp_path)
    with np.load(path) as content:
        fields = dict(content)
    fields["height_agl_m"] = fields["height_agl_m"] * 1000
    np.savez(path, **fields)
    assert "not feet or millimetres" in refusal(path, stepped)
