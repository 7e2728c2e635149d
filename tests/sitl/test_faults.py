import re
from pathlib import Path

import pytest

from sitl.faults import (
    BaroStep,
    BatteryLevel,
    GpsDrift,
    GpsJump,
    GpsLoss,
    GpsMultipath,
    LinkDelay,
    LinkLoss,
    MagDisturbance,
    MotorLoss,
    PacketLoss,
    SensorStuck,
    WindStep,
    parse_fault,
)

S = 1_000_000
SPECS = {
    "motor=2:0.5@60s": MotorLoss(60 * S, None, 2, 0.5),
    "gps_loss@60s+20s": GpsLoss(60 * S, 80 * S),
    "gps_jump=5m@60s": GpsJump(60 * S, None, 5.0),
    "gps_drift=0.2m/s@60+30": GpsDrift(60 * S, 90 * S, 0.2),
    "multipath=2m@0s": GpsMultipath(0, None, 2.0),
    "baro_step=-3@1s": BaroStep(S, None, -3.0),
    "mag_disturb=0.2G@1s": MagDisturbance(S, None, 0.2),
    "battery=low@1s": BatteryLevel(S, None, 0.14),
    "battery=30%@1s": BatteryLevel(S, None, 0.3),
    "sensor_stuck=baro@1.5s": SensorStuck(1_500_000, None, "baro"),
    "wind_step=8@30s": WindStep(30 * S, None, 8.0),
    "wind_step=-2.5@0.5+1.25": WindStep(500_000, 1_750_000, -2.5),
    "link_loss@60s+20s": LinkLoss(60 * S, 80 * S),
    "packet_loss=30%": PacketLoss(0, None, 0.3),
    "packet_loss=30%@5s": PacketLoss(5 * S, None, 0.3),
    "delay=200ms": LinkDelay(0, None, 200_000),
    "delay=1.5s+10s": LinkDelay(0, 10 * S, 1_500_000),
}


@pytest.mark.parametrize(("spec", "fault"), SPECS.items(), ids=SPECS)
def test_a_spec_is_read(spec, fault):
    read = parse_fault(spec)
    assert type(read) is type(fault)
    assert read == fault


def test_every_fault_is_read_once_and_stands_in_the_readmes_table():
    with pytest.raises(ValueError, match="known: ") as unknown:
        parse_fault("meteor@60s")
    known = set(str(unknown.value).split("known: ")[1].split(", "))
    assert {re.split("[=@]", spec)[0] for spec in SPECS} == known
    table = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8").split("## Faults")[1]
    rows = [line for line in table.split("\n## ")[0].splitlines() if line.startswith("| `")]
    assert {re.split("[=@`]", row)[1] for row in rows} == known
    for row in rows:
        parse_fault(row.split("`")[1])


@pytest.mark.parametrize(
    ("spec", "complaint"),
    [
        ("meteor@3s", "unknown 'meteor'; known: motor, gps_loss"),
        ("motor=2:0.5", "no start; wanted NAME[=VALUE]@START[+DURATION], like motor=2:0.5@60s"),
        ("motor 2", "wanted NAME"),
        ("motor=5:0.5@1s", "bad value '5:0.5'; wanted such as motor=2:0.5@60s"),
        ("motor=2:1.5@1s", "bad value"),
        ("motor@1s", "bad value None"),
        ("wind_step=strong@1s", "bad value 'strong'"),
        ("wind_step=nan@1s", "bad value 'nan'"),
        ("wind_step=400@1s", "m/s within ±100"),
        ("gps_loss=3@1s", "bad value '3'"),
        ("gps_jump@1s", "metres"),
        ("packet_loss=130%", "0 to 100 %"),
        ("packet_loss=-1", "0 to 100 %"),
        ("delay=2h", "bad value '2h'"),
        ("delay=90s", "0 to 60000 ms"),
        ("battery=empty@1s", "low, critical, emergency or a charge in %"),
        ("sensor_stuck=lidar@1s", "accel, gyro, baro, mag, gps"),
        ("gps_loss@99999999999s", "wanted NAME"),
    ],
)
def test_a_bad_spec_is_one_clear_line(spec, complaint):
    with pytest.raises(ValueError) as error:
        parse_fault(spec)
    assert complaint in str(error.value) and "\n" not in str(error.value)


def test_a_fault_is_active_from_its_start_until_before_its_end():
    fault = parse_fault("gps_loss@60s+20s")
    times_us = (59_999_999, 60_000_000, 79_999_999, 80_000_000)
    assert [fault.active(t) for t in times_us] == [False, True, True, False]
    assert parse_fault("motor=1:0@1s").active(10**12)
