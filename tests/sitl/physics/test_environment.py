import numpy as np
import pytest

from sitl.physics.environment import AIR, blow


def gusts(wind, height_m, frames=200_000, turbulent=1):
    air = np.zeros(1, AIR).view(np.recarray)
    air["mean_wind_ned_mps"], air["turbulent"] = wind, turbulent
    normals = np.random.default_rng(5).standard_normal((frames, 3))
    out, still = np.zeros((frames, 3)), np.zeros(3)
    for row, drive in zip(out, normals, strict=True):
        blow(air[0], height_m, still, drive, 0.01, row)
    return out - wind


@pytest.fixture(scope="module")
def blown():
    return gusts((0.0, 8.0, 0.0), 30.0, 400_000)


def test_gusts_have_the_standards_strength(blown):
    feet = 30.0 / 0.3048
    sigma_w = 0.1 * 8.0
    sigma_u = sigma_w / (0.177 + 0.000823 * feet) ** 0.4
    across, along, down = blown.std(axis=0)  # the wind blows east
    assert along == pytest.approx(sigma_u, rel=0.15)
    assert across == pytest.approx(sigma_u, rel=0.15)
    assert down == pytest.approx(sigma_w, rel=0.1)
    assert np.abs(blown.mean(axis=0)).max() < 0.35


def test_the_spectrum_along_the_wind_is_drydens(blown):
    """Φ(ω) ∝ 1 / (1 + (L ω / V)²): its density halves at ω = V / L."""
    feet = 30.0 / 0.3048
    corner_hz = 8.0 / (30.0 / (0.177 + 0.000823 * feet) ** 1.2) / (2.0 * np.pi)
    pieces = blown[:, 1].reshape(-1, 40_000) * np.hanning(40_000)
    power = (np.abs(np.fft.rfft(pieces, axis=1)) ** 2).mean(axis=0)
    hz = np.fft.rfftfreq(40_000, 0.01)

    def band(centre):
        return power[(hz > 0.7 * centre) & (hz < 1.4 * centre)].mean()

    for ratio in (4.0, 16.0):
        expected = 2.0 / (1.0 + ratio**2)
        assert band(ratio * corner_hz) / band(corner_hz) == pytest.approx(expected, rel=0.6)


def test_no_gusts_unless_asked_for_and_none_in_a_calm():
    assert not gusts((3.0, 1.0, 0.0), 30.0, 100, turbulent=0).any()
    assert not gusts((0.0, 0.0, 0.0), 30.0, 100).any()
