"""What is asked of the vehicle in each state of the course, and when the state counts as done."""

from __future__ import annotations

import math
from collections.abc import Callable

from mavspiral.errors import LimitError, LinkError
from mavspiral.flight.checks import (
    check_before_arming,
    endurance,
    height_of_home,
    other_copters,
    position_rate,
)
from mavspiral.flight.follower import Follower
from mavspiral.flight.messages import Command, MessageId
from mavspiral.flight.origin import origin_from_pair
from mavspiral.flight.profile import Mode, Profile
from mavspiral.flight.reference import Reference
from mavspiral.flight.situation import Situation
from mavspiral.frames import GeoPoint

__all__ = [
    "armed",
    "ask_arm",
    "ask_mode",
    "ask_origin",
    "ask_parameters",
    "ask_takeoff",
    "ask_telemetry",
    "ask_version",
    "at_height",
    "checked",
    "consented",
    "disarmed",
    "finished",
    "follows",
    "handed_over",
    "heard",
    "identified",
    "never",
    "origin_known",
    "prestreamed",
    "routed",
    "stands",
    "telemetry_flows",
]

# An unknown name is met with silence; a slow vehicle is waited for as long as one more comes.
_PARAMETERS_S = 4.0
_PAIR_AFTER_S = 3.0
_HOVER_MPS = 0.5
_ELSEWHERE_M = 10_000.0


def never(_: Situation) -> bool:
    """False: only the user ends this state."""
    return False


def heard(s: Situation) -> bool:
    """Whether the vehicle has been heard."""
    return s.link.vehicle is not None


def identified(s: Situation) -> bool:
    """Whether it has told its version."""
    if s.vehicle.version is None:
        return False
    s.profile = s.profile.of_version(s.vehicle.version.version)
    s.tell("info", f"{s.profile.name} {s.vehicle.version.version}")
    planned_for = s.config.planned_for
    if planned_for is not None and planned_for != s.profile.name:
        s.tell(
            "warning", f"the mission was planned for {planned_for}; this is {s.profile.name}, flown as such"
        )
    return True


def ask_version(s: Situation) -> bytes:
    """Ask which version it flies."""
    return s.link.command(Command.REQUEST_MESSAGE, MessageId.AUTOPILOT_VERSION)


def telemetry_flows(s: Situation) -> bool:
    """Whether the streams are as they were asked for."""
    return s.telemetry.settled and s.vehicle.local is not None


def ask_telemetry(s: Situation) -> bytes:
    """Ask for the streams that we need and against all others."""
    return b"".join(s.telemetry.ask(s.now_us, s.link.arrivals, s.link.command))


def origin_known(s: Situation) -> bool:
    """Whether its local origin is known: told by itself, or after a while worked out."""
    vehicle = s.vehicle
    if vehicle.local is None:
        if s.elapsed_s > _PAIR_AFTER_S:
            s.tell_once("warning", "waiting: the vehicle does not know where it is yet; has its GPS a fix?")
        return False
    if vehicle.origin is None and s.elapsed_s > _PAIR_AFTER_S and vehicle.place is not None:
        vehicle.origin = origin_from_pair(vehicle.place, vehicle.local)
    return vehicle.origin is not None


def ask_origin(s: Situation) -> bytes:
    """Ask for its local origin, and after a while for the pair that tells it too."""
    asked = s.link.command(Command.REQUEST_MESSAGE, MessageId.GPS_GLOBAL_ORIGIN)
    if s.elapsed_s > _PAIR_AFTER_S - 1:
        asked += s.link.command(Command.REQUEST_MESSAGE, MessageId.GLOBAL_POSITION_INT)
    return asked


def routed(s: Situation) -> bool:
    """True once the trajectory from where it stands is known in its own frame.

    Raises:
        LimitError: it stands somewhere else altogether.
    """
    assert s.vehicle.origin is not None
    s.origin = s.vehicle.origin
    s.to_vehicle = s.frame.to_vehicle(GeoPoint(*s.origin))
    home_enu_m = s.to_vehicle.position_enu_m(s.vehicle.position_ned_m)
    if (away_m := float(math.hypot(*home_enu_m[:2]))) > _ELSEWHERE_M:
        raise LimitError(
            f"the vehicle says that it is {away_m / 1000:.0f} km away from the building: the wrong mission, or a wrong position"
        )
    s.trajectory = s.route(home_enu_m)
    east_m, north_m, up_m = s.trajectory.legs[0].path(0.0).tolist()
    s.begins_enu_m = east_m, north_m, up_m
    s.leg_begins_s = tuple(s.trajectory.span_s(leg.name)[0] for leg in s.trajectory.legs)
    s.inspection_ends_s = s.trajectory.span_s("inspection")[1]
    s.reference = Reference.of(s.trajectory, s.to_vehicle)
    # Compiled, or loaded, on the ground: in the air it would be late.
    Follower(s.reference, s.config.governor, 0.0).advance(0.0, longest_s=0.0, hold=True)
    # Rounded: -0.0 is on neither side.
    east_m, north_m, up_m = (round(float(metres), 1) + 0.0 for metres in home_enu_m)
    side = "below the building's ground" if up_m < 0.0 else "above ground"
    across, along = "east" if east_m >= 0.0 else "west", "north" if north_m >= 0.0 else "south"
    where = f"home is {abs(east_m):.1f} m {across} and {abs(north_m):.1f} m {along} of the plan's origin, {abs(up_m):.1f} m {side}"
    s.tell_once("info", f"{where}; the flight takes {s.trajectory.duration_s:.0f} s")
    return True


