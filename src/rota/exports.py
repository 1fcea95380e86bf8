"""The formats that plans are exported to, each made by a function that is loaded when it is called.

``FORMATS`` names all of them; the command line and the page take their choices from it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.model.plan import Plan
    from rota.model.planner_settings import Settings


def function_at(where: str, **fixed: str) -> Callable[..., Any]:
    """The function at ``module:name`` of Rota, loaded when it is called; fixed: what it is always called with."""
    module, name = where.split(":")

    def call(*arguments: Any, **given: Any) -> Any:
        return getattr(import_module(f"rota.{module}"), name)(*arguments, **fixed, **given)

    return call


def geojson_warning(plan: Plan) -> str | None:
    """That maps would look for it elsewhere, of a mission without an origin."""
    told = "the mission has no origin: coordinates are in local metres, not in WGS84 as maps expect"
    return told if plan.mission.origin is None else None


@dataclass(frozen=True, kw_only=True)
class Format:
    """A format and its line in the help. It is made by ``text`` or ``timed_text`` (a file), ``folder`` or ``timed``.

    ``folder`` writes files for each robot and returns the paths; ``timed_text`` also takes the instant of the start.
    ``timed`` takes that, too, and writes a file, or a folder where ``is_folder``. settings: the module and the name of
    the ``Settings`` that either takes as well. in_phase: what keeps robots in phase where vehicles see no clock.
    warning: what the receiver should know of a plan. judges: the check's loops run. charging: plans whose robots charge
    are told whole, by a clock, or as single flights with a table of when each starts, or not at all.
    """

    holds: str
    text: Callable[[Plan], str] | None = None
    timed_text: Callable[[Plan, datetime], str] | None = None
    folder: Callable[..., tuple[Path, ...]] | None = None
    timed: Callable[..., tuple[Path, ...]] | None = None
    is_folder: bool = False
    takes_origin: bool = True
    settings: tuple[str, str] | None = None
    in_phase: str | None = None
    warning: Callable[[Plan], str | None] = lambda plan: None
    judges: bool = False
    charging: Literal["whole", "flights", "refused"] = "whole"

    @property
    def has_clock(self) -> bool:
        """Whether what is written tells instants."""
        return self.timed_text is not None or self.timed is not None

    @property
    def is_text(self) -> bool:
        """Whether it is one file of text."""
        return self.text is not None or self.timed_text is not None


BY_ARDUPILOT = "a speed for each leg and waits, which ArduPilot cuts to whole seconds; start all robots together"

FORMATS = {
    "geojson": Format(
        holds="a map of ground and routes", text=function_at("files.geojson:geojson_text"), warning=geojson_warning
    ),
    "csv": Format(holds="a table of all timed points", text=function_at("files.plan_table:csv_text")),
    "kml": Format(holds="ground and tracks that Google Earth plays", timed_text=function_at("files.kml_tour:kml_text")),
    "gpx": Format(holds="tracks with times (GPX 1.1)", timed_text=function_at("files.gpx_tracks:gpx_text")),
    "qgroundcontrol": Format(
        holds=".plan files for ArduPilot",
        folder=function_at("files.qgroundcontrol:write_qgroundcontrol", autopilot="ardupilot"),
        in_phase=BY_ARDUPILOT,
        charging="flights",
    ),
    "qgroundcontrol-px4": Format(
        holds=".plan files for PX4",
        folder=function_at("files.qgroundcontrol:write_qgroundcontrol", autopilot="px4"),
        in_phase="a speed for each leg and waits, for 65,535 rounds; start all robots together",
        charging="flights",
    ),
    "waypoints": Format(
        holds="QGC WPL 110 lists for ArduPilot",
        folder=function_at("files.waypoint_list:write_waypoint_lists"),
        in_phase=BY_ARDUPILOT,
        charging="flights",
    ),
    "dji-wpml": Format(
        holds="KMZ for DJI's ground stations",
        folder=function_at("files.dji_waylines:write_dji_waylines"),
        settings=("rota.files.dji_waylines", "WaylineSettings"),
        in_phase="a speed for each leg and waits of whole seconds, until robots fly home; start all together",
        charging="flights",
    ),
    "nav2": Format(
        holds="waypoints and a nav_msgs/Path for Nav2 (YAML)",
        folder=function_at("files.nav2_waypoints:write_nav2_waypoints"),
        takes_origin=False,
        in_phase="speed_m_s and wait_s of each waypoint, for clients that heed them; start all robots together",
        charging="flights",
    ),
    "vda5050": Format(
        holds="VDA 5050 orders and their updates",
        timed=function_at("files.vda5050_files:write_vda5050_orders"),
        is_folder=True,
        takes_origin=False,
        settings=("rota.files.vda5050_files", "OrderSettings"),
        in_phase="maxSpeed of each edge, driven at, and actions that wait; start all robots together",
        charging="flights",
    ),
    "create2-sketch": Format(
        holds="sketches for Create 2 robots",
        folder=function_at("export_create2:create2_sketches"),
        takes_origin=False,
        judges=True,
        charging="refused",
    ),
    "create2-reactive": Format(
        holds="programs for Create 2 robots that turn at every bump, with no plan",
        folder=function_at("export_create2:create2_programs"),
        takes_origin=False,
        warning=function_at("export_create2:covering_time"),
        judges=True,
        charging="refused",
    ),
    "rosbag2": Format(
        holds="a bag of ROS 2 in MCAP, for Foxglove and RViz",
        timed=function_at("export_bag:rosbag2"),
        is_folder=True,
        takes_origin=False,
        judges=True,
    ),
    "rosbag2-sqlite3": Format(
        holds="a bag of ROS 2 in SQLite",
        timed=function_at("export_bag:rosbag2", storage="sqlite3"),
        is_folder=True,
        takes_origin=False,
        judges=True,
    ),
    "rosbag1": Format(
        holds="a bag of ROS 1 (.bag)", timed=function_at("export_bag:rosbag1"), takes_origin=False, judges=True
    ),
}


@dataclass(frozen=True, kw_only=True)
class Export:
    """A plan on its way into a format, with all that was asked for found to make sense."""

    plan: Plan
    kind: Format
    start: datetime
    given: dict[str, Settings]

    def text(self) -> str:
        """The file's text, of a format that is made as text."""
        if self.kind.timed_text is not None:
            return self.kind.timed_text(self.plan, self.start)
        assert self.kind.text is not None
        return self.kind.text(self.plan)

    def write(self, output: str | Path) -> tuple[Path, ...]:
        """Write the file or the folder; returns the paths written."""
        from rota.files.atomic_write import write_atomically

        output = str(output)
        if self.kind.is_text:
            write_atomically(output, self.text())
            return (Path(output),)
        writes = self.kind.timed or self.kind.folder
        assert writes is not None
        clock = () if self.kind.timed is None else (self.start,)
        if self.has_flights:
            from rota.files.flight_files import write_flights

            return write_flights(self.plan, output, partial(writes, **self.given), *clock)
        return writes(self.plan, output, *clock, **self.given)

    @property
    def has_flights(self) -> bool:
        """Whether the files are single flights, since robots charge."""
        from rota.routes.flights import recharges

        return self.kind.charging == "flights" and recharges(self.plan)


