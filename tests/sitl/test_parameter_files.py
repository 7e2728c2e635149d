"""The files of parameters: as complete as the real vehicles' lists, and exact on the wire."""

import struct

import pytest

from sitl.copter_params import copter_defaults
from sitl.link.parameters import ParameterTable
from sitl.params import Params

PX4 = ParameterTable(Params())


@pytest.mark.parametrize(
    ("table", "count"), [(copter_defaults(), 1392), (PX4, 880)], ids=["arducopter", "px4"]
)
def test_every_name_and_value_fits_on_the_wire(table, count):
    assert len(table) == count
    for name, value in table.items():
        assert 0 < len(name.encode("ascii")) <= 16
        if isinstance(value, int):
            assert struct.unpack("<i", struct.pack("<i", value)) == (value,)
        else:
            (told,) = struct.unpack("<f", struct.pack("<f", value))
            assert told == pytest.approx(value, rel=1e-6, abs=1e-30)


def test_defaults_are_those_that_were_seen():
    copter = copter_defaults()
    assert list(copter)[:3] == ["FORMAT_VERSION", "SYSID_THISMAV", "SYSID_MYGCS"]
    assert (copter["FS_EKF_THRESH"], copter["BATT_LOW_VOLT"], copter["WPNAV_SPEED"]) == (0.8, 10.5, 1000.0)
    assert (PX4["SYS_AUTOSTART"], PX4["MPC_XY_CRUISE"], PX4["BAT1_V_CHARGED"]) == (10040, 5.0, 4.05)
    assert isinstance(PX4["CAL_ACC0_ID"], int)
