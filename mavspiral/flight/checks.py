"""May this vehicle fly this plan? Judged on the ground, from what it says about itself."""

from __future__ import annotations

import math
from collections.abc import Iterable

from mavspiral.flight.messages import Heartbeat
from mavspiral.flight.packing import SYSTEM_ID
from mavspiral.flight.profile import Profile
from mavspiral.flight.reference import Extremes
from mavspiral.flight.vehicle import Vehicle

__all__ = [
    "Finding",
    "check_before_arming",
    "endurance",
    "height_of_home",
    "loss_words",
    "other_copters",
    "parameter",
    "position_rate",
]

Finding = tuple[str, str]
"""Severity ("info", "warning" or "error") and the words."""

_SPEED_TOLERANCE = 1.01
_HASTY_S = 0.3  # a link's hiccup
_SELDOM_S = 0.3  # for so long path time runs on without a position (`streamer`)
_HEIGHT_DOUBTED_M, _HEIGHT_WRONG_M = 5.0, 15.0
"""A receiver without RTK is some metres off in height; 15 m and more are another datum, or another place."""

_TOO_LONG = 1.1
"""Of the endurance: a home a little elsewhere than planned makes a sortie a little longer."""
_NONE = 8  # MAV_AUTOPILOT_INVALID


def check_before_arming(
    vehicle: Vehicle,
    profile: Profile,
    extremes: Extremes,
    *,
    battery_min_pct: float,
    safe_return_m: float,
    sets_failsafes: bool,
) -> list[Finding]:
    """What stands against the flight ("error") and what the pilot should know ("warning", "info" where nothing helps)."""
    findings = [
        *_state(vehicle, battery_min_pct),
        *_low_battery(vehicle, profile),
        *([] if profile.unguarded is None else [("info", profile.unguarded)]),
        *_speeds(vehicle, profile, extremes),
    ]
    if not sets_failsafes:
        findings += _loss(vehicle, profile)
        findings += _return(vehicle, profile, safe_return_m)
        findings += _pitfalls(vehicle, profile)
    return findings


def _state(vehicle: Vehicle, battery_min_pct: float) -> list[Finding]:
    findings: list[Finding] = []
    if vehicle.flying:
        findings.append(
            (
                "error",
                "the vehicle says that it is in the air, mavspiral starts from the ground: change its mode to RTL or LAND (`mode RTL` "
                "in MAVProxy, or the pilot's switch), wait until it has disarmed, and ask again",
            )
        )
    elif vehicle.armed:
        findings.append(
            ("error", "the vehicle is armed already; disarm it, mavspiral starts from the ground")
        )
    battery_pct = vehicle.status.battery_pct if vehicle.status else None
    if battery_pct is None:
        findings.append(("warning", "the vehicle does not tell its battery level"))
    elif battery_pct < battery_min_pct:
        findings.append(("error", f"battery at {battery_pct} %, below {battery_min_pct:g} %; charge it"))
    return findings


def _speeds(vehicle: Vehicle, profile: Profile, extremes: Extremes) -> list[Finding]:
    findings: list[Finding] = []
    wanted = (extremes.horizontal_mps, extremes.climb_mps, extremes.descent_mps)
    axes = ("horizontal speed", "climb", "descent")
    for name, axis, plan_mps in zip(profile.speed_parameters, axes, wanted, strict=True):
        allowed_mps = parameter(vehicle, profile, name)
        if allowed_mps is None:
            findings.append(
                ("warning", f"{name} could not be read; the plan's {axis} of {plan_mps:.1f} m/s is unchecked")
            )
        elif plan_mps > allowed_mps * _SPEED_TOLERANCE:
            words = f"the plan's {axis} reaches {plan_mps:.2f} m/s, {name} allows {allowed_mps:.2f}"
            findings.append(("error", f"{words}; plan it slower or raise {name}"))
    return findings + _acceleration(vehicle, profile, extremes)


def _acceleration(vehicle: Vehicle, profile: Profile, extremes: Extremes) -> list[Finding]:
    name, plan_mps2 = profile.acceleration_parameter, extremes.acceleration_mps2
    allowed_mps2 = None if name is None else parameter(vehicle, profile, name)
    if allowed_mps2 is None or plan_mps2 <= allowed_mps2 * _SPEED_TOLERANCE:
        return []
    words = f"the plan's acceleration reaches {plan_mps2:.2f} m/s², {name} allows {allowed_mps2:.2f}"
    return [("error", f"{words}; plan it gentler or raise {name}")]


