"""The README's table of faults, flown row by row in both dialects: the modes in bold are those that the vehicle changes to."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from sitl.faults import parse_fault

PX4, COPTER = 2, 3  # columns
AFTER_S, WATCHED_S = 2.0, 45.0
SPEED_MPS = 2.0
README = Path(__file__).parents[3] / "README.md"


def rows():
    table = README.read_text(encoding="utf-8").split("## Faults")[1].split("\n## ")[0]
    found = [re.split(r"(?<!\\)\|", line)[1:-1] for line in table.splitlines() if line.startswith("| `")]
    assert all(len(row) == 4 for row in found)
    return {row[0].strip().strip("`"): row for row in found}


def promised(row, column):
    return re.findall(r"\*\*([A-Z_]+)\*\*", row[column])


def struck(simulator, spec):
    """Have the fault that the spec names begin soon, for as long as it says."""
    fault = parse_fault(spec)
    begins_us = simulator.time_us + round(AFTER_S * 1e6)
    lasts_us = None if fault.end_us is None else fault.end_us - fault.start_us
    simulator.inject(
        replace(fault, start_us=begins_us, end_us=None if lasts_us is None else begins_us + lasts_us)
    )


def modes(simulator):
    return [event.text for event in simulator.take_events() if event.kind == "mode"]


@pytest.fixture(scope="module")
def offboard(px4_client):
    """A PX4 that is streamed to in OFFBOARD, its state and where it is."""
    client = px4_client.airborne()
    north, east, down = client.simulator.report.estimate.position_ned_m.tolist()
    client.live(1.0, lambda: client.setpoint((north, east, down)))
    client.command(176, 1, 6, 0)
    client.live(1.0, lambda: client.setpoint((north, east, down)))
    assert client.flight.mode.name == "OFFBOARD"
    return client, client.simulator.snapshot(), (north, east, down)


@pytest.mark.parametrize("spec", rows())
def test_px4_answers_as_the_table_says(offboard, spec):
    client, state, (north, east, down) = offboard
    client.simulator.restore(state)
    client.simulator.take_events()
    begin_us = client.now_us = client.simulator.time_us
    struck(client.simulator, spec)
    told = []
    for _ in range(round(WATCHED_S * 10)):
        ahead_m = SPEED_MPS * 1e-6 * (client.now_us - begin_us)
        client.live(0.1, lambda: client.setpoint((north + ahead_m, east, down), (SPEED_MPS, 0.0, 0.0)))  # noqa: B023
        told += modes(client.simulator)
    assert told == promised(rows()[spec], PX4)


@pytest.mark.parametrize("spec", rows())
def test_arducopter_answers_as_the_table_says(aloft, spec):
    north, east, down = aloft.here.tolist()
    begin_s = aloft.now_s
    struck(aloft.simulator, spec)
    told = []
    for _ in range(round(WATCHED_S * 10)):
        ahead_m = SPEED_MPS * (aloft.now_s - begin_s)
        aloft.target(p=(north + ahead_m, east, down), v=(SPEED_MPS, 0.0, 0.0))
        received, aloft.outbox = aloft.outbox, b""
        step = aloft.simulator.step(aloft.simulator.time_us + 100_000, received)
        told += [event.text for event in step.events if event.kind == "mode"]
    assert told == promised(rows()[spec], COPTER)
