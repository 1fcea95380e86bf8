"""ROS map_server maps (.yaml and image) to polygons in metres."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray
from shapely import MultiPolygon, affinity, box

from rota.errors import MissionError
from rota.files.blocks import block_of, lines_of_faults, read_block
from rota.files.local_file import local_file, read_text
from rota.files.map_image import read_brightness
from rota.files.pixel_outline import straight_outline
from rota.files.yaml_text import parse_text
from rota.model.fields import field_of
from rota.model.limits import COORDINATE, LENGTH
from rota.model.polygons import polygons_of

Unknown = Literal["map_server reading", "blocked", "free"]

UNKNOWN_BRIGHTNESS = 205  # what map_saver writes for unknown cells
MOST_CELLS = 20  # that gaps to close may be wide
ROUNDING = 1e-6  # cells: 0.15 m are three of 0.05 m

Pixels = NDArray[np.bool_]


class InsideError(MissionError):
    """The point that should tell which free part is meant does not lie in free space."""


class GapsError(MissionError):
    """The gaps to close are so wide that nothing is left, or wider than is allowed."""


class MapArea(NamedTuple):
    """The free part of a map, everything else on its sheet (None: nothing), and warnings. Metres, map frame."""

    area: MultiPolygon
    obstacles: MultiPolygon | None
    warnings: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class MapFile:
    """The keys of a map_server .yaml file. ``origin``: x, y of the lower left corner in metres, yaw in radians."""

    image: str = field_of(count=((1, None),))
    resolution: float = field_of(written=LENGTH)
    origin: tuple[float, float, float] = field_of(written=COORDINATE)
    negate: Literal[0, 1, False, True] = field_of()
    occupied_thresh: float = field_of(least=0, most=1)
    free_thresh: float = field_of(least=0, most=1)
    mode: Literal["trinary", "scale"] = field_of("trinary")


def read_map(
    path: Path,
    inside: tuple[float, float],
    unknown: Unknown = "map_server reading",
    *,
    close_gaps_m: float = 0.0,
    confine_to: Path | None = None,
) -> MapArea:
    """The free part of a ROS map that holds the point ``inside``, and the rest of the sheet as obstacles.

    path: the map's .yaml. inside: (x, y) in metres in the map's frame. unknown: "blocked" keeps cells of brightness
    205 (unknown by convention) out of the free space whatever the thresholds say; "free" adds every unknown cell to it.
    close_gaps_m: gaps and nooks of the free space that are narrower than this, in whole cells, are no part of it
    (a morphological closing of what is not free, by a disc as wide). The part is chosen as drawn, before anything is
    grown by a body; cells that touch at a corner only are not connected, nor can one look through between them. Its
    border, and the obstacles' with it, is simplified by at most half a pixel. ``confine_to``: folder that the image
    must lie in.

    Raises InsideError when ``inside`` is not in free space (saying where the nearest is), GapsError for gaps that are
    too wide to close, and MissionError for files that are missing, damaged or wrong and for a map without free space.
    """
    sheet = _read_sheet(path)
    image = local_file(path.parent, sheet.image, confine_to=confine_to)
    brightness = read_brightness(image, alpha_counts=sheet.mode == "trinary")
    # row 0 of the image is the top of the map
    brightness = brightness[::-1]
    free, warnings = _free_cells(path, sheet, brightness, unknown)
    if close_gaps_m > 0:
        free, more = _without_gaps(path, free, close_gaps_m, sheet)
        warnings += more
    blocked = (
        "a wall, in unknown space or in a gap that is closed" if close_gaps_m > 0 else "a wall or in unknown space"
    )
    part = _connected_part(path, free, _to_pixels(sheet, inside), sheet, blocked)
    area = straight_outline(part)
    rows, columns = part.shape
    rest = polygons_of(box(0, 0, columns, rows).difference(area))
    return MapArea(_to_metres(sheet, area), None if rest.is_empty else _to_metres(sheet, rest), warnings)


def free_place(path: Path, *, confine_to: Path | None = None) -> tuple[float, float]:
    """A point (x, y) in metres in the largest free part of a ROS map, as far from its border as there is.

    Raises MissionError as ``read_map`` does.
    """
    from scipy import ndimage

    sheet = _read_sheet(path)
    image = local_file(path.parent, sheet.image, confine_to=confine_to)
    free, _ = _free_cells(path, sheet, read_brightness(image, alpha_counts=sheet.mode == "trinary")[::-1], "blocked")
    labels, _ = ndimage.label(free)
    largest = labels == np.bincount(labels[free]).argmax()
    away = ndimage.distance_transform_cdt(np.pad(largest, 1), metric="taxicab")[1:-1, 1:-1]
    row, column = np.unravel_index(int(away.argmax()), away.shape)
    return _place(sheet, float(column) + 0.5, float(row) + 0.5)


def _read_sheet(path: Path) -> MapFile:
    """The YAML file of a ROS map; MissionError with line and column for what is wrong in it."""
    what = "a ROS map_server .yaml file"
    document = parse_text(read_text(path, what), str(path), what)
    # map files carry keys for other programs
    sheet, faults = read_block(block_of(MapFile, "mission", makes=MapFile, is_open=True), document.value)
    if faults:
        raise MissionError(*lines_of_faults(document, faults))
    if sheet.free_thresh > sheet.occupied_thresh:
        message = f"{sheet.free_thresh} is above occupied_thresh {sheet.occupied_thresh}; it must not be"
        raise MissionError(document.line(("free_thresh",), message))
    return cast(MapFile, sheet)


def _free_cells(path: Path, sheet: MapFile, brightness: Any, unknown: Unknown) -> tuple[Pixels, tuple[str, ...]]:
    """What map_server calls free (nav2 map_io.cpp, loadMapFromFile), and a warning when that takes in unknown cells."""
    occupancy = (brightness if sheet.negate else 255 - brightness) / 255
    free: Pixels = occupancy < sheet.free_thresh
    occupied = occupancy > sheet.occupied_thresh
    doubtful = brightness == UNKNOWN_BRIGHTNESS
    warnings: tuple[str, ...] = ()
    if unknown == "free":
        free = ~occupied | (doubtful & ~free)
    elif unknown == "blocked":
        free = free & ~doubtful
    elif (count := int((free & doubtful).sum())) > 0:
        warnings = (
            f"{path}: {count} cells have the value {UNKNOWN_BRIGHTNESS}, by convention unknown, and free_thresh "
            f"{sheet.free_thresh} reads them as free; unknown: blocked beside map keeps robots out of them",
        )
    if not free.any():
        raise MissionError(f"{path}: the map has no free space; check negate ({int(sheet.negate)}) and the thresholds")
    return free, warnings


def _without_gaps(path: Path, free: Pixels, narrower_m: float, sheet: MapFile) -> tuple[Pixels, tuple[str, ...]]:
    """The cells of all free discs as wide as whole cells allow, and a warning when nothing is narrower than these."""
    from scipy import ndimage

    cells = math.floor(narrower_m / sheet.resolution + ROUNDING)
    if cells < 2:
        two = f"two cells of {path} are {2 * sheet.resolution:g} m wide"
        return free, (f"close_gaps_m {narrower_m:g} closes nothing; {two}",)
    if cells > MOST_CELLS:
        most_m = MOST_CELLS * sheet.resolution
        raise GapsError(f"{narrower_m:g} is not allowed; at most {most_m:g} m are, {MOST_CELLS} cells of {path}")
    from_middle = np.arange(cells) - (cells - 1) / 2
    disc = np.hypot(from_middle[:, None], from_middle) <= cells / 2
    roomy: Pixels = ndimage.binary_opening(free, structure=disc)
    if not roomy.any():
        raise GapsError(f"closes all of the free space of {path}; nowhere is it {narrower_m:g} m wide")
    return roomy, ()


def _connected_part(path: Path, free: Pixels, point: tuple[float, float], sheet: MapFile, blocked: str) -> Pixels:
    """The free cells connected by their sides with the one that holds ``point`` (column, row, in pixels).

    blocked: what all others are, in words.
    """
    from scipy import ndimage

    rows, columns = free.shape
    column, row = math.floor(point[0]), math.floor(point[1])
    on_sheet = 0 <= column < columns and 0 <= row < rows
    if on_sheet and free[row, column]:
        labels, _ = ndimage.label(free)
        return np.asarray(labels == labels[row, column])
    free_rows, free_columns = np.nonzero(free)
    aside = np.maximum(np.abs(free_columns + 0.5 - point[0]) - 0.5, 0)
    above = np.maximum(np.abs(free_rows + 0.5 - point[1]) - 0.5, 0)
    distances = np.hypot(aside, above)
    nearest = int(distances.argmin())
    x, y = _place(sheet, free_columns[nearest] + 0.5, free_rows[nearest] + 0.5)
    what = f"lies in {blocked}" if on_sheet else f"lies off the map {path}"
    away_m = float(distances[nearest]) * sheet.resolution
    raise InsideError(f"{what}; the nearest free place is {away_m:.3g} m away, at [{x:.6g}, {y:.6g}]")


def _matrix(sheet: MapFile) -> list[float]:
    x, y, yaw = sheet.origin
    cos, sin = math.cos(yaw) * sheet.resolution, math.sin(yaw) * sheet.resolution
    return [cos, -sin, sin, cos, x, y]


def _to_metres(sheet: MapFile, pixels: MultiPolygon) -> MultiPolygon:
    return polygons_of(affinity.affine_transform(pixels, _matrix(sheet)))


def _place(sheet: MapFile, column: float, row: float) -> tuple[float, float]:
    a, b, d, e, x, y = _matrix(sheet)
    return a * column + b * row + x, d * column + e * row + y


def _to_pixels(sheet: MapFile, point: tuple[float, float]) -> tuple[float, float]:
    x, y, yaw = sheet.origin
    dx, dy = point[0] - x, point[1] - y
    cos, sin = math.cos(yaw) / sheet.resolution, math.sin(yaw) / sheet.resolution
    return cos * dx + sin * dy, -sin * dx + cos * dy
