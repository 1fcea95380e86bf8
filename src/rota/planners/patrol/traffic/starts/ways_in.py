"""Whether ways lead from the fleet's entrances to where its robots start."""

from __future__ import annotations

import math
from collections import defaultdict

import numpy as np
import shapely

from rota.errors import MissionError
from rota.geometry.free_space import standing_space
from rota.model.fleet import Place, StartPoints
from rota.model.mission import TOUCH_M, Mission
from rota.model.start_faults import ENTRANCE_CLEARANCE, ENTRANCE_NEAR
from rota.planners.patrol.ground.standing import POCKET_ARC_CORNERS


def require_ways_in(mission: Mission) -> None:
    """MissionError that names every start to which no way leads from an entrance; a box is judged by its room."""
    fleet = mission.fleet
    if fleet.entrances is None:
        return
    placed: dict[float, list[tuple[str, Place]]] = defaultdict(list)
    if isinstance(fleet.start, StartPoints):
        placed[fleet.body_radius_m] += [(f"fleet.start.points[{k}]", at) for k, at in enumerate(fleet.start.points_m)]
    for k, robot in enumerate(fleet.robots or ()):
        if robot.start is not None:
            placed[robot.body_radius_m].append((f"fleet.robots[{k}].start", robot.start))
    faults = []
    for body_m, starts in placed.items():
        inside = standing_space(mission, body_m * (1 + ENTRANCE_CLEARANCE), arc_corners=POCKET_ARC_CORNERS)
        away_m = shapely.distance(inside, shapely.points(np.array([place for _, place in starts])))
        round_m = body_m * (1 / math.cos(math.pi / POCKET_ARC_CORNERS) - 1 + ENTRANCE_NEAR) + 2 * TOUCH_M
        for i in np.flatnonzero(~(away_m <= round_m)):  # nan where there is no place at all
            where, (x, y) = starts[i]
            faults.append(f"{where}: [{x:.9g}, {y:.9g}]: no way leads there from fleet.entrances for such a body")
    if faults:
        raise MissionError(*faults)
