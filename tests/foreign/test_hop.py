import pytest
from hop import hop


@pytest.mark.sitl(seed=4, wind_mps=3.0, speedup=8.0)
def test_it_hops_in_a_breeze(sitl_vehicle):
    assert hop(sitl_vehicle.mavutil_url, 4.0) >= 3.5
