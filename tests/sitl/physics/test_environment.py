import math

import numpy as np
import pytest
from scipy.signal import welch

from sitl.physics.environment import AIR, blow, shear

FRAME_S = 0.01
FRAMES, PIECE = 300_000, 30_000
FOOT_M = 0.3048


def wind_of(mean, height_m, frames=100, turbulent=0):
    air = np.zeros(1, AIR).view(np.recarray)
    air["mean_wind_ned_mps"], air["turbulent"] = mean, turbulent
    normals = np.random.default_rng(5).standard_normal((frames, 3))
    out, still = np.zeros((frames, 3)), np.zeros(3)
    for row, drive in zip(out, normals, strict=True):
        blow(air[0], height_m, still, drive, FRAME_S, row)
    return out


def gusts(mean, height_m, frames):
    return wind_of(mean, height_m, frames, 1) - wind_of(mean, height_m, 1)


def standard(height_m, wind_20ft_mps):
    """MIL-F-8785C, 3.7.3.4.2: σ and L of u and v, and of w; height in feet."""
    h = height_m / FOOT_M
    sigma_w, across = 0.1 * wind_20ft_mps, 0.177 + 0.000823 * h
    return (sigma_w / across**0.4, h / across**1.2 * FOOT_M), (sigma_w, height_m)


@pytest.fixture(scope="module", params=[(8.0, 15.0), (12.0, 40.0)], ids=["8 m/s at 15 m", "12 m/s at 40 m"])
def blown(request):
    wind_mps, height_m = request.param
    return wind_mps, height_m, gusts((0.0, wind_mps, 0.0), height_m, FRAMES)


def test_gusts_have_the_standards_strength(blown):
    wind_mps, height_m, gust = blown
    (sigma_u, length_u), (sigma_w, length_w) = standard(height_m, wind_mps)
    across, along, down = gust.std(axis=0)  # the wind blows east
    # A variance over time T of a process with time constant τ scatters by about √(2τ/T).
    airspeed = wind_mps * shear(height_m)
    rough_u, rough_w = (
        2.0 * math.sqrt(2.0 * length / airspeed / (FRAMES * FRAME_S)) for length in (length_u, length_w)
    )
    assert along == pytest.approx(sigma_u, rel=rough_u)
    assert across == pytest.approx(sigma_u, rel=rough_u)
    assert down == pytest.approx(sigma_w, rel=rough_w)


@pytest.mark.parametrize("axis", ["u", "v", "w"])
def test_the_spectrum_is_drydens(blown, axis):
    """Welch's estimate against Φ(Ω) of MIL-F-8785C with Ω = ω/V, one-sided in Hz, averaged in thirds of octaves."""
    wind_mps, height_m, gust = blown
    (sigma, length), vertical = standard(height_m, wind_mps)
    if axis == "w":
        sigma, length = vertical
    signal = gust[:, {"u": 1, "v": 0, "w": 2}[axis]]
    hz, power = welch(signal, 1.0 / FRAME_S, nperseg=PIECE)
    airspeed = wind_mps * shear(height_m)
    x2 = (2.0 * np.pi * hz * length / airspeed) ** 2
    shape = 2.0 / (1.0 + x2) if axis == "u" else (1.0 + 3.0 * x2) / (1.0 + x2) ** 2
    expected = 2.0 * sigma**2 * length / airspeed * shape
    corner = airspeed / length / (2.0 * np.pi)
    for centre in corner * np.array([1.0, 2.0, 4.0, 8.0, 16.0]):
        band = (hz > centre * 2.0 ** (-0.5)) & (hz < centre * 2.0**0.5)
        pieces = 2.0 * FRAMES / PIECE * band.sum() * 0.5  # independent ones, for a window that halves them
        assert power[band].mean() == pytest.approx(expected[band].mean(), rel=4.0 / math.sqrt(pieces))


@pytest.mark.parametrize(("height_m", "share"), [(20 * FOOT_M, 1.0), (60.0, 1.4672), (180.0, 1.6918)])
def test_the_mean_wind_grows_with_the_logarithm_of_the_height(height_m, share):
    assert wind_of((3.0, -4.0, 0.0), height_m, 1)[0] == pytest.approx(
        (3.0 * share, -4.0 * share, 0.0), rel=1e-3
    )


def test_near_the_ground_the_wind_is_that_at_three_feet():
    assert shear(0.0) == shear(0.9) < shear(1.0) < shear(400.0 * FOOT_M)


def test_no_gusts_unless_asked_for_and_none_in_a_calm():
    steady = wind_of((3.0, 1.0, 0.0), 30.0)
    assert (steady == steady[0]).all()
    assert not gusts((0.0, 0.0, 0.0), 30.0, 100).any()
