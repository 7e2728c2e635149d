"""A plan, a fake vehicle, and a loop that flies one with the other on a simulated clock."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
import pytest
from fake_flight import HOME, VEHICLE_ORIGIN, make_trajectory
from fake_px4 import FakePx4


@pytest.fixture
def trajectory():
    """A flight from 20 m above a home that is neither the plan's origin nor the vehicle's."""
    return make_trajectory(np.array([12.0, -31.0, -3.0]))


@pytest.fixture
def px4():
    """A vehicle that booted 40 m away from where it stands, on ground 3 m below the plan's."""
    return FakePx4(VEHICLE_ORIGIN, HOME)
