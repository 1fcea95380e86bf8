"""Sweep files: which missions, planners, efforts, settings and seeds to plan; faults with file, line, column, field."""

from __future__ import annotations

import glob
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

from rota.errors import MissionError
from rota.files.blocks import Block, Fault, block_of, lines_of_faults, nearest_key, read_block
from rota.files.json_schema import file_schema
from rota.files.local_file import read_text
from rota.files.shape_schema import TEXT
from rota.files.yaml_text import Document, parse_text
from rota.model.fields import field_of
from rota.model.limits import DURATION
from rota.model.planner_registry import planner_names
from rota.model.refusals import Where, show_value

MOST_SEEDS = 1_000_000
SEED: dict[str, Any] = {"least": 0, "most": 2**32}


@dataclass(frozen=True, kw_only=True)
class SeedRange:
    """So many seeds in a row."""

    first: int = field_of(0, **SEED)
    count: int = field_of(least=1, most=MOST_SEEDS)


@dataclass(frozen=True, kw_only=True)
class SweepFile:
    """What a sweep plans: each mission by each planner, effort and choice of settings, with each seed."""

    rota_sweep: Literal[1] = field_of(meaning="version of this format")
    name: str = field_of(count=TEXT)
    missions: tuple[str, ...] = field_of(
        meaning="mission files, or patterns with *, from the sweep's folder", count=((1, None), *TEXT)
    )
    planners: tuple[str, ...] | None = field_of(None, "null: as each mission says", count=((1, None), *TEXT))
    efforts: tuple[Literal["quick", "normal", "high"], ...] | None = field_of(
        None, "of planners that have an effort; null: as each mission says"
    )
    settings: dict[str, Any] = field_of(
        dict,
        "values for fields of the missions by their paths, such as fleet.speed_m_s: [1, 2]",
        says={"type": "object", "additionalProperties": {"type": "array", "minItems": 1}},
    )
    seeds: tuple[int, ...] | SeedRange = field_of(
        (0,), count=((1, MOST_SEEDS),), needs="a list or {first, count} is needed", **SEED
    )
    time_limit_s: float | None = field_of(None, "of each cell; then its best plan so far counts", written=DURATION)

    @property
    def all_seeds(self) -> list[int]:
        """The seeds in their order."""
        seeds = self.seeds
        return list(range(seeds.first, seeds.first + seeds.count)) if isinstance(seeds, SeedRange) else list(seeds)


def _sweep_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Planners that are not known, values given twice, and settings that a key of their own is for."""
    planners = data.get("planners")
    for k, name in enumerate(planners if isinstance(planners, list) else []):
        if isinstance(name, str) and name not in planner_names():
            yield ("planners", k), f"{show_value(name)} is not known; {nearest_key(name, list(planner_names()))}"
    lists: list[tuple[Where, Any]] = [((key,), data.get(key)) for key in ("missions", "planners", "efforts", "seeds")]
    settings = data.get("settings", {})
    if not isinstance(settings, dict):
        yield ("settings",), f"{show_value(settings)} is not allowed; a mapping of keys to values is needed"
    for path, values in settings.items() if isinstance(settings, dict) else ():
        lists.append((("settings", path), values))
        if not isinstance(values, list) or not values:
            needed = "it must not be empty" if values == [] else "a list is needed"
            yield ("settings", path), f"{show_value(values)} is not allowed; {needed}"
        if path in ("planner", "seed") or path.endswith(".effort"):
            yield ("settings", path), f"is not allowed here; use {path.rpartition('.')[2]}s"
        if not all(path.split(".")):
            yield ("settings", path), "is no path of a field; names with dots between them are needed"
    for where, values in lists:
        yield from _repetitions(where, values)


def _repetitions(where: Where, values: Any) -> Iterator[tuple[Where, str]]:
    """Each value of a list that stands in it before."""
    for k, value in enumerate(values if isinstance(values, list) else []):
        if any(value == other and type(value) is type(other) for other in values[:k]):
            yield (*where, k), f"{show_value(value)} is given twice; each once is needed"


class ReadSweep(NamedTuple):
    """A sweep as its file says, and the mission files that it names: as told, and where each is."""

    file: SweepFile
    missions: dict[str, Path]


def read_sweep(path: str | Path) -> ReadSweep:
    """Read a sweep file (.yaml, .yml, or .json); paths in it begin at its folder.

    Raises MissionError with one line per fault, all at once: ``file:line:column: path.to.field: what is wrong, what is
    allowed``. The missions themselves are not read.
    """
    path = Path(path)
    document = parse_text(read_text(path, "a sweep file"), str(path), "a sweep file")
    file, faults = read_block(_block(), document.value)
    missions, missing = _mission_files(document, path.parent)
    if faults or missing:
        raise MissionError(*lines_of_faults(document, [*faults, *missing]))
    return ReadSweep(file, missions)


def _mission_files(document: Document, folder: Path) -> tuple[dict[str, Path], list[Fault]]:
    """The files that the missions of a document stand for, those of a pattern in the order of their names."""
    entries = document.value.get("missions") if isinstance(document.value, dict) else None
    files: dict[str, Path] = {}
    faults = []
    for k, entry in enumerate(entries if isinstance(entries, list) else []):
        if not isinstance(entry, str) or not entry:
            continue
        names = sorted(glob.glob(entry, root_dir=folder)) if glob.has_magic(entry) else [entry]
        names = [name for name in names if (folder / name).is_file()]
        if not names:
            faults.append(Fault(("missions", k), f"there is no such file in {folder.absolute()}"))
        files.update({name: folder / name for name in names})
    return files, faults


def _block() -> Block:
    """The block of a sweep file."""
    ranges = {SeedRange: block_of(SeedRange, "mission", makes=SeedRange)}
    return block_of(SweepFile, "mission", ranges, makes=SweepFile, rules=_sweep_faults)


def sweep_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a sweep file."""
    return file_schema(_block(), "Rota sweep")
