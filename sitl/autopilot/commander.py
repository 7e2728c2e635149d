"""The commander: decides what the vehicle does, from orders, setpoints and its own condition.

Pure logic on values, after PX4 v1.17 as it was seen to behave without a radio control. What it makes of orders is in
`commander_orders`, what the modes do in the table of `modes`, what it does by itself in need in `failsafe`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from sitl.autopilot.arming import home_in, home_of, idle_limit_us, is_ready
from sitl.autopilot.commander_orders import carry_out, may_fly, remark, stand_down
from sitl.autopilot.errands import orbit_run
from sitl.autopilot.failsafe import change_conduct, descent, watch_charge
from sitl.autopilot.geofence import TERMINATE, watch_geofence
from sitl.autopilot.memory import NOTHING, CommanderState, notify
from sitl.autopilot.offboard import commands_every_axis, lost_us
from sitl.autopilot.pilot import Pilot
from sitl.autopilot.progress import proceed
from sitl.autopilot.shooting import shoot
from sitl.autopilot.upset import ends_flight, leaning_axis, watch_attitude
from sitl.clock import FRAME_S
from sitl.condition import Condition
from sitl.orders import Mode, Order, Verdict
from sitl.signals import Demand, Setpoint, Sticks
from sitl.status import FlightStatus, Landed, Severity

__all__ = ["Commander", "CommanderState"]

_DISARMED = Demand(armed=False, idle=True, setpoint=NOTHING)
_IDLE = Demand(armed=True, idle=True, setpoint=NOTHING)
_LOOK_US = 100_000
_WITH_JOYSTICK = (1, 2, 3)
"""COM_RC_IN_MODE where MANUAL_CONTROL counts. 1, joystick only, is PX4's SITL's own."""
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
        return carry_out(self._state, order, condition, self.parameters, lost_us=self._lost_us)

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

    def hear_sticks(self, sticks: Sticks, now_us: int) -> None:
        """Take a pilot's sticks, as COM_RC_IN_MODE lets it: obeyed in POSITION only."""
        if self.parameters["COM_RC_IN_MODE"] in _WITH_JOYSTICK:
            self._state.sticks, self._state.sticks_at_us = sticks, now_us

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
            remark(state, condition, watch_geofence(state, condition, self.parameters))
            if state.outside and self.parameters["GF_ACTION"] == TERMINATE:
                stand_down(state, condition, "Disarmed by failsafe")
            if not state.armed:
                return _DISARMED
            remark(state, condition, watch_charge(state, condition, self.parameters))
        lost_us = self._lost_us(state.mode)
        streamed = now_us <= lost_us
        remark(state, condition, change_conduct(state, condition, self.parameters, streamed=streamed))
        if not may_fly(state, condition, self.parameters):
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

    def _lost_us(self, mode: Mode) -> float:
        """Until when what that mode follows counts as streamed, if no more comes: setpoints, or sticks."""
        if mode is Mode.OFFBOARD:
            limit_s = self.parameters["COM_OF_LOSS_T"] * self._loss_scale
            return lost_us(self._state.steered_at_us, limit_s)
        if mode is Mode.POSITION and self._state.sticks_at_us is not None:
            return lost_us(self._state.sticks_at_us, self.parameters["COM_RC_LOSS_T"] * self._loss_scale)
        return math.inf

    def _demanded(self, setpoint: Setpoint) -> Demand:
        """To fly that; the same demand for the same setpoint."""
        self._state.setpoint = setpoint
        if setpoint is not self._flying.setpoint:
            self._flying = Demand(True, False, setpoint)
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
            notify(self._state, condition, Severity.INFO, "Connection to ground station lost")

    def _watch_attitude(self, condition: Condition) -> None:
        """Tell of a vehicle that has tipped over, and stop it where PX4 does."""
        state = self._state
        text = watch_attitude(state, condition, self.parameters)
        if text:
            notify(state, condition, Severity.CRITICAL, text)
            notify(state, condition, Severity.CRITICAL, "Failsafe activated")
        if ends_flight(state, condition, self.parameters):
            stand_down(state, condition, "Disarmed by failsafe")

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
            stand_down(state, condition, f"Disarmed by {by}")
