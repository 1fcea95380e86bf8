"""A worst ratio of gap to period below which no plan of a team of a given size comes."""

from __future__ import annotations

from rota.planners.patrol.bounds.area_bound import area_rate
from rota.planners.patrol.bounds.rate_bound import swept_robots
from rota.planners.patrol.bounds.seeable_area import surely_seeable_m2
from rota.planners.patrol.bounds.strongest_robot import strongest_robot, sweep_m2_s
from rota.planners.patrol.bounds.turning_bound import circle_radius_m, turning_robots
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.tolerances import SURELY


def proved_ratio(problem: Problem, robots: int) -> float:
    """A ratio below which no plan of so many robots has its worst gap: sweeping takes more robots for such periods.

    0 when nothing is to be swept. Source: the bounds of ``area_bound``, ``rate_bound`` and ``turning_bound``, for
    stretched periods.
    """
    robot = strongest_robot(problem.mission.fleet)
    swept = [k for k, region in enumerate(problem.regions) if region.demand == "every_point"]
    shapes = [problem.regions[k].shape for k in swept]
    areas_m2 = surely_seeable_m2(problem.regions, problem.sure_space, problem.walls, problem.sure_robot)
    seeable_m2 = [areas_m2[k] for k in swept]
    radius_m = circle_radius_m(problem.mission)
    lost_m2 = [shape.area - m2 for shape, m2 in zip(shapes, seeable_m2, strict=True)]

    def robots_needed(stretch: float) -> float:
        periods_s = [stretch * problem.regions[k].period_s for k in swept]
        return max(
            area_rate(seeable_m2, periods_s, robot)[0],
            swept_robots(shapes, lost_m2, periods_s, robot)[0],
            turning_robots(shapes, seeable_m2, periods_s, robot, radius_m)[0],
        )

    # footprints and borders only lower what sweeping takes
    high = sum(m2 / (sweep_m2_s(robot) * problem.regions[k].period_s) for k, m2 in zip(swept, seeable_m2, strict=True))
    low, high = 0.0, high / robots
    if high == 0:
        return 0.0
    for _ in range(14):  # halvings, to a tenth of a thousandth
        middle = (low + high) / 2
        if robots_needed(middle) > robots * SURELY:
            low = middle
        else:
            high = middle
    return low
