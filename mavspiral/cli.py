"""The verbs. Only they exit, and they print by `terminal`; only `main` has lines of its own, on stderr.

Exit codes: 0 it holds · 1 it was worked out and does not hold · 2 the input contradicts itself or cannot be
read · 3 nobody at the other end of the link.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from mavspiral.arguments import (
    Connect,
    Json,
    MissionFile,
    OfAutopilot,
    Out,
    Signing,
    System,
    autopilot_named,
    place_named,
)
from mavspiral.errors import STOPPED, MavspiralError
from mavspiral.terminal import (
    failures_as_json,
    must_be_asked,
    stage_bar,
    tell,
    tell_json,
    tell_uploaded,
    tell_verdict,
)

if TYPE_CHECKING:
    from mavspiral.mission import Mission

__all__ = ["app", "main"]

app = typer.Typer(
    help="One smooth spiral around a building: planned, flown in simulation, measured, and flown for real.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

UsageError: Any = typer.BadParameter.__base__
"""Of click, whether typer imports it or brings its own."""


def main() -> None:
    """Runs the verb of the command line; errors are one line each, and their exit codes."""
    for stream in (sys.stdout, sys.stderr):  # a console that knows no ² gets a question mark, not a traceback
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        code = app(sys.argv[1:] or ["--help"], prog_name="mavspiral", standalone_mode=False)
        if code == STOPPED:  # typer has eaten the KeyboardInterrupt
            print("mavspiral: stopped", file=sys.stderr)
        sys.exit(code if isinstance(code, int) else 0)
    except UsageError as error:
        verb = f"mavspiral {error.ctx.info_name}" if error.ctx and error.ctx.parent else "mavspiral"
        message = " ".join(error.format_message().split()).rstrip(".")
        print(
            f"{verb}: {message[:1].lower()}{message[1:]}. Fix: {verb} --help lists what it takes",
            file=sys.stderr,
        )
        sys.exit(2)
    except typer.Abort as error:
        print("mavspiral: stopped", file=sys.stderr)
        sys.exit(STOPPED if isinstance(error.__cause__ or error.__context__, KeyboardInterrupt) else 1)
    except MavspiralError as error:
        print(f"mavspiral: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        print("mavspiral: stopped", file=sys.stderr)
        sys.exit(STOPPED)
    except OSError as error:  # stdout is closed or full
        with contextlib.suppress(OSError):
            print(f"mavspiral: cannot write to the terminal: {error.strerror}", file=sys.stderr)
        os._exit(1)


@app.command()
def plan(mission: MissionFile, out: Out = None, as_json: Json = False) -> None:
    """Plan the inspection, judge it, write its files.

    NAME.plan, .waypoints, .csv, .photos.csv, .kml, .geojson, .png and .json.
    """
    from mavspiral.deliver import write_plan
    from mavspiral.planner import STAGES
    from mavspiral.planner import plan as make_plan
    from mavspiral.show.rows import plan_rows

    brief = _load(mission)
    with failures_as_json(brief, as_json), stage_bar(STAGES, as_json) as on_stage:
        inspection = make_plan(brief, on_stage)
    summary = inspection.summary()
    summary["files"] = write_plan(inspection, _folder(out, brief), summary)
    tell(summary, as_json, plan_rows(summary))


@app.command()
def simulate(
    mission: MissionFile,
    wind: Annotated[
        float, typer.Option("--wind", metavar="MPS", help="Mean wind from the west, m/s.", min=0.0, max=30.0)
    ] = 0.0,
    gust: Annotated[bool, typer.Option("--gust", help="Add Dryden gusts to the wind.")] = False,
    seed: Annotated[
        int, typer.Option("--seed", metavar="N", help="Of every random number; same seed, same bits.", min=0)
    ] = 0,
    fault: Annotated[
        list[str] | None,
        typer.Option("--fault", metavar="SPEC", help="NAME[=VALUE]@START[+DURATION], e.g. motor=2:0.5@60s."),
    ] = None,
    via: Annotated[
        Literal["stream", "mission"],
        typer.Option("--via", help="Stream setpoints, or upload the exported mission and fly it in AUTO."),
    ] = "stream",
    set_failsafes: Annotated[
        bool, typer.Option("--set-failsafes", help="Fly with the vehicle's failsafes set, as fly does.")
    ] = False,
    autopilot: OfAutopilot = None,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Fly it against the bundled vehicle, and measure it.

    Closed loop, in lockstep; judged against the mission's [accept].
    """
    from mavspiral.closedloop import simulate as fly_simulated
    from mavspiral.deliver import write_flight
    from mavspiral.files import try_folder
    from mavspiral.planner import STAGES
    from mavspiral.show.rows import flight_rows

    brief = _load(mission)
    folder = try_folder(_folder(out, brief))
    with failures_as_json(brief, as_json), stage_bar(STAGES, as_json) as on_stage:
        flight = fly_simulated(
            brief,
            seed=seed,
            wind_mps=wind,
            gusts=gust,
            faults=tuple(fault or ()),
            autopilot=autopilot_named(autopilot),
            via=via,
            set_failsafes=set_failsafes,
            on_stage=on_stage,
        )
    summary = flight.summary()
    summary["files"] = write_flight(flight, folder, summary)
    tell(summary, as_json, flight_rows(summary, brief))
    if not flight.passed:
        raise typer.Exit(1)


