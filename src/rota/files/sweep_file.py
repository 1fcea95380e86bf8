"""Sweep files: which missions, planners, efforts, settings and seeds to plan; faults with file, line, column, field."""

from __future__ import annotations

import glob
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Discriminator, Field, Tag, ValidationError

from rota.errors import MissionError
from rota.files.local_file import read_text
from rota.files.schema_block import Block, Duration, Text, Where, nearest_key
from rota.files.schema_faults import Fault, positioned, schema_faults
from rota.files.yaml_text import Document, parse_text
from rota.model.planner_registry import planner_names
from rota.model.refusals import shown

MOST_SEEDS = 1_000_000
Seed = Annotated[int, Field(strict=True, ge=0, le=2**32)]


class SeedRange(Block):
    """So many seeds in a row."""

    first: Seed = 0
    count: Annotated[int, Field(strict=True, ge=1, le=MOST_SEEDS)]


def _seeds_kind(value: Any) -> str | None:
    if isinstance(value, dict | SeedRange):
        return "<range>"
    return "<list>" if isinstance(value, list) else None


Seeds = Annotated[
    Annotated[Annotated[list[Seed], Field(min_length=1, max_length=MOST_SEEDS)], Tag("<list>")]
    | Annotated[SeedRange, Tag("<range>")],
    Discriminator(
        _seeds_kind, custom_error_type="wrong_kind", custom_error_message="a list or {first, count} is needed"
    ),
]


class SweepFile(Block):
    """What a sweep plans: each mission by each planner, effort and choice of settings, with each seed."""

    rota_sweep: Literal[1] = Field(description="version of this format")
    name: Text
    missions: list[Text] = Field(min_length=1, description="mission files, or patterns with *, from the sweep's folder")
    planners: list[Text] | None = Field(None, min_length=1, description="null: as each mission says")
    efforts: list[Literal["quick", "normal", "high"]] | None = Field(
        None, min_length=1, description="of planners that have an effort; null: as each mission says"
    )
    settings: dict[str, Annotated[list[Any], Field(min_length=1)]] = Field(
        default={}, description="values for fields of the missions by their paths, such as fleet.speed_m_s: [1, 2]"
    )
    seeds: Seeds = Field(default=[0])
    time_limit_s: Duration | None = Field(None, description="of each cell; then its best plan so far counts")

    @property
    def all_seeds(self) -> list[int]:
        """The seeds in their order."""
        seeds = self.seeds
        return list(range(seeds.first, seeds.first + seeds.count)) if isinstance(seeds, SeedRange) else list(seeds)

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """Planners that are not known, values given twice, and settings that a key of their own is for."""
        planners = data.get("planners")
        for k, name in enumerate(planners if isinstance(planners, list) else []):
            if isinstance(name, str) and name not in planner_names():
                yield ("planners", k), f"{shown(name)} is not known; {nearest_key(name, list(planner_names()))}"
        lists: list[tuple[Where, Any]] = [
            ((key,), data.get(key)) for key in ("missions", "planners", "efforts", "seeds")
        ]
        settings = data.get("settings")
        for path, values in settings.items() if isinstance(settings, dict) else ():
            lists.append((("settings", path), values))
            if path in ("planner", "seed") or path.endswith(".effort"):
                yield ("settings", path), f"is not allowed here; use {path.rpartition('.')[2]}s"
            if not all(path.split(".")):
                yield ("settings", path), "is no path of a field; names with dots between them are needed"
        for where, values in lists:
            yield from _repeated(where, values)


def _repeated(where: Where, values: Any) -> Iterator[tuple[Where, str]]:
    """Each value of a list that stands in it before."""
    for k, value in enumerate(values if isinstance(values, list) else []):
        if any(value == other and type(value) is type(other) for other in values[:k]):
            yield (*where, k), f"{shown(value)} is given twice; each once is needed"


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
    faults: list[Fault] = []
    file: SweepFile | None = None
    try:
        file = SweepFile.model_validate(document.value)
    except ValidationError as error:
        faults += schema_faults(document, error)
    missions, missing = _mission_files(document, path.parent)
    if faults or missing or file is None:
        raise MissionError(*positioned(document, [*faults, *missing]))
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


def sweep_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a sweep file."""
    schema = SweepFile.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "Rota sweep"}
