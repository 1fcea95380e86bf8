"""What the chosen planner cannot use of a mission file; it is refused, not ignored."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rota.files.schema_block import Where

# a plan file of 100,000 robots is some 300 MB, and its check takes minutes; a patrol plans robot by robot
MOST_ROBOTS, MOST_PATROLLING = 100_000, 10_000
OTHER_CONTROLLERS = ("settle", "voronoi", "virtual_force")
OF_RECIPROCAL = ("velocity", "samples", "boundary", "horizon_s", "neighbours", "neighbour_range_m", "alpha")
NEEDED = {"samples": ("velocity", "sampled"), "horizon_s": ("boundary", "circle")}


OF_TASK = {"purpose": "monitor", "contact_free": "monitor", "most_steps": "cover"}  # of bouncing robots


def unused_by_patrol(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """What of a mission file the planner patrol cannot use."""
    if data.get("moving_obstacles"):
        yield ("moving_obstacles",), "the patrol planner has no use for moving_obstacles: remove them"
    yield from _coming_and_going(data)
    listed = _inner(data, "fleet", "robots")
    count = len(listed) if isinstance(listed, list) else listed
    if isinstance(count, int) and MOST_PATROLLING < count <= MOST_ROBOTS:
        yield ("fleet", "robots"), f"{count} is not allowed; the patrol planner plans for at most {MOST_PATROLLING}"
    if _inner(data, "patrol", "method") == "sun2019" and _inner(data, "fleet", "sensor", "shape") == "square":
        yield ("fleet", "sensor", "shape"), "square is not allowed: patrol.method sun2019 is made for discs; give disc"


def _coming_and_going(
    data: dict[str, Any], message: str = "only robots of a swarm join or leave: remove it"
) -> Iterator[tuple[Where, str]]:
    listed = _inner(data, "fleet", "robots")
    for k, robot in enumerate(listed if isinstance(listed, list) else []):
        for name in ("joins_s", "leaves_s"):
            if _inner(robot, name):
                yield ("fleet", "robots", k, name), message


def growing_footprints(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Footprints that grow with height where there are no heights."""
    listed = _inner(data, "fleet", "robots")
    places: list[tuple[Where, Any]] = [(("fleet",), data.get("fleet"))]
    places += [(("fleet", "robots", k), robot) for k, robot in enumerate(listed if isinstance(listed, list) else [])]
    for where, block in places:
        if _inner(block, "sensor", "half_angle_deg") is not None:
            yield (*where, "sensor", "half_angle_deg"), "is for a swarm with altitudes_m only: remove it"


