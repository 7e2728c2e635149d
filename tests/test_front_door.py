"""The front door: what a user imports, and what that costs."""

from __future__ import annotations

import subprocess
import sys

import mavspiral


def test_every_exported_name_is_there():
    for name in mavspiral.__all__:
        assert getattr(mavspiral, name) is not None


def test_importing_and_help_load_nothing_heavy():
    code = (
        "import sys, mavspiral, mavspiral.cli\n"
        "heavy = {'numba', 'scipy', 'cv2', 'matplotlib', 'mavsdk', 'pymavlink', 'filterpy', 'numpy', 'pydantic'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def test_an_unknown_name_is_an_attribute_error():
    try:
        mavspiral.no_such_thing  # noqa: B018
    except AttributeError as error:
        assert "no_such_thing" in str(error)
    else:
        raise AssertionError
