"""What a process loads before it is asked for anything: most of a small mission's time is loading compiled loops."""

from __future__ import annotations

from contextlib import nullcontext

import shapely

from rota.compiled.compiled_cache import is_compiled
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, PlannerSettings, Zone
from rota.model.planner_registry import DEFAULT
from rota.planning.first_run import compile_by_two
from rota.planning.make_plan import search_plan
from rota.planning.planner import planner_named, planner_of
from rota.replanning.replan import replan
from rota.web.refusal import Json
from rota.web.tasks.context import Context


def load_planning() -> None:
    """Plan a yard, and replan it, so that what both and checking run is loaded, and compiled where it was not yet."""
    mission = _yard()
    with nullcontext() if is_ready(mission) else compile_by_two(planner_of(mission)):
        found = search_plan(mission)
    (line,) = found.plan
    replan(found.plan, at_s=1.0, lost=[line.robot], joined={"new": (2.0, 2.0)}, should_stop=lambda: True)


def prepare(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """Load what validating runs: the bound of a yard is proved, if its loops are compiled (planning compiles them)."""
    mission = _yard()
    if is_ready(mission):
        planner_of(mission).hasty_bound(mission)
    return {}, b""


def is_ready(mission: Mission) -> bool:
    """Whether the loops of a mission's planner are compiled."""
    return is_compiled(*planner_of(mission).compiled_packages(mission))


def _yard() -> Mission:
    """A small yard with a shed and a gate, for the planner that missions have when they name none."""
    small = planner_named(DEFAULT).small_mission()
    planning: PlannerSettings | None = None if small is None else small.planning
    more = {} if planning is None else {"planning": planning}
    return Mission(
        name="yard",
        area=_box(0, 0, 20, 20),
        obstacles=(Obstacle(shape=_box(8, 8, 12, 11)),),
        zones=(Zone(name="gate", shape=_box(0, 0, 4, 4), period_s=50),),
        period_s=100,
        fleet=Fleet(speed_m_s=5, sensor=DiscSensor(radius_m=5)),
        **more,  # type: ignore[arg-type]
    )


def _box(x0: float, y0: float, x1: float, y1: float) -> shapely.MultiPolygon:
    return shapely.MultiPolygon([shapely.box(x0, y0, x1, y1)])
