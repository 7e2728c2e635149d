"""MAVSDK 4 on an ArduCopter: parameters by their types."""

import pytest

pytest.importorskip("mavsdk")

from copter_process import copter
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.param import Param, ParamError
from mavsdk_session import insisted
from patience import LIMIT_S


@pytest.fixture(scope="module")
def param():
    with copter() as (port, _):
        sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
        sdk.add_any_connection(f"tcpout://127.0.0.1:{port}")
        yield Param(sdk.first_autopilot(LIMIT_S))
        sdk.destroy()


@pytest.mark.parametrize("name", ["WP_YAW_BEHAVIOR", "SYSID_MYGCS", "RTL_ALT"])
def test_whole_numbers_are_integers(param, name):
    insisted(param.set_param_int, name, 120)
    assert insisted(param.get_param_int, name) == 120
    with pytest.raises(ParamError) as refusal:
        insisted(param.get_param_float, name)
    assert refusal.value.result.name == "WRONG_TYPE"


def test_the_others_are_floats_and_all_are_there(param):
    insisted(param.set_param_float, "WPNAV_SPEED", 612.5)
    assert insisted(param.get_param_float, "WPNAV_SPEED") == 612.5
    every = insisted(param.get_all_params)
    assert len(every.int_params) + len(every.float_params) == 1392
    assert {"WP_YAW_BEHAVIOR", "SERVO1_FUNCTION"} <= {one.name for one in every.int_params}
