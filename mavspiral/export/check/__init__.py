"""Will QGroundControl load this `.plan`, and will this autopilot take it? Any plan, ours or not."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mavspiral.export.check.autopilot_rules import judge_items
from mavspiral.export.check.dialects import DIALECTS
from mavspiral.export.check.fence_rules import judge_fence
from mavspiral.export.check.findings import Findings
from mavspiral.export.check.loading import judge_loading
from mavspiral.export.check.plan_json import read_plan_json

__all__ = ["Verdict", "check_document", "check_file"]

FIRMWARE = {12: "px4", 3: "ardupilot"}


@dataclass(frozen=True, slots=True)
class Verdict:
    """What was found in a plan. `autopilot` is the one that it was held against, None if the plan names none we know."""

    autopilot: str | None
    items: int
    errors: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether it loads and is taken."""
        return not self.errors

    def summary(self) -> dict[str, Any]:
        """The keys of `check --json`."""
        return {
            "ok": self.ok,
            "autopilot": self.autopilot,
            "items": self.items,
            "errors": list(self.errors),
            "warnings": list(self.warnings),
        }


def check_file(path: Path, autopilot: str | None = None) -> Verdict:
    """The verdict on a file; `autopilot` is "px4" or "ardupilot", by default the plan's own firmwareType.

    Raises:
        InputError: it is no JSON object.
    """
    return check_document(read_plan_json(path), autopilot)


def check_document(document: dict[str, Any], autopilot: str | None = None) -> Verdict:
    """The verdict on a plan that is JSON already."""
    findings = Findings()
    parts = judge_loading(document, findings)
    own = None if parts.firmware is None else FIRMWARE.get(parts.firmware)
    chosen = autopilot or own
    if chosen is None:
        if parts.items or not findings.errors:
            findings.warning(
                "mission.firmwareType", "is neither PX4 (12) nor ArduPilot (3): no autopilot was asked"
            )
    else:
        if own is not None and own != chosen:
            findings.error(
                "mission.firmwareType",
                f"was made for {DIALECTS[own].name}, not {DIALECTS[chosen].name}, so that `mavspiral upload` refuses it. "
                f'Fix: [vehicle] autopilot = "{chosen}", and plan it again; another\'s plan: save it anew with such a vehicle',
            )
        judge_items(parts, DIALECTS[chosen], findings)
        judge_fence(parts, chosen, findings)
    return Verdict(chosen, len(parts.items) + parts.made_n, findings.errors, findings.warnings)
