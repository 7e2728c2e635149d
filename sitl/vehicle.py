"""The vehicle: body, senses, estimator and cascade on one clock, without MAVLink and without modes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np

from sitl.airframe import RECEIVERS, Airframe, Receiver, Senses
from sitl.autopilot.cascade import new_mind, set_demand, set_gains
from sitl.clock import FRAME_US
from sitl.estimator.belief import BELIEF_N, believe
from sitl.estimator.ekf import Ekf
from sitl.estimator.strapdown import EKF2_HORIZON_FRAMES, new_nav, vibration
from sitl.faults import Fault
from sitl.geo import dipole_field
from sitl.kernels import prepared
from sitl.loop import BLOCK_FRAMES, BRAIN, NOISE, WORLD, live
from sitl.params import Params
from sitl.physics.battery import new_pack
from sitl.physics.dynamics import new_body, new_plant
from sitl.physics.sensors import BOOT_NORMALS, GPS_DELAY_FRAMES, measure_range, new_sensed
from sitl.rotation import from_euler
from sitl.signals import (
    BaroSample,
    Demand,
    Estimate,
    FloatArray,
    GeoPoint,
    GpsSample,
    ImuSample,
    MagSample,
    TruthState,
    vector,
)
from sitl.trouble import afflict, discharge

__all__ = ["BatteryState", "Vehicle", "VehicleConfig", "VehicleState"]


@dataclass(frozen=True, slots=True)
class VehicleConfig:
    """Everything that decides a flight besides the demands.

    It stands at `home` (which is truth's NED origin) with its nose at `heading_ned_rad`. The EKF's origin
    lies `origin_offset_ned_m` away from the first good fix. The wind is that at 20 ft (6.1 m) and grows with
    height; `gusts` adds Dryden turbulence to it. Without `noise` the senses tell the truth. `supposed` are
    the sheets by which the estimator judges its senses, where they are not the true ones. `stock_filter` flies
    filterpy's own arithmetic, `output_observer` has the output follow the filter as slowly as PX4's, from as far
    back. `params` are taken as they are: start them from `Params(airframe.params)`.
    """

    airframe: Airframe
    params: Params
    home: GeoPoint
    heading_ned_rad: float = 0.0
    seed: int = 0
    gps: Literal["rtk", "standard"] | Receiver = "rtk"
    wind_ned_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gusts: bool = False
    ground_down_m: float = 0.0
    origin_offset_ned_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    faults: tuple[Fault, ...] = ()
    noise: bool = True
    supposed: tuple[Senses, Receiver] | None = None
    stock_filter: bool = False
    output_observer: bool = False


class BatteryState(NamedTuple):
    """The pack as its monitor sees it."""

    voltage_v: float
    current_a: float
    used_ah: float
    remaining: float


@dataclass(frozen=True, slots=True, eq=False)
class VehicleState:
    """A vehicle's whole state, as a value: who gave it, or a twin by config, can take it back."""

    params: Params
    demand: Demand | None
    faults: tuple[Fault, ...]
    arrays: tuple[np.ndarray, ...]
    generators: tuple[Mapping[str, Any], ...]


def _frame_at(time_us: int) -> int:
    """The first frame that begins no earlier."""
    return -(-time_us // FRAME_US)


class Vehicle:
    """A quadrotor that flies itself to setpoints.

    Attributes:
        time_us: simulated time since the start.
        knows_position: whether position rests on fixes, or on fresh dead reckoning within COM_POS_FS_EPH (PX4's eph).
        on_ground: the land detector's verdict: from thrust, estimate and gyro, never from truth.
    """

    def __init__(self, config: VehicleConfig) -> None:
        self.config = config
        seeds = np.random.SeedSequence(config.seed).spawn(6)
        boot, *self._generators = (np.random.Generator(np.random.PCG64(seed)) for seed in seeds)
        field = dipole_field(config.home.lat_deg, config.home.lon_deg)
        self._receiver = RECEIVERS[config.gps] if isinstance(config.gps, str) else config.gps
        senses, receiver = config.airframe.senses, self._receiver
        self._world, self._brain, self._noise = np.zeros(1, WORLD), np.zeros(1, BRAIN), np.zeros(1, NOISE)
        world, brain = self._world, self._brain
        attitude = from_euler(0.0, 0.0, config.heading_ned_rad)
        world["body"] = new_body(attitude, (0.0, 0.0, config.ground_down_m))
        world["plant"] = new_plant(config.airframe, config.ground_down_m)
        world["pack"] = new_pack(config.airframe)
        world["sensed"] = new_sensed(
            senses, receiver, config.home, field, boot.standard_normal(BOOT_NORMALS), config.noise
        )
        world["air"]["turbulent"] = config.gusts
        world["speed_max_radps"] = config.airframe.rotors.speed_max_radps
        world["sensed"]["baro_alt_m"] = config.home.alt_amsl_m - config.ground_down_m
        brain["mind"], brain["nav"] = new_mind(), new_nav()
        if config.output_observer:
            brain["nav"]["follows"], brain["nav"]["horizon_frames"] = True, EKF2_HORIZON_FRAMES
        senses, receiver = config.supposed or (senses, receiver)
        self._ekf = Ekf(
            brain["nav"],
            senses,
            config.params,
            receiver=receiver,
            field_ned_gauss=field,
            origin_offset_ned_m=config.origin_offset_ned_m,
            stock=config.stock_filter,
        )
        self._motion = world["body"].view("f8")  # as BODY orders it
        self._belief = np.zeros(BELIEF_N)
        self._pack, self._sensed = world["pack"][0], world["sensed"][0]
        self._fixes, self._fix_valid = self._sensed["fix"], self._sensed["fix_valid"]
        self._nav, self._mind = brain["nav"][0], brain["mind"][0]
        # Kept: to describe an array's bytes takes numpy a microsecond.
        self._asked, self._moves = brain["demand"].view("u1").data, self._motion.data
        self._believes = self._belief.data
        self._frame = self.time_us = self._pause_frame = 0
        self.knows_position, self.on_ground = False, True
        self._demand: Demand | None = None
        self._live: Callable[[int, bool, bool], tuple[int, bool, bool]] | None = None
        self._believed: Estimate | None = None
        self._asks = True  # whether the estimator has yet to say what it believes
        self._set_faults(config.faults)
        self.params = config.params

    @property
    def params(self) -> Params:
        """The parameters that it obeys now; assign to change them in flight."""
        return self._params

    @params.setter
    def params(self, params: Params) -> None:
        self._params = self._ekf.params = params
        self._believed, self._asks, self.knows_position = None, True, self._ekf.knows_place
        set_gains(self._brain["gains"], params, self.config.airframe)

    def advance(
        self,
        until_us: int,
        demand: Demand,
        *,
        alert: bool = False,
        onward: Callable[[int], Demand] | None = None,
    ) -> None:
        """Live until `until_us`, which is rounded down to whole frames, under one demand.

        Alert, it looks up as soon as it has lost or found the ground, or its position. A demand that moves goes
        `onward` from frame to frame: to what is asked from that time on.
        """
        if demand is not self._demand:
            self._obey(demand)
        ekf, begin, end = self._ekf, self._frame, until_us // FRAME_US
        live_on = self._live or self._compiled()
        knew, stood = self.knows_position, self.on_ground
        while (frame := self._frame) < end:
            if onward is not None and frame > begin:
                self._obey(onward(frame * FRAME_US))
            if frame >= self._pause_frame:
                self._pause_frame = self._prepare(frame)
            fuses = ekf.running and not ekf.stepwise
            until = min(end, self._pause_frame) if fuses and onward is None else frame + 1
            self._frame, self.knows_position, self.on_ground = live_on(until, alert, fuses)
            if not fuses:
                ekf.step()
                self.knows_position, self._asks = ekf.knows_place, True
            if alert and (self.knows_position is not knew or self.on_ground is not stood):
                break
        self._believed = None
        self.time_us = self._frame * FRAME_US

    def _compiled(self) -> Callable[[int, bool, bool], tuple[int, bool, bool]]:
        records = self._world, self._brain, self._noise, *self._ekf.records, self._belief
        self._live = partial(prepared(live, *records, 0, True, True), *records)
        return self._live

    def _prepare(self, frame: int) -> int:
        """Draw the noise of the frames to come and make the world what the faults that are active now make of it.

        Up to which frame that holds.
        """
        if frame % BLOCK_FRAMES == 0:
            self._draw()
        config = self.config
        active = [fault for fault in self.faults if fault.active(frame * FRAME_US)]
        self._world["received"] = afflict(self._world, config.airframe, config.wind_ned_mps, active)
        discharge(self._world, [fault for fault in active if _frame_at(fault.start_us) == frame])
        block_ends = frame - frame % BLOCK_FRAMES + BLOCK_FRAMES
        return min((at for at in self._fault_frames if frame < at < block_ends), default=block_ends)

    def _obey(self, demand: Demand) -> None:
        set_demand(self._asked, demand)
        self._demand = demand

    def _draw(self) -> None:
        """Noise for the next block of frames, each sense (and the gusts) from its own generator."""
        for generator, name in zip(self._generators, NOISE.names or (), strict=True):
            if self.config.noise or name == "gust":
                generator.standard_normal(out=self._noise[name][0])

    def inject(self, fault: Fault) -> None:
        """Have that go wrong too: from its start, or from the next frame if that has passed."""
        begun = max(fault.start_us, self.time_us)
        self._set_faults((*self.faults, replace(fault, start_us=begun)))

    def heal(self, kind: type[Fault]) -> None:
        """End all faults of that kind with the next frame, and forget those to come."""
        self._set_faults(tuple(fault for fault in self.faults if not isinstance(fault, kind)))

    def _set_faults(self, faults: tuple[Fault, ...]) -> None:
        self.faults = faults
        times_us = {us for fault in faults for us in (fault.start_us, fault.end_us) if us is not None}
        self._fault_frames = {_frame_at(us) for us in times_us}
        self._pause_frame = 0

    @property
    def truth(self) -> TruthState:
        """What really is: for physics and for judges outside."""
        return TruthState(self.time_us, np.frombuffer(self._moves.tobytes()))

    @property
    def estimate(self) -> Estimate:
        """What it believes now."""
        if self._believed is None:
            ekf, knows = self._ekf, self.knows_position
            if self._asks:
                believe(ekf.nav, ekf.book, ekf.sheet, ekf.filter.P, self._belief)
                self._asks = False
            fresh, running = knows or ekf.fixes_fresh(self._frame), ekf.running
            told = np.frombuffer(self._believes.tobytes())
            self._believed = Estimate(self.time_us, told, running, knows, fresh, running)
        return self._believed

    @property
    def fix_age_us(self) -> int:
        """How long ago the estimator used a fix; since the start, before its first."""
        return (self._frame - self._ekf.fix_frame) * FRAME_US

    @property
    def charge_left(self) -> float:
        """What is left in the battery, 0…1."""
        used_ah, _, _, capacity_ah, *_ = self._pack.item()  # as PACK orders it
        return max(0.0, 1.0 - float(used_ah) / float(capacity_ah))

    @property
    def origin(self) -> GeoPoint | None:
        """Where the EKF's NED frame is anchored; None before the first good fix."""
        return GeoPoint(*self._ekf.book["origin"][0].tolist()) if self._ekf.running else None

    def move_origin(self, point: GeoPoint) -> None:
        """Anchor the EKF's NED frame there, once it has one; a demand in that frame is not moved."""
        if self._ekf.running:
            self._ekf.move_origin(point.lat_deg, point.lon_deg, point.alt_amsl_m)
            self._believed, self._asks = None, True

    @property
    def imu(self) -> ImuSample:
        """The latest sample."""
        sample = self._sensed["imu"][1]
        return ImuSample(self.time_us, vector(sample[:3]), vector(sample[3:]))

    @property
    def gps(self) -> GpsSample | None:
        """The fix that arrived last; None before the first, and while there is no reception."""
        taken = (self._frame - GPS_DELAY_FRAMES) // 10 * 10 - 1
        if taken < 0 or not self._fix_valid.item(taken % 16):
            return None
        fix, receiver = self._fixes[taken % 16].copy(), self._receiver
        fix.setflags(write=False)
        return GpsSample(
            (taken + 1) * FRAME_US,
            GeoPoint(*fix[:3].tolist()),
            fix[3:],
            *receiver.sigma,
            receiver.fix_type,
            receiver.satellites,
        )

    @property
    def baro(self) -> BaroSample:
        """The latest sample."""
        alt_m = float(self._sensed["baro_alt_m"])
        kelvin = 288.15 - 0.0065 * alt_m
        pressure_pa = 101325.0 * (kelvin / 288.15) ** 5.25588
        return BaroSample(self._frame // 4 * 4 * FRAME_US, pressure_pa, alt_m, kelvin - 273.15)

    @property
    def mag(self) -> MagSample:
        """The latest sample."""
        return MagSample(self._frame // 4 * 4 * FRAME_US, vector(self._sensed["mag_frd_gauss"]))

    @property
    def range_m(self) -> float:
        """What a range finder under the belly reads; infinite where it looks past the ground."""
        ground_down_m = float(self._world["plant"]["ground_down_m"][0])
        return measure_range(ground_down_m - float(self._motion[2]), self._motion[6:10])

    @property
    def vibration(self) -> tuple[float, float, float]:
        """How restless the IMU is: PX4's coning, gyro (rad/s) and accelerometer (m/s²) metrics."""
        return vibration(self._nav)

    @property
    def battery(self) -> BatteryState:
        """The pack as its monitor sees it."""
        used_ah, voltage_v, current_a, *_ = self._pack.item()  # as PACK orders it
        return BatteryState(voltage_v, current_a, used_ah, self.charge_left)

    @property
    def thrust(self) -> float:
        """Collective thrust that the cascade asks for, 0…1."""
        return float(self._mind["thrust"])

    @property
    def motors(self) -> FloatArray:
        """What each motor was last told, 0…1, in PX4's order."""
        return vector(self._mind["signals"], 4)

    @property
    def attitude_wanted(self) -> FloatArray:
        """The attitude that the cascade steers to, FRD to NED."""
        return vector(self._mind["q_wanted_ned_frd"], 4)

    @property
    def rate_wanted(self) -> FloatArray:
        """The body rates that the cascade steers to, about FRD axes, rad/s."""
        return vector(self._mind["rate_wanted_frd_radps"])

    @property
    def velocity_wanted(self) -> FloatArray:
        """The velocity that the position controller asks for, NED."""
        return vector(self._mind["velocity_wanted_ned_mps"])

    @property
    def acceleration_wanted(self) -> FloatArray:
        """The acceleration that the velocity controller asks for, NED."""
        return vector(self._mind["acceleration_wanted_ned_mps2"])

    def _arrays(self) -> tuple[np.ndarray, ...]:
        return self._world, self._brain, self._noise, *self._ekf.arrays()

    def snapshot(self) -> VehicleState:
        """The whole state, as a value."""
        return VehicleState(
            self._params,
            self._demand,
            self.faults,
            tuple(array.copy() for array in self._arrays()),
            tuple(generator.bit_generator.state for generator in self._generators),
        )

    def restore(self, state: VehicleState) -> None:
        """Become again what `snapshot` saw."""
        for mine, saved in zip(self._arrays(), state.arrays, strict=True):
            mine[...] = saved
        for generator, saved_state in zip(self._generators, state.generators, strict=True):
            generator.bit_generator.state = saved_state
        self._ekf.resume()
        self._frame, self.on_ground = int(self._nav["frame"]), bool(self._mind["on_ground"])
        self.time_us = self._frame * FRAME_US
        self.params = state.params
        self._demand = state.demand
        self._set_faults(state.faults)