def _loss(vehicle: Vehicle, profile: Profile) -> list[Finding]:
    findings: list[Finding] = []
    action = parameter(vehicle, profile, profile.loss_action)
    timeout_s = parameter(vehicle, profile, profile.loss_timeout)
    if action is None:
        findings.append(
            ("warning", f"{profile.loss_action} could not be read; what loss of the link does is unknown")
        )
    elif int(action) not in profile.safe_loss_actions:
        does = profile.loss_actions.get(int(action), f"action {int(action)}")
        safe = ", ".join(f"{code} {profile.loss_actions[code]}" for code in sorted(profile.safe_loss_actions))
        findings.append(
            ("warning", f"if the link is lost: {does} ({profile.loss_action} = {int(action)}); safer: {safe}")
        )
    if action and profile.loss_listens_to is not None:
        heard = parameter(vehicle, profile, profile.loss_listens_to)
        if heard is not None and int(heard) != SYSTEM_ID:
            words = f"{profile.loss_action} waits for the heartbeat of system {int(heard)}, and this is {SYSTEM_ID}"
            findings.append(("warning", f"{words}: the loss of this link alone goes unnoticed"))
    if timeout_s is not None and timeout_s < _HASTY_S:
        words = f"{profile.loss_timeout} = {timeout_s:g} s: a setpoint that is so late already counts as a lost link"
        findings.append(("warning", words))
    if timeout_s is not None and timeout_s > profile.long_loss_s:
        findings.append(
            (
                "warning",
                f"{profile.loss_timeout} = {timeout_s:g} s: so long it flies on blindly if the link is lost",
            )
        )
    return findings


def _return(vehicle: Vehicle, profile: Profile, safe_return_m: float) -> list[Finding]:
    height_m = parameter(vehicle, profile, profile.return_height)
    if height_m is None or height_m >= safe_return_m:
        return []
    words = (
        f"its own Return flies home at {height_m:.0f} m ({profile.return_height}), maybe through the building"
    )
    return [("warning", f"{words}; set it to {math.ceil(safe_return_m)} or more")]


def _low_battery(vehicle: Vehicle, profile: Profile) -> list[Finding]:
    if profile.low_battery is None:
        return []
    name, words = profile.low_battery
    acts = parameter(vehicle, profile, name)
    return [("info", f"{name} = {acts:g}: {words}")] if acts else []


def _pitfalls(vehicle: Vehicle, profile: Profile) -> list[Finding]:
    findings: list[Finding] = []
    for name, words in profile.pitfalls.items():
        value = vehicle.parameters.get(name)
        now = None if value is None else value.number(bytewise=profile.integers_bytewise)
        if now is not None and (wanted := profile.failsafes[name](now, 0.0)) != now:
            if name in profile.forbidding:
                findings.append(("error", f"{name} = {now:g}: {words}; set it to {wanted:g}"))
            else:
                findings.append(("warning", f"{name} = {now:g}: {words}; safer: {wanted:g}"))
    return findings


def position_rate(interval_s: float) -> list[Finding]:
    """That it tells too seldom where it is to be followed: path time stands whenever nobody knows."""
    if interval_s <= _SELDOM_S:
        return []
    words = f"its position comes every {interval_s:.2f} s, less often than every {_SELDOM_S:g} s"
    return [("error", f"{words}; raise LOCAL_POSITION_NED on this link, or take a faster link")]


def endurance(flight_s: float, endurance_s: float) -> list[Finding]:
    """That the flight from where it stands takes longer than a battery lasts."""
    if flight_s <= endurance_s:
        return []
    words = f"from here the flight takes {flight_s:.0f} s, and [vehicle] endurance_s = {endurance_s:g}: start nearer to the building"
    return [("error" if flight_s > _TOO_LONG * endurance_s else "warning", words)]


def height_of_home(is_m: float, planned_m: float) -> list[Finding]:
    """That it stands higher or lower than the mission says, both above the building's ground: so the building would be missed."""
    off_m = is_m - planned_m
    if not abs(off_m) > _HEIGHT_DOUBTED_M:
        return []
    high, low = ("above", "low") if off_m > 0.0 else ("below", "high")
    words = (
        f"it says that it stands {abs(off_m):.0f} m {high} where the mission has its home (home_height_m = {planned_m:g}): if "
        f"that is not so, all is flown {abs(off_m):.0f} m too {low}; mend ground_amsl_m or home_height_m, or its height above the sea"
    )
    return [("error" if abs(off_m) > _HEIGHT_WRONG_M else "warning", words)]


def other_copters(flown: tuple[int, int] | None, others: Iterable[Heartbeat]) -> list[Finding]:
    """That there are other copters beside system and component `flown`, which is the first that was heard: that by chance."""
    systems = sorted(beat.system_id for beat in others if beat.is_copter and beat.autopilot != _NONE)
    if not systems or flown is None:
        return []
    there = "another copter is" if len(systems) == 1 else "other copters are"
    words = (
        f"{there} on this link (system {', '.join(map(str, systems))}); this flight is system {flown[0]}'s"
    )
    return [("warning", f"{words}: if that is the wrong one, --system names the other")]


def loss_words(vehicle: Vehicle, profile: Profile) -> str:
    """What the vehicle does by itself without a link, as far as its parameters were read."""
    action = parameter(vehicle, profile, profile.loss_action)
    if action is None:
        return "what the vehicle does now is not known: look at it"
    does = profile.loss_actions.get(int(action), f"action {int(action)}")
    return f"the vehicle is on its own: {does} ({profile.loss_action} = {int(action)})"


def parameter(vehicle: Vehicle, profile: Profile, name: str) -> float | None:
    """What the vehicle said the parameter is, in SI units; None if it did not."""
    value = vehicle.parameters.get(name)
    if value is None:
        return None
    return value.number(bytewise=profile.integers_bytewise) * profile.parameter_units.get(name, 1.0)
