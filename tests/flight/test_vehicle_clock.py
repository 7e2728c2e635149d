import random

import pytest

from mavspiral.flight.vehicle_clock import VehicleClock


def heard(clock, rate, seconds=20.0, boot_ms=5000, jitter_s=0.0, begin_us=1_000_000, loss=0.0):
    rng = random.Random(2)
    for k in range(int(seconds * 50)):
        now_us = begin_us + k * 20_000
        if rng.random() >= loss:
            clock.observe(now_us + int(rng.uniform(0, jitter_s) * 1e6), boot_ms + round(rate * k * 20))
    return now_us


def test_in_lockstep_it_is_exact():
    clock = VehicleClock()
    last_us = heard(clock, 1.0)
    assert clock.rate == pytest.approx(1.0, abs=1e-12)
    assert clock.at(last_us + 7000) == pytest.approx(5e6 + last_us - 1e6 + 7000, abs=1e-3)


@pytest.mark.parametrize("rate", [0.5, 0.9, 0.99, 3.0, 20.0])
def test_other_rates_are_followed(rate):
    clock = VehicleClock()
    last_us = heard(clock, rate)
    assert clock.rate == pytest.approx(rate, rel=5e-3)
    assert clock.at(last_us) == pytest.approx(5e6 + rate * (last_us - 1e6), abs=3000)


def test_jitter_and_loss_are_smoothed():
    clock = VehicleClock()
    last_us = heard(clock, 1.0, jitter_s=0.03, loss=0.3)
    assert clock.rate == pytest.approx(1.0, abs=0.01)
    late_us = 5e6 + last_us - 1e6 - clock.at(last_us)
    assert 0 < late_us < 30_000, "behind by about the mean delay"


def test_how_often_it_is_heard_is_known():
    clock = VehicleClock()
    assert clock.interval_s == 0.0
    for ms in range(1000, 6000, 250):
        clock.observe(ms * 1000 + 77, ms)
    assert clock.interval_s == pytest.approx(0.25)


def test_a_reboot_is_a_new_beginning():
    clock = VehicleClock()
    last_us = heard(clock, 1.0)
    heard(clock, 1.0, seconds=2, boot_ms=0, begin_us=last_us + 20_000)
    assert clock.at(last_us + 20_000 + 1_980_000) == pytest.approx(1_980_000, abs=1)


def test_a_jump_is_told_once_it_is_sure():
    clock = VehicleClock()
    last_us = heard(clock, 1.0)
    before_s = 1e-6 * clock.at(last_us)
    for k in range(1, 5):
        clock.observe(last_us + 20_000 * k, 20 * k)
        assert clock.jump_s == 0.0 and clock.jumps
    clock.observe(last_us + 100_000, 100)
    assert clock.jump_s == pytest.approx(-before_s, abs=0.01) and not clock.jumps


def test_an_observation_that_was_overtaken_by_seconds_is_no_jump():
    clock = VehicleClock()
    for k in range(150, 1000):
        clock.observe(20_000 * k, 20 * k)
        if k % 10 == 0:
            clock.observe(20_000 * k + 5_000, 20 * k - 2000)
    assert clock.jump_s == 0.0


def test_two_messages_at_once_do_no_harm():
    clock = VehicleClock()
    clock.observe(1000, 10)
    clock.observe(1000, 30)
    clock.observe(21_000, 50)
    assert 0.01 <= clock.rate < 10
