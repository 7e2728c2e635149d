"""MAVSDK 4's blocking API against one vehicle over UDP, in the idioms of its examples."""

import math
import time

import pytest

pytest.importorskip("mavsdk")

from mavsdk.plugins.action import Action, ActionError, OrbitYawBehavior
from mavsdk.plugins.failure import Failure, FailureError, FailureResult, FailureType, FailureUnit
from mavsdk.plugins.geofence import Circle, FenceType, Geofence, GeofenceData, Point, Polygon
from mavsdk.plugins.manual_control import ManualControl, ManualControlError, ManualControlResult
from mavsdk.plugins.mission import Mission, MissionPlan
from mavsdk.plugins.mission import MissionItem as PlanItem
from mavsdk.plugins.mission_raw import MissionItem, MissionRaw, MissionRawError, MissionRawResult
from mavsdk.plugins.offboard import (
    AccelerationNed,
    Attitude,
    AttitudeRate,
    Offboard,
    PositionGlobalYaw,
    PositionNedYaw,
    VelocityBodyYawspeed,
    VelocityNedYaw,
)
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import FlightMode, LandedState, Telemetry
from mavsdk_session import insisted, system_of
from patience import eventually as wait

LAT_DEG, LON_DEG = 23.96028, 32.8675
DEGREE_M = 111_000.0


class Drone:
    def __init__(self, system):
        self.telemetry = Telemetry(system)
        self.action = Action(system)
        self.offboard = Offboard(system)
        self.mission = MissionRaw(system)
        self.plan = Mission(system)
        self.failure = Failure(system)
        self.geofence = Geofence(system)
        self.param = Param(system)
        self.joystick = ManualControl(system)
        wait(self.telemetry.health_all_ok)
        wait(lambda: math.isfinite(self.telemetry.home().latitude_deg))
        # It waits for us, however late: armed on the ground, and for the next setpoint.
        insisted(self.param.set_param_float, "COM_DISARM_PRFLT", -1.0)
        insisted(self.param.set_param_float, "COM_OF_LOSS_T", 5.0)

    @property
    def height_m(self):
        return self.telemetry.position().relative_altitude_m

    @property
    def ned_m(self):
        p = self.telemetry.position_velocity_ned().position
        return p.north_m, p.east_m, p.down_m

    @property
    def speeds_mps(self):
        v = self.telemetry.velocity_ned()
        return v.north_m_s, v.east_m_s

    @property
    def from_home_m(self):
        """Home is where it was armed."""
        here, home = self.telemetry.position(), self.telemetry.home()
        north_m = (here.latitude_deg - home.latitude_deg) * DEGREE_M
        east_m = (here.longitude_deg - home.longitude_deg) * DEGREE_M * math.cos(math.radians(LAT_DEG))
        return math.hypot(north_m, east_m)

    def airborne(self, height_m=8.0):
        if self.telemetry.landed_state() is not LandedState.IN_AIR or self.height_m < 3.0:
            wait(lambda: not self.telemetry.armed())
            insisted(self.action.set_takeoff_altitude, height_m)
            insisted(self.action.arm)
            insisted(self.action.takeoff)
            wait(lambda: self.telemetry.landed_state() is LandedState.IN_AIR)
            wait(lambda: self.height_m > height_m - 0.5)
            wait(lambda: self.telemetry.flight_mode() is FlightMode.HOLD)
        return self

    def landed(self):
        if self.telemetry.armed():
            insisted(self.action.land)
            wait(lambda: not self.telemetry.armed())


@pytest.fixture(scope="module")
def drone(shared_vehicle):
    with system_of(shared_vehicle) as system:
        yield Drone(system)


def item(seq, command, p1=0.0, p2=0.0, p3=0.0, p4=math.nan, north_m=0.0, east_m=0.0, height_m=0.0, frame=3):
    x, y = 0, 0
    if frame == 3:
        x = round((LAT_DEG + north_m / DEGREE_M) * 1e7)
        y = round((LON_DEG + east_m / (DEGREE_M * math.cos(math.radians(LAT_DEG)))) * 1e7)
    return MissionItem(seq, frame, command, int(seq == 0), 1, p1, p2, p3, p4, x, y, height_m, 0)


def test_parameters_are_read_and_set(drone):
    assert insisted(drone.param.get_param_int, "SYS_AUTOSTART") == 10040
    insisted(drone.param.set_param_float, "MPC_XY_CRUISE", 4.0)
    assert insisted(drone.param.get_param_float, "MPC_XY_CRUISE") == pytest.approx(4.0)
    insisted(drone.action.set_return_to_launch_altitude, 15.0)
    assert insisted(drone.action.get_return_to_launch_altitude) == pytest.approx(15.0)
    names = {p.name for p in insisted(drone.param.get_all_params).float_params}
    assert {"MPC_XY_CRUISE", "NAV_ACC_RAD", "MIS_YAW_ERR"} <= names


