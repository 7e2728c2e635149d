"""What a pilot reads and answers in flight, on a pseudo-terminal."""

import contextlib
import os
import pty
import select
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mavspiral.console import Console
from mavspiral.flight.flight_log import Event
from mavspiral.flight.wishes import Wish

ROOT = Path(__file__).parents[2]
WITHIN_S = 60.0


@contextlib.contextmanager
def a_terminal(monkeypatch):
    """The pilot's end; the program's is stdin, stdout and stderr. (No fixture: pytest sets these anew for the test itself.)"""
    pilots, programs = pty.openpty()
    kept = os.dup(0)
    streams = [os.fdopen(os.dup(programs), mode) for mode in ("r", "w", "w")]
    os.dup2(programs, 0)
    with monkeypatch.context() as patch:
        for name, stream in zip(("stdin", "stdout", "stderr"), streams, strict=True):
            patch.setattr(sys, name, stream)
        try:
            yield pilots
        finally:
            os.dup2(kept, 0)
            for number in (kept, pilots, programs):
                os.close(number)
            for stream in streams:
                with contextlib.suppress(OSError):
                    stream.close()


def until(ask):
    end_s = time.monotonic() + WITHIN_S
    while (answer := ask()) is None:
        assert time.monotonic() < end_s
        time.sleep(0.01)
    return answer


def read_until(pilots, words):
    text, end_s = "", time.monotonic() + WITHIN_S
    while words not in text:
        assert time.monotonic() < end_s, text
        text += os.read(pilots, 4096).decode()
    return text


@pytest.mark.parametrize(("typed", "answer"), [("y\n", True), ("YES\n", True), ("n\n", False), ("\n", False)])
def test_a_question_is_answered_when_the_pilot_answers_and_not_before(monkeypatch, typed, answer):
    with a_terminal(monkeypatch) as terminal, Console() as console:
        os.write(terminal, b"y\n")  # typed before it was asked: no answer to this question
        assert select.select([0], [], [], WITHIN_S)[0], "the line has come through the terminal"
        assert [console.approve("fly") for _ in range(3)] == [None] * 3
        shown = read_until(terminal, "[y/N]: ")
        assert shown.count("Fly? [y/N]") == 1
        os.write(terminal, typed.encode())
        assert until(lambda: console.approve("fly")) is answer


def test_a_held_vehicle_is_asked_about_once_and_every_answer_means_something(monkeypatch):
    with a_terminal(monkeypatch) as terminal, Console() as console:
        for typed, wish in (("g", Wish.GO_ON), ("r", Wish.GO_HOME), ("l", Wish.LAND), ("h", Wish.HAND_OVER)):
            assert console.wish(held=False) is None
            assert console.wish(held=True) is None
            assert console.wish(held=True) is None
            assert read_until(terminal, "Ctrl-C returns home").count("[g/r/l/h]") == 1
            os.write(terminal, f"{typed}\n".encode())
            assert until(lambda: console.wish(held=True)) is wish


def test_a_held_vehicle_flies_home_where_nobody_can_be_asked(monkeypatch):
    monkeypatch.setattr("sys.stdin", None)
    with Console() as console:
        assert console.wish(held=False) is None
        assert console.wish(held=True) is Wish.GO_HOME


def test_a_question_survives_that_nothing_is_held(monkeypatch):
    """Asked once: `wish` is called at every step, whether a vehicle is held or not."""
    with a_terminal(monkeypatch) as terminal, Console() as console:
        for _ in range(5):
            assert console.approve("fly") is None and console.wish(held=False) is None
        console.say(Event(1_000_000, "warning", "careful"))
        shown = read_until(terminal, "careful")
        before, _ = shown.split("warning: careful")
        assert before.count("[y/N]") == 1


def test_a_terminal_that_stands_still_keeps_nobody_waiting(monkeypatch):
    with a_terminal(monkeypatch) as terminal:
        console = Console()
        begin_s = time.thread_time()
        for number in range(3000):  # more than a terminal holds that nobody reads
            console.say(Event(number, "info", "x" * 60))
        assert time.thread_time() - begin_s < 1.0 and console._printer.is_alive()
        read_until(terminal, "     0.0 s  " + "x" * 60)
        os.set_blocking(terminal, False)
        console._told.put(None)
        end_s = time.monotonic() + WITHIN_S
        while console._printer.is_alive():
            assert time.monotonic() < end_s
            try:
                os.read(terminal, 65536)
            except BlockingIOError:
                time.sleep(0.001)


def test_yes_is_the_answer_to_everything():
    with Console(yes=True) as console:
        assert console.approve("fly") is True


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--connect", "nonsense", "--yes"], "no link is called 'nonsense'. Fix: "),
        (["--connect", "udpin://127.0.0.1:9"], "Fix: --yes"),
        (["--connect", "udpin://127.0.0.1:9", "--yes", "--resume"], "no journal to resume from"),
        (
            ["--connect", "udpin://127.0.0.1:9", "--yes", "--out", "/proc/nowhere"],
            "/proc/nowhere: cannot be written",
        ),
    ],
)
def test_what_needs_no_plan_is_judged_before_there_is_one(tmp_path, options, words):
    out = [] if "--out" in options else ["--out", str(tmp_path)]
    answer = subprocess.run(
        [sys.executable, "-m", "mavspiral.cli", "fly", "missions/kiosk.toml", *options, *out],
        cwd=ROOT, capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert answer.returncode == 2 and answer.stdout == "", answer.stdout
    (line,) = answer.stderr.splitlines()
    assert words in line and "Fix:" in line
