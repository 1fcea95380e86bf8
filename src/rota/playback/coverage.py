"""How much ground robots that spread have in range, and how many cells robots that bounce have entered, over time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rota.cells.cell_map import cell_map_of
from rota.check.presence import away_times_s
from rota.check.routes import sensors_of
from rota.model.arrays import Floats
from rota.model.mission import DiscSensor
from rota.model.plan import Plan, Trajectory
from rota.planning.plan_summary import range_at_the_end
from rota.playback import kernels
from rota.routes.flights import on_charger

MOMENTS = 400
CELLS = 20_000


class Coverage(NamedTuple):
    """Shares (t,) of the ground at times_s (t,); what: in words. at_rest: the last share, measured on shapes."""

    what: str
    times_s: Floats
    shares: Floats
    at_rest: float | None

    @property
    def header(self) -> dict[str, Any]:
        """What of it is no array."""
        return {"what": self.what, "at_rest": self.at_rest}


def range_over_time(plan: Plan) -> Coverage | None:
    """What robots of a swarm, or that all hold in the end, have in range, as pictures count it; None for others.

    Judged at the centres of some ``CELLS`` cells.
    """
    loops_s = max((trajectory.loop_duration_s for trajectory in plan), default=0.0)
    if not len(plan.trajectories) or (loops_s and not plan.mission.planning.makes_runs):
        return None
    cell_map = cell_map_of(plan.mission, CELLS)
    end_s = max(float(trajectory.times_s[-1]) for trajectory in plan) + loops_s
    times_s = np.linspace(0.0, end_s, MOMENTS if end_s > 0 else 1)
    places_m = np.stack([_places_at(trajectory, times_s) for trajectory in plan], 1)
    reaches_m, squares = sensors_of(plan)
    radii_m = np.tile(reaches_m, (len(times_s), 1))
    for k, trajectory in enumerate(plan):
        sensor = plan.mission.fleet.robot(trajectory.robot).sensor
        if isinstance(sensor, DiscSensor) and sensor.half_angle_deg is not None:
            radii_m[:, k] = [sensor.radius_at_m(float(height_m)) for height_m in places_m[:, k, 2]]
    joins_s, leaves_s = away_times_s(plan)
    radii_m[(times_s[:, None] < joins_s) | (times_s[:, None] > leaves_s)] = -1.0
    radii_m[np.stack([on_charger(trajectory, times_s) for trajectory in plan], 1)] = -1.0
    flat_m = np.ascontiguousarray(places_m[:, :, :2])
    counts = kernels.cells_in_range(flat_m, radii_m, squares, cell_map.x_m, cell_map.y_m, cell_map.inside)
    seen, free, _ = range_at_the_end(plan)
    return Coverage(
        what="ground in range",
        times_s=times_s,
        shares=counts / max(int(cell_map.inside.sum()), 1),
        at_rest=seen.area / free.area if free.area > 0 and not loops_s else None,
    )


def coverage_over_time(entered_s: Floats, cells: int) -> Coverage:
    """The share of ``cells`` cells that have been entered; entered_s: (rows, columns) when each first was, or inf."""
    times_s = np.unique(np.concatenate([[0.0], entered_s[np.isfinite(entered_s)]]))
    shares = np.searchsorted(np.sort(entered_s.ravel()), times_s, side="right") / max(cells, 1)
    return Coverage(what="cells entered", times_s=times_s, shares=shares, at_rest=None)


def _places_at(trajectory: Trajectory, times_s: Floats) -> Floats:
    """Places (t, 3) of a robot; height 0 where it has none."""
    places_m = trajectory.at(times_s)
    return np.pad(places_m, ((0, 0), (0, 3 - places_m.shape[1])))
