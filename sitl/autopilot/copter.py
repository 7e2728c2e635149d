"""ArduCopter's commander: decides what the vehicle does, from orders, targets and its own condition.

Pure logic on values, after ArduCopter 4.6.3 as it was seen to behave without a radio control. What the modes do is
in the table of `copter_modes`. What it does by itself in need is in `copter_failsafe` and `copter_fence`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from sitl.autopilot.angled import Angled
from sitl.autopilot.arming import home_of, is_ready
from sitl.autopilot.auto import Auto, begin_auto
from sitl.autopilot.auto_items import AutoItem, navigates
from sitl.autopilot.circle import Circle, begin_circle
from sitl.autopilot.copter_failsafe import LOOK_US, watch
from sitl.autopilot.copter_fence import watch_fence
from sitl.autopilot.copter_memory import (
    PLACE_US,
    PREARM_US,
    CopterState,
    knows_place,
    stand_down,
    sticks_of,
)
from sitl.autopilot.copter_modes import COPTER_MODES
from sitl.autopilot.copter_orders import carry_out, steer
from sitl.autopilot.fence import fence_parts
from sitl.autopilot.glide import start_glide
from sitl.autopilot.guided import Guided, begin_guided
from sitl.autopilot.hands import Led, led
from sitl.autopilot.memory import NOTHING, notify
from sitl.autopilot.pilot import Pilot
from sitl.autopilot.shooting import shoot
from sitl.autopilot.smart import fly_back
from sitl.autopilot.trip import Trip
from sitl.clock import FRAME_S
from sitl.condition import Condition
from sitl.orders import Mode, Order, SetHome, SetOutput, Verdict
from sitl.plans import MissionRun, PlanItem
from sitl.signals import Demand, GeoPoint, Setpoint
from sitl.status import FenceStatus, FlightStatus, Landed, Severity

__all__ = ["Copter"]

_YAW_DROOP = 0.1
"""What ArduCopter's yaw rate loop leaves undone, by gains of little integral: 0.37° behind was seen at 17°/s."""
_SPOOL_US = 1_000_000
_CRAWL_MPS, _STILL_MPS, _TOUCH_US = 0.27, 0.25, 333_000
"""A landing that wants to sink faster than the first and does not sink by the second has its feet on the ground."""
_DISARMED = Demand(armed=False, idle=True, setpoint=NOTHING)
_IDLE = Demand(armed=True, idle=True, setpoint=NOTHING)


