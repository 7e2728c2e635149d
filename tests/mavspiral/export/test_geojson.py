import json

import numpy as np
import pytest

from mavspiral.export.geojson import flight_geojson
from mavspiral.frames import wrap_rad, yaw_enu_to_ned


def test_the_map_brings_back_the_flight_and_its_pictures(planned):
    kiosk = planned("kiosk")
    frame = kiosk.site.heights.frame
    text = json.dumps(flight_geojson(kiosk.trajectory, kiosk.shots, frame, "kiosk"), allow_nan=False)
    features = json.loads(text)["features"]
    lines = [f for f in features if f["geometry"]["type"] == "LineString"]
    points = [f for f in features if f["geometry"]["type"] == "Point"]
    assert [f["properties"]["leg"] for f in lines] == [leg.name for leg in kiosk.trajectory.legs]
    assert len(points) == len(kiosk.shots)
    for line in lines:
        lon, lat, alt = np.array(line["geometry"]["coordinates"]).T
        place = frame.to_enu(lat, lon, alt)
        about = line["properties"]
        t_s = np.linspace(about["begin_s"], about["begin_s"] + about["duration_s"], len(place))
        assert np.abs(place - kiosk.trajectory(t_s).position_enu_m).max() < 0.05
    for point, yaw_enu_rad in zip(points, kiosk.shots.yaw_enu_rad, strict=True):
        error = np.radians(point["properties"]["yaw_ned_deg"]) - yaw_enu_to_ned(yaw_enu_rad)
        assert wrap_rad(error) == pytest.approx(0.0, abs=2e-4)
