"""What is wrong in a plan file, each fault with its field's path."""

from __future__ import annotations

import reprlib
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches

from pydantic import BaseModel, ValidationError

from rota.errors import PlanError, RotaError
from rota.files.plan_schema import (
    DiscSensorFields,
    FleetFields,
    ImportanceMapFields,
    MissionFields,
    PlanFields,
    SquareSensorFields,
    StartFields,
    TrajectoryFields,
)

MOST_FAULTS = 20


def plan_faults(error: ValidationError) -> Iterator[str]:
    """One line per fault that pydantic found: the field's path, what is wrong and what is allowed."""
    faults = error.errors(include_url=False)
    for fault in faults[:MOST_FAULTS]:
        message = f"{_path(fault['loc'])}: {fault['msg']}"
        if fault["type"] == "extra_forbidden":
            known = get_close_matches(str(fault["loc"][-1]), _all_keys(), n=1)
            message = f"{_path(fault['loc'])}: unknown key" + (f"; did you mean {known[0]}?" if known else "")
        elif isinstance(fault["input"], str | int | float) and fault["type"] not in ("missing", "fault"):
            message += f", not {reprlib.repr(fault['input'])}"
        yield message
    if len(faults) > MOST_FAULTS:
        yield f"and {len(faults) - MOST_FAULTS} more faults"


def _path(location: tuple[int | str, ...]) -> str:
    """Where a field stands, as in ``mission.zones[2].shape``."""
    # pydantic names the member of a union it tried; that is no part of the file
    parts = [part for part in location if part not in ("disc", "square", "fewest", "list", "map", "number")]
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in parts).lstrip(".") or "plan"


def _all_keys() -> list[str]:
    """The keys among which the nearest to an unknown one is sought."""
    models: list[type[BaseModel]] = [
        PlanFields,
        MissionFields,
        FleetFields,
        ImportanceMapFields,
        StartFields,
        TrajectoryFields,
        DiscSensorFields,
        SquareSensorFields,
    ]
    return [key for model in models for key in model.model_fields]


@contextmanager
def named_field(field: str) -> Iterator[None]:
    """Any RotaError raised inside becomes a PlanError that names the field of the plan file."""
    try:
        yield
    except RotaError as error:
        raise PlanError(f"{field}: {error}") from error
