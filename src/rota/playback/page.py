"""Plan and report -> one HTML page with the player, which opens from disk without a network."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from functools import cache
from html import escape
from pathlib import Path

import rota
from rota.check.report import DemandVerdict, Report
from rota.check.report_table import report_table
from rota.files.atomic_write import replaced_file, require_suffix
from rota.model.plan import Plan
from rota.planning.plan_summary import (
    RobotRow,
    bound_sentence,
    ratio_sentence,
    robot_rows,
    robots_sentence,
    round_off,
)
from rota.playback.playback import CELLS, playback_of

STATIC = Path(rota.__file__).parent / "web" / "static"
MODULES = STATIC / "js" / "player"
STYLES = ("vendor/leaflet/leaflet.css", "style/page.css", "style/player.css")
START = 'import "rota/page.js";'
IMPORTED = re.compile(r'^((?:import|export)\b[^"\n]*)"\./([\w-]+\.js)";$', re.MULTILINE)
PICTURE = re.compile(r"url\([^)]*\)")

MOST_BYTES = 1_000_000  # of the packed playback; with more, the cells are made larger
FEWEST_CELLS = 1_000


def write_page(plan: Plan, report: Report, path: str | Path) -> None:
    """Write the page of a plan to ``path``, whole or not at all; RotaError for another suffix than .html."""
    require_suffix(Path(path), (".html",), "a page")
    with replaced_file(path) as partial:
        partial.write_text(page_text(plan, report), encoding="utf-8", newline="\n")


def page_text(plan: Plan, report: Report, cells: int = CELLS) -> str:
    """The page: title, verdict and demands as text, then the map for browsers that run scripts; cells: the most."""
    leaflet = (STATIC / "vendor" / "leaflet" / "leaflet.js").read_text(encoding="utf-8")
    scripts = [_in_script(leaflet), json.dumps({"imports": _modules()}), START]
    hashes = " ".join(f"'sha256-{_hash(script)}'" for script in scripts)
    policy = f"default-src 'none'; script-src {hashes} data:; style-src 'unsafe-inline'; img-src data: blob:"
    style = "\n".join(PICTURE.sub("none", (STATIC / name).read_text(encoding="utf-8")) for name in STYLES)
    name = escape(plan.mission.name)
    packed = base64.b64encode(_packed_playback(plan, report, cells)).decode()
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{name}</title>
<style>{style}</style>
</head>
<body>
<header class="page-top"><h1>{name}</h1><p>{escape(robots_sentence(plan))} Verdict: {report.verdict}.</p></header>
<main>
<div class="page-stage">
<div id="map" role="application" aria-label="Map of the plan"></div>
<aside id="controls" aria-label="Player"><p id="message"><noscript>The map needs JavaScript. \
</noscript>The plan in words is below.</p></aside>
</div>
{_in_words(plan, report)}
</main>
<script type="application/octet-stream" id="playback">{packed}</script>
<script>{scripts[0]}</script>
<script type="importmap">{scripts[1]}</script>
<script type="module">{scripts[2]}</script>
</body>
</html>
"""


def _packed_playback(plan: Plan, report: Report, cells: int) -> bytes:
    """The playback by gzip, with fewer cells where it would be larger than ``MOST_BYTES``.

    Cells may take half of that at least, however much the robots' ways take.
    """
    packed = gzip.compress(playback_of(plan, report, cells), mtime=0)
    if len(packed) <= MOST_BYTES or cells <= FEWEST_CELLS:
        return packed
    least = gzip.compress(playback_of(plan, report, FEWEST_CELLS), mtime=0)
    taken, allowed = len(packed) - len(least), max(MOST_BYTES - len(least), MOST_BYTES / 2)
    if taken <= allowed:
        return packed
    fewer = max(FEWEST_CELLS, int(0.95 * cells * allowed / taken))
    return gzip.compress(playback_of(plan, report, fewer), mtime=0)


@cache
def _modules() -> dict[str, str]:
    """The player's modules by the names that an import map gives them; data: URLs, in which ./ has no meaning."""
    found = {}
    for file in sorted(MODULES.glob("*.js")):
        source = IMPORTED.sub(r'\1"rota/\2";', file.read_text(encoding="utf-8"))
        found[f"rota/{file.name}"] = "data:text/javascript;base64," + base64.b64encode(source.encode()).decode()
    return found


def _in_script(source: str) -> str:
    """A script's text that does not end its element."""
    return source.replace("</", "<\\/")


def _hash(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _in_words(plan: Plan, report: Report) -> str:
    """What is known of the plan, as text and tables."""
    sentences = [robots_sentence(plan), bound_sentence(plan), ratio_sentence(plan, report)]
    facts = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences if sentence)
    verdict = report_table(report).splitlines()[0]
    parts = [f'<section class="page-words"><h2>The plan</h2><p>{escape(verdict[0].upper() + verdict[1:])}.</p>']
    parts.append(f"<ul>{facts}</ul>")
    if report.demands:
        head = ("zone", "asks", "period, s", "worst gap, s", "area, m²", "left out, m²", "outcome")
        parts.append(_table("What is asked", head, [_demand_cells(demand) for demand in report.demands]))
    if any(trajectory.loop_duration_s for trajectory in plan):
        titles = ("robot", "loop, m", "loop, s", "slack", "serves")
        parts.append(_table("Robots", titles, [_robot_cells(row) for row in robot_rows(plan)]))
    if report.violations:
        wrong = "".join(f"<li>{escape(violation.text())}</li>" for violation in report.violations)
        parts.append(f"<h2>Violations</h2><ul>{wrong}</ul>")
    return "\n".join([*parts, "</section>"])


def _demand_cells(demand: DemandVerdict) -> tuple[str | float, ...]:
    asks = "visit" if demand.demand == "visit" else "every point"
    sizes = (demand.area_m2, demand.excluded_area_m2)
    return (demand.name, asks, demand.period_s, demand.worst_gap_s, *sizes, demand.outcome)


def _robot_cells(row: RobotRow) -> tuple[str | float, ...]:
    slack = "shared" if row.slack is None else f"{row.slack:.0%}"
    return row.robot, row.loop_length_m, row.loop_time_s, slack, ", ".join(row.zones) or "nothing"


def _table(caption: str, head: tuple[str, ...], rows: list[tuple[str | float, ...]]) -> str:
    """A heading and a table, which the keyboard can scroll; numbers to the right."""
    titles = "".join(f'<th scope="col">{escape(title)}</th>' for title in head)
    lines = "".join("<tr>" + "".join(_cell(value) for value in row) + "</tr>" for row in rows)
    region = f'<h2>{caption}</h2><div class="page-scroll" tabindex="0" role="region" aria-label="{caption}, in full">'
    return f"{region}<table><thead><tr>{titles}</tr></thead><tbody>{lines}</tbody></table></div>"


def _cell(value: str | float) -> str:
    if isinstance(value, str):
        return f"<td>{escape(value)}</td>"
    text = "never" if value == float("inf") else round_off(value)
    return f'<td class="number">{text}</td>'
