import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze
from mavspiral.survey.shots import flown_shots, shots_of

LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, 0.8, 1.0)


def line(yaw_from=1.0, yaw_to=1.0, end=(60.0, 0.0, 10.0)):
    path, gaze = LinePath((0.0, 0.0, 10.0), end), TurnGaze(yaw_from, yaw_to)
    away = LinePath((-20.0, 0.0, 10.0), (0.0, 0.0, 10.0))
    still = TurnGaze(yaw_from, yaw_from)
    return Trajectory(
        (
            Leg("approach", away, still, fastest_law(away, still, LIMITS)),
            Leg("inspection", path, gaze, fastest_law(path, gaze, LIMITS)),
        )
    )


def test_shots_are_evenly_spaced_along_the_wall_with_both_ends(camera):
    flight = line()
    shots = shots_of(flight, camera, standoffs_m=[8.0], side_overlap=0.6)
    # The picture is 12 m wide: 4.8 m from shot to shot, so 13 gaps on 60 m. Speeding up, the shutter is no limit.
    assert (shots.t_s[0], shots.t_s[-1]) == flight.span_s("inspection")
    assert len(shots) == 14
    assert np.allclose(np.diff(shots.position_enu_m[:, 0]), 60 / 13, atol=0.02)
    assert (shots.pitch_rad == 0).all()
    assert np.allclose(shots.yaw_enu_rad, 1.0)


def test_turning_on_the_spot_takes_shots_too(camera):
    flight = line(0.0, 3.0, end=(0.1, 0.0, 10.0))
    shots = shots_of(flight, camera, standoffs_m=[8.0], side_overlap=0.6)
    swept_m = 8.0 * np.diff(shots.yaw_enu_rad)
    assert len(shots) == 1 + np.ceil(24 / 4.8)
    assert swept_m.max() < 4.9


def test_the_shutter_is_given_its_time(camera):
    flight = line()
    shots = shots_of(flight, camera, standoffs_m=[1.0], side_overlap=0.9)
    gaps_s = np.diff(shots.t_s)
    assert gaps_s.min() >= camera.min_interval_s - 1e-9
    assert (shots.t_s[0], shots.t_s[-1]) == pytest.approx(flight.span_s("inspection"))
    assert gaps_s.mean() < 1.1 * camera.min_interval_s


def test_flown_shots_are_where_the_flight_was_at_their_path_time(camera):
    flight = line()
    shots = shots_of(flight, camera, standoffs_m=[8.0], side_overlap=0.6)
    begin_s, end_s = flight.span_s("inspection")
    path_t_s = np.concatenate([[np.nan] * 5, np.arange(begin_s, end_s + 0.01, 0.02), [end_s] * 50, [np.nan]])
    known = np.isfinite(path_t_s)
    there = flight(np.where(known, path_t_s, 0.0))
    offset = np.array([0.1, -0.2, 0.3])
    yaw = there.yaw_enu_rad + 0.01
    position = there.position_enu_m + offset
    position[-20:] += 100.0  # after the end, path time stands still: too late for the last shot
    flown = flown_shots(shots, path_t_s, position, yaw)
    assert (flown.t_s == shots.t_s).all()
    assert np.allclose(flown.position_enu_m, shots.position_enu_m + offset, atol=1e-3)
    assert np.allclose(flown.yaw_enu_rad, shots.yaw_enu_rad + 0.01, atol=1e-5)

    cut = path_t_s.copy()
    cut[known & (path_t_s > begin_s + 6.0)] = np.nan
    assert len(flown_shots(shots, cut, position, yaw)) == (shots.t_s <= begin_s + 6.02).sum() < len(shots)
    assert len(flown_shots(shots, np.full(9, np.nan), position[:9], yaw[:9])) == 0


def test_no_shots_are_taken_between_two_passes(camera):
    legs = line().legs
    first, gap, second = (
        LinePath((0.0, 0.0, 10.0), (30.0, 0.0, 10.0)),
        LinePath((30.0, 0.0, 10.0), (30.0, 50.0, 10.0)),
        LinePath((30.0, 50.0, 10.0), (60.0, 50.0, 10.0)),
    )
    still = TurnGaze(1.0, 1.0)
    named = (("inspection-a", first), ("transit-1-1", gap), ("inspection-b", second))
    flight = Trajectory(
        (legs[0], *(Leg(name, path, still, fastest_law(path, still, LIMITS)) for name, path in named))
    )
    shots = shots_of(flight, camera, standoffs_m=[8.0, 8.0], side_overlap=0.6)
    assert flight.on("inspection", shots.t_s).all()
    for span_s in flight.spans_s("inspection"):
        assert np.isin(span_s, shots.t_s).all()
    assert ((shots.position_enu_m[:, 1] == 0.0) | (shots.position_enu_m[:, 1] == 50.0)).all()
