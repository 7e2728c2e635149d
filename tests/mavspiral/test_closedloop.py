"""Whole flights in lockstep: they pass, they repeat to the bit, and what breaks them is said."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mavspiral.closedloop import simulate
from mavspiral.errors import InputError
from mavspiral.flight.flight_log import FlightLog
from mavspiral.frames import wrap_rad
from mavspiral.motion.nearest import path_times_s
from mavspiral.survey.solids import Solids

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


def test_tracking_is_truth_against_the_reference_at_the_same_time(kiosk):
    """By another road: the trajectory, asked for the path times of the log, against the truth in the log."""
    log = kiosk.log
    on_it = log.on_leg("inspection")
    there = kiosk.trajectory(log.path_t_s[on_it]).position_enu_m
    error_m = np.sqrt(((log.truth_position_enu_m[on_it] - there) ** 2).sum(axis=1))
    assert np.allclose(error_m, kiosk.tracking_m, atol=1e-3)
    assert 0.0 < kiosk.tracking_p95_m < 0.3


def test_clearance_is_of_the_whole_flight_and_kept(kiosk):
    assert kiosk.clearance_min_m >= 3.0
    assert kiosk.clearance_min_m <= kiosk.inspection.certificate["clearance"].worst + 0.3


def test_what_is_seen_is_ray_cast_from_the_poses_that_were_flown(planned, kiosk):
    inspection = planned("kiosk")
    assert len(inspection.shots) == inspection.summary()["photos"] > 30
    assert kiosk.coverage.patches is inspection.coverage.patches
    assert kiosk.coverage.walls == pytest.approx(inspection.coverage.walls, abs=0.02)
    # Another place, hence other pixels, but not by much.
    seen = kiosk.coverage.seen & inspection.coverage.seen
    off = np.abs(kiosk.coverage.best_gsd_m[seen] / inspection.coverage.best_gsd_m[seen] - 1)
    assert 0.0 < off.max() < 0.15
    assert kiosk.summary()["coverage"]["walls"] == round(kiosk.coverage.walls, 4)


def test_shots_are_those_of_the_spiral_from_whatever_home(planned):
    """Another home, another approach, other path times: the same shots."""
    inspection = planned("kiosk")
    route = inspection.route_from(inspection.home_enu_m + np.array([-150.0, -40.0, 0.0]))
    t_s = np.arange(0.0, route.duration_s, 0.02)
    there = route(t_s)
    shots = inspection.flown_shots(route, t_s, there.position_enu_m, there.yaw_enu_rad)
    assert np.array_equal(shots.t_s, inspection.shots.t_s)
    assert np.allclose(shots.position_enu_m, inspection.shots.position_enu_m, atol=2e-3)
    assert np.allclose(np.exp(1j * shots.yaw_enu_rad), np.exp(1j * inspection.shots.yaw_enu_rad), atol=1e-3)


def test_a_flight_that_was_cut_short_did_not_see_what_comes_later(planned, kiosk):
    """The same log without its second half sees less, and [accept] says so."""
    inspection, log = planned("kiosk"), kiosk.log
    half = len(log.t_us) // 2
    # The flight's own route differs from the plan's by millimetres of approach only.
    shots = inspection.flown_shots(
        inspection.trajectory,
        np.where(np.arange(len(log.t_us)) < half, log.path_t_s, np.nan),
        log.truth_position_enu_m,
        log.truth_yaw_enu_rad,
    )
    seen = inspection.coverage_from(shots)
    assert len(shots) < len(kiosk.shots) == len(inspection.shots)
    assert 0.1 < seen.walls < 0.9
    assert any("[accept] coverage" in line for line in replace(kiosk, coverage=seen).failures)
    assert not any("coverage" in line for line in kiosk.failures)


def test_a_broken_motor_fails_and_says_so(planned):
    flight = simulate(planned("kiosk"), seed=1, faults=("motor=2:0.3@40s",))
    assert not flight.passed
    assert flight.failures
    assert not flight.outcome.ok


@pytest.mark.parametrize("airframe", ["7inch", "camera"])
def test_every_bundled_airframe_flies_the_kiosk(planned, airframe):
    inspection = planned("kiosk")
    mission = inspection.mission
    other = mission.vehicle.model_copy(update={"airframe": airframe})
    flight = simulate(mission.model_copy(update={"vehicle": other}), seed=1)
    assert flight.passed, flight.failures


def test_a_link_that_loses_three_frames_of_ten_does_not_end_the_flight_and_repeats_to_the_bit(planned):
    flight, again = (simulate(planned("kiosk"), seed=1, faults=("packet_loss=30%",)) for _ in range(2))
    assert flight.outcome.ok
    assert flight.clearance_min_m >= 3.0
    assert flight.tlog == again.tlog


@pytest.mark.parametrize(
    ("fault", "reason", "end"),
    [
        ("gps_loss@60s+20s", "the vehicle's own failsafe took over: AUTO.LAND", "m from home"),
        ("battery=critical@60s", "the vehicle's own failsafe took over: AUTO.LOITER", "in LAND"),
        ("link_loss@60s+20s", "link lost", "in RETURN, 0.0 m from home"),
    ],
)
def test_a_failsafe_takes_the_flight_over_and_is_watched_to_its_end(planned, fault, reason, end):
    """The log ends with the session; the clearance is of all that the vehicle then did by itself, too."""
    flight = simulate(planned("kiosk"), seed=1, faults=(fault,))
    assert not flight.passed
    assert reason in flight.outcome.reason
    *_, said, last = flight.log.events
    assert reason in said.text
    assert last.text.startswith("left alone the vehicle has disarmed") and end in last.text
    assert flight.clearance_t_s[-1] > flight.log.t_us[-1] / 1e6 + 10.0
    assert flight.clearance_min_m >= 3.0


def test_a_vehicle_whose_failsafe_does_nothing_is_said_to_hang_in_the_air(planned):
    """ArduPilot's FS_GCS_ENABLE is 0: without its setpoints it holds, and nobody brings it home."""
    flight = simulate(planned("kiosk"), seed=1, faults=("link_loss@90s",), autopilot="ardupilot")
    assert "link lost" in flight.outcome.reason and not flight.passed
    assert "is still armed after 300 s, in GUIDED" in flight.log.events[-1].text