class Copter(Pilot[CopterState]):
    """Takes orders and targets, and says frame by frame what the cascade shall do. `parameters` are ArduPilot's."""

    def __init__(self, parameters: Mapping[str, float]) -> None:
        super().__init__(CopterState())
        self.parameters = parameters

    @property
    def mode(self) -> Mode:
        """What is done now."""
        return self._state.mode

    def obey(self, order: Order, condition: Condition) -> Verdict:
        """Carry out the order, or not."""
        self.holds_until_us = 0
        return carry_out(self._state, order, condition, self.parameters)

    def steer(self, setpoint: Setpoint, condition: Condition) -> None:
        """Take a target: obeyed in GUIDED only, when armed. It ends a take-off."""
        steer(self._state, setpoint, condition, self.parameters)

    def hear_ground_station(self, now_us: int) -> None:
        """A heartbeat of the ground station that FS_GCS_ENABLE watches."""
        self._state.gcs_heard_us = now_us

    def hear_channels(self, pulses_us: Mapping[int, int], now_us: int) -> None:
        """Take what a ground station puts on a radio's channels; 0 lets go of one."""
        self._state.radio = self._state.radio.told(pulses_us, now_us)

    def command(self, condition: Condition) -> Demand:
        """What the cascade shall do until the next frame."""
        state, now_us = self._state, condition.time_us
        if self.onward is not None and now_us < self.holds_until_us and not condition.on_ground:
            return self.onward(now_us)
        next_look_us = now_us - now_us % LOOK_US + LOOK_US
        self.holds_until_us, self.onward = 0, None
        if not state.told_place and knows_place(condition):
            state.told_place = True
            state.home = state.home or home_of(condition)
            notify(state, condition, Severity.INFO, "EKF3 IMU0 is using GPS")
        if state.payload.is_waiting:
            shoot(state, condition)
        if state.armed:
            self._watch_ground(condition)
            if now_us % LOOK_US == 0:
                self._look(condition)
        if not state.armed:
            self.holds_until_us = 0 if self._is_expectant(now_us) else next_look_us
            return _DISARMED
        if not self._may_fly(condition):
            if not isinstance(state.going, Guided):
                state.going = None
            return _IDLE
        demand = self._demanded(self._proceed(condition, FRAME_S))
        if self._touches(condition):
            return _IDLE
        streamed = isinstance(state.going, Guided) and state.going.trip is None
        if streamed and not (condition.on_ground or self._is_expectant(now_us)):
            self.holds_until_us, self.onward = next_look_us, self._guided_on
        return demand

    def status(self, condition: Condition) -> FlightStatus:
        """What the commander says of itself."""
        state, aloft = self._state, Landed.IN_AIR
        if isinstance(state.going, Guided) and state.going.trip is not None and not state.going.climbed:
            aloft = Landed.TAKING_OFF
        elif COPTER_MODES[state.mode].lands or (isinstance(state.going, Auto) and state.going.comes_down):
            aloft = Landed.LANDING
        return FlightStatus(
            armed=state.armed,
            mode=state.mode,
            landed=Landed.ON_GROUND if condition.on_ground else aloft,
            ready=condition.time_us >= PREARM_US and is_ready(condition),
            failsafe=state.alarms.any,
            home=state.home,
            setpoint=state.setpoint,
            plans=state.plans,
            run=state.run,
            mission_ok=navigates(state.plans.mission),
            knows_place=knows_place(condition),
            outputs=state.outputs,
            goal_ned_m=None if state.going is None else state.going.goal_ned_m,
            fence=FenceStatus(
                fence_parts(state, self.parameters),
                state.fence.breached,
                state.fence.count,
                state.fence.last,
                state.fence.time_us,
            ),
            channels=tuple(state.radio.pulses_us(condition.time_us, self.parameters).items()),
        )

    def _proceed(self, condition: Condition, dt_s: float) -> Setpoint:
        """The setpoint a frame further along what the mode does."""
        state, parameters = self._state, self.parameters
        going = self._begin(condition) if state.going is None else state.going
        sticks = sticks_of(state, condition.time_us, parameters)
        if sticks is not None:
            going = led(going, sticks, condition, leans=COPTER_MODES[state.mode].level)
        elif isinstance(going, Led):
            going = self._begin(condition)
        if isinstance(going, Auto):
            going = going.step(condition, dt_s, parameters, state.payload.bearing_rad(condition))
            state.run, state.speeds = going.run, going.speeds
            if going.deed is not None and going.deed.command == AutoItem.SET_HOME:
                going = self._moved_home(going, going.deed, condition)
            elif going.deed is not None and going.deed.command == AutoItem.SET_SERVO:
                self.obey(SetOutput(int(going.deed.params[0]), int(going.deed.params[1])), condition)
            elif going.deed is not None:
                state.payload = state.payload.told(going.deed, state.home)
        else:
            going = going.step(condition, dt_s, parameters, state.speeds)
        state.going = going
        setpoint = going.setpoint
        if (COPTER_MODES[state.mode].level or state.blind) and not isinstance(going, Led):
            return setpoint._replace(
                position_ned_m=(math.nan, math.nan, setpoint.position_ned_m[2]),
                velocity_ned_mps=(math.nan, math.nan, setpoint.velocity_ned_mps[2]),
                acceleration_ned_mps2=(0.0, 0.0, 0.0),
            )
        return setpoint

    def _guided_on(self, now_us: int) -> Demand:
        """The demand of the next frame while nothing happens: GUIDED's target moves by itself."""
        state = self._state
        assert isinstance(state.going, Guided)
        state.going = state.going.moved(now_us, FRAME_S, self.parameters, state.speeds)
        return self._demanded(state.going.setpoint)

    def _demanded(self, setpoint: Setpoint) -> Demand:
        self._state.setpoint = setpoint
        return Demand(armed=True, idle=False, setpoint=self._as_the_cascade_takes_it(setpoint))

    def _is_expectant(self, now_us: int) -> bool:
        """Whether something beside the target and what it looks for may change within frames."""
        state = self._state
        finds_place = not state.told_place and now_us >= PLACE_US
        return finds_place or state.payload.is_waiting or self.has_news

    def _moved_home(self, going: Auto, item: PlanItem, condition: Condition) -> Auto:
        """DO_SET_HOME in a mission: the heights that follow count from the new one."""
        state = self._state
        lat_deg, lon_deg, alt_m = item.params[4:]
        if item.is_relative and state.home is not None:
            alt_m += state.home.point.alt_amsl_m
        self.obey(SetHome(None if item.params[0] == 1.0 else GeoPoint(lat_deg, lon_deg, alt_m)), condition)
        return going if state.home is None else replace(going, home=state.home)

    def _as_the_cascade_takes_it(self, setpoint: Setpoint) -> Setpoint:
        """ArduPilot damps the speed's error where the cascade damps the speed: (1 + D)·a makes up for that. A lean has no speed."""
        leans = math.isnan(setpoint.velocity_ned_mps[0])
        gain = 1.0 if leans else 1.0 + self.parameters["PSC_VELXY_D"]
        north, east, down = setpoint.acceleration_ned_mps2
        return Setpoint(
            setpoint.position_ned_m,
            setpoint.velocity_ned_mps,
            (north * gain, east * gain, down),
            setpoint.yaw_ned_rad,
            setpoint.yaw_rate_ned_radps * (1.0 - _YAW_DROOP),
            setpoint.attitude,
        )

    def _begin(self, condition: Condition) -> Guided | Angled | Auto | Circle | Trip:
        state = self._state
        if state.mode is Mode.GUIDED:
            return begin_guided(condition)
        if state.mode is Mode.AUTO and state.home is not None and condition.origin is not None:
            state.payload = replace(state.payload, paused=False)
            if self.parameters["MIS_RESTART"] == 1.0:
                state.run = MissionRun()
            return begin_auto(
                state.plans.mission, state.run, condition, state.home, state.speeds, self.parameters
            )
        if state.mode is Mode.CIRCLE:
            return begin_circle(condition, self.parameters)
        if state.mode is Mode.SMARTRTL:
            return fly_back(start_glide(condition.estimate), state.home, state.trail, self.parameters)
        return COPTER_MODES[state.mode].trip(start_glide(condition.estimate), state.home, self.parameters)

    def _watch_ground(self, condition: Condition) -> None:
        """Disarm who has landed by itself, and who stands for DISARM_DELAY."""
        state, now_us = self._state, condition.time_us
        if not condition.on_ground:
            state.flown, state.standing_since_us = True, None
            return
        if state.standing_since_us is None:
            state.standing_since_us = now_us
        lands = COPTER_MODES[state.mode].lands or (isinstance(state.going, Auto) and state.going.comes_down)
        delay_s = self.parameters["DISARM_DELAY"]
        tired = delay_s > 0.0 and now_us - state.standing_since_us >= 1e6 * delay_s
        if tired or (lands and state.flown):
            stand_down(state, condition)

    def _touches(self, condition: Condition) -> bool:
        """Whether a landing has not got lower for a third of a second: who flies on with his feet down tips over in gusts."""
        state, setpoint = self._state, self._state.setpoint
        lands = math.isnan(setpoint.position_ned_m[2]) and setpoint.velocity_ned_mps[2] > _CRAWL_MPS
        if not lands or abs(float(condition.estimate.velocity_ned_mps[2])) > _STILL_MPS:
            state.touching_since_us = None
            return False
        if state.touching_since_us is None:
            state.touching_since_us = condition.time_us
        return condition.time_us - state.touching_since_us >= _TOUCH_US

    def _look(self, condition: Condition) -> None:
        """What may call for a failsafe, and the way back."""
        state, parameters = self._state, self.parameters
        watch(state, condition, parameters)
        if state.armed:
            watch_fence(state, condition, parameters)
        if state.armed and state.mode is not Mode.SMARTRTL and knows_place(condition):
            state.trail = state.trail.longer(condition, parameters)

    def _may_fly(self, condition: Condition) -> bool:
        """Whether the motors may do more than idle."""
        state = self._state
        if not condition.on_ground:
            return True
        if condition.time_us < state.armed_at_us + _SPOOL_US:
            return False
        if isinstance(state.going, Guided):
            return state.going.trip is not None
        if isinstance(state.going, Angled):
            return state.going.lifts(self.parameters)
        sticks = sticks_of(state, condition.time_us, self.parameters)
        if sticks is not None:
            return sticks.up > 0.0
        return state.mode is Mode.AUTO and state.auto_armed and not state.flown
