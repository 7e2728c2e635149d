import pytest

from sitl.faults import GpsLoss, MotorLoss, WindStep, parse_fault


@pytest.mark.parametrize(
    ("spec", "fault"),
    [
        ("motor=2:0.5@60s", MotorLoss(60_000_000, None, 2, 0.5)),
        ("gps_loss@60s+20s", GpsLoss(60_000_000, 80_000_000)),
        ("wind_step=8@30s", WindStep(30_000_000, None, 8.0)),
        ("wind_step=-2.5@0.5+1.25", WindStep(500_000, 1_750_000, -2.5)),
    ],
)
def test_a_spec_is_read(spec, fault):
    assert parse_fault(spec) == fault


@pytest.mark.parametrize(
    ("spec", "complaint"),
    [
        ("meteor@3s", "unknown 'meteor'; known: motor, gps_loss, wind_step"),
        ("motor=2:0.5", "NAME"),
        ("motor=5:0.5@1s", "bad value '5:0.5'; wanted such as motor=2:0.5@60s"),
        ("motor=2:1.5@1s", "bad value"),
        ("motor@1s", "bad value None"),
        ("wind_step=strong@1s", "bad value 'strong'"),
        ("wind_step=nan@1s", "bad value 'nan'"),
        ("gps_loss=3@1s", "bad value '3'"),
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
