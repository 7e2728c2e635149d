"""Whole flights in lockstep: they pass, they repeat to the bit, and what breaks them is said."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest

from mavspiral.closedloop import simulate
from mavspiral.errors import InputError
from mavspiral.flight.flight_log import FlightLog

GOLDEN = Path(__file__).parents[1] / "golden" / "kiosk.flight.csv"


@pytest.fixture(scope="module")
def kiosk(planned):
    return simulate(planned("kiosk"), seed=3)


@pytest.mark.parametrize("name", ["torre", "asilo", "kiosk"])
def test_every_mission_of_the_gallery_flies_and_holds(planned, name):
    flight = simulate(planned(name), seed=1)
    assert flight.passed, flight.failures
    assert flight.outcome.ok
    assert flight.stream.rate_hz == pytest.approx(50.0, abs=0.01)


def test_the_vehicle_never_stands_at_the_plans_origin(planned):
    """Else a mixed-up frame would pass: every plan's home is metres away, on ground of another height."""
    for name in ("torre", "asilo", "kiosk"):
        home = planned(name).home_enu_m
        assert np.hypot(*home[:2]) > 20.0
        assert abs(home[2]) > 1.0


def test_one_seed_gives_the_same_bits_and_another_does_not(planned, kiosk):
    again, other = simulate(planned("kiosk"), seed=3), simulate(planned("kiosk"), seed=4)
    assert again.tlog == kiosk.tlog
    assert np.array_equal(again.log.truth_position_enu_m, kiosk.log.truth_position_enu_m)
    assert other.tlog != kiosk.tlog


def test_tracking_is_truth_against_the_reference_at_the_same_time(planned, kiosk):
    """By another road: the trajectory, asked for the path times of the log, against the truth in the log."""
    log = kiosk.log
    on_it = log.on_leg("inspection")
    there = planned("kiosk").trajectory(log.path_t_s[on_it]).position_enu_m
    error_m = np.sqrt(((log.truth_position_enu_m[on_it] - there) ** 2).sum(axis=1))
    assert np.allclose(error_m, kiosk.tracking_m, atol=1e-3)
    assert 0.0 < kiosk.tracking_p95_m < 0.3


def test_clearance_is_of_the_whole_flight_and_kept(kiosk):
    assert kiosk.clearance_min_m >= 3.0
    assert kiosk.clearance_min_m <= kiosk.inspection.certificate["clearance"].worst + 0.3


def test_a_broken_motor_fails_and_says_so(planned):
    flight = simulate(planned("kiosk"), seed=1, faults=("motor=2:0.3@40s",))
    assert not flight.passed
    assert flight.failures
    assert not flight.outcome.ok


def test_wind_is_felt_and_survived(planned):
    calm, windy = (
        simulate(planned("kiosk"), seed=1),
        simulate(planned("kiosk"), seed=1, wind_mps=6.0, gusts=True),
    )
    assert windy.outcome.ok
    assert windy.clearance_min_m >= 3.0
    assert windy.tracking_p95_m > calm.tracking_p95_m


def test_an_unknown_fault_is_refused(planned):
    with pytest.raises(InputError, match="--fault"):
        simulate(planned("kiosk"), faults=("meteor@3s",))


def test_the_log_survives_its_file(kiosk, tmp_path):
    path = tmp_path / "kiosk.flight.npz"
    kiosk.log.save(path)
    back = FlightLog.load(path)
    assert np.array_equal(back.truth_position_enu_m, kiosk.log.truth_position_enu_m)
    assert back.events == kiosk.log.events


def test_the_golden_flight(kiosk, renew_golden):
    """`pytest --renew-golden` writes it anew. Within 5 cm it is the same flight on another machine."""
    log = kiosk.log
    rows = np.column_stack([log.t_us / 1e6, log.truth_position_enu_m])[::50]
    if renew_golden:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["t_s", "east_m", "north_m", "up_m"])
        writer.writerows([f"{value:.3f}" for value in row] for row in rows)
        GOLDEN.write_text(text.getvalue())
    golden = np.loadtxt(GOLDEN, delimiter=",", skiprows=1)
    assert golden.shape == rows.shape
    assert np.allclose(rows, golden, atol=0.05)
