"""Files that claim what they do not hold: refused in a line, in bounded memory."""

from __future__ import annotations

import io
import json
import multiprocessing
import resource
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from mavspiral.errors import InputError
from mavspiral.shape.readers import MapRequest, read_site

MEMORY_MB = 250
"""Above what the process holds once all readers are imported and compiled."""


def tiff(cols, rows, rows_per_strip, pixel_m=1.0, compression=1):
    """A GeoTIFF of float32 in UTM zone 14 that declares any size and holds 64 bytes of pixels."""
    doubles = struct.pack("<3d", pixel_m, pixel_m, 0.0) + struct.pack("<6d", 0, 0, 0, 678_494, 2_145_987, 0)
    keys = struct.pack("<16H", 1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32614)
    body = doubles + keys + bytes(64)
    tags = [
        (256, 4, 1, cols),
        (257, 4, 1, rows),
        (258, 3, 1, 32),
        (259, 3, 1, compression),
        (262, 3, 1, 1),
        (273, 4, 1, 8 + len(doubles) + len(keys)),
        (277, 3, 1, 1),
        (278, 4, 1, rows_per_strip),
        (279, 4, 1, 64),
        (339, 3, 1, 3),
        (33550, 12, 3, 8),
        (33922, 12, 6, 32),
        (34735, 3, 16, 8 + len(doubles)),
    ]
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags) + bytes(4)
    return b"II*\0" + struct.pack("<I", 8 + len(body)) + body + directory


def las(count, vlrs=0, evlrs=0, point_size=30, compressed=False, chunks=0):
    head = bytearray(375)
    head[:4], head[24:26] = b"LASF", bytes((1, 4))
    struct.pack_into("<HII", head, 94, 375, 375, vlrs)
    struct.pack_into("<BHI", head, 104, 6 | (0x80 if compressed else 0), point_size, 0)
    struct.pack_into("<12d", head, 131, *[0.001] * 3, *[0.0] * 3, *[9.0, 0.0] * 3)
    struct.pack_into("<QIQ", head, 235, 375 if evlrs else 0, evlrs, count)
    table = struct.pack("<qII", 375 + 8, 0, chunks) if compressed else b""
    return bytes(head) + table + bytes(300)


