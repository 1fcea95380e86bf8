"""The lanes of a mission as a graph: places where they end, ways from place to place, and what these take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from rota.errors import NoPlanFound
from rota.model.arrays import Floats, Ints
from rota.model.mission import Lane, Mission
from rota.planners.patrol.driving.timed_line import TimedLine, steady


@dataclass(frozen=True, kw_only=True)
class Network:
    """Ends of lanes (n, 2), the fastest lane from each to its neighbours, and the speed of the robots.

    ways_s: (n, n) sparse, the seconds that it takes. lane: by two ends its number plus one, with a minus where it is
    driven from its last point to its first.
    """

    ends_m: Floats
    ways_s: csr_array
    lane: dict[tuple[int, int], int]
    lanes: tuple[Lane, ...]
    speed_m_s: float

    def line_along(self, ends: Sequence[int]) -> TimedLine:
        """The timed line along ends that follow each other."""
        times_s, places_m = [0.0], [self.ends_m[ends[0]]]
        for a, b in pairwise(ends):
            number = self.lane[a, b]
            lane = self.lanes[abs(number) - 1]
            line_m = np.array(lane.line_m[:: 1 if number > 0 else -1])
            steps_m = np.hypot(*np.diff(line_m, axis=0).T)
            duration_s = lane.duration_s(self.speed_m_s)
            times_s += (times_s[-1] + duration_s * np.cumsum(steps_m) / steps_m.sum()).tolist()
            places_m += list(line_m[1:])
        return steady(np.array(times_s), np.array(places_m))


@dataclass(frozen=True, kw_only=True)
class Calls:
    """Places to come to: the number (m,) of the lane's end, the period (m,) and the part (m,) of the network of each.

    leg_s: (m, m) the fastest ways, inf where there is none. before: (m, n) the end before each end on the fastest way
    from a place. From everywhere in a part there is a way to everywhere in it.
    """

    end: Ints
    period_s: Floats
    part: Ints
    leg_s: Floats
    before: Ints

    def __len__(self) -> int:
        return len(self.end)

    def way(self, a: int, b: int) -> list[int]:
        """The ends on the fastest way from one place to another, both of theirs included."""
        ends = [int(self.end[b])]
        while ends[-1] != self.end[a]:
            ends.append(int(self.before[a, ends[-1]]))
        return ends[::-1]


def network_of(mission: Mission, speed_m_s: float) -> Network:
    """The graph of the mission's lanes; of several lanes between two ends the fastest counts."""
    ends_m, which = np.unique(
        np.array([end for lane in mission.lanes for end in lane.ends_m]), axis=0, return_inverse=True
    )
    pairs = which.reshape(-1, 2).tolist()
    best, lane_of = dict[tuple[int, int], float](), dict[tuple[int, int], int]()
    for k, ((a, b), lane) in enumerate(zip(pairs, mission.lanes, strict=True)):
        takes_s = lane.duration_s(speed_m_s)
        for way, number in [((a, b), k + 1)] + ([] if lane.one_way else [((b, a), -k - 1)]):
            if a != b and takes_s < best.get(way, np.inf):
                best[way], lane_of[way] = takes_s, number
    rows, columns = np.array(list(best), np.int64).reshape(-1, 2).T  # none where each lane is a ring
    ways_s = csr_array((list(best.values()), (rows, columns)), shape=(len(ends_m), len(ends_m)))
    return Network(ends_m=ends_m, ways_s=ways_s, lane=lane_of, lanes=mission.lanes, speed_m_s=speed_m_s)


def calls_of(mission: Mission, network: Network) -> Calls:
    """The places of all zones with a period. Those at one end of a lane are one, with the shortest of their periods.

    NoPlanFound where no lane ends in a zone, or no robot that comes to it comes back.
    """
    part = connected_components(network.ways_s, connection="strong")[1]
    alone = np.bincount(part)[part] == 1
    points = shapely.points(network.ends_m)
    shortest_s = dict[int, float]()
    for zone in mission.zones:
        if zone.period_s is None:
            continue
        inside = np.flatnonzero(shapely.covers(zone.shape, points))
        if not len(inside):
            raise NoPlanFound(f"zone {zone.name}: no lane ends in it, and on lanes robots come to ends")
        inside = inside[np.argsort(alone[inside], kind="stable")]  # with ways there and back first
        near = inside[~alone[inside]] if not alone[inside].all() else inside
        nearest = int(near[np.argmin(shapely.distance(points[near], zone.shape.centroid))])
        shortest_s[nearest] = min(zone.period_s, shortest_s.get(nearest, np.inf))
    end = np.array(sorted(shortest_s))
    leg_s, before = dijkstra(network.ways_s, indices=end, return_predecessors=True)
    return Calls(
        end=end, period_s=np.array([shortest_s[int(k)] for k in end]), part=part[end].astype(np.int64),
        leg_s=leg_s[:, end], before=before.astype(np.int64),
    )  # fmt: skip
