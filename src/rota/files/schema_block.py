"""What every block of a mission file does: known keys only, and contradictions named at the field at fault."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, ModelWrapValidatorHandler, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from rota.model.importance import MOST_IMPORTANCE

# generous for anything that moves on this planet, and so that no square, sum or quotient overflows or is lost
SMALLEST_M, FARTHEST_M = 1e-3, 1e7  # beyond it no projection holds, and sums of squares lose the millimetres
SHORTEST_S, LONGEST_S = 1e-3, 1e9
SLOWEST, FASTEST = 1e-6, 1e6  # metres or radians per second

Text = Annotated[str, Field(strict=True, min_length=1)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Length = Annotated[Number, Field(ge=SMALLEST_M, le=FARTHEST_M)]
LengthOrZero = Annotated[Number, Field(ge=0, le=FARTHEST_M)]
Coordinate = Annotated[Number, Field(ge=-FARTHEST_M, le=FARTHEST_M)]
Duration = Annotated[Number, Field(ge=SHORTEST_S, le=LONGEST_S)]
Moment = Annotated[Number, Field(ge=0, le=LONGEST_S)]
Rate = Annotated[Number, Field(ge=SLOWEST, le=FASTEST)]
Importance = Annotated[Number, Field(ge=0, le=MOST_IMPORTANCE)]
Where = tuple[str | int, ...]


class Block(BaseModel):
    """A mapping with known keys; an unknown one is named together with the nearest known one."""

    model_config = ConfigDict(extra="forbid")

    @model_validator(mode="wrap")
    @classmethod
    def _name_faults(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        lines = [_custom(place, text, data) for place, text in cls.faults(data)] if isinstance(data, dict) else []
        try:
            block = handler(data)
        except ValidationError as error:
            lines = [_reworded(cls, dict(line)) for line in error.errors(include_url=False)] + lines
        if lines:
            raise ValidationError.from_exception_data(cls.__name__, lines)
        return block

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """Contradictions between the raw values of a block, each as the field at fault and what is wrong with it."""
        yield from ()


def given_of(data: dict[str, Any], *fields: str) -> list[str]:
    """Those of the fields that a raw block gives a value."""
    return [field for field in fields if data.get(field) is not None]


def _custom(place: tuple[str | int, ...], message: str, value: Any) -> InitErrorDetails:
    return InitErrorDetails(
        type=PydanticCustomError("fault", "{message}", {"message": message}), loc=place, input=value
    )


def _reworded(block: type[Block], line: dict[str, Any]) -> InitErrorDetails:
    if line["type"] == "extra_forbidden" and len(line["loc"]) == 1:
        key, known = str(line["loc"][0]), list(block.model_fields)
        error = PydanticCustomError("unknown_key", "{message}", {"message": f"unknown key; {nearest_key(key, known)}"})
        return InitErrorDetails(type=error, loc=line["loc"], input=line["input"])
    if line["type"] in ("unknown_key", "fault", "ring") or line["type"].startswith("wrong_"):
        error = PydanticCustomError(line["type"], "{message}", {"message": line["msg"]})
        return InitErrorDetails(type=error, loc=line["loc"], input=line["input"])
    return InitErrorDetails(type=line["type"], loc=line["loc"], input=line["input"], ctx=line.get("ctx", {}))


def nearest_key(key: str, known: list[str]) -> str:
    """A hint for an unknown key: the nearest known one, or all that are known."""
    near = difflib.get_close_matches(key, known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"known here: {', '.join(known)}"