def test_telemetry_comes_at_the_rate_that_is_asked_for(drone):
    """By the vehicle's own clock, of which its attitude tells; some may be lost on their way, most are not."""
    for rate_hz, rel in ((1.0, 0.5), (20.0, 0.3)):
        insisted(drone.telemetry.set_rate_position, rate_hz)
        time.sleep(0.3)
        heard_s = []

        def hear(*_, heard_s=heard_s):
            heard_s.append(drone.telemetry.attitude_quaternion().timestamp_us / 1e6)

        handle = drone.telemetry.subscribe_position(hear)
        wait(lambda heard_s=heard_s: len(heard_s) > 1 and heard_s[-1] - heard_s[0] > 12.0)
        drone.telemetry.unsubscribe_position(handle)
        assert (len(heard_s) - 1) / (heard_s[-1] - heard_s[0]) == pytest.approx(rate_hz, rel=rel)


def test_a_geofence_goes_up_comes_down_and_is_cleared(drone):
    corners = [(0.001, 0.001), (0.001, -0.001), (-0.001, -0.001), (-0.001, 0.001)]
    points = [Point(LAT_DEG + a, LON_DEG + b) for a, b in corners]
    circle = Circle(Point(LAT_DEG, LON_DEG), 20.0, FenceType.EXCLUSION)
    insisted(drone.geofence.upload_geofence, GeofenceData([Polygon(points, FenceType.INCLUSION)], [circle]))
    fence = insisted(drone.mission.download_geofence)
    assert [(f.command, f.param1) for f in fence] == [(5001, 4.0)] * 4 + [(5004, 20.0)]
    insisted(drone.geofence.clear_geofence)
    assert insisted(drone.mission.download_geofence) == []


def test_a_mission_that_px4_refuses_is_refused(drone):
    with pytest.raises(MissionRawError) as error:
        insisted(
            drone.mission.upload_mission, [item(0, 22, height_m=5.0), item(1, 82, north_m=5.0, height_m=5.0)]
        )
    assert error.value.result is MissionRawResult.UNSUPPORTED


def test_take_off_goto_and_landing(drone):
    drone.landed()
    drone.airborne(8.0)
    home = drone.telemetry.home()
    lat_deg = home.latitude_deg + 10.0 / DEGREE_M
    insisted(drone.action.goto_location, lat_deg, home.longitude_deg, home.absolute_altitude_m + 11.0, 90.0)
    wait(lambda: abs(drone.telemetry.position().latitude_deg - lat_deg) * DEGREE_M < 0.5)
    wait(lambda: abs(drone.height_m - 11.0) < 0.5)
    wait(lambda: abs(drone.telemetry.attitude_euler().yaw_deg - 90.0) < 5.0)
    drone.landed()


def test_offboard_by_position_velocity_and_acceleration(drone):
    drone.airborne()
    north_m, east_m, down_m = drone.ned_m
    drone.offboard.set_position_ned(PositionNedYaw(north_m + 4.0, east_m, down_m, 0.0))
    insisted(drone.offboard.start)
    wait(lambda: abs(drone.ned_m[0] - north_m - 4.0) < 0.4)
    assert drone.telemetry.flight_mode() is FlightMode.OFFBOARD
    drone.offboard.set_velocity_ned(VelocityNedYaw(0.0, 2.0, 0.0, 0.0))
    wait(lambda: drone.ned_m[1] > east_m + 4.0)
    drone.offboard.set_velocity_body(VelocityBodyYawspeed(0.0, 0.0, 0.0, 30.0))
    wait(lambda: drone.telemetry.attitude_euler().yaw_deg > 40.0)
    place = PositionNedYaw(north_m, east_m, down_m - 2.0, 0.0)
    still = VelocityNedYaw(0.0, 0.0, 0.0, 0.0)
    drone.offboard.set_position_velocity_ned(place, still)
    wait(lambda: math.dist(drone.ned_m, (north_m, east_m, down_m - 2.0)) < 0.6)
    drone.offboard.set_position_velocity_acceleration_ned(place, still, AccelerationNed(0.0, 0.0, 0.0))
    time.sleep(0.3)
    assert drone.offboard.is_active()
    insisted(drone.offboard.stop)
    wait(lambda: drone.telemetry.flight_mode() is FlightMode.HOLD)