def test_what_a_vehicle_does_alone_repeats_to_the_bit(planned):
    first, again = (simulate(planned("kiosk"), seed=1, faults=("link_loss@60s",)) for _ in range(2))
    assert np.array_equal(first.clearance_m, again.clearance_m) and first.log.events == again.log.events


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


def test_the_way_home_from_anywhere_on_the_torre_keeps_clear_of_it(planned):
    inspection = planned("torre")
    above_home = inspection.trajectory(0.0).position_enu_m
    heights = inspection.site.heights
    solids = Solids.of(heights.height_agl_m, heights.cell_m, heights.origin_enu_m)
    for t_s in np.linspace(3.0, inspection.trajectory.duration_s - 5.0, 25):
        here = inspection.trajectory(t_s).position_enu_m
        way = inspection.way_home(here, above_home, 0.3)
        states = way.sampled(0.1)
        assert np.allclose(states.position_enu_m[0], here)
        assert np.allclose(states.position_enu_m[-1], above_home)
        assert solids.distance_m(states.position_enu_m).min() >= inspection.clearance_required_m - 1e-9


@pytest.mark.parametrize("trigger", ["digicam", "distance", "none"])
def test_the_vehicle_shoots_by_every_trigger_and_sees_the_walls(planned, trigger):
    kiosk = planned("kiosk")
    camera = kiosk.mission.camera.model_copy(update={"trigger": trigger})
    flight = simulate(replace(kiosk, mission=kiosk.mission.model_copy(update={"camera": camera})), seed=3)
    assert flight.outcome.ok
    assert flight.coverage.walls > 0.99
    assert len(flight.shots) >= len(kiosk.shots) - 1


