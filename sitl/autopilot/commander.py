"""The commander: decides what the vehicle does, from orders, setpoints and its own condition.

Pure logic on values, after PX4 v1.17 as it was seen to behave without a radio control. What the modes do
is in the table of `modes`, what it does by itself in need in `failsafe`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

from sitl.autopilot.arming import home_in, home_of, idle_limit_us, is_ready, why_not_arm
from sitl.autopilot.charge import charge_of
from sitl.autopilot.errands import change_speed, circle, orbit_run, reposition, set_home
from sitl.autopilot.failsafe import change_conduct, descent, watch_charge
from sitl.autopilot.geofence import TERMINATE, watch_geofence
from sitl.autopilot.memory import NOTHING, CommanderState
from sitl.autopilot.modes import MODES, climbs
from sitl.autopilot.offboard import commands_every_axis, lost_us
from sitl.autopilot.pilot import Pilot
from sitl.autopilot.planning import leave_mission, shoot, stand_down_mission, take_plan
from sitl.autopilot.progress import proceed
from sitl.autopilot.upset import ends_flight, leaning_axis, watch_attitude
from sitl.clock import FRAME_S
from sitl.condition import Condition
from sitl.orders import (
    Arm,
    ChangeSpeed,
    Disarm,
    GoToItem,
    Mode,
    Orbit,
    Order,
    Pause,
    Reposition,
    SetHome,
    SetOutput,
    StartMission,
    SwitchMode,
    TakeOff,
    TakePlan,
    TurnTo,
    UsePayload,
    Verdict,
    WishMode,
)
from sitl.signals import Demand, Setpoint
from sitl.status import FlightStatus, Landed, Notice, Severity

__all__ = ["Commander", "CommanderState"]

_DISARMED = Demand(armed=False, idle=True, setpoint=NOTHING)
_IDLE = Demand(armed=True, idle=True, setpoint=NOTHING)
_LOOK_US = 100_000
_ALOFT = {Mode.TAKEOFF: Landed.TAKING_OFF, Mode.LAND: Landed.LANDING}


class Commander(Pilot[CommanderState]):
    """Takes orders and setpoints, and says frame by frame what the cascade shall do.

    `parameters` are PX4's, by name. `loss_scale` stretches COM_OF_LOSS_T, as PX4 does when it runs faster
    than real time.
    """

    def __init__(self, parameters: Mapping[str, float], loss_scale: float = 1.0) -> None:
        super().__init__(CommanderState())
        self.parameters = parameters
        self._loss_scale = loss_scale
        self._flying = Demand(armed=True, idle=False, setpoint=NOTHING)

    @property
    def mode(self) -> Mode:
        """What is really done now."""
        return self._state.conduct

    def obey(self, order: Order, condition: Condition) -> Verdict:
        """Carry out the order, or not."""
        self.holds_until_us = 0
        match order:
            case Arm(force):
                return self._arm(condition, force=force)
            case Disarm(force):
                return self._disarm(condition, force=force)
            case TakeOff(alt_amsl_m):
                self._state.takeoff_alt_amsl_m = alt_amsl_m
                return self._switch(Mode.TAKEOFF, condition)
            case SwitchMode(mode):
                self._state.takeoff_alt_amsl_m = math.nan
                return self._switch(mode, condition)
            case WishMode(name):
                return self._refuse_mode(name, condition)
            case Reposition():
                return reposition(
                    self._state, order, condition, self.parameters, flies=self._may_fly(condition)
                )
            case Orbit():
                verdict = circle(
                    self._state, order, condition, self.parameters, flies=self._may_fly(condition)
                )
                if verdict is not Verdict.ACCEPTED:
                    self._notify(condition, Severity.CRITICAL, "Orbit command rejected")
                return verdict
            case ChangeSpeed():
                return change_speed(self._state, order)
            case TakePlan():
                self._remark(condition, take_plan(self._state, order, condition, self.parameters))
                return Verdict.ACCEPTED
            case GoToItem(seq):
                return self._go_to(seq)
            case StartMission():
                return self._start_mission(condition)
            case UsePayload(item):
                if self._state.payload.is_busy_for(item):
                    return Verdict.NOT_NOW
                told = self._state.payload.told(item, self._state.home)
                self._state.payload = replace(told, paused=False)
                return Verdict.ACCEPTED
            case SetHome(point):
                return set_home(self._state, point, condition)
            case TurnTo() | SetOutput() | Pause():
                return Verdict.DENIED

    def steer(self, setpoint: Setpoint, condition: Condition) -> None:
        """Take an OFFBOARD setpoint: a proof of life in any mode, obeyed in OFFBOARD only.

        One that leaves an axis without any command stops the vehicle, which then waits for a better one.
        """
        state = self._state
        state.steered_at_us = condition.time_us
        if state.conduct is not Mode.OFFBOARD:
            return
        if commands_every_axis(setpoint):
            state.steering = setpoint
        elif state.steering is not None:
            state.steering = state.course = None
            self.holds_until_us = 0

    def hear_ground_station(self, now_us: int) -> None:
        """The ground station is there; when it is not any more, that is told and nothing else."""
        self._state.ground_heard_us = now_us

    def hear_of_origin(self, condition: Condition) -> None:
        """The estimate's frame has been moved: where home is in it."""
        self._state.home = home_in(condition, self._state.home)

    def command(self, condition: Condition) -> Demand:
        """What the cascade shall do until the next frame."""
        state, now_us = self._state, condition.time_us
        undisturbed = now_us < self.holds_until_us and condition.knows_position and not condition.on_ground
        if undisturbed and state.armed and state.steering is not None:
            return self._demanded(state.steering)
        self.holds_until_us = 0
        if state.home is None:
            state.home = home_of(condition) if is_ready(condition) else None
        if state.payload.is_waiting:
            shoot(state, condition)
        if now_us % _LOOK_US == 0:
            self._watch_ground_station(condition)
        if state.armed:
            self._watch_ground(condition)
        next_look_us = now_us - now_us % _LOOK_US + _LOOK_US
        if not state.armed:
            self.holds_until_us = 0 if self._is_expectant() else next_look_us
            return _DISARMED
        if now_us % _LOOK_US == 0:
            self._watch_attitude(condition)
            self._remark(condition, watch_geofence(state, condition, self.parameters))
            if state.outside and self.parameters["GF_ACTION"] == TERMINATE:
                self._stand_down(condition, "Disarmed by failsafe")
            if not state.armed:
                return _DISARMED
            self._remark(condition, watch_charge(state, condition, self.parameters))
        lost_us = self._lost_us()
        streamed = state.mode is not Mode.OFFBOARD or now_us <= lost_us
        self._remark(condition, change_conduct(state, condition, self.parameters, streamed=streamed))
        if not self._may_fly(condition):
            state.course = None
            return _IDLE
        conduct = state.conduct
        if conduct is Mode.LAND and not condition.knows_position:
            state.course = None
            return self._demanded(descent(self.parameters))
        if conduct is Mode.OFFBOARD and state.steering is not None:
            if not (condition.on_ground or self._is_expectant()):
                self.holds_until_us = min(int(lost_us), next_look_us)
            return self._demanded(state.steering)
        return self._demanded(proceed(state, condition, FRAME_S, self.parameters))

    def status(self, condition: Condition) -> FlightStatus:
        """What the commander says of itself."""
        state = self._state
        aloft = _ALOFT.get(state.conduct, Landed.IN_AIR)
        return FlightStatus(
            armed=state.armed,
            mode=state.conduct,
            landed=Landed.ON_GROUND if condition.on_ground else aloft,
            ready=is_ready(condition)
            and not (state.upset if state.armed else leaning_axis(condition, self.parameters)),
            failsafe=state.failsafe is not None or state.upset,
            home=state.home,
            setpoint=state.setpoint,
            plans=state.plans,
            run=state.run,
            mission_ok=state.mission_ok,
            orbit=orbit_run(state, condition),
            payload=state.payload.status,
        )

    def _arm(self, condition: Condition, *, force: bool) -> Verdict:
        state = self._state
        if state.armed:
            return Verdict.ACCEPTED
        if not force:
            axis = leaning_axis(condition, self.parameters)
            if axis:
                self._notify(condition, Severity.CRITICAL, f"Preflight Fail: Attitude failure ({axis})")
                return Verdict.NOT_NOW
            streamed = condition.time_us <= self._lost_us()
            reason = why_not_arm(condition, state.mode, streamed=streamed, mission_ok=state.mission_ok)
            if reason is not None:
                self._notify(condition, Severity.CRITICAL, f"Arming denied: {reason}")
                return Verdict.NOT_NOW
        state.armed, state.armed_at_us = True, condition.time_us
        state.flown, state.standing_since_us, state.failsafe = False, None, None
        state.charge, state.for_need = charge_of(condition.charge_left, self.parameters), None
        state.course = None
        if not state.home_locked:
            state.home = home_of(condition) or state.home
        self._notify(condition, Severity.INFO, "Armed by external command")
        return Verdict.ACCEPTED

    def _disarm(self, condition: Condition, *, force: bool) -> Verdict:
        if not self._state.armed:
            return Verdict.ACCEPTED
        if not (condition.on_ground or force):
            self._notify(condition, Severity.CRITICAL, "Disarming denied: not landed")
            return Verdict.NOT_NOW
        self._stand_down(condition, "Disarmed by external command")
        return Verdict.ACCEPTED

    def _stand_down(self, condition: Condition, text: str) -> None:
        state = self._state
        state.armed, state.failsafe, state.for_need, state.steering = False, None, None, None
        state.outside = False
        state.course, state.leaning_since_us, state.upset = None, None, False
        state.setpoint = NOTHING
        stand_down_mission(state)
        state.mode = MODES[state.mode].after_disarm or state.mode
        self._notify(condition, Severity.INFO, text)

    def _switch(self, mode: Mode, condition: Condition) -> Verdict:
        state = self._state
        row = MODES[mode]
        lost = mode is Mode.OFFBOARD and condition.time_us > self._lost_us()
        homeless = row.needs_home and state.home is None
        # Disarmed, PX4 takes any mode, and then will not arm.
        if state.armed and (lost or homeless or (row.needs_mission and not state.mission_ok)):
            return self._refuse_mode(mode.name.capitalize(), condition)
        if mode is not Mode.MISSION:
            leave_mission(state)
        if state.conduct is not mode or mode is Mode.TAKEOFF:
            state.steering = state.course = None
        state.mode, state.failsafe, state.for_need, state.speed_mps = mode, None, None, math.nan
        return Verdict.ACCEPTED

    def _refuse_mode(self, name: str, condition: Condition) -> Verdict:
        text = f"Switching to mode '{name}' is currently not available"
        self._notify(condition, Severity.CRITICAL, text)
        return Verdict.NOT_NOW

    def _start_mission(self, condition: Condition) -> Verdict:
        if not self._state.mission_ok:
            self._notify(condition, Severity.CRITICAL, "Mission start denied! No valid mission")
            return Verdict.DENIED
        verdict = self._switch(Mode.MISSION, condition)
        return self._arm(condition, force=False) if verdict is Verdict.ACCEPTED else verdict

    def _go_to(self, seq: int) -> Verdict:
        state = self._state
        if not 0 <= seq < len(state.plans.mission):
            return Verdict.DENIED
        state.run = replace(state.run, seq=seq, finished=False)
        if state.conduct is Mode.MISSION:
            state.course = None
        return Verdict.ACCEPTED

    def _lost_us(self) -> float:
        """Until when setpoints count as streamed, if no more come."""
        limit_s = self.parameters["COM_OF_LOSS_T"] * self._loss_scale
        return lost_us(self._state.steered_at_us, limit_s)

    def _demanded(self, setpoint: Setpoint) -> Demand:
        """To fly that; the same demand for the same setpoint."""
        self._state.setpoint = setpoint
        if setpoint is not self._flying.setpoint:
            self._flying = Demand(armed=True, idle=False, setpoint=setpoint)
        return self._flying

    def _is_expectant(self) -> bool:
        """Whether something beside setpoints and battery may change within frames."""
        state = self._state
        waits = state.home is None or state.payload.is_waiting or state.for_need is not None
        return waits or self.has_news

    def _watch_ground_station(self, condition: Condition) -> None:
        heard_us, limit_s = self._state.ground_heard_us, self.parameters["COM_DL_LOSS_T"]
        if heard_us is not None and condition.time_us - heard_us > 1e6 * limit_s:
            self._state.ground_heard_us = None
            self._notify(condition, Severity.INFO, "Connection to ground station lost")

    def _watch_attitude(self, condition: Condition) -> None:
        """Tell of a vehicle that has tipped over, and stop it where PX4 does."""
        text = watch_attitude(self._state, condition, self.parameters)
        if text:
            self._notify(condition, Severity.CRITICAL, text)
            self._notify(condition, Severity.CRITICAL, "Failsafe activated")
        if ends_flight(self._state, condition, self.parameters):
            self._stand_down(condition, "Disarmed by failsafe")

    def _watch_ground(self, condition: Condition) -> None:
        """Disarm who does not take off, and who has landed."""
        state, now_us = self._state, condition.time_us
        if not condition.on_ground:
            state.flown, state.standing_since_us = True, None
            return
        if state.standing_since_us is None:
            state.standing_since_us = now_us
        limit_us = idle_limit_us(self.parameters, flown=state.flown)
        if limit_us is not None and now_us - state.standing_since_us >= limit_us:
            by = "landing" if state.flown else "auto preflight disarming"
            self._stand_down(condition, f"Disarmed by {by}")

    def _may_fly(self, condition: Condition) -> bool:
        """Whether the motors may do more than idle."""
        state = self._state
        if not condition.on_ground:
            return True
        if not MODES[state.conduct].leaves_ground:
            return False
        if state.conduct is Mode.TAKEOFF and not climbs(condition, state.takeoff_alt_amsl_m):
            return False
        spooled_us = state.armed_at_us + 1e6 * self.parameters["COM_SPOOLUP_TIME"]
        return state.flown or condition.time_us >= spooled_us

    def _remark(self, condition: Condition, remarks: Iterable[tuple[Severity, str]]) -> None:
        for severity, text in remarks:
            self._notify(condition, severity, text)

    def _notify(self, condition: Condition, severity: Severity, text: str) -> None:
        self._state.notices = (*self._state.notices, Notice(condition.time_us, severity, text))
