"""Whatever comes in, ArduCopter's dialect raises nothing and goes on telling."""

import math

import pytest
from copter_client import Client
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sitl.link.codec import Codec
from sitl.link.messages import layout, message_type

ABSURD = (math.nan, math.inf, -math.inf, 3e38, -1e30, -1.0, 0.0, 1e-30)
absurd = st.one_of(st.floats(width=32), st.sampled_from(ABSURD))
COMMANDS = [16, 17, 20, 21, 22, 112, 115, 176, 178, 179, 192, 195, 206, 300, 400, 401, 410, 511, 512, 31999]
PARAMETERS = [
    *(b"PSC_JERK_XY", b"PSC_JERK_Z", b"WPNAV_ACCEL", b"WPNAV_SPEED", b"ATC_INPUT_TC", b"PSC_VELXY_FLTD"),
    *(b"GUID_TIMEOUT", b"FS_GCS_ENABLE", b"RTL_CONE_SLOPE", b"WP_YAW_BEHAVIOR", b"ANGLE_MAX", b"SYSID_MYGCS"),
    *(b"ATC_ACCEL_Y_MAX", b"ATC_SLEW_YAW", b"SYSID_THISMAV", b"WPNAV_JERK", b"\xff\xfe"),
    *(b"ATC_RAT_YAW_P", b"ATC_RAT_YAW_I", b"ATC_RAT_YAW_FLTE", b"ATC_RAT_YAW_IMAX"),
]


def any_message(number, filler):
    return Codec(255, 190).encode(layout(number).unpack(filler))


def encoded(name, *values):
    return Codec(255, 190).encode(message_type(name)(*values))


hostile = st.lists(
    st.one_of(
        st.binary(max_size=300),
        st.builds(
            lambda number, params: encoded("COMMAND_LONG", *params, number, 1, 1, 0),
            st.sampled_from(COMMANDS),
            st.lists(absurd, min_size=7, max_size=7),
        ),
        st.builds(
            lambda number, params, x, frame: encoded(
                "COMMAND_INT", *params[:4], x, x, params[4], number, 1, 1, frame, 0, 0
            ),
            st.sampled_from(COMMANDS),
            st.lists(absurd, min_size=5, max_size=5),
            st.integers(-(2**31), 2**31 - 1),
            st.integers(0, 11),
        ),
        st.builds(
            lambda values, mask, frame: encoded(
                "SET_POSITION_TARGET_LOCAL_NED", 0, *values, mask, 1, 1, frame
            ),
            st.lists(absurd, min_size=11, max_size=11),
            st.integers(0, 4095),
            st.sampled_from([1, 7, 8, 9]),
        ),
        st.builds(
            lambda name, value: encoded("PARAM_SET", value, 1, 1, name, 9),
            st.sampled_from(PARAMETERS),
            absurd,
        ),
        st.builds(
            any_message,
            st.sampled_from(
                [0, 4, 11, 20, 21, 23, 39, 40, 41, 43, 44, 45, 51, 66, 73, 75, 76, 84, 86, 110, 111]
            ),
            st.binary(min_size=255, max_size=255),
        ),
    ),
    max_size=12,
)


@given(hostile)
@settings(
    max_examples=100,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_whatever_comes_it_goes_on_and_says_so(_hovering, chunks):
    simulator, state = _hovering
    simulator.restore(state)
    for chunk in chunks:
        simulator.step(simulator.time_us + 10_000, chunk)
    sent = simulator.step(simulator.time_us + 2_000_000, b"").send
    assert "HEARTBEAT" in {type(item.message).__name__ for item in Codec(255, 190).decode(sent)}


@pytest.mark.parametrize("name", PARAMETERS[:-1])
@pytest.mark.parametrize("value", [0.0, -5.0, 3e38])
def test_no_parameter_stops_a_flight_that_is_guided_and_returns(aloft, name, value):
    aloft.say(mavlink.MAVLink_param_set_message(1, 1, name, value, 9))
    aloft.live(0.5, lambda: aloft.target(p=(5.0, 5.0, -12.0), v=(1.0, 0.0, 0.0), a=(0.1, 0.0, 0.0)))
    aloft.live(0.5, lambda: aloft.target(v=(1.0, 0.0, 0.0), yaw_rate=0.2))
    aloft.command(176, 1, 6)
    aloft.live(1.5)
    assert math.isfinite(float(aloft.here.sum()))


@pytest.mark.parametrize("bad", [math.inf, -math.inf])
def test_a_heading_that_is_no_number_is_ignored(aloft, bad):
    aloft.live(0.2, lambda: aloft.target(p=(5.0, 5.0, -12.0), yaw=bad))
    aloft.live(0.2, lambda: aloft.target(v=(1.0, 0.0, 0.0), yaw_rate=bad))
    aloft.say(mavlink.MAVLink_command_int_message(1, 1, 0, 192, 0, 0, -1.0, 0.0, 0.0, bad, 0, 0, 0.0))
    aloft.live(0.5)
    assert math.isfinite(float(aloft.here.sum()))


@pytest.mark.parametrize("numbers", [[16], [16, 177], [22, 177, 16], [115, 178], [20], [93, 21]])
def test_odd_missions_are_flown_or_refused_but_never_break(aloft, numbers):
    items = [(number, 3, (1.0, -1.0, 1.0, 1.0, 0.0, 0.0, 12.0)) for number in numbers]
    client = Client(aloft.simulator)
    client.upload(items)
    client.command(176, 1, 3)
    client.live(10.0)
    assert client.flight.armed
