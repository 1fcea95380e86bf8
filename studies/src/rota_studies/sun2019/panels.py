"""What the runs came to, as panels of maps and curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from shapely import LineString

from rota.draw.palette import OVER_PERIOD, ROUTE_COLOURS, route_style
from rota.model.mission import AREA, Mission
from rota.model.plan import Plan
from rota_studies.panels.curve_panel import Curve, CurvePanel, Level
from rota_studies.panels.map_panel import Dots, MapPanel, Strokes
from rota_studies.sun2019.results import Found, Printed, Sensors, Way, ZoneSensors
from rota_studies.sun2019_method.partition import CostedPartition
from rota_studies.tables import counted

Floats = NDArray[np.float64]

# of sensors, by zone: shapes differ as well as colours
ZONE_COLOURS, ZONE_MARKERS = tuple(ROUTE_COLOURS[k] for k in (0, 6, 7)), "osD"
REST_COLOUR, REST_MARKER = ROUTE_COLOURS[3], "^"
QUARTERS = (0.125, 0.625)  # of a late route, where it is marked
MOST_WAY = 3.0  # times its last length: a tour that is longer still has a crossing more
INK, GREY = "#222222", "#8A8A8A"


def zone_title(name: str) -> str:
    """A zone as tables and legends call it: by its name on all pictures; the paper's zone 3 is the rest of the area."""
    return "rest" if name == AREA else name


def rest_note(mission: Mission) -> str:
    """What the ground outside zones asks, which no label on the map tells."""
    return "" if mission.period_s is None else f"outside zones every {mission.period_s:g} s"


def _in_zone_order(mission: Mission, sensors: Sensors) -> list[tuple[int, ZoneSensors]]:
    """The zones as the mission tells them, the rest last, each with its number there: colours then stay the same."""
    numbers = {zone.name: k for k, zone in enumerate(mission.zones)} | {AREA: len(mission.zones)}
    return sorted(((numbers[zone.name], zone) for zone in sensors.zones), key=lambda pair: pair[0])


def sensors_by_zone(mission: Mission, sensors: Sensors) -> tuple[int, ...]:
    """Sensors of each zone as the mission tells them, the rest last."""
    return tuple(len(zone.positions_m) for _, zone in _in_zone_order(mission, sensors))


def sensor_dots(mission: Mission, sensors: Sensors, *, discs: bool) -> tuple[Dots, ...]:
    """The virtual sensors of each zone, with the discs that they see if asked for."""
    return tuple(
        Dots(
            label=f"{zone_title(zone.name)}: {len(zone.positions_m)}",
            places_m=zone.positions_m,
            colour=REST_COLOUR if zone.name == AREA else ZONE_COLOURS[k % len(ZONE_COLOURS)],
            marker=REST_MARKER if zone.name == AREA else ZONE_MARKERS[k % len(ZONE_MARKERS)],
            reach_m=sensors.virtual_radius_m if discs else 0.0,
        )
        for k, zone in _in_zone_order(mission, sensors)
    )


def deployment_panel(title: str, mission: Mission, sensors: Sensors) -> MapPanel:
    """Sensors and what they see: Figures 6a, 6b, 13a and 16a."""
    note = counted(len(sensors.positions_m), "virtual sensor")
    return MapPanel(title=title, note=note, mission=mission, dots=sensor_dots(mission, sensors, discs=True))


def cost_panel(title: str, deployed: Sequence[tuple[str, Sensors]], *, wide: bool = False) -> CurvePanel:
    """The fitness of Eq. 11 by iteration: Figures 6c, 13b and 16b. Sensors without a history have no curve.

    The random start, with half of the sensors deployed, costs so much that it would squeeze all else; a note tells it.
    """
    known = [(label, sensors.cost) for label, sensors in deployed if sensors.cost is not None]
    curves = tuple(
        Curve(label, cost[1:], ZONE_COLOURS[k], at=np.arange(1.0, len(cost)), marked=False)
        for k, (label, cost) in enumerate(known)
    )
    starts, ends = (" and ".join(f"{cost[at]:,.0f}" for _, cost in known) for at in (0, -1))
    note = f"from {starts} to {ends}"
    return CurvePanel(
        title=title, note=note, curves=curves, across="iterations", up="cost (Eq. 11)", logarithmic=True, wide=wide
    )


def frame_panel(
    title: str, mission: Mission, sensors: Sensors, frame: Way, *, edges: tuple[Floats, ...] = ()
) -> MapPanel:
    """The frame with where it changes sub-region, and legs that no robot can travel: Figures 8, 13c and 16c."""
    pieces = [frame.path_m[a : b + 1] for a, b in zip(frame.leg_start[:-1], frame.leg_start[1:], strict=True)]
    strokes = [Strokes(f"graph, {len(edges)} edges", edges, GREY, width_pt=0.4)] if edges else []
    strokes.append(Strokes("frame", (frame.path_m,), INK, width_pt=1.1))
    if frame.blocked_legs:
        blocked = [piece for piece in pieces if not _free(mission, piece)]
        strokes.append(Strokes("leg through a wall", tuple(blocked), OVER_PERIOD, (0.0, (2.0, 1.0)), 2.2))
    crossings_m = crossing_places(sensors, frame)
    dots = [dots._replace(size_pt=3.2) for dots in sensor_dots(mission, sensors, discs=False)]
    if len(crossings_m):
        dots.append(Dots("crossing", crossings_m, OVER_PERIOD, "o", 5.5, filled=False))
    note = f"{frame.length_m:,.0f} m, {counted(frame.zone_crossings, 'crossing')} between zones"
    return MapPanel(title=title, note=note, mission=mission, strokes=tuple(strokes), dots=tuple(dots))


