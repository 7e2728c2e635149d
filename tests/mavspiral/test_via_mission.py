"""The exported mission, uploaded and flown in AUTO by the bundled vehicle, measured as the streamed one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mavspiral.closedloop import simulate
from mavspiral.errors import LimitError
from mavspiral.export.corners import CUT_M
from mavspiral.handover import inspection_missions
from mavspiral.motion.nearest import path_times_s


@pytest.fixture(scope="module")
def flown(planned):
    return simulate(planned("kiosk"), seed=3, via="mission")


def test_it_is_uploaded_compared_flown_and_landed(flown):
    texts = [event.text for event in flown.log.events]
    assert flown.outcome.ok, flown.outcome
    assert any("items uploaded, read back and compared" in text for text in texts)
    assert texts[-1] == "flown, landed, disarmed"
    assert flown.summary()["via"] == "mission"
    assert flown.summary()["setpoints"]["sent"] == 0


def test_it_sees_all_of_the_building_and_keeps_the_clearance(flown):
    assert flown.coverage.walls >= 0.99
    assert flown.clearance_min_m >= flown.inspection.clearance_required_m
    assert len(flown.shots) >= len(flown.inspection.shots)  # by time, and it is slower than planned


def test_it_stays_within_what_the_exporter_states(flown):
    stated_m = inspection_missions(flown.inspection).missions[0].thinned.chord_error_m + CUT_M
    assert flown.tracking_m.max() <= stated_m
    assert flown.tracking_p95_m <= 0.5


def test_the_ardupilot_dialect_flies_its_file_too_and_sees_all_of_the_building(planned):
    flight = simulate(planned("kiosk").flown_by("ardupilot"), seed=3, via="mission")
    assert flight.outcome.ok, flight.outcome
    assert flight.coverage.walls >= 0.99
    assert flight.clearance_min_m >= flight.inspection.clearance_required_m
    assert flight.tracking_p95_m <= 0.5
    assert len(flight.shots) >= len(flight.inspection.shots)


def test_same_seed_same_bits(planned, flown):
    again = simulate(planned("kiosk"), seed=3, via="mission")
    assert again.tlog == flown.tlog
    assert np.array_equal(again.log.truth_position_enu_m, flown.log.truth_position_enu_m)


def test_a_link_lost_before_the_take_off_is_a_flight_that_failed(planned):
    flight = simulate(planned("kiosk"), via="mission", faults=("link_loss@5s",))
    assert not flight.left_the_ground and not flight.passed
    assert "link lost" in flight.outcome.reason
    assert len(flight.shots) == 0 and flight.coverage.walls == 0.0
    assert flight.summary()["tracking"]["p95_m"] is None


def for_vehicle(inspection, **values):
    vehicle = inspection.mission.vehicle.model_copy(update=values)
    return replace(inspection, mission=inspection.mission.model_copy(update={"vehicle": vehicle}))


def test_several_sorties_are_all_flown_and_show_all_of_it(planned):
    kiosk = for_vehicle(planned("kiosk"), endurance_s=130.0)
    flight = simulate(kiosk, seed=3, via="mission")
    landed = [event for event in flight.log.events if event.text == "flown, landed, disarmed"]
    assert len(landed) == len(inspection_missions(kiosk).missions) >= 2
    assert flight.outcome.ok
    assert flight.coverage.walls >= 0.99
    assert flight.clearance_min_m >= kiosk.clearance_required_m
    assert flight.tracking_p95_m <= 0.5
    assert flight.summary()["setpoints"] == {"sent": 0, "rate_hz": 0.0}


def test_a_stretch_without_a_mission_is_not_flown_without_a_word(planned):
    with pytest.raises(LimitError, match=r"kiosk: no \.plan .* endurance_s = 60"):
        simulate(for_vehicle(planned("kiosk"), endurance_s=60.0), via="mission")


def test_path_times_of_who_flies_the_curve_slower_and_beside_it(planned):
    trajectory = planned("kiosk").trajectory
    t_s = np.linspace(0.0, trajectory.duration_s, 3000)
    place = trajectory(t_s).position_enu_m + np.array([0.0, 0.0, 0.4])
    found = path_times_s(trajectory, place)
    # Slower, and a leg's end is about: from 0.4 m beside it the next leg's beginning may be nearer.
    moving = np.sqrt((trajectory(t_s).velocity_enu_mps ** 2).sum(axis=1)) > 1.0
    level = np.abs(trajectory(t_s).velocity_enu_mps[:, 2]) < 0.3
    assert np.abs(found - t_s)[moving & level].max() < 0.15
    assert np.all(np.diff(found) >= 0.0)