def export_of(
    plan: Plan,
    to: str,
    *,
    origin: str | tuple[float, float] | None = None,
    start_time: str | datetime | None = None,
    settings: Sequence[str] | Mapping[str, object] = (),
) -> Export:
    """The export of a plan to a format.

    origin: latitude and longitude, or LAT,LON, for a mission without. start_time: an instant, or one in ISO 8601, for
    formats with a clock. settings: values by their names, or KEY=VALUE, for formats that have some. RotaError for what
    the format does not take, by the names of the options of ``rota export``.
    """
    from rota.files.timed_places import START, instant_given

    kind = FORMATS[export_format(to)]
    settings = [f"{key}={value}" for key, value in settings.items()] if isinstance(settings, Mapping) else settings
    if origin is not None:
        plan = place_for(plan, origin, to)
    if start_time is not None and not kind.has_clock:
        clocks = ", ".join(name for name, other in FORMATS.items() if other.has_clock)
        raise RotaError(f"--start-time: {start_time!r} is not allowed: {to} has no clock; these have one: {clocks}")
    if kind.charging == "refused":
        _require_no_charging(plan, to)
    start = START if start_time is None else instant_given(start_time, "--start-time")
    return Export(plan=plan, kind=kind, start=start, given=_settings_given(to, settings))


