"""Plans of missions far from the origin, as at UTM coordinates, are searched for near it: so rounding decides nothing.

Places come from the numbers of the mission less its lower left corner, and the corner is added to those of the plan.
Between a number and half or twice as much the difference is exact, so that plans hold what the mission has unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, is_dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import shapely

from rota.errors import CheckpointError, MissionError, NoPlanFound
from rota.model.fields import fields_of
from rota.model.limits import LARGEST_M
from rota.model.trajectory import Trajectory, forward_accelerations
from rota.planning.checkpoint import Checkpoint
from rota.planning.planner import Answer, Handover, Planner, Request

if TYPE_CHECKING:
    from rota.check.report import Report
    from rota.model.mission import Mission
    from rota.model.plan import Plan

FAR = 10.0  # times its extent that a mission lies away from the origin, from where on it is moved
PLACE = re.compile(r"(?<=[(\[])(-?[\d.]+(?:e[+-]?\d+)?), (-?[\d.]+(?:e[+-]?\d+)?)(?=[)\]])")  # as planners tell them
Moved = TypeVar("Moved")


def plan_near_origin(planner: Planner, request: Request) -> Answer:
    """The planner's answer; it is asked near the origin if it wants that, and places are as the mission has them."""
    way = _way_to_origin(planner, request.mission)
    if way is None:
        return planner.plan(request)
    judge = _Judge(way, request.judge)
    near = replace(
        request, mission=way.here(request.mission), judge=judge,
        checkpoint=request.checkpoint and way.run_here(request.checkpoint),
    )  # fmt: skip
    with way.correct_failures():
        answer = planner.plan(near)
    return replace(
        answer, plan=judge.there(answer.plan), facts=tuple(map(way.tell, answer.facts)),
        checkpoint=answer.checkpoint and way.run_there(answer.checkpoint),
    )  # fmt: skip


def takeovers_near_origin(planner: Planner, asked: Handover) -> Iterator[Plan]:
    """The planner's plans that take over, likewise."""
    way = _way_to_origin(planner, asked.mission)
    if way is None:
        yield from planner.takeovers(asked)
        return
    places = {name: (x - way.corner_m[0], y - way.corner_m[1]) for name, (x, y) in asked.places.items()}
    near = replace(
        asked, mission=way.here(asked.mission), places=places, seam=way.here(asked.seam), loops=way.here(asked.loops),
        going_on={name: way.here(line) for name, line in asked.going_on.items()},
        lateness=lambda plan: asked.lateness(way.there(plan)),
    )  # fmt: skip
    with way.correct_failures():
        for plan in planner.takeovers(near):
            yield way.there(plan)


def _way_to_origin(planner: Planner, mission: Mission) -> _Way | None:
    """How the mission is moved; None: it is near, or the planner takes it where it is."""
    if not planner.plans_near_origin:
        return None
    x0, y0, x1, y1 = mission.area.bounds
    far_m = FAR * max(x1 - x0, y1 - y0)
    corner_m = tuple(low if max(abs(low), abs(high)) > far_m else 0.0 for low, high in ((x0, x1), (y0, y1)))
    return _Way((corner_m[0], corner_m[1])) if any(corner_m) else None


