"""What a study's figures and tables hold, as data: tables and curves as CSV, all of a section as JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from typing import Any

from rota_studies.panels.cells_panel import HeatPanel
from rota_studies.panels.curve_panel import CurvePanel
from rota_studies.panels.map_panel import MapPanel
from rota_studies.panels.study_picture import Panel
from rota_studies.plain import plain
from rota_studies.section import Section

Json = dict[str, Any]
FORMS = ("svg", "pdf", "csv", "json")


def further_files(section: Section, forms: Iterable[str], stem: str) -> dict[str, bytes]:
    """Files of a section beside its page, by name. forms: of FORMS; stem: what names begin with."""
    files: dict[str, bytes] = {}
    for form in forms:
        if form == "csv":
            files |= {name: text.encode() for name, text in _csv_files(section, f"{stem}-figure-{section.figure}")}
        elif form == "json":
            text = json.dumps(section_data(section), ensure_ascii=False, indent=1, allow_nan=False) + "\n"
            files[f"{stem}-figure-{section.figure}.json"] = text.encode()
        else:
            for picture in section.pictures:
                files[f"{picture.file.removesuffix('.png')}.{form}"] = picture.drawn("svg" if form == "svg" else "pdf")
    return files


def section_data(section: Section) -> Json:
    """Panels and tables: marks (sensors, robots) and lines (frames, segments, ways) in metres, curves, cells, rows."""
    return {
        "figure": section.figure,
        "heading": section.heading,
        "verdicts": plain(section.verdicts),
        "panels": [_panel_data(panel) for picture in section.pictures for panel in picture.panels],
        "tables": [plain(table) for table in section.tables],
    }


def _panel_data(panel: Panel) -> Json:
    """One panel: only what it has."""
    found: Json = {"title": panel.title, "note": panel.note}
    if isinstance(panel, CurvePanel):
        found |= {"across": panel.across, "up": panel.up}
        found["curves"] = [
            {"label": one.label, "at": plain(one.places), "values": plain(one.values)}
            | ({} if one.band is None else {"least": plain(one.band[0]), "most": plain(one.band[1])})
            for one in panel.curves
        ]
        found["levels"] = [{"label": one.label, "value": plain(one.value)} for one in panel.levels]
    elif isinstance(panel, MapPanel):
        found["mission"] = panel.mission.name
        found["marks"] = [{"label": one.label, "places_m": plain(one.places_m)} for one in panel.dots]
        found["lines"] = [{"label": one.label, "paths_m": plain(one.paths_m)} for one in panel.strokes]
        if panel.plan is not None:
            found["robots"] = [
                {"robot": one.robot, "times_s": plain(one.times_s), "positions_m": plain(one.positions_m)}
                for one in panel.plan
            ]
        if isinstance(panel, HeatPanel):
            found |= {"cell_m": panel.cell_m, "cells": plain(panel.values)}
    else:
        found |= {"mission": panel.mission.name, "places_m": plain(panel.places_m)}
    return found


def _csv_files(section: Section, stem: str) -> Iterable[tuple[str, str]]:
    """A file for each table, and one for each panel of curves."""
    for k, table in enumerate(section.tables, 1):
        yield f"{stem}-table-{k}.csv", _csv([table.head, *table.rows])
    panels = [panel for picture in section.pictures for panel in picture.panels if isinstance(panel, CurvePanel)]
    for k, panel in enumerate(panels, 1):
        rows: list[Sequence[Any]] = [("curve", panel.across, panel.up, "least", "most")]
        for curve in panel.curves:
            band = curve.band if curve.band is not None else ([""] * len(curve.values),) * 2
            columns = (plain(curve.places), plain(curve.values), *map(plain, band))
            rows += [(curve.label, *row) for row in zip(*columns, strict=True)]
        yield f"{stem}-curves-{k}.csv", _csv(rows)


def _csv(rows: Iterable[Sequence[Any]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()
