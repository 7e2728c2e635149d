import math

import numpy as np
import pymap3d
import pytest

from sitl.geo import dipole_field, geodetic_of_ned, ned_of_geodetic

PLACES = [(19.4332, -99.1412, 2240.0), (-33.9, 151.2, 10.0), (64.1, -21.9, 50.0), (0.0, 0.0, 0.0)]


@pytest.mark.parametrize("origin", PLACES)
@pytest.mark.parametrize("ned", [(10.0, -20.0, -30.0), (900.0, 1200.0, 50.0), (-5000.0, 3000.0, -120.0)])
def test_both_ways_agree_with_pymap3d(origin, ned):
    place = geodetic_of_ned(origin, ned)
    theirs = pymap3d.ned2geodetic(*ned, *origin)
    np.testing.assert_allclose(place[:2], theirs[:2], atol=1e-11)
    np.testing.assert_allclose(place[2], theirs[2], atol=1e-6)
    np.testing.assert_allclose(ned_of_geodetic(origin, place), ned, atol=1e-6)


def test_the_dipole_points_north_and_dips_as_it_should():
    north, _, down = dipole_field(0.0, 0.0)
    assert north > 0.2 and abs(down) < 0.15
    assert dipole_field(70.0, 0.0)[2] > 0.4 and dipole_field(-70.0, 0.0)[2] < -0.4
    # IGRF at Mexico City: 0.40 G, declination 5° east, dip 47°; a dipole comes within a fifth.
    field = np.array(dipole_field(19.43, -99.13))
    assert np.linalg.norm(field) == pytest.approx(0.40, rel=0.2)
    assert abs(math.degrees(math.atan2(field[1], field[0])) - 5.0) < 8.0
