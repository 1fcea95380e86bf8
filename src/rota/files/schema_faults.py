"""What pydantic finds wrong with a parsed file, in a newcomer's words and with positions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from pydantic import ValidationError

from rota.files.yaml_text import Document, Place
from rota.model.refusals import refusal, shown


class Fault(NamedTuple):
    """What is wrong, what is allowed, and where; ``at_key``: the key itself is at fault, not its value."""

    place: Place
    message: str
    at_key: bool = False


def schema_faults(document: Document, error: ValidationError) -> list[Fault]:
    """Every fault pydantic found: its place in the document, and what is wrong and what is allowed there."""
    faults: list[Fault] = []
    for line in error.errors(include_url=False):
        place = tuple(step for step in line["loc"] if not str(step).startswith("<"))
        kind, value = line["type"], line["input"]
        if kind == "missing" and place and isinstance(place[-1], int):
            # a tuple that is too short: pydantic tells each missing number by itself
            if faults and faults[-1].place == place[:-1]:
                faults.pop()
            message = f"{shown(value)} is too short; {int(place[-1]) + 1} numbers are needed"
            place = place[:-1]
        else:
            message = refusal(kind, value, dict(line.get("ctx", {})), line["msg"])
        faults.append(Fault(place, message, at_key=kind == "unknown_key"))
    return faults


def positioned(document: Document, faults: Iterable[Fault]) -> list[str]:
    """One line ``file:line:column: path.to.field: message`` per fault, in the file's order, none twice."""
    ordered = sorted(faults, key=lambda fault: document.position(fault.place, key=fault.at_key))
    return list(dict.fromkeys(document.line(fault.place, fault.message, key=fault.at_key) for fault in ordered))
