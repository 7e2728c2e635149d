"""Vehicles in lockstep with scripted clients, as fixtures."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import pytest
from copter_client import Client as Copter
from copter_client import new_simulator
from px4_client import messages, new_px4


@pytest.fixture
def new_client():
    return new_px4


@pytest.fixture(scope="module")
def px4_client():
    """A PX4's client for tests that restore what they have changed."""
    return new_px4()


@pytest.fixture
def client(new_client):
    return new_client()


@pytest.fixture(scope="session")
def pick():
    return messages


@pytest.fixture
def copter():
    """A client of an ArduCopter that has just been switched on."""
    return Copter(new_simulator())


@pytest.fixture(scope="session")
def _hovering():
    """An ArduCopter that hovers 10 m above home in GUIDED, and its state."""
    client = Copter(new_simulator())
    client.airborne()
    return client.simulator, client.simulator.snapshot()


@pytest.fixture
def aloft(_hovering):
    """A client of an ArduCopter that hovers 10 m above home in GUIDED."""
    simulator, state = _hovering
    simulator.restore(state)
    simulator.take_events()
    return Copter(simulator)
