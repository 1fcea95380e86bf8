"""Maps of importance: a GeoTIFF that holds it, or a picture whose black and white are worth what the mission says."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from rota.errors import MissionError
from rota.files.raster_map import Raster, Scale, Site, read_raster
from rota.model.importance import ALLOWED, MOST_IMPORTANCE, ImportanceMap

MOST_PLACES = 2**18  # of a map in a plan file; a finer one is averaged down to that
DIGITS = 6  # of the greatest importance, to which a map is rounded: so plan files stay small
UNSCALED = "black and white are needed: a picture does not say what a square metre is worth where it is black and white"


def read_importance_map(path: Path, site: Site, scale: Scale | None) -> ImportanceMap:
    """The importance of the ground all over a site; scale: what black and white are worth, see ``read_raster``.

    Raises MissionError as ``read_raster`` does, for a picture whose pixels would not be square on the site, and for
    values that no importance can have.
    """
    raster = read_raster(path, site, scale, "importance", UNSCALED)
    if raster.low_m != site.bounds[:2]:  # a picture, which begins half a pixel within
        _require_square(path, raster, site)
    values, low_m, step_m = _coarse(raster, site)
    wrong = values[~((values >= 0) & (values <= MOST_IMPORTANCE))]
    if len(wrong):
        raise MissionError(f"{path}: holds {wrong[0]:.6g}; {ALLOWED}")
    if values.max() == 0:
        raise MissionError(f"{path}: is worth 0 all over the area; some ground must be worth more")
    rounded = np.round(values, DIGITS - 1 - math.floor(math.log10(values.max())))
    return ImportanceMap(values=rounded, low_m=low_m, step_m=step_m)


def _require_square(path: Path, raster: Raster, site: Site) -> None:
    """Raise MissionError where rows miss by more than one and a hundredth: the picture is of elsewhere."""
    x0, y0, x1, y1 = site.bounds
    rows, columns = raster.values.shape
    wanted = columns * (y1 - y0) / (x1 - x0)
    if abs(rows - wanted) > 1 + wanted / 100:
        raise MissionError(
            f"{path}: {columns} x {rows} pixels over {x1 - x0:.6g} m x {y1 - y0:.6g} m; pixels must be square there:"
            f" {columns} x {max(round(wanted), 2)} are needed, or others in that ratio"
        )


def _coarse(raster: Raster, site: Site) -> Raster:
    """The raster, averaged down to ``MOST_PLACES`` where it has more."""
    rows, columns = raster.values.shape
    if rows * columns <= MOST_PLACES:
        return raster
    from PIL import Image

    share = math.sqrt(MOST_PLACES / (rows * columns))
    size = max(int(columns * share), 1), max(int(rows * share), 1)
    image = Image.fromarray(raster.values.astype(np.float32)).resize(size, Image.Resampling.BOX)
    x0, y0, x1, y1 = site.bounds
    step = (x1 - x0) / size[0], (y1 - y0) / size[1]
    return Raster(np.asarray(image, np.float64), (x0 + step[0] / 2, y0 + step[1] / 2), step)