@app.command()
def fly(
    mission: MissionFile,
    connect: Connect,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Do everything but arm.")] = False,
    rate: Annotated[
        float, typer.Option("--rate", metavar="HZ", help="Setpoints a second.", min=10.0, max=100.0)
    ] = 50.0,
    signing: Signing = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on where the flights in NAME.journal ended.")
    ] = False,
    set_failsafes: Annotated[
        bool,
        typer.Option(
            "--set-failsafes", help="Set what the vehicle does without a link, for this flight; else warn."
        ),
    ] = False,
    align: Annotated[
        str | None,
        typer.Option(
            "--align",
            metavar="PLACE",
            help="LAT,LON or home: the place on the map where it stands; the plan is shifted by how far off that is.",
        ),
    ] = None,
    autopilot: OfAutopilot = None,
    system: System = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before flying.")] = False,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Fly it with a real vehicle, setpoint by setpoint.

    Connect, check, arm, take off, inspect, return, land.
    """
    from mavspiral.console import Console
    from mavspiral.deliver import write_live
    from mavspiral.files import try_folder
    from mavspiral.flight.journal import read_journal
    from mavspiral.flight.signing import read_key
    from mavspiral.flight.transports import judge_url
    from mavspiral.live import fly as fly_live
    from mavspiral.planner import STAGES
    from mavspiral.planner import plan as make_plan
    from mavspiral.show.rows import live_rows, plan_rows

    # All that can be judged without the plan is judged before it: a large one takes a minute.
    brief = _load(mission)
    judge_url(connect)
    key = None if signing is None else read_key(signing)
    align_at, dialect = None if align is None else place_named(align), autopilot_named(autopilot)
    if not (yes or dry_run):
        must_be_asked(f"fly {brief.name}", f"--yes, if the vehicle at {connect} may take off")
    elif align_at is not None and not yes:
        must_be_asked(f"fly {brief.name}: the shift", "--yes, if it may be taken")
    folder = try_folder(_folder(out, brief))
    if resume:
        read_journal(folder / f"{brief.name}.journal")
    with failures_as_json(brief, as_json), stage_bar(STAGES, as_json) as on_stage:
        inspection = make_plan(brief, on_stage)
    if not as_json:
        planned = inspection.summary()
        tell(planned, as_json, plan_rows(planned))
    with Console(quiet=as_json, yes=yes) as console:
        flight = fly_live(
            inspection,
            connect,
            dry_run=dry_run,
            rate_hz=rate,
            signing_key=key,
            folder=folder,
            resume=resume,
            set_failsafes=set_failsafes,
            autopilot=dialect,
            system_id=system,
            align_at=align_at,
            asks=not (yes or dry_run),
            approve=console.approve,
            wished=console.wish,
            on_event=console.say,
        )
    summary = flight.summary()
    summary["files"] = write_live(flight, folder, summary)
    tell(summary, as_json, live_rows(summary))
    if flight.outcome.exit_code:
        raise typer.Exit(flight.outcome.exit_code)


@app.command()
def check(
    plan_file: Annotated[
        Path, typer.Argument(help="A .plan, ours or not.", metavar="PLAN", show_default=False)
    ],
    autopilot: Annotated[
        Literal["px4", "ardupilot"] | None,
        typer.Option("--autopilot", help="Who shall take it; by default whom it was made for."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Judge a .plan: will it load, and be flown?

    Will QGroundControl load it, and will the autopilot take it: item by item, with the reason.
    """
    from mavspiral.export.check import check_file

    verdict = check_file(plan_file, autopilot)
    if as_json:
        tell_json(verdict.summary())
    else:
        tell_verdict(plan_file, verdict)
    if not verdict.ok:
        raise typer.Exit(1)


@app.command()
def upload(
    source: Annotated[
        Path,
        typer.Argument(
            help="A .plan, or a mission file (TOML) to plan first.", metavar="SOURCE", show_default=False
        ),
    ],
    connect: Connect,
    signing: Signing = None,
    system: System = None,
    as_json: Json = False,
) -> None:
    """Upload mission, fence and rally points.

    And read them back, and compare them item by item.
    """
    from mavspiral.console import Console
    from mavspiral.export.check.plan_json import read_plan_json
    from mavspiral.flight.signing import read_key
    from mavspiral.flight.transports import judge_url
    from mavspiral.uploads import upload as upload_plan

    judge_url(connect)
    key = None if signing is None else read_key(signing)
    if source.suffix == ".toml":
        from mavspiral.handover import the_document
        from mavspiral.planner import STAGES
        from mavspiral.planner import plan as make_plan

        with stage_bar(STAGES, as_json) as on_stage:
            inspection = make_plan(_load(source), on_stage)
        document = the_document(inspection)
    else:
        document = read_plan_json(source)
    with Console(quiet=as_json) as console:
        uploaded = upload_plan(document, connect, signing_key=key, system_id=system, on_event=console.say)
    if as_json:
        tell_json(uploaded.summary())
    else:
        tell_uploaded(source, uploaded)
    if uploaded.outcome.exit_code:
        raise typer.Exit(uploaded.outcome.exit_code)


def _load(path: Path) -> Mission:
    from mavspiral.mission import load_mission

    return load_mission(path)


def _folder(out: Path | None, mission: Mission) -> Path:
    return out if out is not None else Path("out") / mission.name


if __name__ == "__main__":
    main()
