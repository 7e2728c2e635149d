"""Whatever comes in, the vehicle does not raise, its state stays finite, and it keeps less than a frame of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from sitl.link.codec import Codec
from sitl.link.messages import layout

KNOWN = sorted(number for number in common.mavlink_map if number >= 0 and layout(number) is not None)
OBEYED = [number for number in KNOWN if "target_system" in common.mavlink_map[number].fieldnames]
ABSURD = (math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1e-45, -0.0, 21196.0, 65535.0, 2147483647.0)
COMMANDS = sorted({v for k, v in vars(common).items() if k.startswith("MAV_CMD_") and isinstance(v, int)})


@st.composite
def frames(draw):
    """A valid frame of any kind, its numbers absurd, more often than not meant for the vehicle."""
    number = draw(st.sampled_from(OBEYED) | st.sampled_from(KNOWN))
    entry, kind = common.mavlink_map[number], layout(number).type
    types = dict(zip(entry.fieldnames, entry.fieldtypes, strict=True))
    values = []
    for name, length in zip(entry.ordered_fieldnames, entry.lengths, strict=True):
        wire = types[name].split("_mavlink")[0]
        if wire == "char":
            values.append(draw(st.binary(max_size=length)))
            continue
        if name in ("target_system", "target_component"):
            one = st.sampled_from((1, 1, 1, 0, 2, 255))
        elif name == "command":
            one = st.sampled_from(COMMANDS) | st.integers(0, 65535)
        elif wire in ("float", "double"):
            one = st.sampled_from(ABSURD) | st.floats(width=32)
        else:
            bits, low = int(wire.strip("uint_")), 0 if wire[0] == "u" else 1
            lowest, highest = -low << (bits - 1), (1 << (bits - low)) - 1
            one = st.integers(0, 9) | st.sampled_from((lowest, highest))
        values.append(tuple(draw(one) for _ in range(length)) if length > 1 else draw(one))
    return Codec(255, 190).encode(kind(*values))


@st.composite
def broken(draw):
    """A frame with some bits turned, cut short, or made longer than it says."""
    data = bytearray(draw(frames()))
    for _ in range(draw(st.integers(0, 3))):
        data[draw(st.integers(0, len(data) - 1))] ^= 1 << draw(st.integers(0, 7))
    return bytes(data[: draw(st.integers(0, len(data)))]) + draw(st.binary(max_size=20))


DATAGRAMS = st.lists(st.binary(max_size=300) | broken() | frames(), min_size=1, max_size=30)


@pytest.fixture(scope="module")
def in_the_air():
    """A vehicle that hovers in OFFBOARD, and its state then."""
    from sitl.airframe import load_airframe
    from sitl.params import Params
    from sitl.signals import GeoPoint
    from sitl.simulator import Simulator, SimulatorConfig
    from sitl.vehicle import VehicleConfig

    airframe = load_airframe("x500")
    vehicle = VehicleConfig(airframe, Params(airframe.params), GeoPoint(19.4, -99.1, 2240.0))
    simulator, codec = Simulator(SimulatorConfig(vehicle)), Codec(255, 190)
    simulator.exchange(3_000_000, (b"", b""))
    command = layout(common.MAVLINK_MSG_ID_COMMAND_LONG).type
    for number in (400, 22):
        one = command(*[1.0, *[math.nan] * 6], number, 1, 1, 0)
        simulator.exchange(simulator.time_us, (codec.encode(one), b""))
    simulator.exchange(12_000_000, (b"", b""))
    assert simulator.report.flight.landed.name == "IN_AIR"
    return simulator, simulator.snapshot()


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(datagrams=DATAGRAMS, signed=st.booleans())
def test_no_datagram_stops_it(in_the_air, datagrams, signed):
    simulator, state = in_the_air
    simulator.restore(state)
    for number, data in enumerate(datagrams):
        other = datagrams[-number]
        simulator.exchange(simulator.time_us + 10_000, (data, other))
    simulator.exchange(simulator.time_us + 500_000, (b"", b""))
    truth = simulator.truth
    for value in (truth.position_ned_m, truth.velocity_ned_mps, truth.q_ned_frd, truth.rate_frd_radps):
        assert np.isfinite(value).all()
    assert all(math.isfinite(value) for value in simulator.parameters.values())
    for link in simulator.snapshot().links:
        assert len(link.codec.pending) < 600


@settings(max_examples=30, deadline=None)
@given(garbage=st.lists(st.binary(max_size=280), max_size=40))
def test_garbage_changes_nothing_in_the_flight(in_the_air, garbage):
    simulator, state = in_the_air
    ends = []
    for datagrams in ([], garbage):
        simulator.restore(state)
        for data in datagrams:
            simulator.exchange(simulator.time_us, (data, b""))
        simulator.exchange(state.links[0].telemetry.schedule[0][0] + 1_000_000, (b"", b""))
        ends.append(simulator.truth)
    assert (ends[0].position_ned_m == ends[1].position_ned_m).all()


@settings(max_examples=30, deadline=None)
@given(
    numbers=st.lists(st.integers(0, 65535) | st.integers(0, 8), max_size=40),
    count=st.sampled_from((0, 1, 5, 501, 65535)),
    kind=st.integers(0, 255) | st.integers(0, 2),
)
def test_mission_items_in_any_order_are_no_trouble(in_the_air, numbers, count, kind):
    simulator, state = in_the_air
    simulator.restore(state)
    codec = Codec(255, 190)
    announce = layout(common.MAVLINK_MSG_ID_MISSION_COUNT).type
    item = layout(common.MAVLINK_MSG_ID_MISSION_ITEM_INT).type
    named = {"count": count, "target_system": 1, "target_component": 1, "mission_type": kind}
    said = codec.encode(announce._make(named.get(field, 0) for field in announce._fields))
    simulator.exchange(simulator.time_us + 10_000, (said,))
    for seq in numbers:
        one = item(
            math.nan, math.inf, 0.0, math.nan, 2**31 - 1, -(2**31), math.inf, seq, 16, 1, 1, 3, 0, 1, kind
        )
        simulator.exchange(simulator.time_us + 10_000, (codec.encode(one),))
    simulator.exchange(simulator.time_us + 100_000, (b"",))
    assert np.isfinite(simulator.truth.position_ned_m).all()


@pytest.mark.parametrize("value", ABSURD[:7], ids=repr)
def test_no_command_stops_it_whatever_it_is_given(in_the_air, value):
    simulator, state = in_the_air
    simulator.restore(state)
    codec, kind = Codec(255, 190), layout(common.MAVLINK_MSG_ID_COMMAND_LONG).type
    for number in COMMANDS:
        for usual in (1.0, 2.0):
            for at in (0, 1, 2, 6):
                params = [value if i <= at else usual for i in range(7)]
                frame = codec.encode(kind(*params, number & 0xFFFF, 1, 1, 0))
                simulator.exchange(simulator.time_us, (frame,))
    simulator.exchange(simulator.time_us + 200_000, (b"",))


DEEDS = (93, 112, 177, 178, 195, 197, 201, 203, 205, 206, 214, 530, 1000, 2000, 2001, 2500, 2501, 80)


@pytest.mark.parametrize("value", [math.inf, -math.inf, math.nan, 3.4e38], ids=repr)
def test_no_mission_item_stops_it_whatever_it_is_given(new_client, value):
    """Each deed alone between take-off and the next place, so that one refused does not save the others."""
    client = new_client()
    client.until(lambda: client.flight.ready, 10.0)
    home = client.flight.home.point
    up = (22, (0.0, 0.0, 0.0, math.nan, home.lat_deg, home.lon_deg, 3.0), 3)
    on = (16, (0.0, 0.0, 0.0, math.nan, home.lat_deg + 2e-5, home.lon_deg, 3.0), 3)
    client.command(400, 1.0, 21196.0)
    client.command(22)
    client.live(5.0)
    state, now_us = client.simulator.snapshot(), client.now_us
    for number in DEEDS:
        client.simulator.restore(state)
        client.now_us = now_us
        for params in ((value,) * 4, (0.0, 1.0, value, 0.0)):
            client.upload([up, (number, (*params, 0.0, 0.0, 0.0), 2), on])
            client.command(300, 0.0)
            client.live(0.5)
    assert np.isfinite(client.simulator.truth.position_ned_m).all()
