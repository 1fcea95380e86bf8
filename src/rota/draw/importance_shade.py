"""How much ground matters, as a quiet shade under all else."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patches import Patch, PathPatch

from rota.cells.importance_cells import ImportanceCells, importance_cells
from rota.draw.palette import GROUND, IMPORTANT
from rota.model.arrays import Floats
from rota.model.mission import Mission

CELLS_ACROSS, DARKER = 400.0, 0.6
SHADES = LinearSegmentedColormap.from_list("importance", [GROUND, IMPORTANT])


@lru_cache(maxsize=4)
def shaded_cells(mission: Mission) -> ImportanceCells | None:
    """The importance of the mission's area, fine enough for a picture; None where all ground is worth as much."""
    x0, y0, x1, y1 = mission.area.bounds
    return importance_cells(mission, mission.area, max(x1 - x0, y1 - y0) / CELLS_ACROSS)


def shade(values: Floats, most: float) -> Floats:
    """How dark importance is drawn, 0..1; middling importance is darker than its share, so that it shows."""
    return np.asarray((values / most) ** DARKER)


def draw_importance(mission: Mission, ax: Axes, ground: PathPatch) -> bool:
    """Shade the ground by its importance, the darker the more; False where all is worth as much."""
    cells = shaded_cells(mission)
    if cells is None:
        return False
    rows, columns = cells.values.shape
    (left, bottom), side_m = (low - cells.side_m / 2 for low in cells.low_m), cells.side_m
    image = ax.imshow(
        shade(cells.values, float(cells.values.max())), cmap=SHADES, vmin=0, vmax=1, origin="lower", zorder=1.05,
        extent=(left, left + columns * side_m, bottom, bottom + rows * side_m), interpolation="nearest",
    )  # fmt: skip
    image.set_clip_path(ground)
    return True


def importance_legend(mission: Mission) -> list[Patch]:
    """Legend entries for the most and the least important ground; none where all is worth as much."""
    cells = shaded_cells(mission)
    if cells is None:
        return []
    told = cells.values[cells.ground_m2 > 0]
    most = float(told.max())
    return [
        Patch(
            facecolor=SHADES(float(shade(np.array(value), most))), edgecolor="#888888", label=f"importance {value:.3g}"
        )
        for value in np.unique([most, float(told.min())])[::-1].tolist()
    ]
