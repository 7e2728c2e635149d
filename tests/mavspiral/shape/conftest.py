"""One stepped building with a neighbour, written in every format that is read."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame

LAT, LON, GROUND_M = 19.4, -97.3, 100.0
FRAME = LocalFrame(GeoPoint(LAT, LON, GROUND_M))
PODIUM = (-20.0, -15.0, 20.0, 15.0, 12.0)
TOWER = (4.0, 2.0, 16.0, 12.0, 30.0)
NEIGHBOUR = (45.0, -4.0, 53.0, 4.0, 9.0)
UTM = "EPSG:32614"


class Stepped:
    """The building: a podium of 40 × 30 × 12 m, on it a tower of 12 × 10 m up to 30 m; 25 m east a house of 9 m."""

    at, ground_m, frame, neighbour_at = (LAT, LON), GROUND_M, FRAME, (0.0, 49.0)

    @staticmethod
    def height_m(x, y):
        h = np.zeros(np.broadcast(x, y).shape)
        for west, south, east, north, top in (NEIGHBOUR, PODIUM, TOWER):
            h[(x >= west) & (x <= east) & (y >= south) & (y <= north)] = top
        return h

    @staticmethod
    def to_edge_m(x, y):
        """How far a place is from the nearest wall in plan."""
        near = np.full(np.broadcast(x, y).shape, np.inf)
        for west, south, east, north, _ in (NEIGHBOUR, PODIUM, TOWER):
            dx = np.maximum(np.maximum(west - x, x - east), 0)
            dy = np.maximum(np.maximum(south - y, y - north), 0)
            inner = np.minimum(np.minimum(x - west, east - x), np.minimum(y - south, north - y))
            near = np.minimum(near, np.where(inner > 0, inner, np.hypot(dx, dy)))
        return near

    @staticmethod
    def triangles_m(boxes=(PODIUM, TOWER, NEIGHBOUR)):
        """The closed boxes as triangles `(n, 3, 3)`, each from the ground to its top."""
        made = []
        for west, south, east, north, top in boxes:
            ring = np.array([(west, south), (east, south), (east, north), (west, north)])
            floor, roof = (np.column_stack([ring, np.full(4, z)]) for z in (0.0, top))
            quads = [roof, floor[::-1]] + [
                np.array([floor[i], floor[(i + 1) % 4], roof[(i + 1) % 4], roof[i]]) for i in range(4)
            ]
            made += [q[list(corners)] for q in quads for corners in ((0, 1, 2), (0, 2, 3))]
        return np.array(made)

    def geojson(self, folder):
        def outline(box, **tags):
            west, south, east, north, top = box
            xy = [(west, south), (east, south), (east, north), (west, north), (west, south)]
            lat, lon, _ = FRAME.to_geodetic([[x, y, 0.0] for x, y in xy])
            return {
                "type": "Feature",
                "properties": {"height": top, **tags},
                "geometry": {"type": "Polygon", "coordinates": [np.column_stack([lon, lat]).tolist()]},
            }

        features = [
            outline(PODIUM, building="yes", name="house"),
            outline(PODIUM, **{"building:part": "yes"}),
            outline(TOWER, **{"building:part": "yes"}),
            outline(NEIGHBOUR, building="yes"),
        ]
        return _text(folder / "stepped.geojson", {"type": "FeatureCollection", "features": features})

    def npz(self, folder, cell_m=0.5):
        south_west = np.array([-60.0, -50.0])
        x = south_west[0] + (np.arange(int(140 / cell_m)) + 0.5) * cell_m
        y = south_west[1] + (np.arange(int(100 / cell_m)) + 0.5) * cell_m
        lat, lon, _ = FRAME.to_geodetic([*south_west, 0.0])
        path = folder / "stepped.npz"
        np.savez(
            path,
            height_agl_m=self.height_m(x[np.newaxis], y[:, np.newaxis]),
            cell_m=cell_m,
            origin=[lat, lon],
        )
        return path

    def city_document(self, version="2.0", ground_m=GROUND_M):
        vertices, things = [], {}
        for name, box in (("podium", PODIUM), ("tower", TOWER), ("neighbour", NEIGHBOUR)):
            west, south, east, north, top = box
            ring = [(west, south), (east, south), (east, north), (west, north)]
            x, y = _utm(*np.array(ring).T)
            first = len(vertices)
            for z in (ground_m, ground_m + top):
                vertices += [
                    [round(a * 1000) - 700_000_000, round(b * 1000) - 2_100_000_000, round(z * 1000)]
                    for a, b in zip(x, y, strict=True)
                ]
            f = first
            faces = [[f + 3, f + 2, f + 1, f], [f + 4, f + 5, f + 6, f + 7]] + [
                [f + i, f + (i + 1) % 4, f + 4 + (i + 1) % 4, f + 4 + i] for i in range(4)
            ]
            solid = {"type": "Solid", "lod": "2.2", "boundaries": [[[face] for face in faces]]}
            low = {"type": "MultiSurface", "lod": "0", "boundaries": [[faces[0]]]}
            things[name] = {"type": "BuildingPart", "parents": ["house"], "geometry": [low, solid]}
        things["neighbour"] = {"type": "Building", "geometry": things["neighbour"]["geometry"]}
        block = {"type": "Solid", "lod": "1.2", "boundaries": [[[[12, 13, 14, 15]]]]}
        things["house"] = {"type": "Building", "children": ["podium", "tower"], "geometry": [block]}
        return {
            "type": "CityJSON",
            "version": version,
            "transform": {"scale": [0.001] * 3, "translate": [700_000.0, 2_100_000.0, 0.0]},
            "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/32614"},
            "CityObjects": things,
            "vertices": vertices,
        }

    def cityjson(self, folder, version="2.0", ground_m=GROUND_M):
        return _text(folder / "stepped.city.json", self.city_document(version, ground_m))

    def cityjson_lines(self, folder):
        whole = self.city_document()
        head = {**whole, "CityObjects": {}, "vertices": []}
        things = whole["CityObjects"]
        lines = [head]
        for names in (("neighbour",), ("house", "podium", "tower")):
            objects = {name: things[name] for name in names}
            lines.append({"type": "CityJSONFeature", "CityObjects": objects, "vertices": whole["vertices"]})
        path = folder / "stepped.city.jsonl"
        path.write_text("\n".join(json.dumps(line) for line in lines) + "\n")
        return path

    def geotiff(
        self,
        folder,
        name="stepped.tif",
        crs=UTM,
        pixel_m=0.25,
        ground_m=GROUND_M,
        bare=False,
        slope=0.0,
        **options,
    ):
        rasterio = pytest.importorskip("rasterio", reason="the extra geo is not installed")
        pyproj = pytest.importorskip("pyproj", reason="the extra geo is not installed")
        back = pyproj.Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
        lat, lon, _ = FRAME.to_geodetic([[-60.0, 50.0, 0.0], [80.0, -50.0, 0.0]])
        x, y = back.transform(lon, lat, direction="INVERSE")
        pixel = pixel_m if crs == UTM else pixel_m / 105_000.0
        cols, rows = int((x[1] - x[0]) / pixel), int((y[0] - y[1]) / pixel)
        px, py = np.meshgrid(x[0] + (np.arange(cols) + 0.5) * pixel, y[0] - (np.arange(rows) + 0.5) * pixel)
        plon, plat = back.transform(px, py)
        enu = FRAME.to_enu(plat, plon, GROUND_M)
        z = ground_m + slope * enu[..., 0] + (0.0 if bare else 1.0) * self.height_m(enu[..., 0], enu[..., 1])
        z[:8, :8] = -9999.0
        path = folder / name
        profile = {
            "driver": "GTiff",
            "width": cols,
            "height": rows,
            "count": 1,
            "dtype": "float32",
            "nodata": -9999.0,
        }
        transform = rasterio.Affine(pixel, 0.0, x[0], 0.0, -pixel, y[0])
        with rasterio.open(path, "w", **{**profile, "crs": crs, "transform": transform, **options}) as out:
            out.write(z.astype("float32"), 1)
        return path

    def stl(self, folder, triangles=None):
        triangles = self.triangles_m() if triangles is None else triangles
        path = folder / "stepped.stl"
        body = b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in triangles)
        path.write_bytes(b"binary".ljust(80) + struct.pack("<I", len(triangles)) + body)
        return path

    def obj(self, folder, triangles=None):
        triangles = self.triangles_m() if triangles is None else triangles
        lines = ["mtllib ../../secret.mtl", "o house"]
        lines += ["v {:.6f} {:.6f} {:.6f}".format(*corner) for corner in triangles.reshape(-1, 3)]
        lines += [f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}" for i in range(len(triangles))]
        path = folder / "stepped.obj"
        path.write_text("\n".join(lines) + "\n")
        return path

    def ply(self, folder, triangles=None):
        triangles = self.triangles_m() if triangles is None else triangles
        corners = triangles.reshape(-1, 3).astype("<f4")
        head = (
            f"ply\nformat binary_little_endian 1.0\nelement vertex {len(corners)}\nproperty float x\nproperty float y\n"
            f"property float z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
        )
        body = b"".join(struct.pack("<B3i", 3, 3 * i, 3 * i + 1, 3 * i + 2) for i in range(len(triangles)))
        path = folder / "stepped.ply"
        path.write_bytes(head.encode() + corners.tobytes() + body)
        return path

    def las(self, folder, name="stepped.las", classified=True, spacing_m=0.25, crs=UTM, but=None):
        laspy = pytest.importorskip("laspy", reason="the extra cloud is not installed")
        pyproj = pytest.importorskip("pyproj", reason="the extra cloud is not installed")
        x, y = (a.ravel() for a in np.meshgrid(np.arange(-60, 80, spacing_m), np.arange(-50, 50, spacing_m)))
        rng = np.random.default_rng(1)
        x, y = (a + rng.uniform(-0.2, 0.2, len(a)) * spacing_m for a in (x, y))
        height = self.height_m(x, y)
        header = laspy.LasHeader(point_format=6, version="1.4")
        header.scales, header.offsets = np.full(3, 0.001), np.array([700_000.0, 2_100_000.0, 0.0])
        if crs:
            header.add_crs(pyproj.CRS.from_user_input(crs))
        cloud = laspy.LasData(header)
        cloud.x, cloud.y = _utm(x, y)
        cloud.z = GROUND_M + height + rng.normal(0, 0.01, len(x))
        kinds = np.where(height > 0, 6, 2) if classified else np.ones(len(x), dtype=int)
        if but is not None:
            kinds[but(x, y)] = 1
        cloud.classification = kinds.astype("uint8")
        cloud.classification[:3] = 7
        cloud.z[:3] = 900.0
        path = folder / name
        cloud.write(path)
        return path


def _text(path, document):
    path.write_text(json.dumps(document))
    return path


def _utm(x, y):
    pyproj = pytest.importorskip("pyproj", reason="the extra geo is not installed")
    lat, lon, _ = FRAME.to_geodetic(np.column_stack([x, y, np.zeros(len(x))]))
    return pyproj.Transformer.from_crs("EPSG:4326", UTM, always_xy=True).transform(lon, lat)


@pytest.fixture(scope="session")
def stepped():
    return Stepped()
