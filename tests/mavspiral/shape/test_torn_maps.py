"""Random and torn files of every format: read, or refused in one line; never anything else."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mavspiral.errors import InputError
from mavspiral.shape.readers import FORMATS, MapRequest, SiteMap, read_site

WRITERS = {
    "geojson": (".geojson", None, "geojson"),
    "npz": (".npz", None, "npz"),
    "cityjson": (".json", "pyproj", "cityjson"),
    "cityjson_lines": (".jsonl", "pyproj", "cityjson_lines"),
    "geotiff": (".tif", "rasterio", "geotiff"),
    "stl": (".stl", "trimesh", "stl"),
    "obj": (".obj", "trimesh", "obj"),
    "ply": (".ply", "trimesh", "ply"),
    "las": (".las", "laspy", "las"),
    "laz": (".laz", "lazrs", "las"),
}
EXTRAS = {"rasterio": "geo", "pyproj": "geo", "trimesh": "mesh", "laspy": "cloud", "lazrs": "cloud"}


def judged(path, cell_m=2.0):
    mesh = {"units": "m", "up": "z"} if path.suffix in (".stl", ".obj", ".ply") else {}
    try:
        answer = read_site(MapRequest(path, cell_m, 100.0, (19.4, -97.3), **mesh))
    except InputError as error:
        line = str(error)
        assert "\n" not in line
        assert "Fix: " in line
        assert len(line) < 1000
        return line
    assert isinstance(answer, SiteMap)
    assert all("\n" not in warning for warning in answer.warnings)
    return None


@pytest.fixture(scope="module")
def whole(stepped, tmp_path_factory):
    """The valid bytes of a format, made once."""
    made = {}

    def content(kind):
        if kind not in made:
            suffix, _, writer = WRITERS[kind]
            keys = {
                "geotiff": {"pixel_m": 2.0},
                "las": {"spacing_m": 1.5},
                "laz": {"spacing_m": 1.5, "name": "x.laz"},
            }
            path = getattr(stepped, writer)(tmp_path_factory.mktemp(kind), **keys.get(kind, {}))
            made[kind] = suffix, path.read_bytes()
            assert judged(path) is None
        return made[kind]

    return content


def needs(module):
    if module:
        pytest.importorskip(module, reason=f"the extra {EXTRAS[module]} is not installed")


@pytest.mark.parametrize("kind", WRITERS)
@settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(data=st.data())
def test_torn_files_are_read_or_refused_in_one_line(tmp_path, whole, kind, data):
    needs(WRITERS[kind][1])
    suffix, content = whole(kind)
    torn = bytearray(content)
    # The first bytes are where the claims stand.
    near_start = st.integers(0, min(len(torn), 600) - 1)
    places = st.one_of(near_start, st.integers(0, len(torn) - 1))
    for place in data.draw(st.lists(places, max_size=6)):
        torn[place] = data.draw(st.integers(0, 255))
    if data.draw(st.booleans()):
        del torn[data.draw(places) :]
    path = tmp_path / f"torn{suffix}"
    path.write_bytes(bytes(torn))
    judged(path)


@pytest.mark.parametrize("kind", WRITERS)
def test_a_file_cut_short_is_refused(tmp_path, whole, kind):
    needs(WRITERS[kind][1])
    suffix, content = whole(kind)
    for share in (0.0, 0.02, 0.5, 0.97):
        path = tmp_path / f"cut{suffix}"
        path.write_bytes(content[: int(len(content) * share)])
        line = judged(path)
        # An OBJ or a sequence of features may lose its last line and still be one.
        assert line is not None or (share > 0.4 and kind in ("obj", "cityjson_lines")), share


@pytest.mark.parametrize("suffix", FORMATS)
@settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    content=st.binary(max_size=500),
    head=st.sampled_from([b"", b"LASF", b"ply\n", b"II*\0", b"MM\0+", b"solid ", b"PK\3\4"]),
)
def test_any_bytes_are_refused(tmp_path, suffix, content, head):
    path = tmp_path / f"any{suffix}"
    path.write_bytes(head + content)
    assert judged(path) is not None


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_cityjson_of_any_shape_is_read_or_refused(tmp_path_factory, stepped, data):
    needs("pyproj")
    import json

    document = stepped.city_document()
    scalars = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8))
    junk = st.recursive(
        scalars,
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    )
    for _ in range(data.draw(st.integers(1, 3))):
        node = document
        while True:
            keys = list(node) if isinstance(node, dict) else list(range(len(node)))
            if not keys:
                break
            key = data.draw(st.sampled_from(keys))
            if isinstance(node[key], dict | list) and data.draw(st.integers(0, 3)):
                node = node[key]
                continue
            node[key] = data.draw(junk)
            break
    path = tmp_path_factory.mktemp("junk") / "x.city.json"
    path.write_text(json.dumps(document))
    judged(path)
