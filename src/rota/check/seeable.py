"""Which places nobody can see from where bodies can stand."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from rota.check import triangle_kernels
from rota.check.arrays import Flags, Floats, Triangles
from rota.check.blocking import blocks_sight
from rota.check.pieces import Pieces, point_pieces
from rota.check.routes import segments_of
from rota.check.standing import StandingArea, standing_areas
from rota.check.tolerances import slack_of
from rota.check.triangles import triangles_of
from rota.model.mission import DiscSensor, Mission, Obstacle, Sensor

RAGGED_CORNERS, SHARP_RAD = 500, 0.5


def is_ragged(mission: Mission) -> bool:
    """Whether walls have so many sharp corners, as on a scanned floor, that they cut most pieces of the ground."""
    return _sharp_corners(mission.obstacles) > RAGGED_CORNERS


@functools.lru_cache(maxsize=4)
def _sharp_corners(obstacles: tuple[Obstacle, ...]) -> int:
    """The corners of what blocks sight that turn by more than ``SHARP_RAD``; those where rings begin are left out."""
    sides = segments_of(blocks_sight(obstacles))
    turns = np.diff(np.unwrap(np.arctan2(*(sides[:, 2:] - sides[:, :2]).T[::-1])))
    follows = (sides[:-1, 2:] == sides[1:, :2]).all(axis=1)
    return int(np.count_nonzero(follows & (np.abs(turns) > SHARP_RAD)))


def seeable(mission: Mission, areas: tuple[StandingArea, ...], points_m: Floats) -> Flags:
    """Whether each of the points (n, 2) can be seen from anywhere some robot can stand: (n,) bool.

    Points must not lie inside what blocks sight.
    """
    return _ground(mission.obstacles, areas, slack_of(mission)).sees(point_pieces(points_m))


def seeable_ground(mission: Mission, names: tuple[str, ...] = ()) -> SeeableGround:
    """What can be seen of the mission's ground, to be asked again and again; names: by which sensors, if not all."""
    return _ground(mission.obstacles, standing_areas(mission, names), slack_of(mission))


@functools.lru_cache(maxsize=4)
def _ground(obstacles: tuple[Obstacle, ...], areas: tuple[StandingArea, ...], slack_m: float) -> SeeableGround:
    """The same for missions that differ in their periods only; a search has hundreds of plans for them checked."""
    return SeeableGround(blocks_sight(obstacles), areas, slack_m)


class SeeableGround:
    """What can be seen from standing areas past what blocks sight, ``hidden``."""

    def __init__(self, hidden: Any, areas: tuple[StandingArea, ...], slack_m: float) -> None:
        self._hidden, self._areas, self._slack_m = hidden, areas, slack_m

    def sees(self, pieces: Pieces) -> Flags:
        """Whether anything of each of n convex pieces, or places, can be seen: (n,) flags.

        False proves that nothing of a piece can be seen, but for what lies within the slack of its border.
        """
        sight = np.zeros(len(pieces), np.bool_)
        for scene in self._scenes:
            left = np.flatnonzero(~sight)
            if len(left):
                sight[left] = _sees_from(scene, pieces.choose(left), self._slack_m)
        return sight

    def get_ready(self) -> None:
        """Make the ground ready to be looked at."""
        _ = self._scenes

    @functools.cached_property
    def _scenes(self) -> tuple[_Scene, ...]:
        """A scene for each area that is not empty."""
        areas = [area for area in self._areas if not area.shape.is_empty]
        return tuple(_scene_of(area, self._hidden, self._slack_m) for area in areas)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Scene:
    """The ground in reach of one standing area, in triangles; None where all of it can be stood on.

    low_m, high_m: corners of a box beyond which nothing is in reach.
    """

    area: StandingArea
    triangles: Triangles | None
    low_m: Floats
    high_m: Floats


def _scene_of(area: StandingArea, hidden: Any, slack_m: float) -> _Scene:
    """The ground that bodies of one area cannot stand on, as far as they see and half as far again."""
    box_m = np.array(area.shape.bounds)
    low_m, high_m = box_m[:2] - 1.5 * area.sensor.reach_m, box_m[2:] + 1.5 * area.sensor.reach_m
    frame = shapely.box(*low_m, *high_m)
    ground = shapely.difference(shapely.difference(frame, hidden), area.shape)
    # lines alone: what is near a collection of other shapes takes many times as long to find
    walls = shapely.multilinestrings(shapely.get_parts([shapely.boundary(hidden), shapely.boundary(frame)]))
    triangles = triangles_of(ground, walls, shapely.boundary(area.shape), slack_m)
    return _Scene(area=area, triangles=triangles, low_m=low_m, high_m=high_m)


def _half_m(sensor: Sensor) -> float:
    """The radius of a disc, or half the side of a square."""
    return sensor.radius_m if isinstance(sensor, DiscSensor) else sensor.side_m / 2


def _sees_from(scene: _Scene, pieces: Pieces, slack_m: float) -> Flags:
    """Whether any of each piece is seen from the area of the scene: (n,) flags."""
    if not len(pieces):
        return np.zeros(0, np.bool_)
    low_m = np.minimum.reduceat(pieces.corners_m, pieces.offsets[:-1], axis=0)
    high_m = np.maximum.reduceat(pieces.corners_m, pieces.offsets[:-1], axis=0)
    sight = np.asarray(((high_m >= scene.low_m) & (low_m <= scene.high_m)).all(axis=1))
    if scene.triangles is not None:
        near, sensor = np.flatnonzero(sight), scene.area.sensor
        own = pieces.choose(near)
        sight[near] = triangle_kernels.are_seen(
            scene.triangles, own.offsets, own.corners_m, _half_m(sensor), not isinstance(sensor, DiscSensor), slack_m
        )
    return sight
