"""The tables of pictures, read back by each program's own rule."""

import numpy as np
import pytest

from mavspiral.export.geotags import geo_txt, geotags_csv, photo_name
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.survey.shots import Shots

FRAME = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))
PLACES = np.array([[3.0, -4.0, 5.0], [9.0, 9.0, 9.0], [-30.0, 12.0, 40.0], [7.0, 8.0, 12.0]])
# Level to the north, level to the west, half down to the south, straight down with its top to the east.
SHOTS = Shots([1.0, 2.0, 3.0, 4.0], PLACES, np.radians([90, 180, 270, 0]), np.radians([0, 0, -45, -90]))
NAMES = ("DSC00001.JPG", None, "DSC00003.JPG", "DSC00004.JPG")
NAMED = [0, 2, 3]


def gaze_enu(yaw_deg, pitch_deg):
    """Pix4D 202558969: pitch 0 is nadir, 90 forward; yaw is where the top of a nadir image points, clockwise from north."""
    yaw, pitch = np.radians([yaw_deg, pitch_deg])
    return np.array([np.sin(yaw) * np.sin(pitch), np.cos(yaw) * np.sin(pitch), -np.cos(pitch)])


def ours_enu(yaw_enu_rad, pitch_rad):
    level = np.cos(pitch_rad)
    return np.array([np.cos(yaw_enu_rad) * level, np.sin(yaw_enu_rad) * level, np.sin(pitch_rad)])


def pix4d(text):
    """PIX4Dmatic 360056389172: no header but a # comment; name, latitude, longitude, height, yaw, pitch, roll, commas."""
    rows = [line.split(",") for line in text.splitlines() if not line.startswith("#")]
    assert {len(row) for row in rows} == {7}
    return {name: tuple(map(float, values)) for name, *values in rows}


def metashape(text, columns="nyxzabc"):
    """importReference: each column by its letter, n label, x longitude, y latitude, z altitude, abc yaw, pitch, roll."""
    rows = [dict(zip(columns, line.split(","), strict=True)) for line in text.splitlines()[1:]]
    return {row["n"]: {key: float(row[key]) for key in columns if key != "n"} for row in rows}


def odm(text):
    """opendm/geo.py: the first line is the reference system, then blanks between name, x, y and z."""
    head, *lines = text.strip().split("\n")
    parts = [line.split() for line in lines if line and line[0] != "#"]
    return head, {row[0]: tuple(map(float, row[1:4])) for row in parts}, {len(row) for row in parts}


def test_pix4d_finds_each_picture_where_it_was_taken_and_looking_where_it_looked():
    rows = pix4d(geotags_csv(SHOTS, NAMES, FRAME))
    assert list(rows) == ["DSC00001.JPG", "DSC00003.JPG", "DSC00004.JPG"]
    for i, (lat, lon, alt, yaw, pitch, roll) in zip(NAMED, rows.values(), strict=True):
        assert np.allclose(
            FRAME.to_enu(np.array([lat]), np.array([lon]), np.array([alt])), PLACES[i], atol=2e-3
        )
        assert np.allclose(
            gaze_enu(yaw, pitch), ours_enu(SHOTS.yaw_enu_rad[i], SHOTS.pitch_rad[i]), atol=2e-4
        )
        assert roll == 0.0 and 0.0 <= yaw < 360.0
    assert rows["DSC00004.JPG"][3:] == (90.0, 0.0, 0.0)


def test_metashape_finds_the_same_in_the_same_file():
    rows = metashape(geotags_csv(SHOTS, NAMES, FRAME))
    assert rows["DSC00001.JPG"]["a"] == 0.0 and rows["DSC00001.JPG"]["b"] == 90.0
    assert (rows["DSC00003.JPG"]["a"], rows["DSC00003.JPG"]["b"]) == (180.0, 45.0)
    assert rows["DSC00003.JPG"]["y"] == pytest.approx(19.434, abs=1e-3)
    assert rows["DSC00003.JPG"]["x"] == pytest.approx(-99.1409, abs=1e-3)


def test_opendronemap_finds_each_picture_longitude_first_and_no_angles():
    head, rows, widths = odm(geo_txt(SHOTS, NAMES, FRAME))
    assert head == "EPSG:4326" and widths == {4}
    assert list(rows) == ["DSC00001.JPG", "DSC00003.JPG", "DSC00004.JPG"]
    for i, (lon, lat, alt) in zip(NAMED, rows.values(), strict=True):
        assert np.allclose(
            FRAME.to_enu(np.array([lat]), np.array([lon]), np.array([alt])), PLACES[i], atol=2e-3
        )
        assert alt == pytest.approx(2240.0 + PLACES[i, 2], abs=2e-3)


@pytest.mark.parametrize(
    ("first", "number", "name"),
    [
        ("DSC00001.JPG", 0, "DSC00001.JPG"),
        ("DSC00998.ARW", 4, "DSC01002.ARW"),
        ("DJI_0001.JPG", 11, "DJI_0012.JPG"),
        ("100_0007_W.jp2", 3, "100_0010_W.jp2"),
    ],
)
def test_names_count_on_as_the_card_does(first, number, name):
    assert photo_name(first, number) == name
