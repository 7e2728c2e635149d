"""Table I of the paper, worked out again beside the paper's figures: `python tests/bench/paper_table.py`.

Mean squared error, over both axes, between 100 points of a target ring and their approximation. The paper does not
give its shapes' coordinates: the square's side follows from its first row (side²/6 = 105), and the trapezoid and the
bat here are our own, scaled so that the first row agrees. "2 terms" can be read in three ways:

    lost pair   F₀ … F_{n−2} and F₋₁, real part: one term of each harmonic but the first has lost its conjugate,
                so half of the last harmonics is lost; with 2 terms, half of the first
    first n     F₀ … F_{n−1}, real part: every harmonic has lost its conjugate, and half of each is gone
    pairs       A + Σ A_k cos + B_k sin with n − 1 harmonics, as the paper's series (eq. 9) is written
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from mavspiral.curve.fourier import FourierCurve
from mavspiral.shape.contour import Ring

Q = 100
COUNTS = (1, 2, 5, 50, 100)
SIDE_M = 25.1
PAPER_FOURIER = {
    "square": (1.05e2, 2.74e1, 5.75e-1, 3.99e-1, 8.13e-30),
    "trapezoid": (8.37e1, 2.31e1, 8.81e-1, 7.25e-1, 8.84e-30),
    "bat": (8.38e1, 2.78e1, 5.39, 2.28, 1.31e-29),
}
PAPER_POLYNOMIALS = {
    "square": (7.65e1, 2.67e1, 1.44, 1.99e-1, 1.36e-2),
    "trapezoid": (6.18e1, 2.01e1, 1.02, 1.49e-2, 1.32e-2),
    "bat": (6.17e1, 2.05e1, 7.77, 6.71e-2, 5.73e-2),
}
CORNERS = {
    "square": ((0, 0), (1, 0), (1, 1), (0, 1)),
    "trapezoid": ((0, 0), (10, 0), (7.5, 7), (2.5, 7)),
    "bat": (
        *((0, 0), (3, 2.2), (4.2, 0.8), (5, 2.6), (5.8, 0.8), (7, 2.2), (10, 0)),
        *((9, 4.6), (6.4, 4.4), (5.6, 5.6), (5, 5), (4.4, 5.6), (3.6, 4.4), (1, 4.6)),
    ),
}


def target(shape: str) -> np.ndarray:
    """The ring's 100 points at equal arc lengths, in metres; its spread is that of the paper's first row."""
    points = Ring(np.array(CORNERS[shape], dtype=float)).resampled(Q).points_enu_m
    if shape == "square":
        return points * SIDE_M
    return points * np.sqrt(PAPER_FOURIER[shape][0] / points.var(axis=0).mean())


def error(points: np.ndarray, fitted: np.ndarray) -> float:
    return float(((points - fitted) ** 2).mean())


def transform_of(points: np.ndarray, kept: list[int]) -> np.ndarray:
    """The real part of the inverse transform of the kept F_k alone."""
    spectrum = np.fft.fft(points, axis=0)
    mask = np.zeros(Q)
    mask[kept] = 1.0
    return np.real(np.fft.ifft(spectrum * mask[:, None], axis=0))


def lost_pair(points: np.ndarray, n: int) -> np.ndarray:
    return transform_of(points, [0] if n == 1 else [*range(n - 1), -1])


def first_n(points: np.ndarray, n: int) -> np.ndarray:
    return transform_of(points, list(range(n)))


def pairs(points: np.ndarray, n: int) -> np.ndarray:
    """n − 1 harmonics; with 50 and more every F_k is kept, the Nyquist wave too."""
    if n >= Q // 2:
        return transform_of(points, list(range(Q)))
    return FourierCurve.through(points, n - 1)(2 * np.pi * np.arange(Q) / Q)


def raw_polynomial(points: np.ndarray, degree: int) -> np.ndarray:
    """numpy.polyfit on the sample numbers 0 … 99: what one writes first."""
    t = np.arange(Q)
    return np.stack([np.polyval(np.polyfit(t, axis, degree), t) for axis in points.T], axis=1)


def orthogonal(points: np.ndarray, degree: int) -> np.ndarray:
    """The same least squares on an orthonormal basis, so well posed; 99 degrees pass through 100 points."""
    t = np.linspace(-1.0, 1.0, Q)
    basis, _ = np.linalg.qr(np.polynomial.chebyshev.chebvander(t, min(degree, Q - 1)))
    return basis @ (basis.T @ points)


def main() -> None:
    warnings.simplefilter("ignore")  # polyfit says that it is badly conditioned, which is the point
    print("Mean squared error, m²; in brackets the paper's Table I.\n")
    for shape in CORNERS:
        points = target(shape)
        scaled = (
            f"side {SIDE_M} m" if shape == "square" else "our own drawing, scaled to the paper's first row"
        )
        print(f"{shape} ({scaled})\n{'terms':>7}{'paper':>12}{'lost pair':>12}{'first n':>12}{'pairs':>12}")
        for n, paper in zip(COUNTS, PAPER_FOURIER[shape], strict=True):
            ours = "".join(f"{error(points, fit(points, n)):12.3g}" for fit in (lost_pair, first_n, pairs))
            print(f"{n:7}{f'[{paper:.3g}]':>12}{ours}")
        print(f"{'degree':>7}{'paper':>12}{'polyfit':>12}{'orthogonal':>12}")
        for n, paper in zip(COUNTS, PAPER_POLYNOMIALS[shape], strict=True):
            ours = "".join(f"{error(points, fit(points, n)):12.3g}" for fit in (raw_polynomial, orthogonal))
            print(f"{n:7}{f'[{paper:.3g}]':>12}{ours}")
        print()


if __name__ == "__main__":
    main()
