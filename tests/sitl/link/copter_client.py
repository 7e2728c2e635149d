"""A scripted client of an ArduCopter in lockstep: pymavlink packs and parses, the simulator answers."""

from __future__ import annotations

import math

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sitl.airframe import load_airframe
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

HOME = GeoPoint(-35.3633, 149.1652, 584.0)
STEP_US = 10_000
GUIDED, AUTO, LOITER, RTL, LAND = 4, 3, 5, 6, 9


def new_simulator(**config) -> Simulator:
    airframe = load_airframe("x500")
    config = {"origin_offset_ned_m": (7.0, -4.0, 2.0)} | config
    return Simulator(
        SimulatorConfig(VehicleConfig(airframe, Params(airframe.params), HOME, **config), "ardupilot")
    )


class Client:
    """What a script says, and what it hears on one link: `live` gives the messages of the time lived."""

    def __init__(self, simulator: Simulator, system: int = 255) -> None:
        self.simulator = simulator
        self.mav = mavlink.MAVLink(None, system, 190)
        self.mav.robust_parsing = True
        self.outbox = b""
        self.raw = b""

    @property
    def flight(self):
        return self.simulator.report.flight

    @property
    def here(self):
        return self.simulator.report.estimate.position_ned_m

    @property
    def now_s(self):
        return self.simulator.time_us * 1e-6

    def say(self, message) -> None:
        self.outbox += message.pack(self.mav)

    def command(self, number, *params) -> None:
        values = (*params, *(0.0,) * (7 - len(params)))
        self.say(mavlink.MAVLink_command_long_message(1, 1, number, 0, *values))

    def command_int(self, number, frame, *params, x=0, y=0, z=0.0) -> None:
        values = (*params, *(0.0,) * (4 - len(params)))
        self.say(mavlink.MAVLink_command_int_message(1, 1, frame, number, 0, 0, *values, x, y, z))

    def target(
        self, p=None, v=None, a=None, yaw=None, yaw_rate=None, frame=1, system=1, component=1, mask=None
    ):
        """A setpoint; what is left out is ignored."""
        bits = 0x007 * (p is None) | 0x038 * (v is None) | 0x1C0 * (a is None)
        bits |= 0x400 * (yaw is None) | 0x800 * (yaw_rate is None)
        zero = (0.0,) * 3
        self.say(
            mavlink.MAVLink_set_position_target_local_ned_message(
                0, system, component, frame, bits if mask is None else mask,
                *(p or zero), *(v or zero), *(a or zero), yaw or 0.0, yaw_rate or 0.0,
            )
        )  # fmt: skip

    def live(self, seconds, stream=None, every_us=20_000):
        """Simulated time; `stream()` is called at that interval. The messages heard meanwhile."""
        heard = []
        for _ in range(round(seconds * 1e6 / STEP_US)):
            if stream is not None and self.simulator.time_us % every_us == 0:
                stream()
            received, self.outbox = self.outbox, b""
            step = self.simulator.step(self.simulator.time_us + STEP_US, received)
            self.raw += step.send
            heard += self.mav.parse_buffer(step.send) or []
        return [message for message in heard if message.get_type() != "BAD_DATA"]

    def until(self, condition, limit_s, stream=None):
        heard = []
        for _ in range(round(limit_s * 10)):
            heard += self.live(0.1, stream)
            if condition():
                return heard
        raise AssertionError(f"not within {limit_s} s")

    def ask(self, number, *params):
        """The result of a command."""
        self.command(number, *params)
        return next(ack.result for ack in self.live(0.1) if ack.get_type() == "COMMAND_ACK")

    def airborne(self, height_m=10.0):
        assert self.ask(176, 1, GUIDED) == 0
        self.live(max(0.0, 41.5 - self.now_s))
        assert self.ask(400, 1) == 0
        self.live(1.0)
        assert self.ask(22, 0, 0, 0, 0, 0, 0, height_m) == 0
        home_m = float(self.flight.home.position_ned_m[2])
        self.until(lambda: abs(home_m - height_m - self.here[2]) < 0.3, 30.0)
        self.live(3.0)
        return self

    def upload(self, items):
        """Upload (command, frame, params) items after a home; the MISSION_ACK's type, or None."""
        items = [(16, 0, (0, 0, 0, 0, HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m)), *items]
        self.say(mavlink.MAVLink_mission_count_message(1, 1, len(items), 0))
        for _ in range(1000):
            for message in self.live(0.01):
                match message.get_type():
                    case "MISSION_ACK":
                        return message.type
                    case "MISSION_REQUEST":
                        command, frame, (p1, p2, p3, p4, x, y, z) = items[message.seq]
                        self.say(
                            mavlink.MAVLink_mission_item_int_message(
                                1, 1, message.seq, frame, command, 0, 1, p1, p2, p3, p4,
                                round(x * 1e7), round(y * 1e7), z, 0,
                            )
                        )  # fmt: skip
        return None


def pick(messages, name):
    return [message for message in messages if message.get_type() == name]


def texts(messages):
    return [message.text for message in pick(messages, "STATUSTEXT")]


def yaw_deg(client):
    w, x, y, z = client.simulator.report.estimate.q_ned_frd
    return math.degrees(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
