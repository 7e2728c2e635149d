import pymap3d
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mavspiral.flight.messages import GlobalPosition, LocalPosition
from mavspiral.flight.origin import origin_from_pair

metres = st.floats(-500, 500)


@settings(max_examples=50, deadline=None)
@given(metres, metres, st.floats(-100, 100), st.floats(-65, 65), st.floats(-179.9, 179.9))
def test_the_pair_gives_the_origin_back(north, east, down, lat, lon):
    here = pymap3d.ned2geodetic(north, east, down, lat, lon, 30.0)
    origin = origin_from_pair(
        GlobalPosition(1000, *map(float, here)), LocalPosition(1020, north, east, down, 0, 0, 0)
    )
    assert pymap3d.geodetic2ned(*origin, lat, lon, 30.0) == pytest.approx((0, 0, 0), abs=2e-3)


def test_two_moments_are_no_pair():
    assert origin_from_pair(GlobalPosition(1000, 1, 2, 3), LocalPosition(1100, 0, 0, 0, 0, 0, 0)) is None
