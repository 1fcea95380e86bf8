"""The cells of a sweep: every combination of mission, planner, effort and settings, with every seed."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rota.errors import RotaError
from rota.files.mission_file import mission_document, mission_of
from rota.files.mission_json import mission_to_json
from rota.files.sweep_file import ReadSweep, SweepFile
from rota.files.yaml_text import Document
from rota.model.mission import Mission
from rota.model.planner_registry import DEFAULT, planner_names
from rota.model.planner_settings import settings_of
from rota.planning.planner import planner_named

KEY_LENGTH = 20  # hexadecimal digits: a million cells share one with a chance of 1e-12


@dataclass(frozen=True, kw_only=True)
class Combination:
    """One mission as one planner is to plan it, with each of the sweep's seeds.

    mission_file: as the sweep names it. effort: that the sweep asks for; None: as the mission says. settings: values by
    field path. mission: None where it is refused, for the reason ``refused``.
    """

    mission_file: str
    planner: str
    effort: str | None
    settings: Mapping[str, Any]
    mission: Mission | None
    refused: str | None = None

    @property
    def label(self) -> str:
        """The combination in words."""
        parts = [self.mission_file, self.planner, self.effort or ""]
        return " ".join(filter(None, [*parts, *(f"{path}={value}" for path, value in self.settings.items())]))


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One plan to be made. key: the same for the same mission, settings, seed, time limit and version of Rota."""

    combination: Combination
    seed: int
    time_limit_s: float | None
    key: str

    @property
    def plan_name(self) -> str:
        """The name of its plan file: to be told by people, and its own by the key."""
        stem = "".join(
            mark if mark.isalnum() or mark in "-_" else "-" for mark in Path(self.combination.mission_file).stem
        )
        return f"{stem[:60]}-{self.combination.planner}-seed{self.seed}-{self.key}.rota.json"


def cells_of(sweep: ReadSweep) -> list[Cell]:
    """All cells in the order in which they are planned: the seeds of a combination follow each other."""
    limit_s = sweep.file.time_limit_s
    cells = []
    for combination in combinations(sweep):
        asked = (
            {"refused": combination.refused} if combination.mission is None else mission_to_json(combination.mission)
        )
        place = [combination.mission_file, combination.planner, combination.effort, dict(combination.settings)]
        digest = hashlib.sha256(_canonical([version("rota"), place, asked, limit_s]))
        for seed in sweep.file.all_seeds:
            own = digest.copy()
            own.update(str(seed).encode())
            key = own.hexdigest()[:KEY_LENGTH]
            cells.append(Cell(combination=combination, seed=seed, time_limit_s=limit_s, key=key))
    return cells


def _canonical(value: object) -> bytes:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), default=str).encode()


def combinations(sweep: ReadSweep) -> Iterator[Combination]:
    """Every mission by every planner, effort and choice of settings.

    Settings of another planner's block, and efforts of planners that have none, make no difference: such combinations
    are there once.
    """
    for mission_file, path in sweep.missions.items():
        document, refused = _parse(path)
        own = document.value.get("planner", DEFAULT) if document and isinstance(document.value, dict) else DEFAULT
        for planner in sweep.file.planners or [own]:
            for effort, settings in _choices(sweep.file, str(planner)):
                mission, reason = None, refused
                if document is not None:
                    mission, reason = _resolve(document, path.parent, str(planner), effort, settings)
                yield Combination(
                    mission_file=mission_file, planner=str(planner), effort=effort, settings=settings, mission=mission,
                    refused=reason,
                )  # fmt: skip


def _parse(path: Path) -> tuple[Document | None, str | None]:
    try:
        return mission_document(path), None
    except RotaError as error:
        return None, str(error)


def _choices(file: SweepFile, planner: str) -> Iterator[tuple[str | None, dict[str, Any]]]:
    """Efforts and settings that make a difference to this planner."""
    efforts: list[Any] = [None]
    if file.efforts is not None and planner in planner_names():
        has_effort = any(item.name == "effort" for item in settings_of(planner_named(planner).settings))
        efforts = list(file.efforts) if has_effort else efforts
    others = [name for name in planner_names() if name != planner]
    axes = {path: values for path, values in file.settings.items() if path.split(".")[0] not in others}
    for effort in efforts:
        for values in itertools.product(*axes.values()):
            yield effort, dict(zip(axes, values, strict=True))


def _resolve(
    document: Document, folder: Path, planner: str, effort: str | None, settings: Mapping[str, Any]
) -> tuple[Mission | None, str | None]:
    """The mission as it is to be planned, or why it is refused."""
    overrides: dict[str, Any] = {}
    if isinstance(document.value, dict) and document.value.get("planner", DEFAULT) != planner:
        blocks = [name for name in planner_names() if name != planner and name in document.value]
        overrides = {"planner": planner, **dict.fromkeys(blocks)}
    if effort is not None:
        overrides[f"{planner}.effort"] = effort
    try:
        return mission_of(document, folder, overrides={**overrides, **settings}).mission, None
    except RotaError as error:
        return None, str(error)