class _Way:
    """From places as they are to places near the origin, and back; what comes back unchanged is what it was."""

    def __init__(self, corner_m: tuple[float, float]) -> None:
        self.corner_m = corner_m
        self._was: dict[int, tuple[object, object]] = {}  # by its id what was moved here, and what it was

    def __reduce__(self) -> tuple[type[_Way], tuple[object, ...]]:
        """In another process objects are others."""
        return _Way, (self.corner_m,)

    def here(self, value: Moved) -> Moved:
        """The value with all its places near the origin."""

        def less(places_m: Any) -> Any:
            return np.asarray(places_m, np.float64) - self.corner_m

        def keep(was: object, now: object) -> None:
            self._was[id(now)] = (now, was)

        return _map_places(value, _mover(less), keep, lambda _each: None)  # type: ignore[no-any-return]

    def there(self, value: Moved) -> Moved:
        """The value with its places as they are."""

        def more(places_m: Any) -> Any:
            return np.asarray(places_m, np.float64) + self.corner_m

        known = self._was
        return _map_places(  # type: ignore[no-any-return]
            value, _mover(more), lambda was, now: None, lambda each: known.get(id(each), (None, None))[1]
        )

    def run_here(self, run: Checkpoint) -> Checkpoint:
        """The stopped run with its mission near the origin, where its places are already: it goes on bit for bit."""
        near = replace(run, mission=self.here(run.mission))
        x0, y0, x1, y1 = near.mission.area.bounds
        if np.abs(near.places_m[:, :2]).max(initial=0.0) > FAR * max(x1 - x0, y1 - y0):
            raise CheckpointError(
                "places_m: robots are far from the mission's area; runs of missions far from the origin, stopped by an"
                " earlier Rota, begin anew"
            )
        return near

    def run_there(self, run: Checkpoint) -> Checkpoint:
        """The stopped run with its mission as it is."""
        return replace(run, mission=self.there(run.mission))

    def tell(self, text: str) -> str:
        """A sentence of the planner's with the places as they are, to a centimetre."""

        def place(found: re.Match[str]) -> str:
            x, y = (float(number) + by for number, by in zip(found.groups(), self.corner_m, strict=True))
            return f"{round(x, 2):.12g}, {round(y, 2):.12g}"

        return PLACE.sub(place, text)

    @contextmanager
    def correct_failures(self) -> Iterator[None]:
        """What a planner says of why there is no plan tells places, and has a plan, as they are."""
        try:
            yield
        except NoPlanFound as failure:
            raise NoPlanFound(
                self.tell(str(failure)), best=failure.best and self.there(failure.best),
                checkpoint=self.run_there(failure.checkpoint) if isinstance(failure.checkpoint, Checkpoint) else None,
                facts=tuple(map(self.tell, failure.facts)),
            ) from failure  # fmt: skip
        except MissionError as failure:
            raise MissionError(*map(self.tell, failure.faults)) from failure

    def report_here(self, report: Report) -> Report:
        """The check's report with its places near the origin."""
        x, y = self.corner_m

        def near(found: Any) -> Any:
            return (
                found if found.place_m is None else replace(found, place_m=(found.place_m[0] - x, found.place_m[1] - y))
            )

        demands = tuple(
            replace(one, excluded_places=tuple((a - x, b - y, area_m2) for a, b, area_m2 in one.excluded_places))
            for one in report.demands
        )
        return replace(
            report, demands=demands, violations=tuple(map(near, report.violations)),
            margins=tuple(map(near, report.margins)), unmet_points_m=report.unmet_points_m - self.corner_m,
            shown_unmet_m=report.shown_unmet_m - self.corner_m,
        )  # fmt: skip


@dataclass
class _Judge:
    """The check of plans as they are, as a planner near the origin sees it; the plan judged last is kept."""

    way: _Way
    judge: Callable[[Plan], Report]
    last: tuple[Plan, Plan] | None = None

    def there(self, plan: Plan) -> Plan:
        """The plan as it is."""
        last = self.last  # which another thread may change
        if last is None or last[0] is not plan:
            self.last = last = (plan, self.way.there(plan))
        return last[1]

    def __call__(self, plan: Plan) -> Report:
        return self.way.report_here(self.judge(self.there(plan)))

    def __reduce__(self) -> tuple[type[_Judge], tuple[object, ...]]:
        return _Judge, (self.way, self.judge)


def _mover(move: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """From shapes, places and arrays of places to such that are moved."""

    def shift(value: Any) -> Any:
        if isinstance(value, shapely.Geometry):
            return shapely.transform(value, move)
        if isinstance(value, np.ndarray):
            return np.hstack([move(value[:, :2]), value[:, 2:]])
        if value and isinstance(value[0], tuple):
            return tuple(shift(each) for each in value)
        return tuple(move(value).tolist()) if value else value

    return shift


def _map_places(
    value: Any, shift: Callable[[Any], Any], keep: Callable[[object, object], None], known: Callable[[object], object]
) -> Any:
    """The value with all places in it moved: shapes, and fields that may be as low as coordinates.

    keep: told of each value and what became of it. known: what a value is to become, where that is known.
    """
    if (found := known(value)) is not None:
        return found
    if isinstance(value, shapely.Geometry):
        now = shift(value)
    elif isinstance(value, tuple):
        now = tuple(_map_places(each, shift, keep, known) for each in value)
    elif is_dataclass(value) and not isinstance(value, type):
        changed: dict[str, Any] = {}
        for item in fields_of(type(value)):
            was = getattr(value, item.name, None)
            if was is not None and item.kind != "number":
                places = item.least == -LARGEST_M
                after = shift(was) if places else _map_places(was, shift, keep, known)
                changed |= {} if after is was else {item.name: after}
        if changed and isinstance(value, Trajectory) and value.accelerations_m_s2 is not None:
            # rounding makes a leg shorter by a hair
            at = value.times_s, changed["positions_m"], value.accelerations_m_s2
            changed["accelerations_m_s2"] = forward_accelerations(*at)
        now = replace(value, **changed) if changed else value
    else:
        return value
    if now is not value:
        keep(value, now)
    return now
