"""The simulator as a value: same bytes in, same bytes out; snapshots; whatever bytes come, it goes on."""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sitl.airframe import load_airframe
from sitl.faults import LinkLoss, parse_fault
from sitl.link.codec import Codec
from sitl.link.messages import layout, message_type
from sitl.link.streams import OFFBOARD_RATES_HZ
from sitl.orders import Mode
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

COMMAND = message_type("COMMAND_LONG")
SETPOINT = message_type("SET_POSITION_TARGET_LOCAL_NED")


def new_simulator(seed=0, *faults):
    airframe = load_airframe("x500")
    home = GeoPoint(19.435235, -99.146145, 2240.0)
    return Simulator(
        SimulatorConfig(
            VehicleConfig(
                airframe=airframe,
                params=Params(airframe.params),
                home=home,
                seed=seed,
                faults=tuple(map(parse_fault, faults)),
            )
        )
    )


def command(codec, number, *params):
    values = [*params, *[math.nan] * (7 - len(params))]
    return codec.encode(COMMAND(*map(float, values), number, 1, 1, 0))


def script(seconds):
    """(time_us, bytes) of a client that arms, takes off and streams setpoints at 50 Hz."""
    codec = Codec(255, 190)
    for at_us in range(20_000, round(seconds * 1e6) + 1, 20_000):
        data = b""
        if at_us == 5_000_000:
            data += command(codec, 400, 1, 0) + command(codec, 22)
        if at_us == 15_000_000:
            data += command(codec, 176, 1, 6)
        if at_us > 14_000_000:
            s = 1e-6 * (at_us - 14_000_000)
            data += codec.encode(SETPOINT(0, s, 0.0, -3.0, 1.0, *[0.0] * 7, 0, 1, 1, 1))
        yield at_us, data


def fly(simulator, steps):
    return [simulator.step(at_us, data).send for at_us, data in steps]


def test_the_same_seed_gives_the_same_bytes_and_another_one_others():
    first, second, third = new_simulator(3), new_simulator(3), new_simulator(4)
    steps = list(script(20.0))
    sent = fly(first, steps)
    assert sent == fly(second, steps)
    assert first.truth.position_ned_m.tobytes() == second.truth.position_ned_m.tobytes()
    assert sent != fly(third, steps)
    assert first.report.flight.mode is Mode.OFFBOARD


def test_a_restored_simulator_sends_the_same_bytes_as_the_one_that_went_on():
    simulator = new_simulator()
    steps = list(script(19.0))
    fly(simulator, steps[:800])
    state = simulator.snapshot()
    sent = fly(simulator, steps[800:])
    truth = simulator.truth.position_ned_m.tobytes()
    simulator.restore(state)
    assert fly(simulator, steps[800:]) == sent
    assert simulator.truth.position_ned_m.tobytes() == truth
    other = new_simulator()
    other.restore(state)
    assert fly(other, steps[800:]) == sent


def test_steps_of_any_length_give_the_same_flight():
    fine, coarse = new_simulator(), new_simulator()
    sent = b"".join(fine.step(at_us, b"").send for at_us in range(10_000, 3_000_001, 10_000))
    assert b"".join(coarse.step(at_us, b"").send for at_us in (7_000, 1_234_567, 3_000_000)) == sent
    assert fine.time_us == coarse.time_us == 3_000_000


def test_two_frames_at_once_are_the_same_flight_as_one_by_one_whatever_befalls_it():
    """In OFFBOARD the commander looks only when it must: not a frame later than one that looks in each."""
    by_frame, at_once = (new_simulator(0, "gps_loss@17.01+9") for _ in range(2))
    codec, names = Codec(255, 190), [name for name in OFFBOARD_RATES_HZ if name != "HEARTBEAT"]
    quiet = b"".join(command(codec, 511, message_type(name).ID, -1) for name in names)
    assert by_frame.step(10_000, quiet).send == at_once.step(10_000, quiet).send
    silence = ((at_us, b"") for at_us in range(29_020_000, 32_000_001, 20_000))
    events = []
    for at_us, data in (*script(29.0), *silence):
        sent = by_frame.step(at_us, b"").send + by_frame.step(at_us + 10_000, data).send
        step = at_once.step(at_us + 10_000, data)
        assert step.send == sent
        events += step.events
    assert by_frame.truth.numbers.tobytes() == at_once.truth.numbers.tobytes()
    modes = [event.text for event in events if event.kind == "mode"]
    assert modes == ["TAKEOFF", "HOLD", "OFFBOARD", "LAND", "OFFBOARD", "RETURN"]


def test_a_step_says_when_the_next_frame_is_due_and_what_happened():
    simulator = new_simulator()
    events = []
    for at_us, data in script(12.0):
        step = simulator.step(at_us, data)
        events += step.events
        assert step.next_due_us == at_us + 10_000
    assert [(event.kind, event.text) for event in events if event.kind != "notice"] == [
        ("armed", "HOLD"),
        ("mode", "TAKEOFF"),
        ("mode", "HOLD"),
    ]


