"""Maps on which bouncing robots are measured; none of those of Alam & Bobadilla 2020 is published."""

from __future__ import annotations

import shapely
from shapely import MultiPolygon

from rota.files.text_map import text_map
from rota.planners.bounce.cells import Cells, cells_of
from rota_studies.alam2020.maps import ROOM_10 as ROOM_10, ROOM_15 as ROOM_15

OPEN = "\n".join(["." * 10] * 10)
LESS_EIGHT = "\n".join([".########."] + ["." * 10] * 9)  # 92 cells: two robots have 736 ** 2 = 541,696 states


def cells_on(text: str) -> Cells:
    """Cells of 1 m of a typed map, for robots without width that face 8 ways."""
    area, walls = text_map(text, 1.0)
    ground = MultiPolygon(list(shapely.get_parts(area.difference(walls))))
    return cells_of(ground, area.bounds, cell_m=1.0)
