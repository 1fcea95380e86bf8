"""The first two stages: virtual sensors that cover all ground, and a frame, a short closed tour past them.

A virtual sensor sees twice as far as a robot: a robot that goes round the frame at the sensor's range sees to there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_matrix

from rota.errors import NoPlanFound
from rota.model.arrays import Flags, Floats, Ints, ShortInts
from rota.model.mission import DiscSensor
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import lay_out
from rota.planners.patrol.ground.viewpoints import choose_viewpoints, what_places_see
from rota.planners.patrol.tours.visiting_order import short_order

ACROSS_ZONES_M = 10_000.0  # alpha of Eq. 12: metres that a step to a sensor of another period counts as


@dataclass(frozen=True, kw_only=True)
class Frame:
    """A closed tour past the sensors in one part of the space.

    places_m: (n, 2) the sensors in their order; period_class: (n,) whose ground each is there for; legs_m: (n,) metres
    of the way from each to the next, the last to the first.
    """

    places_m: Floats
    period_class: Ints
    legs_m: Floats
    part: int


def frames_past_sensors(problem: Problem, cover: str) -> list[Frame]:
    """The frames, one in each part of the space that has sensors. cover: "greedy" or "exact"."""
    places_m, period_class = deployed_sensors(problem, cover)
    parts = problem.paths.part_of(places_m)
    return [
        frame_past(problem, places_m[parts == part], period_class[parts == part], int(part))
        for part in np.unique(parts)
    ]


def deployed_sensors(problem: Problem, cover: str) -> tuple[Floats, Ints]:
    """Sensors (n, 2), and the period class (n,) that each is there for: ground of the shortest periods has its first.

    Places are chosen among those to look from, for samples as far apart as the paper's cells. Raises NoPlanFound for
    square sensors.
    """
    sensor = problem.robot.sensor
    if not isinstance(sensor, DiscSensor):
        raise NoPlanFound(
            f"fleet.sensor: a square of side {sensor.side_m:.6g} m cannot be used with patrol.method sun2019, which is"
            " made for discs; give shape: disc and a radius_m, or another method"
        )
    wide = replace(problem.robot, sensor=DiscSensor(radius_m=2 * sensor.radius_m))
    step = max(1, round(0.48 * sensor.radius_m / problem.spacing_m))
    lattice = (problem.points.row % step == 0) & (problem.points.column % step == 0)
    points, samples, _ = lay_out(problem.points[(problem.points.row < 0) | lattice], problem.walls, wide)
    places_m = problem.viewpoints.xy_m
    # routes cut corners: discs overlap a little
    start, items = what_places_see(places_m, wide, problem.range_margin_m + 0.04 * sensor.radius_m, samples)
    left, chosen, classes = np.ones(len(points), dtype=bool), list[Ints](), list[Ints]()
    for period_class in range(len(problem.periods_s)):
        wanted = left & (points.period == period_class)
        found = chosen_places(start, items, wanted, cover)
        chosen.append(found)
        classes.append(np.full(len(found), period_class))
        for place in found:
            left[items[start[place] : start[place + 1]]] = False
    return places_m[np.concatenate(chosen)], np.concatenate(classes)


def chosen_places(start: Ints, items: ShortInts, wanted: Flags, cover: str) -> Ints:
    """Places (k,) that see all wanted samples (s,) that any sees. start (c + 1,), items: what each place sees."""
    if cover == "greedy":
        return choose_viewpoints(start, items, wanted, np.ones(len(wanted)))[0]
    kept = wanted[items]
    number = np.cumsum(wanted) - 1
    own_start = np.concatenate([[0], np.cumsum(kept)])[start]
    return exact_cover(own_start, number[items[kept]], int(wanted.sum()))[0]


def frame_past(problem: Problem, places_m: Floats, period_class: Ints, part: int) -> Frame:
    """A short closed tour past the sensors (n, 2) of one part, which changes seldom from one period to another."""
    changes = period_class[:, None] != period_class[None]
    order = short_order(problem.paths.all_pairs(places_m) + ACROSS_ZONES_M * changes)
    places_m = places_m[order]
    legs_m = [problem.paths.distances(a[None], b[None])[0, 0] for a, b in _legs(places_m)]
    return Frame(places_m=places_m, period_class=period_class[order], legs_m=np.array(legs_m), part=part)


def _legs(places_m: Floats) -> zip[tuple[Floats, Floats]]:
    return zip(places_m, np.roll(places_m, -1, axis=0), strict=True)


def greedy_cover(start: Ints, items: Ints, cells: int) -> Ints:
    """Places (k,), each chosen for the most cells that no place before it sees; of equal places the first.

    start (c + 1,), items: the cells that each place sees, of ``cells`` cells. Cells that no place sees stay unseen.
    """
    chosen, _ = choose_viewpoints(start, items, np.ones(cells, dtype=bool), np.ones(cells))
    return chosen


def exact_cover(start: Ints, items: Ints, cells: int, *, node_limit: int = 1) -> tuple[Ints, int]:
    """As few places (k,) as see all cells that any place sees, and a lower bound for any choice of these places.

    start (c + 1,), items: the cells that each place sees, of ``cells`` cells. Integer programming (HiGHS) decides on
    what dominance leaves. node_limit nodes of its tree end it, never the clock; where it has nothing better by then,
    the greedy cover stays. The bound holds for these places, not for sensors anywhere in the plane. Without cells: no
    places, 0.
    """
    greedy = greedy_cover(start, items, cells)
    sees = csr_matrix((np.ones(len(items)), items, start), shape=(len(start) - 1, cells))
    places, wanted = leave_out_dominated(sees)
    if not len(wanted):
        return greedy[:0], 0
    rows = sees[places][:, wanted].T.tocsr()
    count = len(places)
    solution = milp(
        np.ones(count), constraints=LinearConstraint(rows, 1, np.inf), integrality=np.ones(count), bounds=Bounds(0, 1),
        options={"node_limit": node_limit},
    )  # fmt: skip
    proved = solution.mip_dual_bound
    bound = max(1, math.ceil(proved - 1e-6)) if proved is not None and math.isfinite(proved) else 1
    if solution.x is None or round(solution.fun) >= len(greedy):
        return greedy, min(bound, len(greedy))
    chosen = places[np.flatnonzero(solution.x > 0.5)]
    return chosen, min(bound, len(chosen))


def leave_out_dominated(sees: csr_matrix) -> tuple[Ints, Ints]:
    """Places (rows) and cells (columns) that decide: a least cover of these is a least cover of all.

    A place is left out when another one sees all that it sees. A cell is left out when another cell is seen only from
    places that see it, too. Of equal ones the first stays. A cell that nothing sees asks for nothing.
    """
    places = np.arange(sees.shape[0])
    cells = np.flatnonzero(sees.getnnz(axis=0) > 0)
    for _ in range(10):  # after two or three there is hardly anything left to drop
        before = len(places) + len(cells)
        places = places[~_within_another(sees[places][:, cells])]
        cells = cells[~_holds_another(sees[places][:, cells].T.tocsr())]
        if len(places) + len(cells) == before:
            break
    return places, cells


def _within_another(rows: csr_matrix) -> Flags:
    """Rows whose set lies in another row's: (r,) flags; of equal rows all but the first, and all empty rows."""
    inner, outer, size = _subsets(rows)
    drop: Flags = size == 0
    drop[inner[(size[inner] < size[outer]) | (inner > outer)]] = True
    return drop


def _holds_another(rows: csr_matrix) -> Flags:
    """Rows whose set holds another row's: (r,) flags; of equal rows all but the first."""
    inner, outer, size = _subsets(rows)
    drop = np.zeros(len(size), dtype=bool)
    drop[outer[(size[inner] < size[outer]) | (inner < outer)]] = True
    return drop


def _subsets(rows: csr_matrix) -> tuple[Ints, Ints, Ints]:
    """Pairs (p,) of different rows, the first one's set within the second one's, and the size of every row, (r,)."""
    size = np.asarray(rows.getnnz(axis=1), dtype=np.int64)
    shared = (rows @ rows.T).tocoo()
    pairs = (shared.row != shared.col) & (np.rint(shared.data) == size[shared.row])
    return shared.row[pairs].astype(np.int64), shared.col[pairs].astype(np.int64), size
