"""How much ground matters: what a mission says of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rota.model.arrays import Floats
from rota.model.field_values import check_fields
from rota.model.fields import field_of
from rota.model.limits import LARGEST_M
from rota.model.refusals import require

MOST_IMPORTANCE = 1e6
IMPORTANCE: dict[str, Any] = {"least": 0, "most": MOST_IMPORTANCE}
ALLOWED = f"a number from 0 to {MOST_IMPORTANCE:g} is needed"


@dataclass(frozen=True, kw_only=True, eq=False)
class ImportanceMap:
    """Importance at the places of a grid, (rows, columns), the southern row first; straight between these places.

    low_m: (x, y) of the first place; step_m: (x, y) between places. Beyond the rim it is that of the rim. Raises
    MissionError for values that are negative, not finite or above ``MOST_IMPORTANCE``, and where all are 0.
    """

    low_m: tuple[float, float] = field_of(
        meaning="x, y of the first place of the first row", least=-LARGEST_M, most=LARGEST_M
    )
    step_m: tuple[float, float] = field_of(meaning="x, y between places", above=0, most=LARGEST_M)
    values: Floats = field_of(
        meaning="rows of importance, the southern one first", form=tuple[tuple[float, ...], ...], **IMPORTANCE
    )

    def __post_init__(self) -> None:
        values = np.array(self.values, np.float64)
        require(values.ndim == 2 and min(values.shape) > 0, "importance", values.shape, "rows of values are needed")
        wrong = values[~((values >= 0) & (values <= MOST_IMPORTANCE))]
        require(not len(wrong), "importance", float(wrong[0]) if len(wrong) else 0.0, ALLOWED)
        require(bool(values.max() > 0), "importance", 0.0, "some ground must be worth more than 0")
        values.flags.writeable = False
        object.__setattr__(self, "values", values)
        check_fields(self, "importance.")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ImportanceMap):
            return NotImplemented
        same = self.low_m == other.low_m and self.step_m == other.step_m
        return same and np.array_equal(self.values, other.values)

    def __hash__(self) -> int:
        return hash((self.low_m, self.step_m, self.values.tobytes()))

    def at(self, x: Floats, y: Floats) -> Floats:
        """The importance at places, arrays of one shape in metres."""
        rows, columns = self.values.shape
        i = np.clip((x - self.low_m[0]) / self.step_m[0], 0, columns - 1)
        j = np.clip((y - self.low_m[1]) / self.step_m[1], 0, rows - 1)
        i0, j0 = i.astype(np.int64), j.astype(np.int64)
        i1, j1 = np.minimum(i0 + 1, columns - 1), np.minimum(j0 + 1, rows - 1)
        a, b, v = i - i0, j - j0, self.values
        low, high = (1 - a) * v[j0, i0] + a * v[j0, i1], (1 - a) * v[j1, i0] + a * v[j1, i1]
        return np.asarray((1 - b) * low + b * high)