def test_offboard_by_a_place_on_earth(drone):
    drone.airborne()
    here = drone.telemetry.position()
    lat_deg, height_m = here.latitude_deg + 5.0 / DEGREE_M, here.relative_altitude_m + 2.0
    relative = PositionGlobalYaw.AltitudeType.REL_HOME
    drone.offboard.set_position_global(
        PositionGlobalYaw(lat_deg, here.longitude_deg, height_m, 0.0, relative)
    )
    insisted(drone.offboard.start)
    wait(lambda: (drone.telemetry.position().latitude_deg - here.latitude_deg) * DEGREE_M > 4.5)
    wait(lambda: drone.height_m > height_m - 0.3)
    insisted(drone.offboard.stop)
    wait(lambda: drone.telemetry.flight_mode() is FlightMode.HOLD)


def test_a_mission_goes_up_comes_down_is_flown_paused_and_returns(drone):
    drone.landed()
    items = [
        item(0, 22, height_m=6.0),
        item(1, 178, 1.0, 4.0, -1.0, 0.0, frame=2),
        item(2, 16, north_m=12.0, height_m=6.0),
        item(3, 16, north_m=12.0, east_m=12.0, height_m=8.0, p4=45.0),
        item(4, 16, east_m=12.0, height_m=8.0),
        item(5, 20, p4=0.0, frame=2),
    ]
    insisted(drone.mission.upload_mission, items)
    back = insisted(drone.mission.download_mission)
    assert [(i.command, i.x, i.y, i.z) for i in back] == [(i.command, i.x, i.y, i.z) for i in items]
    assert drone.mission.mission_progress().total == len(items)
    insisted(drone.action.arm)
    insisted(drone.mission.start_mission)
    wait(lambda: drone.telemetry.flight_mode() is FlightMode.MISSION)
    wait(lambda: drone.mission.mission_progress().current >= 3)
    insisted(drone.mission.pause_mission)
    wait(lambda: drone.telemetry.flight_mode() is FlightMode.HOLD)
    insisted(drone.mission.start_mission)
    wait(lambda: drone.telemetry.flight_mode() is FlightMode.RETURN_TO_LAUNCH)
    wait(lambda: not drone.telemetry.armed())
    assert drone.from_home_m < 1.0
    insisted(drone.mission.clear_mission)
    assert insisted(drone.mission.download_mission) == []


def test_return_to_launch_lands_at_home(drone):
    drone.airborne()
    insisted(drone.action.return_to_launch)
    wait(lambda: not drone.telemetry.armed())
    assert drone.from_home_m < 1.0


def test_orbit_goes_round_until_it_is_told_otherwise(drone):
    drone.airborne(10.0)
    home = drone.telemetry.home()
    centre_deg = home.latitude_deg + 20.0 / DEGREE_M
    altitude_m = home.absolute_altitude_m + 12.0
    insisted(
        drone.action.do_orbit,
        10.0,
        3.0,
        OrbitYawBehavior.HOLD_FRONT_TO_CIRCLE_CENTER,
        centre_deg,
        home.longitude_deg,
        altitude_m,
    )

    def round_it():
        here = drone.telemetry.position()
        north_m = (here.latitude_deg - centre_deg) * DEGREE_M
        east_m = (here.longitude_deg - home.longitude_deg) * DEGREE_M * math.cos(math.radians(LAT_DEG))
        return math.degrees(math.atan2(east_m, north_m)), math.hypot(north_m, east_m)

    for bearing_deg in (-90.0, 0.0, 90.0):  # it comes from the south and goes clockwise
        wait(lambda bearing_deg=bearing_deg: abs(round_it()[0] - bearing_deg) < 15.0)
        assert round_it()[1] == pytest.approx(10.0, abs=1.5)
    assert drone.height_m == pytest.approx(12.0, abs=1.0)
    velocity = drone.telemetry.velocity_ned()
    assert math.hypot(velocity.north_m_s, velocity.east_m_s) == pytest.approx(3.0, abs=0.5)
    insisted(drone.action.hold)
    wait(lambda: drone.telemetry.flight_mode() is FlightMode.HOLD)


def test_an_orbit_on_the_ground_is_refused(drone):
    drone.landed()
    with pytest.raises(ActionError):
        insisted(
            drone.action.do_orbit, 10.0, 3.0, OrbitYawBehavior.HOLD_INITIAL_HEADING, LAT_DEG, LON_DEG, 200.0
        )


