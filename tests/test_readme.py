"""The README is true: its verbs and options exist, its Python runs, its files are there."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_two_command_lines_stand_between_the_markers():
    block = README.split("<!-- ci:begin -->")[1].split("<!-- ci:end -->")[0]
    lines = [line for line in block.splitlines() if line.startswith("pip install")]
    assert lines == [
        "pip install . && mavspiral simulate missions/torre.toml",
        "pip install '.[test]' && pytest -n 2 --dist loadfile",
    ]


def offered(help_text):
    """The options at the head of a line of what --help says."""
    return set(re.findall(r"^ *(?:-h, )?(--[a-z-]+)", help_text, re.M))


def test_every_picture_and_file_is_there():
    for path in re.findall(r"\]\((?!http)([^)]+)\)", README) + re.findall(
        r"\b(?:missions|tests)/[\w/.]+\w", README
    ):
        assert (ROOT / path).exists(), path


@pytest.mark.parametrize("verb", ["plan", "simulate", "fly", "upload", "check"])
def test_a_verbs_row_names_the_options_that_there_are_and_all_of_them(verb):
    row = next(line for line in README.splitlines() if line.startswith(f"| `mavspiral {verb} "))
    wide = {**os.environ, "COLUMNS": "200"}
    text = subprocess.run(
        [sys.executable, "-m", "mavspiral.cli", verb, "--help"],
        capture_output=True,
        text=True,
        check=True,
        env=wide,
    ).stdout
    assert set(re.findall(r"--[a-z-]+", row)) | {"--help"} == offered(text)


def test_the_vehicles_row_names_the_options_that_there_are_and_all_of_them():
    row = next(line for line in README.splitlines() if line.startswith("| `python -m sitl "))
    text = subprocess.run(
        [sys.executable, "-m", "sitl", "--help"], capture_output=True, text=True, check=True
    ).stdout
    assert set(re.findall(r"--[a-z-]+", row)) | {"--help"} == offered(text)


def test_its_python_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    flies, tests = re.findall(r"```python\n(.*?)```", README, re.S)
    exec(compile(flies, "README.md", "exec"), {})
    compile(tests, "README.md", "exec")  # tests/foreign runs the like
