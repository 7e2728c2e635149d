"""What several tests share: the missions' plans, made once, and the flag that renews golden files.

No example that hypothesis draws has a time limit: on a busy machine any of them may be kept waiting. And whoever starts us in
the background has Ctrl-C ignored by us and by all that we start; several tests send it.
"""

from __future__ import annotations

import signal
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

ROOT = Path(__file__).parents[1]

settings.register_profile("busy", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("busy")
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# A project of somebody else's: test_pytest_plugin runs it in an environment of its own.
collect_ignore = ["foreign"]


def pytest_addoption(parser):
    parser.addoption("--renew-golden", action="store_true", help="write tests/golden anew; read the diff")


@pytest.fixture
def renew_golden(request):
    return request.config.getoption("--renew-golden")


@pytest.fixture(scope="session")
def planned():
    """The plan of a mission of the gallery, by name."""
    from mavspiral import load_mission, plan

    return cache(lambda name: plan(load_mission(ROOT / "missions" / f"{name}.toml")))
