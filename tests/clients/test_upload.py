"""`mavspiral upload` against the vehicle over UDP; MAVSDK, which had no part in it, reads what the vehicle has then."""

import contextlib
import json
import random
import select
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from mavsdk.plugins.mission_raw import MissionRaw
from mavsdk_session import insisted, system_of

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "tests/golden/kiosk.plan"


class LossyRelay:
    """A UDP relay that loses datagrams, by a seed. Listens where the vehicle sends to, and passes on to the client at `client_port` and back."""

    def __init__(self, vehicle_port, client_port, loss, seed=1):
        self.lost_n = self.passed_n = 0
        self._loss, self._random = loss, random.Random(seed)
        self._vehicle = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._vehicle.bind(("127.0.0.1", vehicle_port))
        self._client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._client.bind(("127.0.0.1", 0))
        self._client_address, self._vehicle_address = ("127.0.0.1", client_port), None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        while not self._stop.is_set():
            for ready in select.select([self._vehicle, self._client], [], [], 0.1)[0]:
                with contextlib.suppress(OSError):  # nobody there yet
                    data, address = ready.recvfrom(65536)
                    if ready is self._vehicle:
                        self._vehicle_address = address
                    self._pass(ready, data)

    def _pass(self, source, data):
        if self._random.random() < self._loss:
            self.lost_n += 1
            return
        self.passed_n += 1
        if source is self._vehicle:
            self._client.sendto(data, self._client_address)
        elif self._vehicle_address is not None:
            self._vehicle.sendto(data, self._vehicle_address)

    def close(self):
        self._stop.set()
        self._thread.join()
        self._vehicle.close()
        self._client.close()


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def upload(source, url, *options):
    answer = subprocess.run(
        [sys.executable, "-m", "mavspiral.cli", "upload", str(source), "--connect", url, "--json", *options],
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=400,
    )
    return answer.returncode, json.loads(answer.stdout) if answer.stdout else answer.stderr


def as_mavsdk_sees_it(vehicle):
    with system_of(vehicle) as system:
        plugin = MissionRaw(system)
        document = GOLDEN.read_text()
        wanted = plugin.import_qgroundcontrol_mission_from_string(document)
        lists = plugin.download_mission, plugin.download_geofence, plugin.download_rallypoints
        return wanted, *map(insisted, lists)


def test_mission_fence_and_rally_arrive_as_mavsdk_reads_them(start_vehicle):
    vehicle = start_vehicle("--speedup", "4")
    code, summary = upload(GOLDEN, f"udpin://127.0.0.1:{vehicle.offboard_port}")
    items = json.loads(GOLDEN.read_text())["mission"]["items"]
    assert code == 0, summary
    assert summary == {"ok": True, "items": len(items), "fence": 16, "rally": 1, "differences": []}
    wanted, mission, fence, rally = as_mavsdk_sees_it(vehicle)
    for ours, theirs in zip(wanted.mission_items, mission, strict=True):
        assert (ours.command, ours.x, ours.y) == (theirs.command, theirs.x, theirs.y)
        assert theirs.z == pytest.approx(ours.z, abs=1e-4)
    for ours, theirs in zip(wanted.geofence_items, fence, strict=True):
        assert (ours.command, ours.x, ours.y, ours.param1) == (
            theirs.command,
            theirs.x,
            theirs.y,
            theirs.param1,
        )
    assert [(point.x, point.y) for point in rally] == [(point.x, point.y) for point in wanted.rally_items]


def test_with_30_percent_loss_each_way_it_arrives_equal(start_vehicle, tmp_path):
    """A short one: every lost datagram costs real time. 500 items are flown through loss in lockstep (tests/flight)."""
    vehicle = start_vehicle("--speedup", "2")
    port = free_port()
    plan = json.loads(GOLDEN.read_text())
    del plan["mission"]["items"][10:-1], plan["geoFence"]["polygons"][0]["polygon"][4:]
    short = tmp_path / "short.plan"
    short.write_text(json.dumps(plan))
    relay = LossyRelay(vehicle.offboard_port, port, 0.3)
    try:
        code, summary = upload(short, f"udpin://127.0.0.1:{port}")
    finally:
        relay.close()
    assert code == 0, summary
    assert summary["differences"] == []
    assert relay.lost_n > 0.2 * relay.passed_n


def test_what_the_vehicle_refuses_is_named_and_exits_1(start_vehicle, tmp_path):
    vehicle = start_vehicle("--speedup", "4")
    plan = json.loads(GOLDEN.read_text())
    plan["mission"]["items"][4]["command"] = 82
    path = tmp_path / "spline.plan"
    path.write_text(json.dumps(plan))
    code, summary = upload(path, f"udpin://127.0.0.1:{vehicle.offboard_port}")
    assert code == 1
    assert not summary["ok"]
    assert "refuses the mission at item 5: command 82" in summary["differences"][0]
    plan["mission"]["firmwareType"] = 3
    path.write_text(json.dumps(plan))
    code, summary = upload(path, f"udpin://127.0.0.1:{vehicle.offboard_port}")
    assert code == 1
    assert "made for ArduPilot, the vehicle is PX4" in summary["differences"][0]


def test_signed_it_goes_to_a_vehicle_that_signs(start_vehicle, tmp_path):
    key = tmp_path / "key"
    key.write_text(bytes(range(7, 39)).hex())
    vehicle = start_vehicle("--speedup", "4", "--signing", str(key))
    code, summary = upload(GOLDEN, f"udpin://127.0.0.1:{vehicle.offboard_port}", "--signing", str(key))
    assert (code, summary["ok"]) == (0, True), summary


def test_nobody_there_exits_3_and_a_bad_file_2(tmp_path):
    code, _ = upload(GOLDEN, f"udpin://127.0.0.1:{free_port()}")
    assert code == 3
    (tmp_path / "x.plan").write_text("{}")
    code, words = upload(tmp_path / "x.plan", "udpin://127.0.0.1:1")
    assert code == 2
    assert len(words.splitlines()) == 1