def _require_no_charging(plan: Plan, to: str) -> None:
    from rota.routes.flights import recharges

    if recharges(plan):
        flights = ", ".join(name for name, kind in FORMATS.items() if kind.charging == "flights")
        raise RotaError(
            f"--to: {to!r} is not allowed for a plan whose robots charge: programs of bouncing robots know no charger;"
            f" as single flights there are {flights}"
        )


def export_plan(
    plan: Plan,
    to: str,
    output: str | Path,
    *,
    origin: str | tuple[float, float] | None = None,
    start_time: str | datetime | None = None,
    settings: Sequence[str] | Mapping[str, object] = (),
) -> tuple[Path, ...]:
    """Write the plan in a format of ``FORMATS``, to a file or for a folder of files; returns the paths written.

    The others as in ``export_of``; RotaError for what the format does not take or cannot hold.
    """
    return export_of(plan, to, origin=origin, start_time=start_time, settings=settings).write(output)


def export_format(name: str, where: str = "--to") -> str:
    """The name of a format; raises RotaError for others, which says ``where`` they were given."""
    if name not in FORMATS:
        raise RotaError(f"{where}: {name!r} is not one of {', '.join(map(repr, FORMATS))}")
    return name


def _settings_given(to: str, settings: Sequence[str]) -> dict[str, Settings]:
    """The keyword for a format's settings; nothing for one that has none. RotaError for what they do not take."""
    from rota.links.link_settings import parsed_settings

    where = FORMATS[to].settings
    if where is not None:
        module, name = where
        return {"settings": parsed_settings(getattr(import_module(module), name), settings)}
    if settings:
        having = ", ".join(name for name, other in FORMATS.items() if other.settings is not None)
        raise RotaError(f"--set: {settings[0]!r} is not allowed: {to} has no settings; these have some: {having}")
    return {}


def place_for(plan: Plan, origin: str | tuple[float, float], to: str) -> Plan:
    """The plan with its mission at LAT,LON; RotaError for formats in the mission's own metres."""
    if not FORMATS[to].takes_origin:
        raise RotaError(f"--origin: {origin!r} is not allowed: {to} is in the mission's own metres")
    return placed_plan(plan, origin)


def placed_plan(plan: Plan, origin: str | tuple[float, float]) -> Plan:
    """The plan with its mission at LAT,LON; RotaError for other text, and for a mission elsewhere."""
    from dataclasses import replace

    from rota.model.mission import GeoPoint

    try:
        lat, lon = (float(number) for number in (origin.split(",") if isinstance(origin, str) else origin))
        place = GeoPoint(lat=lat, lon=lon)
    except (TypeError, ValueError):
        raise RotaError(
            f"--origin: {origin!r} is not allowed; LAT,LON in degrees is needed, such as 48.1,11.5, with LAT in -90..90"
            " and LON in -180..180"
        ) from None
    given = plan.mission.origin
    if given not in (None, place):
        raise RotaError(
            f"--origin: {origin!r} is not allowed: the mission has its own, {given.lat:.9g},{given.lon:.9g}"
        )
    return replace(plan, mission=replace(plan.mission, origin=place))
