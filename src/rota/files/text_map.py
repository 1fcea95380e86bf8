"""Small maps typed as text: a character is a square cell, free or an obstacle."""

from __future__ import annotations

import numpy as np
from shapely import MultiPolygon, affinity, box

from rota.errors import MissionError
from rota.files.pixel_outline import exact_outline

FREE, OBSTACLE = ".", "#"
MOST_CHARACTERS = 1_000_000


def text_map(text: str, cell_m: float) -> tuple[MultiPolygon, MultiPolygon]:
    """The rectangle that the text fills, and its obstacles (empty when it has none), in metres.

    text: lines of equal length, the first is the northernmost; blank lines before and after them do not count. The
    lower left corner is (0, 0). Raises MissionError for lines of unequal length, for other characters than ``.`` and
    ``#``, and for a map without free cells.
    """
    lines = [line.strip() for line in text.strip("\n").splitlines()]
    if not lines or not lines[0]:
        raise MissionError("the map has no lines; lines of . (free) and # (obstacle) are needed")
    for k, line in enumerate(lines, start=1):
        wrong = next((character for character in line if character not in (FREE, OBSTACLE)), None)
        if wrong is not None:
            raise MissionError(f"line {k}: {wrong!r} is not allowed; . (free) and # (obstacle) are")
        if len(line) != len(lines[0]):
            raise MissionError(f"line {k} has {len(line)} characters, line 1 has {len(lines[0])}; as many are needed")
    if len(lines) * len(lines[0]) > MOST_CHARACTERS:
        raise MissionError(
            f"the map has {len(lines) * len(lines[0])} characters; at most {MOST_CHARACTERS} are allowed"
        )
    blocked = np.array([[character == OBSTACLE for character in line] for line in reversed(lines)])
    if blocked.all():
        raise MissionError("the map has no free cell; at least one . is needed")
    rows, columns = blocked.shape
    area = MultiPolygon([box(0, 0, columns * cell_m, rows * cell_m)])
    return area, affinity.scale(exact_outline(blocked), cell_m, cell_m, origin=(0, 0))
