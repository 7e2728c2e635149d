"""MAVProxy without windows, and a user at its prompt."""

import contextlib
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from patience import LIMIT_S

PATIENCE_S = 10.0


def mavproxy():
    """Where `mavproxy.py` is: beside this Python, or on the PATH.

    It is in no extra: its wheel wants opencv-python, which overwrites our opencv-python-headless, and 1.2 GB with vtk.
    What it does here needs pymavlink, pyserial and lxml alone: `pip install --no-deps MAVProxy`, as CI does.
    """
    beside = Path(sys.executable).with_name("mavproxy.py")
    found = str(beside) if beside.exists() else shutil.which("mavproxy.py")
    if found is None:
        pytest.skip("no mavproxy.py here: pip install --no-deps MAVProxy")
    return found


class Prompt:
    """What is typed, and what has been printed since."""

    def __init__(self, process):
        self._process = process
        self._printed = ""
        self._seen = 0
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        for line in self._process.stdout:
            self._printed += line

    def sees(self, pattern, limit_s=LIMIT_S):
        """Wait until it is printed after what was seen last."""
        match = self._found(pattern, limit_s)
        assert match, (
            f"{pattern!r} is not in\n{self._printed[self._seen :]}\nafter\n{self._printed[: self._seen]}"
        )
        return match

    def types(self, line, answer, patience_s=PATIENCE_S):
        """Type a line and wait for its answer; type it again where none comes.

        MAVProxy asks once for a list. On a busy machine its socket overflows, and the one answer may be among the lost.
        """
        for _ in range(round(LIMIT_S / patience_s)):
            self._type(line)
            match = self._found(answer, patience_s)
            if match:
                return match
        raise AssertionError(f"{answer!r} is not in\n{self._printed[self._seen :]}\nafter {line!r}")

    def asks(self, line, answer, holds=bool, limit_s=LIMIT_S):
        """Type a question until its answer is one that holds."""
        deadline = time.monotonic() + limit_s
        match = None
        while time.monotonic() < deadline:
            self._type(line)
            match = self._found(answer, 1.0)
            if match and holds(match):
                return match
        raise AssertionError(f"{line!r}: {match}, after\n{self._printed}")

    def _type(self, line):
        time.sleep(0.2)  # nobody types faster
        self._seen = len(self._printed)
        self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()

    def _found(self, pattern, limit_s):
        deadline = time.monotonic() + limit_s
        while time.monotonic() < deadline:
            match = re.compile(pattern).search(self._printed, self._seen)
            if match:
                self._seen = match.end()
                return match
            time.sleep(0.05)
        return None


@contextlib.contextmanager
def session(master, folder):
    """`mavproxy.py --master=…`, its logs in the folder."""
    process = subprocess.Popen(
        [
            *(mavproxy(), f"--master={master}", f"--state-basedir={folder}"),
            *(f"--logfile={folder / 'mav.tlog'}", "--retries=30"),
        ],
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        yield Prompt(process)
    finally:
        process.kill()
        process.wait()
