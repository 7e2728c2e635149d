"""A scripted client of a PX4 in lockstep, over real MAVLink bytes."""

import math

from sitl.airframe import load_airframe
from sitl.link.codec import Codec
from sitl.link.messages import message_type
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

HOME = GeoPoint(19.435235, -99.146145, 2240.0)
STEP_US = 10_000


class Client:
    """What a script says to the vehicle, and all that it has heard: (time_us, link, message)."""

    def __init__(self, simulator, links=1):
        self.simulator = simulator
        self.codecs = [Codec(255, 190) for _ in range(links)]
        self.outbox = [b""] * links
        self.heard = []
        self.now_us = 0
        self.stream = None

    def say(self, name, link=0, **fields):
        self.outbox[link] += self.codecs[link].encode(message_type(name)(**fields))

    def command(self, number, *params, link=0, system=1, component=1):
        values = [*params, *[math.nan] * (7 - len(params))]
        named = {f"param{i}": float(value) for i, value in enumerate(values, start=1)}
        self.say(
            "COMMAND_LONG",
            link,
            **named,
            command=number,
            target_system=system,
            target_component=component,
            confirmation=0,
        )

    def heartbeat(self, link=0, kind=6):
        self.say(
            "HEARTBEAT",
            link,
            custom_mode=0,
            type=kind,
            autopilot=8,
            base_mode=0,
            system_status=4,
            mavlink_version=3,
        )

    def setpoint(self, position=None, velocity=None, mask=None, frame=1, system=1, component=1, **more):
        """A setpoint; groups that are left out are masked."""
        if mask is None:
            mask = 0x1C0 | (0x007 if position is None else 0) | (0x038 if velocity is None else 0)
        x, y, z = position or (0.0,) * 3
        vx, vy, vz = velocity or (0.0,) * 3
        fields = {
            "time_boot_ms": 0,
            "x": x,
            "y": y,
            "z": z,
            "vx": vx,
            "vy": vy,
            "vz": vz,
            "afx": 0.0,
            "afy": 0.0,
            "afz": 0.0,
            "yaw": 0.0,
            "yaw_rate": 0.0,
            "type_mask": mask,
            "target_system": system,
            "target_component": component,
            "coordinate_frame": frame,
        }
        self.say("SET_POSITION_TARGET_LOCAL_NED", **(fields | more))

    def live(self, seconds, stream=None, every_us=20_000):
        """Simulated time; `stream()` is called at that interval. Returns what was heard meanwhile."""
        begin = len(self.heard)
        for _ in range(round(seconds * 1e6 / STEP_US)):
            if stream is not None and self.now_us % every_us == 0:
                stream()
            self.now_us += STEP_US
            received, self.outbox = tuple(self.outbox), [b""] * len(self.codecs)
            for link, data in enumerate(self.simulator.exchange(self.now_us, received)):
                for item in self.codecs[link].decode(data):
                    self.heard.append((self.now_us, link, item.message))
        return [message for _, _, message in self.heard[begin:]]

    def until(self, condition, limit_s, stream=None):
        """Live until the condition holds."""
        for _ in range(round(limit_s * 10)):
            self.live(0.1, stream)
            if condition():
                return
        raise AssertionError(f"not within {limit_s} s")

    @property
    def flight(self):
        return self.simulator.report.flight

    def airborne(self, height_m=10.0):
        self.until(lambda: self.flight.ready, 10.0)
        self.command(400, 1.0, 0.0)
        self.command(
            22, 0, 0, 0, math.nan, math.nan, math.nan, self.simulator.report.origin.alt_amsl_m + height_m
        )
        self.until(lambda: self.flight.mode.name == "TAKEOFF", 1.0)
        self.until(lambda: self.flight.mode.name == "HOLD", 30.0)
        self.live(2.0)
        return self

    def item(self, seq, command, params, frame=3, kind=0, current=0, link=0, autocontinue=1):
        """One MISSION_ITEM_INT. `params` are all seven; a place's are degrees and metres."""
        p1, p2, p3, p4, x, y, z = params
        degree = 1 if frame == 2 else 1e7
        self.say(
            "MISSION_ITEM_INT",
            link,
            param1=p1,
            param2=p2,
            param3=p3,
            param4=p4,
            x=round(x * degree),
            y=round(y * degree),
            z=z,
            seq=seq,
            command=command,
            target_system=1,
            target_component=1,
            frame=frame,
            current=current,
            autocontinue=autocontinue,
            mission_type=kind,
        )

    def count(self, count, kind=0, link=0):
        self.say("MISSION_COUNT", link, count=count, target_system=1, target_component=1, mission_type=kind)

    def upload(self, items, kind=0, link=0, limit_s=10.0):
        """Upload (command, params, frame) items; the MISSION_ACK's result, None when there was none."""
        self.count(len(items), kind, link)
        for _ in range(round(limit_s * 100)):
            heard = self.live(0.01)
            for ack in messages(heard, "MISSION_ACK"):
                return ack.type
            for request in messages(heard, "MISSION_REQUEST_INT"):
                command, params, frame = items[request.seq]
                self.item(request.seq, command, params, frame, kind, int(request.seq == 0), link)
        return None

    def download(self, kind=0, link=0):
        """All items of that kind, read back as MISSION_ITEM_INT."""
        self.say("MISSION_REQUEST_LIST", link, target_system=1, target_component=1, mission_type=kind)
        (count,) = messages(self.live(0.02), "MISSION_COUNT")
        items = []
        for seq in range(count.count):
            self.say(
                "MISSION_REQUEST_INT",
                link,
                seq=seq,
                target_system=1,
                target_component=1,
                mission_type=kind,
            )
            items += messages(self.live(0.02), "MISSION_ITEM_INT")
        self.say("MISSION_ACK", link, target_system=1, target_component=1, type=0, mission_type=kind)
        self.live(0.02)
        return items

    def quiet(self):
        """Switch all telemetry off."""
        for message_id in (
            30,
            31,
            105,
            33,
            32,
            331,
            111,
            141,
            85,
            36,
            74,
            24,
            245,
            1,
            0,
            49,
            230,
            4,
            29,
            2,
            147,
            242,
        ):
            self.command(511, message_id, -1)
        self.live(0.05)
        return self


def messages(heard, name):
    return [message for message in heard if type(message).__name__ == name]


def new_px4(links=1, home=HOME, params=None, **config):
    airframe = load_airframe("x500")
    chosen = Params(airframe.params).replace(**(params or {}))
    vehicle = VehicleConfig(airframe=airframe, params=chosen, home=home, gps="rtk")
    return Client(Simulator(SimulatorConfig(vehicle, **config)), links)
