"""Where robots begin: at the mission's starts, at random places where bodies have room, or on a lattice."""

from __future__ import annotations

import math
from collections import defaultdict

import numpy as np
import shapely
from scipy.spatial import cKDTree
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.errors import MissionError
from rota.model.arrays import Flags, Floats
from rota.model.mission import TOUCH_M, Mission, Robot, StartBox

MOST_PLACES = 1_000_000
LOOSENINGS = 40  # halvings of what the spacing may still be
ON_THE_BORDER_M = 1e-9
TRIES = 2000  # random places for one robot
DENSEST = math.pi / math.sqrt(12)  # share of the plane that equal discs can fill
BATCH = 64
# Random places for equal discs run out when these fill 0.547 of a wide room (Feder, J. Theor. Biol. 87:237, 1980), or
# 0.7476 pi / 4 = 0.587 of a lane as wide as they are (Renyi 1958); many of them never fill this share of a room.
JAMMED = 0.6
SPOT = 0.1  # of the smallest sensor's radius: that of a disc, and what is no larger is no room behind a door
LEAST_RESERVE_M = 1e-3
MANY = 1000  # robots for each part of a room; fewer may fill more of a small part, since one body can fill its own


class _Placed:
    """Robots placed so far, in cells as wide as the most that two of them need between them."""

    def __init__(self, widest_m: float) -> None:
        self._cell_m = max(2 * widest_m, 1e-3)
        self._cells: dict[tuple[int, int], list[tuple[float, float, float]]] = defaultdict(list)

    def has_room(self, x: float, y: float, radius_m: float) -> bool:
        """Whether a body of this radius would touch none of them there."""
        i, j = self._cell(x, y)
        beside = (other for a in (i - 1, i, i + 1) for b in (j - 1, j, j + 1) for other in self._cells.get((a, b), ()))
        return all(math.hypot(x - ox, y - oy) >= max(radius_m + other_m, TOUCH_M) for ox, oy, other_m in beside)

    def add(self, x: float, y: float, radius_m: float) -> None:
        """Place one more robot."""
        self._cells[self._cell(x, y)].append((x, y, radius_m))

    def _cell(self, x: float, y: float) -> tuple[int, int]:
        """The cell of a point."""
        return int(x // self._cell_m), int(y // self._cell_m)


def place_starts(mission: Mission, ground: MultiPolygon, *, seed: int, reserve_m: float) -> Floats:
    """Starts (n, 2) of the mission's robots, in their order.

    Robots without a start of their own begin at random places of the fleet's box, or of the area, where a body that is
    wider by ``reserve_m`` touches nothing. Where it is too tight for that they begin on a lattice, with less reserve if
    need be, at once when they are many equal bodies and the box is surely too tight. Raises MissionError when the
    lattice has not places enough.
    """
    robots = mission.fleet.robots or ()
    rng = np.random.default_rng(seed)
    placed = _Placed(max(robot.body_radius_m for robot in robots) + reserve_m)
    starts = np.full((len(robots), 2), np.nan)
    for k, robot in enumerate(robots):
        if robot.start is not None:
            starts[k] = robot.start
            placed.add(robot.start[0], robot.start[1], robot.body_radius_m)
    rooms: dict[float, MultiPolygon] = {}
    for k, robot in enumerate(robots):
        if robot.start is None:
            radius_m = robot.body_radius_m + reserve_m
            if radius_m not in rooms:
                rooms[radius_m] = _room(mission, ground, radius_m)
                shapely.prepare(rooms[radius_m])
                _require_to_fit(mission, rooms[radius_m], robot)
                if _is_jammed(mission, rooms[radius_m], radius_m):
                    return _on_lattice(mission, ground, reserve_m, seed)
            place = _free_place(rooms[radius_m], placed, radius_m, rng)
            if place is None:
                return _on_lattice(mission, ground, reserve_m, seed)
            starts[k] = place
            placed.add(float(starts[k, 0]), float(starts[k, 1]), radius_m)
    return starts


def _room(mission: Mission, ground: MultiPolygon, radius_m: float) -> MultiPolygon:
    """Where the centre of such a body may be at the start."""
    room = ground.buffer(-radius_m) if radius_m > 0 else ground
    start = mission.fleet.start
    return room.intersection(shapely.box(*start.low_m, *start.high_m)) if isinstance(start, StartBox) else room


def _where(mission: Mission) -> tuple[str, str]:
    """What is too small for its robots, and what would help."""
    if isinstance(mission.fleet.start, StartBox):
        return "fleet.start.box", "a larger box"
    return "fleet.robots", "a larger area"


def _require_to_fit(mission: Mission, room: MultiPolygon, robot: Robot) -> None:
    """Raises MissionError where the robot fits nowhere, or all bodies together cannot."""
    where, larger = _where(mission)
    if room.is_empty:
        raise MissionError(f"{where}: robot {robot.name} with its body of {robot.body_radius_m:.6g} m fits nowhere")
    waiting = [other.body_radius_m for other in mission.fleet.robots or () if other.start is None]
    bodies_m2 = math.pi * sum(body**2 for body in waiting)
    room_m2 = room.buffer(max(waiting)).area
    if bodies_m2 > room_m2 or (len(set(waiting)) == 1 and bodies_m2 > DENSEST * room_m2):
        raise MissionError(
            f"{where}: {len(waiting)} bodies of {bodies_m2:.6g} m2 do not fit in {room_m2:.6g} m2; give fewer"
            f" robots or {larger}"
        )


def _is_jammed(mission: Mission, room: MultiPolygon, radius_m: float) -> bool:
    """Whether random places cannot be found for all bodies without a start: many, of one radius, reserve included."""
    waiting = [robot.body_radius_m for robot in mission.fleet.robots or () if robot.start is None]
    if len(waiting) < MANY * shapely.get_num_geometries(room) or len(set(waiting)) > 1:
        return False
    return len(waiting) * math.pi * radius_m**2 > JAMMED * float(room.buffer(radius_m).area)


def _free_place(
    room: MultiPolygon, placed: _Placed, radius_m: float, rng: np.random.Generator
) -> tuple[float, float] | None:
    """The first of some TRIES random places in the room where the body touches nothing, or None."""
    low, high = np.array(room.bounds[:2]), np.array(room.bounds[2:])
    for _ in range(TRIES // BATCH):
        points = rng.uniform(low, high, (BATCH, 2))
        for x, y in points[shapely.intersects_xy(room, *points.T)]:
            if placed.has_room(x, y, radius_m):
                return float(x), float(y)
    return None


def _on_lattice(mission: Mission, ground: MultiPolygon, reserve_m: float, seed: int) -> Floats:
    """Starts (n, 2) on a lattice where random ones do not fit; all bodies count as the widest without a start."""
    robots = mission.fleet.robots or ()
    waiting = np.array([robot.start is None for robot in robots])
    widest_m = max(robot.body_radius_m for robot in robots if robot.start is None)
    starts = np.array([robot.start or (np.nan, np.nan) for robot in robots], np.float64)
    bodies = np.array([robot.body_radius_m for robot in robots])
    fit = 0
    for radius_m in sorted({widest_m + reserve_m, widest_m}, reverse=True):
        room = _room(mission, ground, radius_m)
        if room.is_empty:
            continue
        places, fit = lattice_starts(
            room, starts[~waiting], bodies[~waiting], count=int(waiting.sum()), radius_m=radius_m,
            rng=np.random.default_rng(seed),
        )  # fmt: skip
        if len(places):
            starts[waiting] = places
            return starts
    where, larger = _where(mission)
    raise MissionError(
        f"{where}: no room was found for {int(waiting.sum())} robots with bodies of up to {widest_m:.6g} m; a lattice"
        f" holds {fit} of them; give fewer robots or {larger}"
    )


def spare_room_m(mission: Mission, ground: MultiPolygon, starts_m: Floats, wish_m: float) -> float:
    """How much wider all bodies may be at their starts, and at chargers, without touching anything, at most wish_m."""
    bodies = np.array([robot.body_radius_m for robot in mission.fleet.robots or ()])
    pairs = cKDTree(starts_m).query_pairs(2 * (bodies.max() + wish_m), output_type="ndarray")
    a, b = pairs.T
    gaps = np.hypot(*(starts_m[a] - starts_m[b]).T) - bodies[a] - bodies[b]
    walls = shapely.distance(ground.boundary, shapely.points(starts_m)) - bodies
    pads = [shapely.distance(ground.boundary, shapely.Point(charger.at)) - bodies.max() for charger in mission.chargers]
    return float(max(0.0, min([gaps.min(initial=np.inf) / 2, walls.min(), *pads])))


def passable_reserve_m(mission: Mission, ground: MultiPolygon, wish_m: float) -> float:
    """How much wider bodies may be, at most wish_m, so that with twice of that they still pass the doors they fit in.

    wish_m, or that halved again and again. A door that the largest body fits through with less than ``LEAST_RESERVE_M``
    to spare on each side may get closed.
    """
    robots = mission.fleet.robots or ()
    body_m = max(robot.body_radius_m for robot in robots)
    spot_m2 = math.pi * (SPOT * min(robot.sensor.reach_m for robot in robots)) ** 2
    rooms, reserve_m = _rooms_for(ground, body_m, spot_m2), wish_m
    while reserve_m > LEAST_RESERVE_M:
        wider = _rooms_for(ground, body_m + 2 * reserve_m, spot_m2)
        inside = [sum(room.intersects(part) for part in wider) for room in rooms]
        if max(inside, default=0) <= 1:
            break
        reserve_m /= 2
    return reserve_m


def _rooms_for(ground: MultiPolygon, body_m: float, spot_m2: float) -> list[BaseGeometry]:
    """Where the middle of a body may be, part by part; no spots that are smaller than so much."""
    room = ground.buffer(-body_m, join_style="mitre") if body_m > 0 else ground
    return [part for part in shapely.get_parts(room) if part.area > spot_m2]


def require_short_steps(mission: Mission, sensors_m: Floats, time_step_s: float, wall_range_m: float | None) -> None:
    """Without the filter a robot beyond the range in which walls count must not reach one in a single step.

    Raises MissionError. sensors_m: (n,) of robots; wall_range_m: None: as far as that.
    """
    for robot, sensor_m in zip(mission.fleet.robots or (), sensors_m.tolist(), strict=True):
        step_m, range_m = robot.ground_speed_m_s * time_step_s, wall_range_m or sensor_m
        if step_m + robot.body_radius_m > range_m:
            raise MissionError(
                f"swarm.time_step_s: {time_step_s:.6g} is not allowed without the filter: robot {robot.name}"
                f" goes {step_m:.6g} m in a step and heeds walls within {range_m:.6g} m only, so it may jump through"
                " one; a shorter step or filter: true is needed"
            )


def lattice_starts(
    room: BaseGeometry, taken_m: Floats, taken_radii_m: Floats, *, count: int, radius_m: float, rng: np.random.Generator
) -> tuple[Floats, int]:
    """Places (count, 2) in a room for bodies of one radius that touch nothing, or none; and how many bodies fit.

    room: where centres may be. taken_m, taken_radii_m: (k, 2) and (k,) bodies that stand there already. The lattices
    are triangular, in both directions, and square. The widest spacing that holds enough is taken. Places are drawn from
    it, and each is shaken by no more than half of the room between neighbours.
    """
    shapely.prepare(room)  # it is asked for every place of every lattice
    x0, y0, x1, y1 = room.bounds
    # tiny bodies in a huge room have more places than anybody needs
    fine_m = max(math.sqrt((x1 - x0) * (y1 - y0) / MOST_PLACES), (x1 - x0 + y1 - y0) / MOST_PLACES)
    least_m = max(2 * radius_m, 1e-6, fine_m) * (1 + 1e-12)

    def fitting(spacing_m: float) -> Floats:
        """The most places with this spacing."""
        return max((_places(room, taken_m, taken_radii_m + radius_m, spacing_m, k) for k in range(3)), key=len)

    tight = fitting(least_m)
    if len(tight) < count:
        return np.empty((0, 2)), len(tight)
    low_m, high_m, best = least_m, least_m + math.hypot(x1 - x0, y1 - y0), tight
    for _ in range(LOOSENINGS):
        middle_m = (low_m + high_m) / 2
        lattice = fitting(middle_m)
        if len(lattice) >= count:
            low_m, best = middle_m, lattice
        else:
            high_m = middle_m
    places = best[np.sort(rng.permutation(len(best))[:count])]
    angle, away = rng.uniform(0, 2 * math.pi, count), (low_m / 2 - radius_m) * np.sqrt(rng.uniform(0, 1, count))
    shaken = places + away[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ok = _clear(room, taken_m, taken_radii_m + radius_m, shaken)
    return rng.permutation(np.where(ok[:, None], shaken, places)), len(tight)


def _places(room: BaseGeometry, taken_m: Floats, apart_m: Floats, spacing_m: float, kind: int) -> Floats:
    """Points (p, 2) of a lattice from the room's lower left; kind 0: rows shifted by halves, 1: columns, 2: square."""
    x0, y0, x1, y1 = room.bounds
    width, height = (y1 - y0, x1 - x0) if kind == 1 else (x1 - x0, y1 - y0)
    rise_m = spacing_m * (1.0 if kind == 2 else math.sqrt(3) / 2 * (1 + 1e-12))
    columns, rows = (int(length / step + 1e-9) + 1 for length, step in ((width, spacing_m), (height, rise_m)))
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    u, v = spacing_m * (i + (0.0 if kind == 2 else 0.5) * (j % 2)), rise_m * j
    points = np.stack([v, u] if kind == 1 else [u, v], axis=-1).reshape(-1, 2) + np.array([x0, y0])
    return np.asarray(points[_clear(room, taken_m, apart_m, points)])


def _clear(room: BaseGeometry, taken_m: Floats, apart_m: Floats, points_m: Floats) -> Flags:
    """Which points (n, 2) lie in the room and as far from each taken place (k, 2) as asked, (k,)."""
    ok = np.asarray(shapely.dwithin(room, shapely.points(points_m), ON_THE_BORDER_M))
    for place, least_m in zip(taken_m, apart_m, strict=True):
        ok &= np.hypot(*(points_m - place).T) >= least_m
    return ok
