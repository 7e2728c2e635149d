"""Vehicles to fly, each in a process of its own."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import pytest
from vehicle_process import launch, stop


@pytest.fixture
def start_vehicle():
    started = []

    def start(*options):
        vehicle = launch(*options)
        started.append(vehicle)
        return vehicle

    yield start
    for vehicle in started:
        stop(vehicle)


@pytest.fixture(scope="module")
def shared_vehicle():
    """One vehicle for all tests of a file, at eight times real time."""
    vehicle = launch("--speedup", "8")
    yield vehicle
    stop(vehicle)
