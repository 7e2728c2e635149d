"""Frames: compass points, round trips, and the vehicle's own geodesy as a second opinion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mavspiral.frames import (
    GeoPoint,
    LocalFrame,
    enu_to_ned,
    ned_to_enu,
    wrap_rad,
    yaw_enu_to_ned,
    yaw_ned_to_enu,
)
from sitl import geo

lat = st.floats(-80, 80)
lon = st.floats(-180, 180)
metres = st.floats(-800, 800)


@pytest.mark.parametrize(
    ("compass_deg", "east", "north"),
    [(0, 0, 1), (90, 1, 0), (180, 0, -1), (270, -1, 0), (45, 1, 1), (135, 1, -1)],
)
def test_compass_points(compass_deg, east, north):
    yaw_enu = float(np.arctan2(north, east))
    assert abs(wrap_rad(yaw_enu_to_ned(yaw_enu) - np.radians(compass_deg))) < 1e-12
    assert abs(wrap_rad(yaw_ned_to_enu(np.radians(compass_deg)) - yaw_enu)) < 1e-12


def test_axes_swap_and_flip():
    assert enu_to_ned([1.0, 2.0, 3.0]).tolist() == [2.0, 1.0, -3.0]
    assert ned_to_enu(enu_to_ned([4.0, 5.0, 6.0])).tolist() == [4.0, 5.0, 6.0]


@given(st.floats(-1e4, 1e4))
def test_wrapped_angles_are_in_range_and_equal(angle):
    wrapped = float(wrap_rad(angle))
    assert -np.pi <= wrapped < np.pi
    assert np.isclose(np.cos(wrapped), np.cos(angle), atol=1e-9)
    assert np.isclose(np.sin(wrapped), np.sin(angle), atol=1e-9)


@given(lat, lon, metres, metres, metres)
def test_geodetic_round_trip(lat_deg, lon_deg, e, n, u):
    frame = LocalFrame(GeoPoint(lat_deg, lon_deg, 500.0))
    back = frame.to_enu(*frame.to_geodetic([e, n, u]))
    assert np.allclose(back, [e, n, u], atol=1e-5)


@given(lat, lon, metres, metres, st.floats(-60, 60), metres, metres)
def test_the_map_to_a_vehicle_agrees_with_going_through_geodetic(lat_deg, lon_deg, e, n, u, away_e, away_n):
    plan = LocalFrame(GeoPoint(lat_deg, lon_deg, 2240.0))
    origin = plan.geo_point([away_e, away_n, -3.0])
    rigid = plan.to_vehicle(origin)
    straight = enu_to_ned(LocalFrame(origin).to_enu(*plan.to_geodetic([e, n, u])))
    assert np.allclose(rigid.position_ned_m([e, n, u]), straight, atol=1e-5)
    assert np.allclose(rigid.position_enu_m(rigid.position_ned_m([e, n, u])), [e, n, u], atol=1e-7)
    assert np.allclose(rigid.R_ned_enu @ rigid.R_ned_enu.T, np.eye(3), atol=1e-12)


@given(lat, lon, st.floats(-300, 300), st.floats(-300, 300), st.floats(-50, 200))
def test_the_vehicles_own_geodesy_agrees(lat_deg, lon_deg, n, e, d):
    place = geo.geodetic_of_ned((lat_deg, lon_deg, 100.0), (n, e, d))
    ours = enu_to_ned(LocalFrame(GeoPoint(lat_deg, lon_deg, 100.0)).to_enu(*place))
    assert np.allclose(ours, [n, e, d], atol=1e-5)
