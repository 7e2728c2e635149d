"""The files of parameters: as complete as the real vehicles' lists, and exact on the wire."""

import struct

import pytest

from sitl.copter_params import copter_defaults
from sitl.copter_types import as_kept, copter_bits
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


def test_every_whole_number_of_an_arducopter_is_one_and_fits():
    defaults, bits = copter_defaults(), copter_bits()
    assert not any(name.startswith("SIM_") for name in bits)
    for name, width in bits.items():
        assert defaults[name] == int(defaults[name]) and abs(defaults[name]) < 2 ** (width - 1), name
    # As its sources declare them.
    assert (bits["WP_YAW_BEHAVIOR"], bits["SYSID_MYGCS"], bits["RTL_ALT"]) == (8, 16, 32)
    assert (bits["SERVO14_FUNCTION"], bits["RC3_DZ"], bits["EK3_SRC1_YAW"], bits["FLTMODE6"]) == (
        16,
        16,
        8,
        8,
    )
    assert not {"WPNAV_SPEED", "GUID_TIMEOUT", "FS_GCS_TIMEOUT", "FENCE_RADIUS", "PSC_POSXY_P"} & set(bits)


@pytest.mark.parametrize(
    ("name", "told", "kept"),
    [
        ("RTL_ALT", 2500.7, 2500.0),
        ("RTL_ALT", 2499.995, 2500.0),
        ("GPS_MIN_ELEV", -99.995, -100.0),
        ("WP_YAW_BEHAVIOR", 300.0, 127.0),
        ("ANGLE_MAX", -1e9, -32768.0),
        ("WPNAV_SPEED", 712.3, 712.3),
    ],
)
def test_a_fraction_of_a_whole_number_is_cut_off(name, told, kept):
    assert as_kept(name, told) == kept
