"""What is told of what a plan has to spare: the type, text and JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

Kind = Literal["period", "range", "battery"]
NAMED = 3  # robots

TEXT, SIZE = {"type": "string"}, {"type": "number", "minimum": 0}


@dataclass(frozen=True, kw_only=True)
class Margin:
    """The thinnest reserve of one kind: ``spare`` of ``limit``, both in ``unit``, of the demand ``who`` at place_m.

    kind: "period", what is left of it when the place is seen again; "range", by how much less far all robots may see;
    "battery", what is left above its reserve of the robot ``who``, of a full one, when there is least.
    robots: those that see the place. places: at how many the reserve was looked for; None where it is proved for all.
    place_m: None for a zone to visit, and where all is always in sight.
    """

    kind: Kind
    who: str
    robots: tuple[str, ...]
    spare: float
    limit: float
    unit: Literal["s", "m"]
    place_m: tuple[float, float] | None
    places: int | None

    @property
    def share(self) -> float:
        """What is to spare as a share of the limit."""
        return self.spare / self.limit

    def text(self) -> str:
        """The reserve in words."""
        what = "time" if self.kind == "period" else self.kind
        within = "of" if self.kind == "battery" else "in"
        percent = 100 * self.share
        share = f"{math.floor(10 * percent) / 10:g} %" if percent >= 0.1 else f"{percent:.1g} %"
        spare = f"{math.floor(1e3 * self.spare) / 1e3:g} of {self.limit:g} {self.unit} ({share})"
        where = "" if self.place_m is None else f" at ({self.place_m[0]:.2f}, {self.place_m[1]:.2f})"
        seen = f", seen by {names_text(self.robots)}" if self.robots else ""
        looked = "" if self.places is None else f"; of {self.places} places"
        return f"least {what} to spare: {spare}, {within} {self.who}{where}{seen}{looked}"


def names_text(names: Sequence[str]) -> str:
    """The first names in words, and how many more there are."""
    others = len(names) - NAMED
    told = [*names[:NAMED], *([f"{others} more"] if others > 0 else [])]
    return " and ".join([", ".join(told[:-1]), told[-1]] if len(told) > 1 else told)


def margin_properties() -> dict[str, Any]:
    """The JSON Schema of each value of a reserve."""
    return {
        "kind": {"enum": list(get_args(Kind))},
        "who": {**TEXT, "description": "the demand, or of a battery the robot"},
        "robots": {"type": "array", "items": TEXT, "description": "those that see the place"},
        "spare": {**SIZE, "description": "in unit"},
        "limit": SIZE,
        "unit": {"enum": ["s", "m"]},
        "share": {**SIZE, "description": "of the limit"},
        "place_m": {"type": ["array", "null"], "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
        "places": {"type": ["integer", "null"], "description": "at how many it was looked for; null: proved for all"},
        "text": TEXT,
    }
