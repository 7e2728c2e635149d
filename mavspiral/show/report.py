"""The flight on one page that stands alone: verdict, figures, picture, warnings, events."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable
from pathlib import Path

__all__ = ["report_html"]

_STYLE = """
body{font:15px/1.5 system-ui,sans-serif;color:#22303c;max-width:1080px;margin:2.5rem auto;padding:0 1rem}
h1{font-size:1.7rem;margin:0} p.sub{color:#5b6b7a;margin:.2rem 0 1.2rem}
.verdict{display:inline-block;padding:.25rem .8rem;border-radius:1rem;color:#fff;font-weight:600}
.pass{background:#2e7d32}.fail{background:#c62828}
table{border-collapse:collapse;margin:1rem 0 1.6rem;min-width:26rem}
th,td{text-align:left;padding:.3rem 1.2rem .3rem 0;border-bottom:1px solid #e3e8ed;vertical-align:top}
td.n,th.n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums} img{max-width:100%;border:1px solid #e3e8ed}
li{margin:.15rem 0} .events td{border:0;padding:.1rem 1.2rem .1rem 0} .warning{color:#8a5200}.error{color:#c62828}
"""


def report_html(
    *,
    title: str,
    subtitle: str,
    passed: bool,
    failures: Iterable[str],
    warnings: Iterable[str],
    figures: Iterable[tuple[str, str, str]],
    events: Iterable[tuple[float, str, str]],
    picture: Path,
) -> str:
    """A whole HTML page; `figures` are name, value and what is asked of it, `events` time, severity and text."""
    image = base64.b64encode(picture.read_bytes()).decode("ascii")
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td class=n>{html.escape(value)}</td><td>{html.escape(asked)}</td></tr>"
        for name, value, asked in figures
    )
    told = "".join(
        f'<tr class="{html.escape(severity)}"><td class=n>{t_s:.1f} s</td>'
        f"<td>{'' if severity == 'info' else html.escape(severity)}</td><td>{html.escape(text)}</td></tr>"
        for t_s, severity, text in events
    )
    failed, warned = _listed(failures, "error"), _listed(warnings, "warning")
    verdict = (
        "<span class='verdict pass'>passed</span>" if passed else "<span class='verdict fail'>failed</span>"
    )
    return (
        "<!doctype html><html lang=en><meta charset=utf-8>"
        '<meta name=viewport content="width=device-width, initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{_STYLE}</style>"
        f"<h1>{html.escape(title)} {verdict}</h1><p class=sub>{html.escape(subtitle)}</p>"
        + failed
        + f"<table><tr><th>figure</th><th class=n>measured</th><th>asked</th></tr>{rows}</table>"
        f'<img alt="planned and flown path" src="data:image/png;base64,{image}">'
        + (f"<h2>Warnings of the plan</h2>{warned}" if warned else "")
        + f"<h2>Events</h2><table class=events>{told}</table></html>\n"
    )


def _listed(lines: Iterable[str], severity: str) -> str:
    items = "".join(f"<li class={severity}>{html.escape(line)}</li>" for line in lines)
    return f"<ul>{items}</ul>" if items else ""