def checked(s: Situation) -> bool:
    """Whether the parameters are read and nothing stands against the flight.

    Raises:
        LimitError: something does.
        LinkError: it answers nothing.
    """
    missing = [name for name in s.profile.parameters if name not in s.vehicle.parameters]
    quiet_s = (s.now_us - max(s.entered_us, s.parameter_us)) * 1e-6
    if missing and quiet_s < _PARAMETERS_S:
        return False
    if not (s.vehicle.results or s.vehicle.parameters or s.vehicle.version):
        raise LinkError(
            "the vehicle speaks, and answers nothing that it is asked: it does not hear us, or obeys nobody who speaks MAVLink 2. "
            "Fix: a link that carries both ways, and MAVLink 2 on it (MAV_PROTO_VER, SERIALn_PROTOCOL = 2)"
        )
    assert s.trajectory is not None and s.reference is not None and s.to_vehicle is not None
    findings = check_before_arming(
        s.vehicle,
        s.profile,
        s.reference.extremes(),
        battery_min_pct=s.config.battery_min_pct,
        safe_return_m=s.safe_return_m,
        sets_failsafes=s.config.set_failsafes,
    )
    findings += position_rate(s.clock.interval_s)
    findings += endurance(s.trajectory.duration_s, s.config.endurance_s)
    if not s.vehicle.flying:
        home_up_m = float(s.to_vehicle.position_enu_m(s.vehicle.position_ned_m)[2])
        findings += height_of_home(home_up_m, s.config.home_height_enu_m)
    if s.config.system_id is None:
        findings += other_copters(s.link.vehicle, s.link.others.values())
    for severity, text in findings:
        if severity != "error":
            s.tell_once(severity, text)
    errors = [text for severity, text in findings if severity == "error"]
    if errors:
        raise LimitError("; ".join(errors))
    return True


def ask_parameters(s: Situation) -> bytes:
    """Ask for the parameters that have not come yet."""
    missing = (name for name in s.profile.parameters if name not in s.vehicle.parameters)
    return b"".join(s.link.parameter_request(name) for name in missing)


def consented(s: Situation) -> bool:
    """Whether the user has agreed to the flight."""
    return s.consented


def handed_over(s: Situation) -> bool:
    """Whether it holds by itself."""
    return s.vehicle.mode == s.profile.hold.custom_mode


def armed(s: Situation) -> bool:
    """Whether it is armed."""
    return s.vehicle.armed


def ask_arm(s: Situation) -> bytes:
    """Ask it to arm, in the mode that this takes."""
    arm_in = s.profile.arm_in
    if arm_in is None and s.vehicle.mode == s.profile.follow.custom_mode:
        # It landed by its failsafe, is in that mode still, and will not arm in it.
        arm_in = s.profile.climb[-1]
    if arm_in is not None and s.vehicle.mode != arm_in.custom_mode:
        return s.link.command(Command.DO_SET_MODE, *arm_in.command)
    return s.link.command(Command.COMPONENT_ARM_DISARM, 1.0)


def at_height(s: Situation) -> bool:
    """Whether it hovers at the height of the first point; or above it, as where its own least height of a take-off is more.

    Raises:
        LimitError: it does, but too far away from it.
    """
    assert s.reference is not None
    here, first = s.vehicle.position_ned_m, s.reference.at(0.0).position_ned_m
    if (
        math.hypot(*s.vehicle.velocity_ned_mps) > _HOVER_MPS
        or here[2] - first[2] > s.profile.takeoff_within_m
    ):
        return False
    if (off_m := math.dist(here, first)) > s.config.join_max_m:
        raise LimitError(f"it hovers {off_m:.1f} m from the first point, more than {s.config.join_max_m:g} m")
    return True


def ask_takeoff(s: Situation) -> bytes:
    """Ask it to climb to the first point's height, unless it already does."""
    mode = s.profile.takeoff_mode
    if s.vehicle.flying or (mode is not None and s.vehicle.mode == mode.custom_mode):
        return b""
    if s.profile.takeoff_from_home and s.vehicle.home is None:
        return s.link.command(Command.REQUEST_MESSAGE, MessageId.HOME_POSITION)
    assert s.trajectory is not None and s.reference is not None
    first_enu_m = s.trajectory(0.0).position_enu_m
    alt_amsl_m = s.frame.geo_point(first_enu_m).alt_amsl_m
    home = s.vehicle.home
    height_home_m = math.nan if home is None else alt_amsl_m - home.alt_amsl_m
    return s.link.command(Command.NAV_TAKEOFF, *s.profile.takeoff_params(alt_amsl_m, height_home_m))


def prestreamed(s: Situation) -> bool:
    """Whether it has seen setpoints for long enough."""
    return s.elapsed_s >= s.profile.pre_stream_s


def ask_mode(mode: Callable[[Profile], Mode]) -> Callable[[Situation], bytes]:
    """What asks for `mode` as long as the vehicle is in another."""

    def ask(s: Situation) -> bytes:
        wanted = mode(s.profile)
        if s.vehicle.mode == wanted.custom_mode:
            return b""
        return s.link.command(Command.DO_SET_MODE, *wanted.command)

    return ask


def follows(s: Situation) -> bool:
    """Whether it follows our setpoints."""
    return s.vehicle.mode == s.profile.follow.custom_mode


def stands(s: Situation) -> bool:
    """Whether the setpoint has come to rest."""
    return s.follower is None or s.follower.pace.rate == 0.0


def finished(s: Situation) -> bool:
    """Whether path time has reached the end."""
    return s.follower is not None and s.follower.finished


def disarmed(s: Situation) -> bool:
    """Whether it is disarmed, and that not because it has just begun anew."""
    return not s.vehicle.armed and not s.clock.jumps
