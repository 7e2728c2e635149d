"""`mavspiral fly` as a user runs it, over UDP against the bundled vehicle: killed in mid-inspection, and going on."""

import itertools
import json
import math
import signal
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from patience import eventually
from pymavlink import mavutil

from mavspiral.flight.journal import borrowed_in, read_journal
from mavspiral.logbook.card import card_numbers
from mavspiral.logbook.progress import progress_of
from mavspiral.survey.solids import Solids
from sitl.link.tlog import logged_frames

LOST_N = 12
"""The journal may lose a second, which is eight of a vehicle that lives so much faster."""
ROOT = Path(__file__).parents[2]
FLIES_S = 300.0
SETPOINT = 84
RATE_HZ = 50


class Flying:
    """A `fly` of the kiosk, and what it has said."""

    def __init__(self, vehicle, out, *options, mission="missions/kiosk.toml"):
        url = f"udpin://127.0.0.1:{vehicle.offboard_port}"
        command = ["-m", "mavspiral.cli", "fly", str(mission), "--connect", url, "--yes", "--out", str(out)]
        self.process = subprocess.Popen(
            [sys.executable, *command, *options],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.lines = []
        self._came = threading.Condition()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        for line in itertools.chain(self.process.stdout, [None]):
            with self._came:
                self.lines.append("(over)" if line is None else line.rstrip())
                self._came.notify_all()

    def wait_for(self, words):
        with self._came:
            self._came.wait_for(
                lambda: any(words in line or line == "(over)" for line in self.lines), FLIES_S
            )
        assert any(words in line for line in self.lines), "\n".join(self.lines)

    def end(self):
        code = self.process.wait(FLIES_S)
        self.wait_for("(over)")
        return code, self.process.stderr.read()


def inspects(out, path_s):
    """Wait until so many seconds of the inspection are behind it, as its own journal says."""

    def far_enough():
        flight = read_journal(out / "kiosk.journal")[-1]
        return len(flight.rows) and flight.rows[-1, 3] - flight.place["inspection_s"] > path_s

    eventually(far_enough, FLIES_S)


def setpoints_ms(tlog):
    """Of which moments of the vehicle's clock the setpoints were that it has received."""
    frames = logged_frames(tlog.read_bytes())
    return np.array(
        [struct.unpack_from("<I", f, 10)[0] for f in frames if int.from_bytes(f[7:10], "little") == SETPOINT]
    )


def test_killed_in_mid_inspection_it_resumes_and_every_wall_is_seen(start_vehicle, tmp_path):
    vehicle = start_vehicle("--speedup", "8", "--tlog", str(tmp_path / "vehicle.tlog"))
    flying = Flying(vehicle, tmp_path, "--set-failsafes")
    flying.wait_for("leg inspection")
    inspects(tmp_path, 25.0)  # a third of it or so
    flying.process.kill()
    assert flying.end()[0] == -signal.SIGKILL
    [killed] = read_journal(tmp_path / "kiosk.journal")
    assert killed.end is None and killed.events
    assert borrowed_in(tmp_path / "kiosk.journal"), "nobody lived to put the vehicle's own parameters back"
    vehicle.says("disarm", FLIES_S)
    sent_ms, last_ms = setpoints_ms(tmp_path / "vehicle.tlog"), killed.rows[-1, 1] / 1e3
    assert np.sum(sent_ms <= last_ms) > RATE_HZ
    assert np.sum(sent_ms > last_ms) <= RATE_HZ, "at most a second of log is lost"
    assert (tmp_path / "kiosk.tlog").stat().st_size > 100_000

    answer = Flying(vehicle, tmp_path, "--resume", "--json")
    code, errors = answer.end()
    summary = json.loads(answer.lines[0])
    assert code == 0, (summary["failures"], errors)
    assert summary["inspected"]["flights"] == 2
    assert summary["coverage"]["walls"] > 0.99
    assert not borrowed_in(tmp_path / "kiosk.journal"), "the resumed flight did"
    _, second = read_journal(tmp_path / "kiosk.journal")
    taken_n = len(killed.pictures) + len(second.pictures)
    # Whose telling was late or lost may have no number: on the wall clock some have none, in lockstep all have.
    known_n = sum(n >= 0 for row in card_numbers([killed.pictures, second.pictures]) for n in row)
    assert known_n > 0.8 * taken_n
    for table, blank in ((summary["files"]["geotags"], ","), (summary["files"]["geo_txt"], " ")):
        named = [line.split(blank)[0] for line in Path(table).read_text().splitlines()[1:]]
        numbers = [int(name.removeprefix("DSC").removesuffix(".JPG")) for name in named]
        assert len(numbers) == known_n and numbers[0] == 1 and numbers == sorted(set(numbers))
        assert numbers[-1] <= taken_n + LOST_N  # of the second that the journal may lose
    assert 0.0 < second.begin["begin_s"] < second.begin["end_s"] and second.end["ok"]
    for number in ("", ".1"):
        assert (tmp_path / f"kiosk{number}.flight.npz").stat().st_size > 10_000


def test_aligned_on_the_ground_the_shift_is_in_the_journal(start_vehicle, planned, tmp_path):
    """The vehicle stands 2 m east and 1 m north of where the map has the mission's home."""
    kiosk = planned("kiosk")
    place = kiosk.site.heights.frame.geo_point(kiosk.home_enu_m + np.array([2.0, 1.0, 0.0]))
    vehicle = start_vehicle("--home", f"{place.lat_deg:.8f},{place.lon_deg:.8f},{place.alt_amsl_m:.2f},40")
    code, errors = (flying := Flying(vehicle, tmp_path, "--align", "home", "--dry-run", "--json")).end()
    assert code == 0, errors
    aligned = json.loads(flying.lines[0])["aligned"]
    assert (aligned["east_m"], aligned["north_m"]) == pytest.approx((2.0, 1.0), abs=0.1)
    assert progress_of(kiosk, tmp_path / "kiosk.journal").shift_enu_m == pytest.approx(
        [aligned["east_m"], aligned["north_m"], 0.0], abs=1e-3
    )


def disarmed_s(vehicle):
    """When it disarmed, by its own clock; infinity before that."""
    return next((float(line[1:].split()[0]) for line in vehicle.lines if "] disarmed" in line), math.inf)


def test_a_hung_process_leaves_the_vehicle_to_its_own_failsafe_and_clear_of_the_building(
    start_vehicle, planned, tmp_path
):
    vehicle = start_vehicle("--speedup", "6")
    listener = mavutil.mavlink_connection(f"udpin:127.0.0.1:{vehicle.gcs_port}", source_system=255)
    flying = Flying(vehicle, tmp_path, "--set-failsafes")
    flying.wait_for("leg inspection")
    inspects(tmp_path, 12.0)
    flying.process.send_signal(signal.SIGSTOP)
    places, until = [], time.monotonic() + FLIES_S
    while time.monotonic() < until:
        message = listener.recv_match(type="GLOBAL_POSITION_INT", blocking=True, timeout=1.0)
        if message is not None:
            places.append((message.lat / 1e7, message.lon / 1e7, message.alt / 1e3))
            if message.time_boot_ms / 1e3 > disarmed_s(vehicle):
                break
    flying.process.send_signal(signal.SIGCONT)
    code, _ = flying.end()
    listener.close()
    assert any("failsafe" in line.lower() for line in vehicle.lines), vehicle.lines
    inspection = planned("kiosk")
    heights = inspection.site.heights
    flown_enu_m = heights.frame.to_enu(*np.array(places).T)
    assert flown_enu_m[:, 2].max() > inspection.safe_height_enu_m - 1.0, "it returned above the building"
    assert Solids.of_map(heights).distance_m(flown_enu_m).min() > inspection.mission.vehicle.radius_m + 1.0
    assert np.linalg.norm(flown_enu_m[-1] - inspection.home_enu_m) < 3.0
    assert code != 0
    armed_n = sum("Armed by" in line for line in vehicle.lines)
    assert armed_n == 1, "awake again, it does not fly on"
