"""Scripts written for MAVSDK before version 4 (`from mavsdk import System`, over gRPC) fly the vehicle too.

The old package and the new one share the name `mavsdk`, so the script wants an interpreter of its own:
`python -m venv old && old/bin/pip install 'mavsdk<4'`, then MAVSPIRAL_OLD_MAVSDK_PYTHON=old/bin/python pytest.
"""

import os
import subprocess
from pathlib import Path

import pytest

PYTHON = os.environ.get("MAVSPIRAL_OLD_MAVSDK_PYTHON")


@pytest.mark.skipif(
    not PYTHON,
    reason="MAVSPIRAL_OLD_MAVSDK_PYTHON names no interpreter that has 'mavsdk<4', which collides with ours",
)
def test_a_script_from_before_mavsdk_4_flies_and_lands(start_vehicle):
    vehicle = start_vehicle("--speedup", "5")
    script = Path(__file__).with_name("old_system_api.py")
    flown = subprocess.run(
        [PYTHON, script, str(vehicle.offboard_port)], capture_output=True, text=True, timeout=400
    )
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert flown.stdout.split("\n")[:-1] == [
        "connected",
        "healthy",
        "taken off",
        "there",
        "offboard",
        "landed",
    ]
    vehicle.says("mode: LAND")
    kinds = [line.split("] ")[-1] for line in vehicle.lines]
    assert kinds.index("mode: TAKEOFF") < kinds.index("mode: OFFBOARD") < kinds.index("mode: LAND")