def test_a_parameter_that_is_set_changes_the_flight():
    simulator = new_simulator()
    name = message_type("PARAM_SET")(2.0, 1, 1, b"MPC_XY_P", 9)
    simulator.step(20_000, Codec(255, 190).encode(name))
    assert simulator._craft.vehicle.params["MPC_XY_P"] == 2.0


def test_a_link_that_is_lost_leads_home_and_back_into_offboard_when_it_returns():
    simulator = new_simulator(0, "link_loss@18s+3s")
    steps = list(script(25.0))
    begin, end = 18 * 50 - 1, 21 * 50 - 1  # the step at 18.00 s, and that at 21.00 s
    silent = [not sent for sent in fly(simulator, steps[:end])]
    assert silent[begin:] == [True] * (3 * 50)
    assert not any(silent[50:begin])
    assert simulator.report.flight.mode is Mode.RETURN and simulator.report.flight.failsafe
    fly(simulator, steps[end:])
    assert simulator.report.flight.mode is Mode.OFFBOARD


def test_a_bad_link_is_equally_bad_for_the_same_seed_also_from_a_snapshot():
    faults = ("packet_loss=30%", "delay=200ms")
    first, second, third = new_simulator(3, *faults), new_simulator(3, *faults), new_simulator(4, *faults)
    steps = list(script(12.0))
    sent = fly(first, steps)
    assert sent == fly(second, steps)
    assert sent != fly(third, steps)
    sound = fly(new_simulator(3), steps)
    assert 0.5 < len(b"".join(sent)) / len(b"".join(sound)) < 0.9
    one = new_simulator(3, *faults)
    fly(one, steps[:300])
    other = new_simulator(9)
    other.restore(one.snapshot())
    assert fly(other, steps[300:]) == fly(one, steps[300:])


def test_a_fault_may_be_ordered_in_flight_and_taken_back():
    simulator = new_simulator()
    simulator.inject(parse_fault("link_loss@0s"))
    assert simulator.step(2_000_000, b"").send == b""
    simulator.heal(LinkLoss)
    assert simulator.step(4_000_000, b"").send


def test_without_fixes_it_comes_down_by_itself_and_says_so():
    simulator = new_simulator(0, "gps_loss@18s")
    events = []
    for at_us, data in script(40.0):
        events += simulator.step(at_us, data).events
    told = [event for event in events if "Descend" in event.text]
    assert [event.text for event in told] == [
        "Failsafe activated: Autopilot disengaged, switching to Descend"
    ]
    assert 23.0 < told[0].time_us * 1e-6 < 23.5  # 5 s of dead reckoning
    assert "disarmed" in [event.kind for event in events]
    assert abs(simulator.truth.position_ned_m[2]) < 0.05


@pytest.fixture(scope="module")
def flying():
    simulator = new_simulator()
    fly(simulator, script(17.0))
    return simulator, simulator.snapshot()


absurd = st.one_of(
    st.floats(width=32), st.sampled_from([math.nan, math.inf, -math.inf, 3e38, -1e30, 21196.0])
)
hostile = st.lists(
    st.one_of(
        st.binary(max_size=300),
        st.builds(
            lambda number, params, target: Codec(255, 190).encode(COMMAND(*params, number, target, 1, 0)),
            st.sampled_from([11, 16, 17, 20, 21, 22, 176, 192, 400, 510, 511, 512, 520, 31999]),
            st.lists(absurd, min_size=7, max_size=7),
            st.sampled_from([0, 1, 255]),
        ),
        st.builds(
            lambda values, mask, frame: Codec(255, 190).encode(SETPOINT(0, *values, mask, 1, 1, frame)),
            st.lists(absurd, min_size=11, max_size=11),
            st.integers(0, 4095),
            st.sampled_from([1, 7, 8, 9]),
        ),
        st.builds(
            lambda value, name, kind: Codec(255, 190).encode(
                message_type("PARAM_SET")(value, 1, 1, name, kind)
            ),
            absurd,
            st.sampled_from(
                [b"COM_OF_LOSS_T", b"MIS_TAKEOFF_ALT", b"NAV_RCL_ACT", b"RTL_CONE_ANG", b"\xff\xfe"]
            ),
            st.sampled_from([6, 9]),
        ),
        st.builds(
            lambda number, filler: any_message(number, filler),
            st.sampled_from([0, 4, 11, 20, 21, 23, 43, 44, 45, 75, 76, 84, 110, 111]),
            st.binary(min_size=255, max_size=255),
        ),
    ),
    max_size=12,
)


def any_message(number, filler):
    kind = layout(number)
    return Codec(255, 190).encode(kind.unpack(filler))


@given(hostile)
@settings(
    max_examples=60,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_whatever_comes_the_flight_goes_on_and_telemetry_is_sent(flying, chunks):
    simulator, state = flying
    simulator.restore(state)
    now_us = simulator.time_us
    heard = Codec(255, 190)
    for chunk in chunks:
        now_us += 10_000
        heard.decode(simulator.step(now_us, chunk).send)
    sent = simulator.step(now_us + 1_500_000, b"").send
    names = {type(item.message).__name__ for item in heard.decode(sent)}
    assert "HEARTBEAT" in names
    assert heard.rejected == 0
    assert simulator.time_us == now_us + 1_500_000