def npz(shape, zeros=0, tear=b"", by=b""):
    raw = io.BytesIO()
    np.lib.format.write_array_header_1_0(raw, {"descr": "<f8", "fortran_order": False, "shape": shape})
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open("height_agl_m.npy", "w") as entry:
            entry.write(raw.getvalue().replace(tear, by, 1))
            for _ in range(zeros // 1_000_000 or 1):
                entry.write(bytes(1_000_000 if zeros else 64))
        for key, value in (("cell_m", 0.5), ("origin", [19.0, -99.0])):
            one = io.BytesIO()
            np.save(one, np.array(value))
            archive.writestr(f"{key}.npy", one.getvalue())
    return out.getvalue()


def city(**changes):
    document = {
        "type": "CityJSON",
        "version": "2.0",
        "transform": {"scale": [1, 1, 1], "translate": [678_000, 2_146_000, 0]},
        "metadata": {"referenceSystem": "EPSG:32614"},
        "CityObjects": {
            "a": {
                "type": "Building",
                "geometry": [{"type": "MultiSurface", "lod": "2", "boundaries": [[[0, 1, 2, 3]]]}],
            }
        },
        "vertices": [[0, 0, 9], [9, 0, 9], [9, 9, 9], [0, 9, 9]],
        **changes,
    }
    return json.dumps(document).encode()


def geojson(*corners):
    ring = [list(c) for c in (*corners, corners[0])]
    one = {
        "type": "Feature",
        "properties": {"building": "yes", "height": 9},
        "geometry": {"type": "Polygon", "coordinates": [ring]},
    }
    return json.dumps({"type": "FeatureCollection", "features": [one]}).encode()


def stl(*corners, count=None):
    return bytes(80) + struct.pack("<I12fH", 1 if count is None else count, 0, 0, 0, *corners, 0)


PLY = "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\nproperty list uint int vertex_indices\nend_header\n"
HUGE = 4_000_000_000

FILES = {
    "shape.npz": npz((100_000, 100_000)),
    "flat.npz": npz((1 << 60,)),
    "negative.npz": npz((-5, 7)),
    "short.npz": npz((3000, 4000)),
    "token.npz": npz((30, 40), tear=b"40), }", by=b"40 "),
    "header.npz": npz((1000, 1000), zeros=400_000_000, tear=b"NUMPY\1\0", by=b"NUMPY\2\0"),
    "bomb.npz": npz((1000, 1000), zeros=400_000_000),
    "deep.geojson": b"[" * 100_000,
    "digits.json": b'{"type": ' + b"9" * 9000 + b"}",
    "digits.city.jsonl": city() + b"\n" + b"9" * 9000,
    "wide.geojson": geojson((-99, 19), (99, 19), (99, 20), (-99, 20)),
    "corners.city.json": city(vertices=[[0, 0, 9], [10**9, 0, 9], [10**9, 10**6, 9], [0, 10**6, 9]]),
    "index.city.json": city(
        CityObjects={
            "a": {
                "type": "Building",
                "geometry": [{"type": "MultiSurface", "lod": 2, "boundaries": [[[0, 1, 10**18]]]}],
            }
        }
    ),
    "scale.city.json": city(transform={"scale": [1e308, 1e308, 1e308], "translate": [1e308, 0, 0]}),
    "loop.city.json": city(
        CityObjects={
            "a": {"type": "Building", "children": ["b"]},
            "b": {"type": "Building", "children": ["a"]},
        }
    ),
    "size.tif": tiff(100_000, 100_000, 1),
    "strip.tif": tiff(60_000, 60_000, 60_000, pixel_m=0.001, compression=8),
    "most.tif": tiff(HUGE // 2, HUGE // 2, 1, pixel_m=1e-6),
    "empty.tif": tiff(40, 40, 40),
    "vrt.tif": b"<VRTDataset rasterXSize='9' rasterYSize='9'></VRTDataset>",
    "count.stl": stl(*range(9), count=HUGE),
    "far.stl": stl(0, 0, 0, 3e38, 0, 1, 0, 3e38, 1),
    "wide.stl": stl(0, 0, 0, 1.9e4, 0, 1, 0, 1.9e4, 1),
    "nan.stl": stl(0, 0, 0, float("nan"), 0, 1, 0, 1, 1),
    "count.ply": PLY.format("binary_little_endian", HUGE, HUGE).encode() + bytes(99),
    "ascii.ply": PLY.format("ascii", HUGE, 1).encode() + b"0 0 0\n",
    "list.ply": PLY.format("binary_little_endian", 1, 1).encode()
    + bytes(12)
    + struct.pack("<I", HUGE)
    + bytes(9),
    "digits.ply": PLY.format("ascii", "9" * 6000, 1).encode(),
    "index.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 9\nf 1 2 4000000000\n",
    "digits.obj": b"v 1e999 0 0\nv 1 0 0\nv 0 1 9\nf 1 2 3\n",
    "count.las": las(1 << 60),
    "vlrs.las": las(1, vlrs=HUGE),
    "evlrs.las": las(1, evlrs=HUGE),
    "wide.las": las(500, point_size=65_535),
    "count.laz": las(1 << 60, compressed=True),
    "chunks.laz": las(10, compressed=True, chunks=HUGE),
}
MODULES = {
    "tif": "rasterio",
    "stl": "trimesh",
    "ply": "trimesh",
    "obj": "trimesh",
    "las": "laspy",
    "laz": "lazrs",
}


def _read_all(folder, good, queue):
    """In a process of its own, so that its peak of memory is its own."""
    for path in good:
        _read(path)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    for name in FILES:
        line = _read(folder / name)
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        queue.put((name, line, after - before))
    queue.put(None)


def _read(path):
    mesh = {"units": "m", "up": "z"} if path.suffix in (".stl", ".obj", ".ply") else {}
    try:
        read_site(MapRequest(path, 0.5, 100.0, (19.4, -97.3), **mesh))
    except InputError as error:
        return str(error)
    return None


def test_no_file_makes_a_reader_allocate_what_it_only_claims(tmp_path, stepped, monkeypatch):
    # The spawned process imports this file by its name.
    monkeypatch.syspath_prepend(Path(__file__).parents[3])
    for module in ("rasterio", "pyproj", "trimesh", "laspy", "lazrs"):
        pytest.importorskip(module, reason="the extras geo, mesh and cloud are not all installed")
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content)
    good = [
        getattr(stepped, kind)(tmp_path)
        for kind in ("geojson", "npz", "cityjson", "geotiff", "stl", "ply", "obj", "las")
    ]
    good.append(stepped.las(tmp_path, name="stepped.laz"))
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    process = context.Process(target=_read_all, args=(tmp_path, good, queue))
    process.start()
    answers = {}
    while (answer := queue.get(timeout=120)) is not None:
        answers[answer[0]] = answer[1:]
    process.join(120)
    assert set(answers) == set(FILES)
    for name, (line, more_mb) in answers.items():
        assert line is not None, f"{name} was read"
        assert "Fix: " in line, line
        assert "\n" not in line
        assert len(line) < 1200
        assert more_mb < MEMORY_MB, f"{name}: {more_mb:.0f} MB: {line}"


def test_layers_of_a_laz_that_are_larger_than_the_file(tmp_path, stepped):
    pytest.importorskip("lazrs", reason="the extra cloud is not installed")
    path = stepped.las(tmp_path, name="layers.laz", spacing_m=1.0)
    content = bytearray(path.read_bytes())
    (points,) = struct.unpack_from("<I", content, 96)
    struct.pack_into("<I", content, points + 8 + 30 + 4, HUGE)  # the first layer of the first chunk
    path.write_bytes(content)
    assert "its chunk 1 claims 4,000," in _read(path)


@pytest.mark.parametrize("name", FILES)
def test_hostile_files_one_by_one(tmp_path, name):
    kind = name.rsplit(".", 1)[1]
    if "city" in name:
        pytest.importorskip("pyproj", reason="the extra geo is not installed")
    if kind in MODULES:
        pytest.importorskip(MODULES[kind], reason="its extra is not installed")
    (tmp_path / name).write_bytes(FILES[name])
    assert "Fix: " in (_read(tmp_path / name) or "it was read")