def _unused_in_space(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """What swarms with altitudes cannot use."""
    if data.get("moving_obstacles"):
        yield ("moving_obstacles",), "a swarm with altitudes_m has no use for moving_obstacles: remove them"
    yield from _coming_and_going(data, "robots with altitudes_m neither join nor leave: remove it")
    yield from _periods(
        data, "a swarm with altitudes_m is asked no periods, since footprints grow with height: remove it"
    )


def _unused_settings(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Settings of a swarm that its others make useless."""
    block = data.get("swarm")
    given = [name for name in block if block[name] is not None] if isinstance(block, dict) else []
    for name in given:
        if name in OF_RECIPROCAL and _inner(data, "swarm", "controller") in (None, *OTHER_CONTROLLERS):
            yield ("swarm", name), "only the controller reciprocal uses it: remove it, or choose that controller"
        elif name in NEEDED and _inner(data, "swarm", NEEDED[name][0]) != NEEDED[name][1]:
            yield ("swarm", name), f"is for {NEEDED[name][0]}: {NEEDED[name][1]} only: remove it"


def unused_by_swarm(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """What of a mission file the planner swarm cannot use."""
    fleet = data.get("fleet") if isinstance(data.get("fleet"), dict) else {}
    assert isinstance(fleet, dict)
    if fleet.get("robots", "fewest") == "fewest":
        yield ("fleet", "robots"), "fewest is not allowed: a swarm needs a number of robots, or a list of them"
    listed = fleet.get("robots") if isinstance(fleet.get("robots"), list) else []
    places: list[tuple[Where, Any]] = [(("fleet",), fleet)]
    places += [(("fleet", "robots", k), robot) for k, robot in enumerate(listed or [])]
    flying = _inner(data, "swarm", "altitudes_m") is not None
    for where, block in places:
        if flying and _inner(block, "sensor", "shape") == "square":
            yield (*where, "sensor", "shape"), "square is not allowed: a swarm with altitudes_m has discs; give disc"
        if _inner(block, "turn_rate_rad_s") is not None:
            yield (*where, "turn_rate_rad_s"), "robots of a swarm turn at once: remove it"
    yield from _unused_settings(data)
    if flying:
        yield from _unused_in_space(data)


def unused_by_bounce(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """What of a mission file the planner bounce cannot use."""
    if data.get("moving_obstacles"):
        yield ("moving_obstacles",), "the bounce planner has no use for moving_obstacles: remove them"
    yield from _coming_and_going(data)
    if _inner(data, "fleet", "start", "box") is not None:
        yield ("fleet", "start", "box"), "bouncing robots start at points: give points, or remove it"
    typed = _inner(data, "area", "text") is not None
    free = _inner(data, "bounce", "cells") == "none"
    if free:
        yield from _starts_without_cells(data)
    elif _inner(data, "bounce", "cell_m") is None and not typed:
        yield ("bounce", "cell_m"), "is missing; give the side of a cell in metres"
    robots, task = _inner(data, "fleet", "robots"), _inner(data, "bounce", "task") or "monitor"
    count = len(robots) if isinstance(robots, list) else robots if isinstance(robots, int) else None
    if task == "cover" and count is None:
        yield ("fleet", "robots"), "a number of robots, or a list of them, is needed to cover an area"
    if count is None and _inner(data, "fleet", "start", "points") is not None:
        yield ("fleet", "start"), "bouncing robots as few as possible begin where the planner likes: remove it"
    for name in ("bouncing_angles_deg", "start_headings_deg"):
        angles = _inner(data, "bounce", name)
        if isinstance(angles, list) and len(angles) not in (1, count):
            each = f" or one for each of {count}" if count is not None else ""
            yield ("bounce", name), f"{len(angles)} angles are not allowed; one for all robots{each} is needed"
    for name, only in OF_TASK.items():
        if _inner(data, "bounce", name) is not None and task in ("monitor", "cover") and task != only:
            yield ("bounce", name), f"is for task: {only} only: remove it"
    if task == "monitor":
        yield from _unwatched_by_bounce(data)
    elif task == "cover":
        yield from _periods(data, "covering happens once: remove the period, or write bounce.task: monitor")


def _starts_without_cells(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Every start that is given, which robots without cells do not heed."""
    message = "with bounce.cells: none robots begin where the planner likes: remove it"
    if _inner(data, "fleet", "start") is not None:
        yield ("fleet", "start"), message
    listed = _inner(data, "fleet", "robots")
    for k, robot in enumerate(listed if isinstance(listed, list) else []):
        if _inner(robot, "start") is not None:
            yield ("fleet", "robots", k, "start"), message


def _unwatched_by_bounce(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    if data.get("period_s") is not None:
        yield ("period_s",), "bouncing robots monitor zones, not the area: remove it"
    zones = data.get("zones")
    for k, zone in enumerate(zones if isinstance(zones, list) else []):
        asked = _inner(zone, "period_s") is not None or _inner(zone, "geojson") is not None
        if asked and (_inner(zone, "demand") or "every_point") == "every_point":
            yield ("zones", k, "demand"), "every_point is not allowed: bouncing robots visit zones; write demand: visit"


def _periods(data: dict[str, Any], message: str) -> Iterator[tuple[Where, str]]:
    """Every period that is asked for, with what to say of it where none may be."""
    if data.get("period_s") is not None:
        yield ("period_s",), message
    zones = data.get("zones")
    for k, zone in enumerate(zones if isinstance(zones, list) else []):
        if _inner(zone, "period_s") is not None:
            yield ("zones", k, "period_s"), message


def _inner(data: Any, *keys: str) -> Any:
    for key in keys:
        data = data.get(key) if isinstance(data, dict) else None
    return data
