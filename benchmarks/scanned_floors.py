"""Occupancy maps like those that a laser scanner leaves of a building, of any size and raggedness, made by chance.

Rooms on both sides of corridors, doors, furniture, all of it turned by a few degrees; walls whose borders the scanner
drew ragged, speckle where it saw something once, unknown space outside and behind the walls.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

import rota
from rota.geometry.free_space import standing_anywhere

FREE, UNKNOWN, OCCUPIED = 254, 205, 0  # as map_saver writes them

Bytes = NDArray[np.uint8]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class Floor:
    """What the map of a floor is like.

    columns, rows: pixels of ``pixel_m`` metres. turned_deg: by how much the building is turned on the sheet. ragged:
    the share of a wall's border pixels to which the scanner added up to three more, outwards. speckle: occupied pixels
    by themselves, per square metre of free ground. furniture: pieces per room, in the mean. rooms: about so many;
    None for as many as rooms of usual sizes make. sensor_m, period_s, close_gaps_m: of the mission over it. entered:
    whether the mission has entrances, one in every part of the ground that a body finds LIVED_IN_M2 of room in.
    """

    columns: int
    rows: int
    pixel_m: float = 0.05
    turned_deg: float = 0.0
    ragged: float = 0.0
    speckle: float = 0.0
    furniture: float = 2.0
    rooms: int | None = None
    sensor_m: float = 2.5
    period_s: float = 600.0
    close_gaps_m: float | None = None
    entered: bool = False


FLOORS = {
    "office": Floor(columns=2289, rows=927, turned_deg=1.5, ragged=0.05, speckle=0.02),
    "ragged": Floor(columns=2289, rows=927, turned_deg=3.0, ragged=0.35, speckle=0.3, furniture=4.0),
    "ragged-closed": Floor(
        columns=2289, rows=927, turned_deg=3.0, ragged=0.35, speckle=0.3, furniture=4.0, close_gaps_m=0.15
    ),
    "ragged-entered": Floor(
        columns=2289, rows=927, turned_deg=3.0, ragged=0.35, speckle=0.3, furniture=4.0, entered=True
    ),
    "large": Floor(columns=4000, rows=2000, turned_deg=3.0, ragged=0.25, speckle=0.2, furniture=4.0),
    "sixty-rooms": Floor(
        columns=4000, rows=3000, turned_deg=1.0, ragged=0.05, speckle=0.01, furniture=12.0, rooms=60,
        sensor_m=6.0, period_s=900.0,
    ),
}  # fmt: skip
ARC_CORNERS = 32  # of a whole turn round a corner
MARGIN_M, WALL_M, CORRIDOR_M, DOOR_M = 2.0, 0.15, 2.6, 1.2
LIVED_IN_M2 = 1.0
ROOM_M = (4.0, 9.0)  # along the corridor
BAND_M = 7.0  # about the depth of a row of rooms


def drawn_floor(floor: Floor, seed: int) -> tuple[Bytes, tuple[float, float]]:
    """The image (rows, columns), its row 0 at the top, and a free place (x, y) in metres from the lower left corner."""
    rng = np.random.default_rng(seed)
    wide_m, high_m = floor.columns * floor.pixel_m, floor.rows * floor.pixel_m
    turn = math.radians(floor.turned_deg)
    # the building's own frame: the largest one of the sheet's shape that fits when it is turned
    scale = 1 / (math.cos(turn) + math.sin(abs(turn)) * max(wide_m / high_m, high_m / wide_m))
    size_m = ((wide_m - 2 * MARGIN_M) * scale, (high_m - 2 * MARGIN_M) * scale)
    y, x = np.mgrid[0 : floor.rows, 0 : floor.columns] * floor.pixel_m
    x, y = x + floor.pixel_m / 2 - wide_m / 2, y + floor.pixel_m / 2 - high_m / 2
    u = math.cos(turn) * x + math.sin(turn) * y + size_m[0] / 2
    v = -math.sin(turn) * x + math.cos(turn) * y + size_m[1] / 2
    walls, corridor_m = _walls(size_m, floor.rooms, rng)
    inside = (u > 0) & (u < size_m[0]) & (v > 0) & (v < size_m[1])
    pieces = floor.furniture * (floor.rooms or size_m[0] * size_m[1] / (BAND_M * sum(ROOM_M) / 2))
    solid = _filled([*walls, *_furniture(size_m, corridor_m, round(pieces), rng)], u, v)
    solid |= inside & ((u < WALL_M) | (u > size_m[0] - WALL_M) | (v < WALL_M) | (v > size_m[1] - WALL_M))
    solid = _ragged(solid, floor.ragged, rng)
    solid |= rng.random(solid.shape) < floor.speckle * floor.pixel_m**2
    image = np.where(solid, OCCUPIED, np.where(inside, FREE, UNKNOWN)).astype(np.uint8)
    place = _free_place(image == FREE, (np.abs(v - corridor_m) < 0.6) & inside)
    return image[::-1], ((place[1] + 0.5) * floor.pixel_m, (place[0] + 0.5) * floor.pixel_m)


def write_floor(name: str, floor: Floor, seed: int, folder: Path) -> Path:
    """Write the map, its description and a mission over it; the mission's path."""
    image, (x, y) = drawn_floor(floor, seed)
    (folder / f"{name}-map.pgm").write_bytes(b"P5\n%d %d\n255\n" % image.shape[::-1] + image.tobytes())
    (folder / f"{name}-map.yaml").write_text(
        f"image: {name}-map.pgm\nresolution: {floor.pixel_m}\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    gaps = "" if floor.close_gaps_m is None else f", close_gaps_m: {floor.close_gaps_m:g}"
    mission = folder / f"{name}.yaml"
    mission.write_text(
        f"rota: 1\nname: {name}\narea: {{map: {name}-map.yaml, inside: [{x:.3f}, {y:.3f}], unknown: blocked{gaps}}}\n"
        f"period_s: {floor.period_s:g}\nfleet:\n  speed_m_s: 0.8\n"
        f"  sensor: {{shape: disc, radius_m: {floor.sensor_m:g}}}\n  body_radius_m: 0.2\n"
    )
    with mission.open("a") as file:
        file.write(f"  entrances: {lived_in(mission) if floor.entered else 'null'}\n")
    return mission


def lived_in(mission: Path) -> list[list[float]]:
    """A place in every part of the ground that has room for a robot to live in, the largest first, in centimetres."""
    read = rota.read_mission(mission).mission
    parts = standing_anywhere(read, read.fleet.body_radius_m, arc_corners=ARC_CORNERS).geoms
    rooms = sorted((part for part in parts if part.area >= LIVED_IN_M2), key=lambda part: -part.area)
    return [[round(value, 2) for value in part.representative_point().coords[0]] for part in rooms]


def corners_of(mission: Path) -> int:
    """Corners of the area that the mission's map is read as."""
    return int(shapely.get_num_coordinates(rota.read_mission(mission).mission.area))


Box = tuple[float, float, float, float]  # x0, y0, x1, y1 in the building's frame, metres


def _walls(size_m: tuple[float, float], rooms: int | None, rng: np.random.Generator) -> tuple[list[Box], float]:
    """Walls between corridors and rooms, with doors left out; and the height of the middle of a corridor.

    Two rows of rooms have a corridor between them. rooms: about so many, about square; None for usual sizes.
    """
    wide_m, high_m = size_m
    pairs, room_m = max(1, round(high_m / (2 * BAND_M + CORRIDOR_M))), ROOM_M
    if rooms is not None:
        pairs = max(1, round(math.sqrt(rooms * high_m / wide_m) / 2))
        room_m = (2 * pairs * wide_m / rooms,) * 2
    pitch_m = high_m / pairs
    cross_m = wide_m * (0.4 + 0.2 * rng.random())  # a corridor across joins the others
    walls: list[Box] = []
    for k in range(pairs):
        low, middle = k * pitch_m, (k + 0.5) * pitch_m
        bands = ((low, middle - CORRIDOR_M / 2, 1), (middle + CORRIDOR_M / 2, low + pitch_m, 0))
        for bottom, top, door_side in bands:
            for left, right in ((0.0, cross_m - CORRIDOR_M / 2), (cross_m + CORRIDOR_M / 2, wide_m)):
                walls += _row_of_rooms((left, right, bottom, top), room_m, door_side, rng)
    return walls, pitch_m / 2


def _row_of_rooms(
    row: tuple[float, float, float, float], room_m: tuple[float, float], door_side: int, rng: np.random.Generator
) -> list[Box]:
    """Walls of rooms side by side, each with a door in its lower (0) or upper (1) wall; some have one between them.

    row: left, right, bottom, top. room_m: least and greatest width of a room.
    """
    left, right, bottom, top = row
    count = max(1, round((right - left) / rng.uniform(*room_m)))
    ends = np.linspace(left, right, count + 1)
    ends[1:-1] += rng.uniform(-0.8, 0.8, count - 1)
    walls: list[Box] = []
    for k in range(count + 1):
        at = min(max(ends[k], left), right) - (WALL_M if k == count else 0.0)
        door = bottom + rng.uniform(0.3, 0.6) * (top - bottom) if rng.random() < 0.2 and 0 < k < count else top
        walls += [(at, bottom, at + WALL_M, min(door, top)), (at, min(door + DOOR_M, top), at + WALL_M, top)]
    for y, has_doors in ((bottom, door_side == 0), (top - WALL_M, door_side == 1)):
        for k in range(count):
            door = rng.uniform(ends[k] + 0.4, ends[k + 1] - 0.4 - DOOR_M) if has_doors else ends[k + 1]
            walls += [(ends[k], y, door, y + WALL_M), (min(door + DOOR_M, ends[k + 1]), y, ends[k + 1], y + WALL_M)]
    return walls


def _furniture(size_m: tuple[float, float], corridor_m: float, count: int, rng: np.random.Generator) -> list[Box]:
    """Tables and shelves anywhere, and the legs of chairs."""
    found: list[Box] = []
    for _ in range(count):
        x, y = rng.uniform(0, size_m[0]), rng.uniform(0, size_m[1])
        a, b = rng.uniform(0.3, 1.6, 2)
        found.append((x, y, x + a, y + b) if rng.random() < 0.4 else (x, y, x + 0.06, y + 0.06))
    # none in the way of those who walk
    return [box for box in found if not (box[1] - 1.6 < corridor_m < box[3] + 1.6)]


def _filled(boxes: list[Box], u: NDArray[np.float64], v: NDArray[np.float64]) -> Flags:
    """Pixels whose middles lie in one of the boxes."""
    solid = np.zeros(u.shape, dtype=bool)
    du, dv = (u[0, 1] - u[0, 0], u[1, 0] - u[0, 0]), (v[0, 1] - v[0, 0], v[1, 0] - v[0, 0])
    inverse = np.linalg.inv(np.array([du, dv]))
    for x0, y0, x1, y1 in boxes:
        corners = np.array([[x0, x0, x1, x1], [y0, y1, y0, y1]]) - np.array([[u[0, 0]], [v[0, 0]]])
        columns, rows = inverse @ corners
        r0, r1 = max(0, int(rows.min()) - 1), int(rows.max()) + 2
        c0, c1 = max(0, int(columns.min()) - 1), int(columns.max()) + 2
        here = (slice(r0, max(r0, r1)), slice(c0, max(c0, c1)))
        solid[here] |= (u[here] >= x0) & (u[here] < x1) & (v[here] >= y0) & (v[here] < y1)
    return solid


def _ragged(solid: Flags, share: float, rng: np.random.Generator) -> Flags:
    """The pixels with spikes of one to three pixels on some of their border."""
    solid = solid.copy()
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        tip = solid & ~np.roll(solid, step, axis=axis)
        tip = np.roll(solid, step, axis=axis) & ~solid & (rng.random(solid.shape) < share)
        for _ in range(3):
            solid |= tip
            tip = np.roll(tip, step, axis=axis) & (rng.random(solid.shape) < 0.5)
    return solid


def _free_place(free: Flags, among: Flags) -> tuple[int, int]:
    """Row and column of the free pixel, of those, that is farthest from anything else."""
    from scipy import ndimage

    room = ndimage.distance_transform_edt(free) * among
    row, column = np.unravel_index(int(room.argmax()), room.shape)
    return int(row), int(column)
