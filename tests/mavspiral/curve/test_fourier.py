import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mavspiral.curve.fourier import FourierCurve, harmonics_needed, in_phase, points_of, spectra_of

U = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)


def blob(seed=0, waves=9):
    rng = np.random.default_rng(seed)
    c = (rng.normal(size=(waves + 1, 2)) + 1j * rng.normal(size=(waves + 1, 2))) / (
        1.0 + np.arange(waves + 1)
    )[:, None]
    return c - 1j * np.imag(c[:1]) * (np.arange(waves + 1) == 0)[:, None]


def test_the_series_is_the_papers():
    c = blob(1, 3)
    u = np.linspace(-3.0, 9.0, 50)
    s = c[0].real + sum(
        np.outer(np.cos(k * u), c[k].real) - np.outer(np.sin(k * u), c[k].imag) for k in (1, 2, 3)
    )
    np.testing.assert_allclose(FourierCurve(c)(u), s, atol=1e-12)


def test_there_and_back_again():
    c = blob()
    points = FourierCurve(c)(U)
    np.testing.assert_allclose(spectra_of(points)[: len(c)], c, atol=1e-12)
    np.testing.assert_allclose(spectra_of(points)[len(c) :], 0.0, atol=1e-12)
    np.testing.assert_allclose(points_of(spectra_of(points), 256), points, atol=1e-12)
    np.testing.assert_allclose(FourierCurve.through(points, 9)(U), points, atol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_are_derivatives(order):
    curve = FourierCurve(blob())
    h = 1e-5
    slope = (curve(U + h, order - 1) - curve(U - h, order - 1)) / (2.0 * h)
    np.testing.assert_allclose(slope, curve(U, order), atol=1e-6 * np.abs(curve(U, order)).max())


coordinates = st.floats(-500.0, 500.0, width=32)


@given(arrays(np.float64, (32, 2), elements=coordinates))
def test_parseval(points):
    """Half of Σ|c_k|², and the whole of the mean's, is the mean square of any points without a half wave."""
    spectra = spectra_of(points)
    half_wave = (points * np.cos(np.pi * np.arange(32))[:, None]).mean(axis=0)
    without = points - np.outer(np.cos(np.pi * np.arange(32)), half_wave)
    energy = np.abs(spectra[0]) ** 2 + 0.5 * (np.abs(spectra[1:]) ** 2).sum(axis=0)
    np.testing.assert_allclose(energy, (without**2).mean(axis=0), rtol=1e-9, atol=1e-6)


@given(st.integers(0, 10_000), st.floats(0.0, 2.0 * np.pi), st.sampled_from([1, 2, 3]))
def test_derivatives_equal_finite_differences_anywhere(seed, u, order):
    curve, h = FourierCurve(blob(seed)), 1e-5
    slope = (curve(u + h, order - 1) - curve(u - h, order - 1)) / (2.0 * h)
    np.testing.assert_allclose(slope, curve(u, order), atol=1e-6 * np.abs(curve(U, order)).max())


def test_the_harmonics_are_the_fewest_that_keep_the_tolerance():
    spectra = np.stack([np.pad(blob(seed), ((0, 119), (0, 0))) for seed in range(3)])
    needed = harmonics_needed(spectra, tolerance_m=0.3, count=256)

    def worst(harmonics):
        gap = [FourierCurve(s)(U) - FourierCurve(s[: harmonics + 1])(U) for s in spectra]
        return np.linalg.norm(gap, axis=-1).max()

    assert worst(needed) <= 0.3 < worst(needed - 1)


@pytest.mark.parametrize("delay", [0.0, 0.013, 1.7, 4.0, 6.2])
def test_a_curve_started_elsewhere_is_brought_in_phase(delay):
    reference = blob(4)
    late = reference * np.exp(1j * delay * np.arange(len(reference)))[:, None]
    np.testing.assert_allclose(in_phase(late, reference), reference, atol=0.02)


def test_coefficients_that_are_none_are_refused():
    with pytest.raises(ValueError, match="coefficients_m"):
        FourierCurve(np.zeros((3, 3)))
    with pytest.raises(ValueError, match="finite"):
        FourierCurve(np.full((3, 2), np.nan))
