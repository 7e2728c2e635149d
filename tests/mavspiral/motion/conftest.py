"""Trial curves: a helix over a rounded rectangle with a few harmonics, and its gaze."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from mavspiral.motion.limits import Limits


@dataclass(frozen=True)
class FourierHelix:
    """x, y = Σ a_k cos(ku) + b_k sin(ku), slowly narrowed by a set-back; z rises steadily."""

    turns: float = 3.0
    harmonics: dict = field(default_factory=lambda: {1: (22.0, 15.0), 3: (1.6, -1.1), 5: (-0.3, -0.2)})
    pitch_m: float = 2.8
    setback: float = 0.1

    @property
    def u_end_rad(self):
        return 2 * np.pi * self.turns

    def __call__(self, u_rad, order=0):
        u = np.asarray(u_rad, dtype=float)
        rings = np.zeros((order + 1, *u.shape, 2))  # derivatives 0 to order
        for k, (a, b) in self.harmonics.items():
            for n in range(order + 1):
                turned = k * u + n * np.pi / 2
                rings[n] += k**n * np.stack([a * np.cos(turned), b * np.sin(turned)], axis=-1)
        w = np.pi / self.u_end_rad  # scale: 1 - setback·sin²(wu/2)… as a cosine
        scales = [1 - self.setback / 2 * (1 - np.cos(w * u))] + [
            self.setback / 2 * w**n * np.cos(w * u + n * np.pi / 2) for n in range(1, order + 1)
        ]
        binomial = [1]
        for n in range(order):
            binomial.append(binomial[-1] * (order - n) // (n + 1))
        plan = sum(c * s[..., None] * r for c, s, r in zip(binomial, scales, rings[::-1], strict=True))
        slope = self.pitch_m / (2 * np.pi)
        height = slope * u if order == 0 else np.full_like(u, slope if order == 1 else 0.0)
        return np.concatenate([plan, height[..., None]], axis=-1)

    def jet(self, u_rad):
        return np.stack([self(u_rad, order) for order in range(4)])


@dataclass(frozen=True)
class SwayingGaze:
    """Inward on the whole, with a sway."""

    sway_rad: float = 0.15
    times: int = 3

    def __call__(self, u_rad, order=0):
        u = np.asarray(u_rad, dtype=float)
        steady = u + np.pi if order == 0 else np.full_like(u, 1.0 if order == 1 else 0.0)
        return steady + self.sway_rad * self.times**order * np.sin(self.times * u + order * np.pi / 2)

    def jet(self, u_rad):
        return np.stack([self(u_rad, order) for order in range(3)])


@pytest.fixture(scope="session")
def make_helix():
    return FourierHelix


@pytest.fixture(scope="session")
def make_gaze():
    return SwayingGaze


@pytest.fixture(scope="session")
def limits():
    return Limits(5.0, 2.0, 1.5, 2.0, 4.0, np.radians(45), np.radians(60))
