"""Stopped runs of a swarm <-> files: arrays in a zip, as numpy writes them, with the mission as in a plan file."""

from __future__ import annotations

import io
import json
import lzma
import os
import struct
import tokenize
import zipfile
import zlib
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from rota.errors import CheckpointError, MissionError, RotaError
from rota.files.atomic_write import replaced_file
from rota.files.local_file import read_bytes
from rota.files.plan_file import plan_from_json, plan_to_json
from rota.model.plan import Plan
from rota.planning.checkpoint import Checkpoint

CHECKPOINT_VERSION = 1
MADE_BY = "'rota plan' writes one when a swarm is stopped"
NUMBERS = ("steps", "steps_at_rest", "thinned_m")
WHOLE = ("names", "kept_steps", "kept_robots")
ARRAYS = tuple(field.name for field in fields(Checkpoint) if field.name not in ("mission", "seed", *NUMBERS))
# what zipfile, its decompressors and numpy's reader of headers raise at damaged bytes
UNREADABLE = (
    ValueError, EOFError, KeyError, MemoryError, OverflowError, OSError, RuntimeError, SyntaxError, TypeError,
    lzma.LZMAError, struct.error, tokenize.TokenError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def write_checkpoint(run: Checkpoint, path: str | os.PathLike[str]) -> None:
    """Write a stopped run to ``path``: whole or not at all. Raises RotaError when it cannot be written."""
    head = {"rota_run": CHECKPOINT_VERSION, **{name: getattr(run, name) for name in NUMBERS}}
    head["plan"] = plan_to_json(Plan(mission=run.mission, trajectories=(), seed=run.seed))  # as yet without routes
    text = np.frombuffer(json.dumps(head, allow_nan=False).encode(), np.uint8)
    arrays = {name: getattr(run, name) for name in ARRAYS}
    with replaced_file(path) as partial, partial.open("wb") as file:
        np.savez(file, head=text, **arrays)


def read_checkpoint(path: str | os.PathLike[str]) -> Checkpoint:
    """Read a run file. Raises CheckpointError naming the file and what is wrong with it."""
    try:
        data = io.BytesIO(read_bytes(Path(path), f"a run file ({MADE_BY})"))
    except MissionError as error:
        raise CheckpointError(str(error)) from None
    try:
        with zipfile.ZipFile(data):  # numpy would take other kinds of files, too
            pass
        with np.load(data, allow_pickle=False) as file:
            return _run(file)
    except RotaError as error:
        raise CheckpointError("\n".join(f"{path}: {line}" for line in str(error).splitlines())) from None
    except UNREADABLE as error:
        raise CheckpointError(f"{path}: no run file, or not a whole one; a run file is needed ({MADE_BY})") from error


def _run(file: Any) -> Checkpoint:
    """The run that a file holds; CheckpointError for what is missing or of another kind."""
    if "head" not in file.files:
        raise CheckpointError(f"no run file; a run file is needed ({MADE_BY})")
    head = json.loads(file["head"].tobytes().decode())
    version = head.get("rota_run") if isinstance(head, dict) else None
    if version != CHECKPOINT_VERSION or isinstance(version, bool):
        known = f"this Rota reads version {CHECKPOINT_VERSION}"
        raise CheckpointError(f"rota_run: version {version!r} is not known; {known}")
    for name in NUMBERS:
        number = head.get(name)
        if isinstance(number, bool) or not isinstance(number, float if name == "thinned_m" else int):
            raise CheckpointError(f"{name}: {number!r} is not allowed; a number is needed")
    arrays = {}
    for name in ARRAYS:
        if name not in file.files:
            raise CheckpointError(f"{name}: is missing")
        kind = np.dtype(np.int64 if name in WHOLE else np.float64)
        if file[name].dtype != kind:
            raise CheckpointError(f"{name}: holds {file[name].dtype}; {kind} is needed")
        arrays[name] = file[name]
    plan = plan_from_json(head.get("plan"))
    if not plan.mission.planning.makes_runs:
        raise CheckpointError(f"plan.mission.planner: {plan.mission.planning.planner} makes no runs; swarm is needed")
    return Checkpoint(mission=plan.mission, seed=plan.seed, **{name: head[name] for name in NUMBERS}, **arrays)
