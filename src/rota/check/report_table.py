"""The verdict on a plan as plain text, for people."""

from __future__ import annotations

import math

from rota.check.report import DemandVerdict, Report, number_text

TOLD = 5  # parts of the ground that cannot be reached


def report_table(report: Report) -> str:
    """The report as plain text: the verdict, one row per demand, then every violation on a line of its own."""
    claimed = report.lower_bound_robots
    bound = "not known" if claimed is None else f"{claimed} by the plan's own word"
    first = "never" if report.first_coverage_s is None else f"within {number_text(report.first_coverage_s)} s"
    extent = f"all seen once: {first}" if report.demands else "nothing is asked of the ground"
    if report.cells_entered is not None:
        extent = "cells entered: {} of {}".format(*report.cells_entered)
    lines = [f"verdict: {report.verdict}{_since(report)}", f"robots: {report.robots} (lower bound: {bound}); {extent}"]
    if report.run_end is not None:
        lines.append(f"the plan says that its run was {report.run_end.text()}")
    lines += _holding_lines(report)
    lines += [] if report.lateness is None else report.lateness.lines()
    if report.clock_margin_s is not None:
        lines.append(clocks_text(report.clock_margin_s))
    lines += _demand_rows(report) if report.demands else []
    lines += [margin.text() for margin in report.margins]
    lines += [f"not judged: {open_claim}" for open_claim in report.not_judged]
    return "\n".join([*lines, *(f"violation: {violation.text()}" for violation in report.violations)])


def _holding_lines(report: Report) -> list[str]:
    """What a swarm has where it holds, and what of the ground no robot can reach; nothing of other plans."""
    held = report.holding
    if held is None:
        return []
    share = 1 / held.ground_m2 if held.ground_m2 > 0 else 0.0
    when = "held at last" if held.in_range_least_m2 is None else "as loops begin"
    lines = [f"{when}: {held.in_range_m2 * share:.1%} of the ground in range"]
    if held.seen_m2 < held.in_range_m2 - 1e-9 * held.ground_m2:
        lines[0] += f", {held.seen_m2 * share:.1%} seen through no wall"
    if held.importance_in_range is not None:
        lines[0] += f", {held.importance_in_range:.1%} of its importance in range"
    if held.in_range_least_m2 is not None and held.in_range_mean_m2 is not None:
        least, mean = held.in_range_least_m2 * share, held.in_range_mean_m2 * share
        lines.append(f"over a loop: {least:.1%} in range at worst, {mean:.1%} on average")
    lines += [
        f"no robot can reach {number_text(area_m2)} m2 at ({x:.2f}, {y:.2f})" for x, y, area_m2 in held.unreached[:TOLD]
    ]
    if len(held.unreached) > TOLD:
        lines.append(f"nor {len(held.unreached) - TOLD} smaller parts")
    return lines


def met_text(report: Report) -> str:
    """That a plan is met, and from when on, as a sentence."""
    return f"met, every demand, for ever{_since(report)}." if report.demands else "no violations."


def _since(report: Report) -> str:
    """From when on a verdict "met" holds, where that is not from the beginning; else nothing."""
    late = report.verdict == "met" and report.demands and report.holds_from_s > 0
    return f" from t = {number_text(report.holds_from_s)} s on" if late else ""


def clocks_text(margin_s: float) -> str:
    """How far robots' clocks may differ, in words."""
    if math.isinf(margin_s):
        return "clocks may differ by any time: bodies never touch"
    return f"clocks may differ by {number_text(math.floor(1e3 * margin_s) / 1e3)} s before bodies touch"


def _demand_rows(report: Report) -> list[str]:
    """An empty line, a table with a row per demand, and what each of them leaves out."""
    lines = [""]
    rows = [
        ("demand", "asks", "period s", "worst gap s", "area m2", "unseen m2", "excluded m2", "undecided", "outcome")
    ]
    for d in report.demands:
        rows.append(
            (
                d.name,
                d.demand,
                number_text(d.period_s),
                _bracket(d),
                number_text(d.area_m2),
                _unseen(d),
                number_text(d.excluded_area_m2),
                str(d.undecided_cells),
                d.outcome,
            )
        )
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    words = {0, 1, len(rows[0]) - 1}
    for row in rows:
        cells = [c.ljust(w) if k in words else c.rjust(w) for k, (c, w) in enumerate(zip(row, widths, strict=True))]
        lines.append("  ".join(cells).rstrip())
    for d in report.demands:
        for x, y, area in d.excluded_places:
            lines.append(f"nobody can see ({x:.2f}, {y:.2f}) in {d.name}: {number_text(area)} m2 excluded")
    return lines


def _unseen(d: DemandVerdict) -> str:
    """The area that is never seen as text; what is never seen may be narrower than any piece that was looked at."""
    narrow = math.isinf(d.worst_gap_at_least_s) and d.unseen_area_m2 == 0
    return "> 0" if narrow else number_text(d.unseen_area_m2)


def _bracket(d: DemandVerdict) -> str:
    """The worst gap as text: one number, or the bracket that holds it."""
    low, high = number_text(d.worst_gap_at_least_s), number_text(d.worst_gap_s)
    return low if low == high else f"{low} to {high}"
