"""What the verbs say on the terminal: tables and lines, or one JSON object."""

from __future__ import annotations

import contextlib
import json
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from mavspiral.errors import InputError, LimitError

if TYPE_CHECKING:
    from mavspiral.export.check import Verdict
    from mavspiral.mission import Mission
    from mavspiral.uploads import Uploaded

__all__ = [
    "failures_as_json",
    "must_be_asked",
    "stage_bar",
    "tell",
    "tell_json",
    "tell_uploaded",
    "tell_verdict",
]

PATIENCE_S = 1.0


def tell_json(summary: dict[str, Any]) -> None:
    """Prints the one JSON object."""
    print(json.dumps(summary, ensure_ascii=False, allow_nan=False))


def tell(summary: dict[str, Any], as_json: bool, rows: list[tuple[str, str, str]]) -> None:
    """Prints a verb's summary: figures as a table of `rows`, then warnings, failures, verdict and files; no table without rows."""
    if as_json:
        tell_json(summary)
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(highlight=False)
    table = Table(
        title=summary["name"], title_justify="left", title_style="bold", box=None, padding=(0, 2, 0, 0)
    )
    for header, side in (("figure", "left"), ("value", "right"), ("asked", "left")):
        table.add_column(header, justify=side, header_style="dim")  # type: ignore[arg-type]  # one of rich's words
    for row in rows:
        table.add_row(*row)
    if rows:
        console.print(table)
    # Texts, not markup: a line that begins with [accept] must not be taken for a style.
    for word, style, key in (("warning", "yellow", "warnings"), ("failed", "red", "failures")):
        for line in summary.get(key, ()):
            console.print(Text.assemble((word, style), " ", line), soft_wrap=True)
    if "passed" in summary:
        console.print(Text("passed", "green") if summary["passed"] else Text("failed", "red"))
    files = sorted(summary.get("files", {}).values())
    if files:
        console.print(Text(f"wrote {len(files)} files to {Path(files[0]).parent}", "dim"), soft_wrap=True)


def tell_uploaded(source: Path, uploaded: Uploaded) -> None:
    """Prints in what the vehicle's mission differs from ours, a line each, and how much of it was uploaded."""
    for line in uploaded.differences:
        print(line)
    print(
        f"{source.name}: {uploaded.items} items, {uploaded.fence} of the fence, {uploaded.rally} rally points: "
        f"{uploaded.outcome.reason}"
    )


def tell_verdict(path: Path, verdict: Verdict) -> None:
    """Prints what `check` found in the file, line by line."""
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False)
    for word, style, lines in (("error", "red", verdict.errors), ("warning", "yellow", verdict.warnings)):
        for line in lines:
            console.print(Text.assemble((word, style), " ", line), soft_wrap=True)
    words = "loads and is taken" if verdict.ok else "does not pass"
    asked = f", held against {verdict.autopilot}" if verdict.autopilot else ""
    console.print(
        Text(f"{path.name}: {verdict.items} items{asked}: {words}", "green" if verdict.ok else "red"),
        soft_wrap=True,
    )


@contextlib.contextmanager
def failures_as_json(mission: Mission, as_json: bool) -> Iterator[None]:
    """What was worked out and does not hold is an answer too: with --json an object with its failures, exit 1."""
    try:
        yield
    except LimitError as error:
        if not as_json:
            raise
        tell_json({"name": mission.name, "passed": False, "failures": [str(error)]})
        raise typer.Exit(error.exit_code) from None


@contextlib.contextmanager
def stage_bar(stages: Sequence[str], as_json: bool) -> Iterator[Callable[[str, float], None]]:
    """A bar of what is done of the stages, on a terminal's stderr, for work that takes longer than `PATIENCE_S`.

    It gives what is to be told which share of a stage is done; the last one takes half of the bar.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    console = Console(stderr=True)
    if as_json or not console.is_terminal:
        yield lambda stage, share: None
        return
    columns = TextColumn("planning"), BarColumn(), TextColumn("{task.description}")
    progress = Progress(*columns, console=console, transient=True)
    weights = [*[1.0] * (len(stages) - 1), max(1.0, len(stages) - 1.0)]
    task = progress.add_task(stages[0], total=sum(weights))

    def told(stage: str, share: float) -> None:
        k = stages.index(stage)
        done = sum(weights[:k]) + share * weights[k]
        here = stages[min(k + (share >= 1.0), len(stages) - 1)]
        progress.update(task, completed=done, description=here)
        if done == sum(weights):  # what follows, a flight perhaps, is none of the bar's
            stop()

    def stop() -> None:
        late.cancel()
        late.join()
        progress.stop()

    late = threading.Timer(PATIENCE_S, progress.start)
    late.start()
    try:
        yield told
    finally:
        stop()


def must_be_asked(what: str, fix: str) -> None:
    """Nothing, where somebody is there to be asked.

    Raises:
        InputError: nobody is.
    """
    if not sys.stdin.isatty():
        raise InputError(f"{what}: nobody is there to be asked. Fix: {fix}")
