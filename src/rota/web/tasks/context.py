"""What a worker process works with: its database, its limits, and documents laid out in a folder."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rota.files.yaml_text import Document, Place, field_path
from rota.web.names import safe_name
from rota.web.refusal import Json
from rota.web.store.database import Database

_LAID_OUT = re.compile(r"[^\s'\"(\[]*[/\\]rota-\w{8}[/\\]")


@dataclass(frozen=True, kw_only=True)
class Context:
    """The worker's own database connection, and how large what it reads may be."""

    database: Database
    vertices: int
    missions: int
    plans: int


@contextmanager
def lay_out(files: Mapping[str, bytes]) -> Iterator[Path]:
    """A fresh folder with these files, gone after the block."""
    with tempfile.TemporaryDirectory(prefix="rota-", ignore_cleanup_errors=True) as folder:
        for name, content in files.items():
            (Path(folder) / safe_name(name)).write_bytes(content)
        yield Path(folder)


def as_document(value: Any) -> Document:
    """A document without a file, whose faults have fields and no lines."""
    return Document(name="mission", value=value, values_at={}, keys_at={})


def fault_json(place: Place, message: str) -> Json:
    """A fault as the interface tells it: the field in words, its path, and what is wrong with it."""
    return {"field": field_path(place), "path": list(place), "message": with_given_names(message)}


def with_given_names(message: str) -> str:
    """A message with the names of files as they were given, without the folders in which they were laid out."""
    return _LAID_OUT.sub("", message)
