"""ArduCopter's tracking of a circle through MAVLink, against what ArduCopter 4.6.3's SITL was seen to do. Prints one table.

The circle has 10 m and is flown at 3 m/s in GUIDED, setpoints at 50 Hz; horizontal RMS of LOCAL_POSITION_NED against the
commanded path over the second lap and a half, and the heading's error.

python tests/bench/bench_ardupilot.py
"""

from __future__ import annotations

import dataclasses
import math
import sys
from pathlib import Path

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

sys.path.insert(0, str(Path(__file__).parents[2]))

from sitl.airframe import Airframe, load_airframe
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

RADIUS_M, SPEED_MPS = 10.0, 3.0
POS, POS_VEL, POS_VEL_ACC, ALL = 0xDF8, 0x9C0, 0x800, 0x000
SEEN = {  # knowledge/real_autopilots.md, m and degrees
    "position": (POS, 4.3, None),
    "position, velocity": (POS_VEL, 0.73, None),
    "position, velocity, acceleration": (POS_VEL_ACC, 0.27, 3.3),
    "and yaw rate": (ALL, 0.27, 0.37),
}


def sitl_quad() -> Airframe:
    """The bundled body with the air drag of ArduPilot's own SITL quadrotor, per mass.

    Source: ArduPilot, SIM_Frame.cpp and SIM_Motor.cpp: 3.0 kg lean 45° at 15.08 m/s; momentum drag is 0.2·√(ρ T A) of the
    speed with 0.385 m² of discs, the rest is drag of the body.
    """
    x500 = load_airframe("x500")
    mass_kg, rho, discs_m2, speed = 3.0, 1.2, 0.385, 15.08
    weight_n = mass_kg * 9.80665
    momentum = 0.2 * math.sqrt(weight_n * rho * discs_m2)
    area_m2 = (weight_n - math.cos(math.pi / 4) * momentum * speed) / (0.5 * rho * speed**2)
    ours = x500.body.mass_kg
    hover = math.sqrt(ours * 9.80665 / 4.0 / x500.rotors.thrust_n_per_radps2)
    body = dataclasses.replace(x500.body, drag_area_m2=np.full(3, area_m2 * ours / mass_kg))
    rotors = dataclasses.replace(x500.rotors, drag_n_per_radps_mps=momentum / mass_kg * ours / (4.0 * hover))
    return dataclasses.replace(x500, body=body, rotors=rotors)


class Pilot:
    """Flies a simulated ArduCopter by its own messages."""

    def __init__(self, airframe: Airframe, gps: str = "rtk", lead_s: float = 0.0) -> None:
        home = GeoPoint(-35.3633, 149.1652, 584.0)
        config = VehicleConfig(airframe, Params(airframe.params), home, gps=gps)
        self.simulator = Simulator(SimulatorConfig(config, "ardupilot"))
        self.mav = mavlink.MAVLink(None, 255, 190)
        self.mav.robust_parsing = True
        self.lead_s = lead_s

    def live(self, until_s: float, *messages) -> None:
        data = b"".join(message.pack(self.mav) for message in messages)
        self.simulator.step(round(until_s * 1e6), b"")
        self.simulator.step(round(until_s * 1e6), data)

    def command(self, number: int, *params: float):
        return mavlink.MAVLink_command_long_message(1, 1, number, 0, *params, *(0.0,) * (7 - len(params)))

    def take_off(self) -> None:
        for now_s, message in (
            (42.0, self.command(176, 1, 4)),
            (43.0, self.command(400, 1)),
            (45.0, self.command(22, 0, 0, 0, 0, 0, 0, 10)),
        ):
            self.live(now_s, message)
        self.live(60.0)
        assert self.simulator.report.estimate.position_ned_m[2] < -8.0

    def circle(self, mask: int) -> tuple[float, float]:
        """Horizontal RMS in metres and heading RMS in degrees."""
        self.take_off()
        rate, begin_s, off, turned = SPEED_MPS / RADIUS_M, 60.0, [], []
        for step in range(round(3.0 * math.tau / rate * 50.0)):
            t_s = step / 50.0
            if rate * t_s > 1.5 * math.tau:
                estimate = self.simulator.report.estimate
                wanted = RADIUS_M * np.array((math.sin(rate * t_s), 1.0 - math.cos(rate * t_s)))
                off.append(estimate.position_ned_m[:2] - wanted)
                w, x, y, z = estimate.q_ned_frd
                yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
                turned.append(math.remainder(yaw - rate * t_s, math.tau))
            angle = rate * (t_s + self.lead_s)
            c, s = math.cos(angle), math.sin(angle)
            a = SPEED_MPS * rate
            target = mavlink.MAVLink_set_position_target_local_ned_message(
                0, 1, 1, 1, mask,
                RADIUS_M * s, RADIUS_M * (1 - c), -10.0,
                SPEED_MPS * c, SPEED_MPS * s, 0.0, -a * s, a * c, 0.0,
                math.remainder(angle, math.tau), rate,
            )  # fmt: skip
            self.live(begin_s + t_s, target)
        rms_m = math.sqrt(float((np.array(off) ** 2).sum(axis=1).mean()))
        return rms_m, math.degrees(math.sqrt(float((np.array(turned) ** 2).mean())))


def main() -> None:
    print("circle of 10 m at 3 m/s: RMS, m (seen in ArduCopter 4.6.3's SITL); heading, degrees (seen)")
    for name, (mask, seen_m, seen_deg) in SEEN.items():
        for kind, airframe in (("SITL's drag", sitl_quad()), ("x500", load_airframe("x500"))):
            rms_m, yaw_deg = Pilot(airframe).circle(mask)
            seen = f"({seen_deg})" if seen_deg is not None else ""
            print(f"  {name:34} {kind:12} {rms_m:6.3f} ({seen_m})   {yaw_deg:6.2f} {seen}")


if __name__ == "__main__":
    main()
