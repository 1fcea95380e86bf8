"""What takes long is told before it begins: large ground, many robots, many corners, slow turning."""

from __future__ import annotations

import math
from collections.abc import Iterator

import shapely

from rota.model.mission import Mission, inner_reach_m
from rota.planning.planner import about


def planning_ahead(mission: Mission) -> Iterator[str]:
    """What makes planning a mission long, each with a rough estimate."""
    robot = (mission.fleet.unlike_robots)[0]
    reach_m = inner_reach_m(robot.sensor)
    periods_s = [period for period in (mission.period_s, *(zone.period_s for zone in mission.zones)) if period]
    if mission.period_s is not None:
        squares = mission.area.area / reach_m**2
        if squares >= 100_000:
            # measured with the benchmark plan-10-km2 (100,000 squares of the reach: 34 s, 0.76 GB)
            lasts_s, memory = 3.4e-4 * squares, (3.3e8 + 4.3e3 * squares) / 1e9
            yield (
                f"{squares:,.0f} squares of the sensor's reach to watch: at effort quick about"
                f" {about(lasts_s)} and {memory:.0f} GB, more at the others"
            )
        robots = mission.area.area / (2 * reach_m * robot.ground_speed_m_s * mission.period_s)
        if robots >= 200:
            # measured with the benchmark many-robots (353 and 2,058 robots in rows of lanes), and for districts of 10
            # robots that are searched one by one on two cores
            in_rows_s, searched_s = 0.03 * robots, 1.2 * robots
            walls = bool(mission.obstacles) or any(part.interiors for part in mission.area.geoms)
            searched = f", up to {about(searched_s)} where walls are in the way" if walls else ""
            yield (
                f"about {robots:,.0f} robots are needed to sweep the area in {mission.period_s:g} s: at effort quick"
                f" about {about(in_rows_s)} in the open{searched}"
            )
    shapes = [mission.area, *(obstacle.shape for obstacle in mission.obstacles)]
    corners = int(shapely.get_num_coordinates(shapes).sum())
    if corners >= 2_000:
        ragged = "; close_gaps_m beside area.map counts narrow nooks as wall" if corners >= 20_000 else ""
        lasts_s = 7e-3 * corners  # measured with scanned floors of up to 35,500 corners
        yield f"{corners:,} corners of walls: about {about(lasts_s)} to find the ways round them{ragged}"
    if robot.turn_rate_rad_s is not None and periods_s:
        round_s = 2 * math.pi / robot.turn_rate_rad_s
        if round_s > max(periods_s):
            yield (
                f"turning round once takes {round_s:.4g} s, longer than any period: no robot that moves keeps a loop"
                " of its own, and a search for many that share one takes minutes"
            )
