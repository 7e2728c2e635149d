import csv
import io

import numpy as np
import pytest

from mavspiral.export.tables import photos_csv
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.survey.shots import Shots


def test_the_list_of_photos_brings_back_the_poses():
    frame = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))
    place = np.array([[3.0, -4.0, 5.0], [-30.0, 12.0, 40.0]])
    shots = Shots([1.5, 2.25], place, np.radians([90.0, 180.0]), np.radians([0.0, -30.0]))
    rows = list(csv.DictReader(io.StringIO(photos_csv(shots, frame, "DSC00009.JPG"))))
    assert [row["name"] for row in rows] == ["DSC00009.JPG", "DSC00010.JPG"]
    assert [row["seq"] for row in rows] == ["0", "1"]
    assert [float(row["t_s"]) for row in rows] == [1.5, 2.25]
    assert [float(row["yaw_ned_deg"]) for row in rows] == pytest.approx([0.0, -90.0])
    assert [float(row["pitch_deg"]) for row in rows] == [0.0, -30.0]
    back = frame.to_enu(*(np.array([float(row[k]) for row in rows]) for k in ("lat", "lon", "alt_amsl_m")))
    assert np.allclose(back, place, atol=2e-3)
