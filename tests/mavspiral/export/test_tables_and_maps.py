"""The trajectory as a table and as KML, read back as a spreadsheet and Google Earth read them."""

from __future__ import annotations

import csv
import io
from xml.etree import ElementTree

import numpy as np

from mavspiral.export.geo import trajectory_kml
from mavspiral.export.tables import trajectory_csv
from mavspiral.frames import wrap_rad

KML = {"k": "http://www.opengis.net/kml/2.2"}


def test_the_table_says_where_it_is_how_it_moves_and_where_it_looks(planned):
    kiosk = planned("kiosk")
    frame = kiosk.site.heights.frame
    rows = list(csv.DictReader(io.StringIO(trajectory_csv(kiosk.trajectory, frame))))
    column = {key: np.array([float(row[key]) for row in rows]) for key in rows[0] if key != "leg"}
    place = np.column_stack([column["east_m"], column["north_m"], column["up_m"]])
    speed = np.column_stack([column[f"velocity_{axis}_mps"] for axis in ("east", "north", "up")])
    push = np.column_stack([column[f"acceleration_{axis}_mps2"] for axis in ("east", "north", "up")])
    back = frame.to_enu(column["lat_deg"], column["lon_deg"], column["alt_amsl_m"])
    assert np.abs(back - place).max() < 2e-3
    inner = slice(1, -1)
    assert np.abs(np.gradient(place, column["t_s"], axis=0) - speed)[inner].max() < 0.02
    assert np.abs(np.gradient(speed, column["t_s"], axis=0) - push)[inner].max() < 0.25
    yaw_deg = np.degrees(np.unwrap(np.radians(column["yaw_ned_deg"])))
    assert np.abs(np.gradient(yaw_deg, column["t_s"]) - column["yaw_rate_ned_dps"])[inner].max() < 3.0
    states = kiosk.trajectory(column["t_s"])
    assert np.abs(wrap_rad(np.radians(90.0 - column["yaw_ned_deg"]) - states.yaw_enu_rad)).max() < 1e-5
    assert {row["leg"] for row in rows} == {leg.name for leg in kiosk.trajectory.legs}


def test_the_kml_lies_on_the_trajectory_above_the_sea(planned):
    kiosk = planned("kiosk")
    document = ElementTree.fromstring(
        trajectory_kml(kiosk.trajectory, kiosk.site.heights.frame, "a < b & c").encode()
    )
    assert document.findtext("k:Document/k:name", namespaces=KML) == "a < b & c"
    curve = kiosk.trajectory.sampled(0.05).position_enu_m
    lines = document.findall(".//k:LineString", KML)
    assert len(lines) == len(kiosk.trajectory.legs)
    for line in lines:
        assert line.findtext("k:altitudeMode", namespaces=KML) == "absolute"
        text = line.findtext("k:coordinates", namespaces=KML)
        lon, lat, alt = np.array([corner.split(",") for corner in text.split()], dtype=float).T
        for place in kiosk.site.heights.frame.to_enu(lat, lon, alt):
            assert np.sqrt(((curve - place) ** 2).sum(axis=1)).min() < 0.15