def crossing_places(sensors: Sensors, frame: Way) -> Floats:
    """The middle (k, 2), metres, of every straight piece of the frame between sensors of different zones."""
    known = {tuple(place): int(zone) for place, zone in zip(sensors.positions_m, sensors.zone_of, strict=True)}
    zones = [known[tuple(frame.path_m[0])]]
    for place in frame.path_m[1:]:
        # a corner on the way round an obstacle is no sensor, and still belongs to the zone it was left for
        zones.append(known.get(tuple(place), zones[-1]))
    middles_m = (frame.path_m[:-1] + frame.path_m[1:]) / 2
    return np.asarray(middles_m[np.diff(zones) != 0])


def _free(mission: Mission, piece_m: Floats) -> bool:
    """Whether a leg keeps inside the area and out of obstacles that block motion."""
    line = LineString(piece_m)
    walls = [obstacle.shape for obstacle in mission.obstacles if obstacle.blocks_motion]
    tolerance_m = 1e-6
    return mission.area.buffer(tolerance_m).covers(line) and not any(
        line.intersection(wall).length > tolerance_m for wall in walls
    )


def tour_panel(title: str, frame: Way) -> CurvePanel:
    """The way of the shortest tour so far by generation, once it has as few crossings as in the end.

    With more crossings it would be thousands of metres longer, alpha for each.
    """
    way_m = frame.fell_to - (frame.tour_length - frame.length_m)
    last = np.flatnonzero(way_m < MOST_WAY * frame.length_m)
    at, values = np.append(frame.fell_at[last], frame.generations), np.append(way_m[last], frame.length_m)
    # steps, as the tour falls at once
    at, values = np.repeat(at, 2)[1:], np.repeat(values, 2)[:-1]
    note = f"ends at {frame.tour_length:,.0f}, {frame.length_m:,.0f} m of it way"
    curve = Curve("shortest tour", values, ZONE_COLOURS[0], at=at.astype(np.float64), marked=False)
    return CurvePanel(title=title, note=note, curves=(curve,), across="generations", up="way without α, m")


def partition_panel(title: str, partition: CostedPartition, least: float) -> CurvePanel:
    """The lowest cost of Eq. 28 by iteration, and the least of all partitions: Figures 13f and 16f."""
    curve = Curve("swarms", partition.history, ZONE_COLOURS[0])
    note = f"{partition.cost:,.0f} from iteration {settled(partition.history)} on"
    levels = (Level(f"least possible: {least:,.0f}", least, INK),)
    return CurvePanel(title=title, note=note, curves=(curve,), levels=levels, across="iterations", up="cost (Eq. 28)")


def printed_panel(title: str, mission: Mission, printed: Printed) -> MapPanel:
    """Figures 12, 13e, 14 and 16e: the routes as the paper has them, late ones marked, with what the check says."""
    assert printed.routes is not None
    unseen = f", {printed.unseen_m2:,.0f} m² never seen" if printed.unseen_m2 > 0 else ""
    dots: tuple[Dots, ...] = ()
    if len(printed.late):
        marks = np.array([_quarter(printed.routes[k].positions_m, share) for k in printed.late for share in QUARTERS])
        dots = (Dots(f"late by Eq. 26: {len(printed.late)}", marks, OVER_PERIOD, "X", 6.0),)
    return MapPanel(
        title=title, note=f"{counted(printed.robots, 'robot')}; check: {printed.verdict}{unseen}", mission=mission,
        plan=Plan(mission=mission, trajectories=printed.routes), dots=dots, listed_zones=True,
    )  # fmt: skip


def _quarter(route_m: Floats, share: float) -> Floats:
    """The place (2,) where a share of a route (k, 2) is over."""
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(route_m, axis=0).T)))
    return np.array([np.interp(share * along[-1], along, values) for values in route_m.T])


def settled(history: Floats) -> int:
    """From where on a history stays at its last value."""
    return int(np.flatnonzero(history == history[-1])[0])


def segments_panel(title: str, mission: Mission, sensors: Sensors, frame: Way, partition: CostedPartition) -> MapPanel:
    """The segments of the frame, one robot each, with the times of their routes by Eq. 26."""
    n = len(frame.order)
    strokes = []
    for k in range(len(partition.first)):
        places = partition.places(k, n)
        legs = [frame.path_m[frame.leg_start[i] : frame.leg_start[i + 1] + 1] for i in places[:-1]]
        alone = sensors.positions_m[frame.order[places[:1]]]
        path_m = np.vstack([alone, *(leg[1:] for leg in legs)]) if legs else np.vstack([alone, alone])
        colour, style = route_style(k)
        label = f"{partition.times_s[k]:.1f} of {partition.periods_s[k]:g} s"
        strokes.append(Strokes(label, (path_m,), colour, style, 2.0))
    note = counted(len(partition.first), "segment") + ", their times by Eq. 26"
    dots = Dots("sensor", sensors.positions_m, INK, size_pt=2.2)
    return MapPanel(title=title, note=note, mission=mission, strokes=tuple(strokes), dots=(dots,))


def routes_panel(title: str, mission: Mission, found: Found) -> MapPanel:
    """The routes of a plan: Figures 13e, 14 and 16e; the map alone where there is no plan."""
    plan = found.plan_on(mission)
    if plan is None or found.loops_m is None or found.worst_ratio is None:
        return MapPanel(title=title, note="no plan", mission=mission, named_zones=True)
    note = f"{counted(len(plan.trajectories), 'robot')}, {found.loops_m:,.0f} m, worst gap {found.worst_ratio:.2f}"
    note += "" if found.met else ", not met"
    return MapPanel(title=title, note=note, mission=mission, plan=plan, listed_zones=True)