def test_a_battery_that_does_not_last_is_changed_and_all_is_seen(planned):
    """Each sortie takes off anew; the pictures of all of them show what one long flight would."""
    kiosk = planned("kiosk")
    vehicle = kiosk.mission.vehicle.model_copy(update={"endurance_s": 50.0})
    inspection = replace(kiosk, mission=kiosk.mission.model_copy(update={"vehicle": vehicle}))
    sorties = inspection.sorties()
    assert inspection.summary()["sorties"] == len(sorties) >= 2
    flight = simulate(inspection, seed=3)
    assert flight.outcome.ok and flight.clearance_min_m >= 3.0
    assert flight.coverage.walls > 0.99
    assert sum(event.text == "take off" for event in flight.log.events) == len(sorties)
    assert np.all(np.diff(flight.log.t_us) > 0)
    assert len(flight.shots) > len(kiosk.shots), "with an overlap"
    assert len(flight.tracking_m) == flight.log.on_leg("inspection").sum()
    assert flight.tracking_p95_m < 0.3


@pytest.fixture(scope="module")
def ardupilot_torre(planned):
    return simulate(planned("torre"), seed=1, autopilot="ardupilot")


def test_the_torre_is_flown_in_ardupilots_dialect_too(ardupilot_torre):
    flight = ardupilot_torre
    assert flight.passed, flight.failures
    assert flight.summary()["autopilot"] == "ardupilot"
    assert flight.tracking_p95_m <= 0.45
    log = flight.log
    inspecting = log.on_leg("inspection")
    off_rad = np.angle(np.exp(1j * (log.truth_yaw_enu_rad - log.reference_yaw_enu_rad)))[inspecting]
    assert np.degrees(np.quantile(np.abs(off_rad), 0.95)) <= 2.0


@pytest.mark.parametrize("name", ["asilo", "kiosk"])
def test_the_rest_of_the_gallery_holds_in_ardupilots_dialect(planned, name):
    flight = simulate(planned(name), seed=1, autopilot="ardupilot")
    assert flight.passed, flight.failures


def test_one_seed_gives_the_same_bits_in_ardupilots_dialect(planned):
    first, again = (simulate(planned("kiosk"), seed=3, autopilot="ardupilot") for _ in range(2))
    assert first.tlog == again.tlog


def test_the_missions_autopilot_is_the_default_and_the_plan_itself_is_left_alone(planned):
    inspection = planned("kiosk")
    flight = simulate(inspection.flown_by("ardupilot"), seed=1)
    assert any(event.text == "ArduPilot 4.6.3" for event in flight.log.events)
    assert flight.summary()["autopilot"] == "ardupilot"
    assert inspection.mission.vehicle.autopilot == "px4"


def test_a_flight_lasts_from_arming_to_disarming(planned, kiosk):
    """How long the vehicle takes to find itself, 41 s for ArduPilot, is not the plan's."""
    slow = simulate(planned("kiosk"), seed=3, autopilot="ardupilot")
    assert slow.sim_s - slow.duration_s > 38.0
    assert slow.duration_s == pytest.approx(kiosk.duration_s, abs=25.0)


def test_ardupilot_flies_the_exported_mission_in_auto(planned):
    """Armed in GUIDED, which waits for a place; the items that have none come back in another frame."""
    flight = simulate(planned("kiosk"), seed=3, autopilot="ardupilot", via="mission")
    summary = flight.summary()
    assert flight.outcome.ok, flight.outcome
    assert (summary["autopilot"], summary["via"]) == ("ardupilot", "mission")
    assert summary["coverage"]["walls"] > 0.99
    assert summary["tracking"]["p95_m"] < 0.5
    assert summary["clearance_min_m"] > 3.0
    shots = flight.shots
    planned_rad = flight.trajectory(path_times_s(flight.trajectory, shots.position_enu_m)).yaw_enu_rad
    off_deg = np.degrees(np.abs(wrap_rad(shots.yaw_enu_rad - planned_rad)))
    assert np.quantile(off_deg, 0.95) < 20.0 and off_deg.max() < 30.0