def test_a_current_speed_holds_for_the_way_there(drone):
    drone.airborne(8.0)
    home = drone.telemetry.home()
    insisted(drone.action.set_current_speed, 2.0)
    lat_deg = home.latitude_deg + 300.0 / DEGREE_M
    insisted(drone.action.goto_location, lat_deg, home.longitude_deg, home.absolute_altitude_m + 8.0, 0.0)
    wait(lambda: drone.telemetry.velocity_ned().north_m_s > 1.8)
    time.sleep(0.5)
    assert drone.telemetry.velocity_ned().north_m_s == pytest.approx(2.0, abs=0.3)
    insisted(drone.action.hold)


def test_offboard_by_attitude_and_by_body_rates(drone):
    drone.airborne(12.0)
    drone.offboard.set_attitude(Attitude(0.0, -5.0, 0.0, 0.5))
    insisted(drone.offboard.start)
    wait(lambda: drone.telemetry.attitude_euler().pitch_deg < -4.0)
    wait(lambda: drone.telemetry.velocity_ned().north_m_s > 1.0)
    drone.offboard.set_attitude_rate(AttitudeRate(0.0, 0.0, 30.0, 0.5))
    wait(lambda: abs(drone.telemetry.attitude_angular_velocity_body().yaw_rad_s - 0.52) < 0.15)
    insisted(drone.offboard.stop)
    wait(lambda: drone.telemetry.flight_mode() is FlightMode.HOLD)


def test_a_simple_mission_goes_up_and_is_flown_to_its_end(drone):
    drone.landed()
    nan, home = math.nan, drone.telemetry.home()
    items = [
        PlanItem(
            home.latitude_deg + north_m / DEGREE_M, home.longitude_deg, 8.0, 5.0, True, nan, nan,
            PlanItem.CameraAction.NONE, nan, nan, 1.5, nan, nan, PlanItem.VehicleAction.NONE,
        )
        for north_m in (6.0, 12.0, 18.0)
    ]  # fmt: skip
    drone.plan.set_return_to_launch_after_mission(True)
    insisted(drone.plan.upload_mission, MissionPlan(items))
    assert len(insisted(drone.plan.download_mission).mission_items) == 3
    insisted(drone.action.arm)
    insisted(drone.plan.start_mission)
    wait(lambda: drone.plan.mission_progress().current >= 2)
    wait(drone.plan.is_mission_finished)
    wait(lambda: not drone.telemetry.armed())
    assert drone.from_home_m < 1.0
    insisted(drone.plan.clear_mission)


def test_a_joystick_flies_the_position_mode(drone):
    drone.airborne(8.0)
    with pytest.raises(ManualControlError) as error:
        drone.joystick.start_position_control()
    assert error.value.result is ManualControlResult.INPUT_NOT_SET
    insisted(drone.param.set_param_float, "COM_RC_LOSS_T", 3.0)
    begin_m = drone.ned_m

    def pushed(forward, holds):
        """Whether it holds with the stick there."""
        drone.joystick.set_manual_control_input(forward, 0.0, 0.5, 0.0)
        return holds()

    assert pushed(0.0, lambda: True)
    insisted(drone.joystick.start_position_control)
    wait(lambda: pushed(0.3, lambda: math.dist(drone.ned_m, begin_m) > 10.0))
    wait(lambda: pushed(0.0, lambda: math.hypot(*drone.speeds_mps) < 0.1))
    wait(lambda: pushed(0.0, lambda: drone.telemetry.flight_mode() is FlightMode.POSCTL))
    wait(lambda: drone.telemetry.flight_mode() is FlightMode.RETURN_TO_LAUNCH)  # the hands are off


def takes_failures(drone):
    try:
        drone.failure.inject(FailureUnit.SENSOR_GPS, FailureType.OFF, 0)
    except FailureError as error:
        assert error.result in (FailureResult.DISABLED, FailureResult.TIMEOUT)
        return False
    return True


def test_failures_are_disabled_until_the_parameter_says_otherwise(drone):
    with pytest.raises(FailureError) as error:
        insisted(drone.failure.inject, FailureUnit.SENSOR_GPS, FailureType.OFF, 0)
    assert error.value.result is FailureResult.DISABLED
    insisted(drone.param.set_param_int, "SYS_FAILURE_EN", 1)
    wait(lambda: takes_failures(drone))  # the failure plugin hears of it by the echo
    wait(lambda: not drone.telemetry.health().is_global_position_ok)
    insisted(drone.failure.inject, FailureUnit.SENSOR_GPS, FailureType.OK, 0)
    wait(drone.telemetry.health_all_ok)
    with pytest.raises(FailureError) as error:
        insisted(drone.failure.inject, FailureUnit.SENSOR_BARO, FailureType.SLOW, 0)
    assert error.value.result is FailureResult.UNSUPPORTED
    insisted(drone.param.set_param_int, "SYS_FAILURE_EN", 0)
