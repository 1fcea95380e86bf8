"""Figure 22 (Section 5.3): sixteen robots over hills, each a process of its own that knows what the others send."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rota.draw.palette import COVERED, OVER_PERIOD
from rota.errors import LinkError
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.swarm.nodes.launch import run_swarm
from rota.planners.swarm.nodes.process import scene_for
from rota.planning.robot_processes import Launch, ProcessSettings, SwarmRecord
from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.gazebo_figure import MOST, SHOWN_S
from rota_studies.chen2018.panels import COLOURS, SHADE
from rota_studies.chen2018.runs import FILTERED, SETTLE, Controller, Outcome, Runs, covered_in, what
from rota_studies.panels.curve_panel import Curve, CurvePanel, Level
from rota_studies.panels.map_panel import Dots, MapPanel
from rota_studies.panels.relief_panel import ReliefPanel
from rota_studies.section import Picture, Section
from rota_studies.tables import NOTHING, Table, plus_minus
from rota_studies.verdict import Verdict, mostly

Floats = NDArray[np.float64]

CONTROLLERS = (FILTERED, SETTLE)
STEP_S = 0.1
ALTITUDE_M = 50.0
SPREAD = 2.0  # times what they cover at the start, at least, by which robots have spread
WITHIN = 0.01  # of the coverage in the end, from when on robots count as steady
PORTS = range(47_700, 49_000, 20)  # the first that are free
MEASURED = (("rate_hz", ".1f"), ("busy_ms", ".2f"), ("slow_ms", ".2f"))
TOLD_S = (2.0, 5.0, paper.GAZEBO_REST_S)
RELIEF_SHOWS = "Sixteen robots over hills, each with the square that it sees on the ground"
MOMENTS_SHOW = "Sixteen processes that spread over a square, by two controllers, and what they cover by time"


@dataclass(frozen=True, kw_only=True, eq=False)
class Flight:
    """One run of real processes. Coverage by time: times_s, shares, (k,) each.

    at_rest: whether all were in the end. gap_m: least distance between the rims of two bodies. rate_hz: decisions a
    second, of all robots on average; busy_ms, slow_ms: processor time of a decision, median and 95 %. shown_m:
    (t, n, 3) where robots were at the times that are drawn.
    """

    times_s: Floats
    shares: Floats
    at_rest: bool
    gap_m: float
    rate_hz: float
    busy_ms: float
    slow_ms: float
    shown_m: Floats

    @property
    def steady_s(self) -> float:
        """From when on coverage stays within ``WITHIN`` of what it is in the end."""
        away = np.flatnonzero(np.abs(self.shares - self.shares[-1]) > WITHIN)
        return float(self.times_s[away[-1] + 1]) if len(away) else 0.0

    def covered_at(self, time_s: float) -> float:
        """Percent covered at a time."""
        return 100 * float(np.interp(time_s, self.times_s, self.shares))


def figure_22_section(runs: Runs) -> Section:
    """Figure 22: the scene of Section 5.3 in processes."""
    mission = _mission()
    seeds = runs.some(runs.settings.process_seeds)
    flights = {
        one.name: [
            runs.records.get(
                Flight,
                {"what": "processes", **what(mission, one), "seed": seed, "seconds": runs.settings.process_s},
                lambda one=one, seed=seed: _flight(runs, mission, one, seed),  # type: ignore[misc]
            )
            for seed in seeds
        ]
        for one in CONTROLLERS
    }
    published, ours = (flights[one.name] for one in CONTROLLERS)
    return Section(
        figure=22,
        heading="Section 5.3, sixteen processes over hills",
        pictures=_pictures(mission, flights),
        caption=f"Figure 22 with the moments of Figure 23: what was recorded of 16 processes with seed {runs.seed}. "
        "Hills, start box (40 m, in the middle) and body are ours; robots fly 50 m above the ground and are measured "
        "with their squares. The curves are means over the seeds, from the least to the most.",
        paper="Each UAV is “an independent ROS node, which means that the simulation is running in a distributed way”, "
        "50 m above a mountainous region; 16 UAVs scatter and “reach steady state that they have get their maximum "
        "coverage at 10 s”. Start, step, messages, delays and values of coverage are not told.",
        ours=f"{_told(FILTERED, published)} {_told(SETTLE, ours)} At most {MOST:.1%} can be covered. Each robot is a "
        "process that decides ten times a second by what the others sent over UDP, at its own times; climbing counts "
        "as speed. Vehicles are simulated and go exactly as decided; Gazebo's dynamics are not made again. RD here has "
        "Rota's last filter, which heeds how old news are: without it nothing keeps bodies apart. Processes run when "
        "the system lets them, so that a run differs from the next one of the same seed.",
        tables=(_table(flights, runs.settings.process_s),),
        verdicts=_verdicts(published, runs.seeds(maps.gazebo(), FILTERED, runs.settings.claim_seeds)),
    )  # fmt: skip


def _mission() -> Mission:
    mission = maps.gazebo()
    return replace(mission, fleet=replace(mission.fleet, altitude_m=ALTITUDE_M))


def _flight(runs: Runs, mission: Mission, controller: Controller, seed: int) -> Flight:
    """One run in real time, on the first ports that are free."""
    runs.now(f"{mission.name} in processes: {controller.name}, seed {seed}")
    asked = replace(mission, planning=replace(controller.settings, time_step_s=STEP_S))
    for port in PORTS:
        settings = ProcessSettings(seed=seed, port=port, ground_m=maps.hills_m)
        try:
            launch = Launch(time_limit_s=runs.settings.process_s, should_stop=runs.should_stop)
            record = run_swarm(scene_for(asked, settings), settings, launch)
        except LinkError as error:
            refused = error
            continue
        runs.stop_if_asked()
        return flight_of(record)
    raise refused


def flight_of(record: SwarmRecord) -> Flight:
    """What figures need of a recorded run."""
    busy_ms, end = np.concatenate([one.busy_ms for one in record.robots]), record.plan.run_end
    return Flight(
        times_s=np.array([row[0] for row in record.coverage]),
        shares=np.array([row[1] for row in record.coverage]),
        at_rest=end is not None and end.at_rest,
        gap_m=least_gap_m(record.plan, paper.BODY_M),
        rate_hz=float(np.mean([one.rate_hz for one in record.robots])),
        busy_ms=float(np.median(busy_ms)),
        slow_ms=float(np.percentile(busy_ms, 95)),
        shown_m=np.array([places_at(record.plan, time_s) for time_s in SHOWN_S]),
    )


def _pictures(mission: Mission, flights: dict[str, list[Flight]]) -> tuple[Picture, ...]:
    """The swarm over the hills, and each controller's moments above the curves of what is covered."""
    shown = {name: many[0].shown_m for name, many in flights.items()}
    published, reach_m = shown[FILTERED.name], paper.GAZEBO_SENSOR_M / 2
    end_s = SHOWN_S[-1]
    relief = ReliefPanel(
        title=f"RD with the last filter, t = {end_s:g} s",
        note="to one scale; ways to the north are drawn shorter",
        mission=mission,
        ground_m=maps.hills_m,
        places_m=published[-1],
        reach_m=reach_m,
        colour=COVERED,
    )
    letters = iter("abcdef")
    panels = [
        _moment(f"({next(letters)}) {name.split(' ')[0]}, t = {time_s:g} s", mission, places_m)
        for name, shown_m in shown.items()
        for time_s, places_m in zip(SHOWN_S, shown_m, strict=True)
    ]
    curves = tuple(_curve(name, many) for name, many in flights.items())
    most = Level(f"all that can be covered, {MOST:.1%}", 100 * MOST, OVER_PERIOD)
    curve = CurvePanel(
        title="(g) Coverage by time", curves=curves, levels=(most,), across="seconds", up="%", wide=True,
        note=f"the paper: steady at {paper.GAZEBO_REST_S:g} s",
    )  # fmt: skip
    return (
        Picture("chen2018-figure-22.png", RELIEF_SHOWS, (relief,), columns=1),
        Picture("chen2018-figure-22-moments.png", MOMENTS_SHOW, (*panels, curve), columns=3),
    )


def _moment(title: str, mission: Mission, places_m: Floats) -> MapPanel:
    places = places_m[:, :2]
    dots = Dots("robot", places, COVERED, size_pt=2.6, reach_m=paper.GAZEBO_SENSOR_M / 2, shade=SHADE, square=True)
    return MapPanel(title=title, note=f"{covered_in(mission, places):.1%} covered", mission=mission, dots=(dots,))


def _curve(name: str, flights: Sequence[Flight]) -> Curve:
    count = min(len(flight.shares) for flight in flights)
    rows = 100 * np.array([flight.shares[:count] for flight in flights])
    band = np.array([rows.min(axis=0), rows.max(axis=0)])
    return Curve(name, rows.mean(axis=0), COLOURS[name], at=flights[0].times_s[:count], band=band)


def places_at(plan: Plan, time_s: float) -> Floats:
    """(n, 3): where the robots of a plan with heights that hold in the end are at a time."""
    return np.array([
        [np.interp(time_s, way.times_s, along) for along in way.positions_m.T] for way in plan
    ])  # fmt: skip


def least_gap_m(plan: Plan, body_m: float) -> float:
    """Least distance between the rims of two bodies at any moment, seen from above; in closed form between points."""
    times = np.unique(np.concatenate([way.times_s for way in plan]))
    ways = [
        np.column_stack([np.interp(times, way.times_s, way.positions_m[:, axis]) for axis in (0, 1)]) for way in plan
    ]
    least = np.inf
    for one, other in itertools.combinations(ways, 2):
        begin = (one - other)[:-1]
        step = np.diff(one - other, axis=0)
        along = np.clip(-(begin * step).sum(axis=1) / np.maximum((step**2).sum(axis=1), 1e-300), 0, 1)
        least = min(least, float(np.hypot(*(begin + along[:, None] * step).T).min(initial=np.inf)))
    return least - 2 * body_m


def _told(controller: Controller, flights: Sequence[Flight]) -> str:
    """What a controller came to, in words."""
    at_10 = plus_minus([flight.covered_at(paper.GAZEBO_REST_S) for flight in flights], ".1f")
    end = plus_minus([100 * float(flight.shares[-1]) for flight in flights], ".1f")
    steady = plus_minus([flight.steady_s for flight in flights], ".1f")
    return (
        f"{controller.name} covers {at_10} % at 10 s and {end} % in the end, within a point of that from {steady} s on."
    )


def _table(flights: dict[str, list[Flight]], run_s: float) -> Table:
    """A row for each controller, below what the paper prints."""
    rows = []
    for name, many in flights.items():
        rows.append((
            name, f"{sum(flight.at_rest for flight in many)} of {len(many)}",
            plus_minus([flight.steady_s for flight in many], ".1f"),
            *(plus_minus([flight.covered_at(time_s) for flight in many], ".1f") for time_s in TOLD_S),
            plus_minus([100 * float(flight.shares[-1]) for flight in many], ".2f"),
            f"{min(flight.gap_m for flight in many):.2f}",
            *(f"{np.mean([getattr(flight, of) for flight in many]):{form}}" for of, form in MEASURED),
        ))  # fmt: skip
    told = ("**the paper**", "1 of 1", f"{paper.GAZEBO_REST_S:g}", *["not printed"] * len(TOLD_S), *[NOTHING] * 5)
    return Table(
        title=f"16 processes, {len(next(iter(flights.values())))} seeds, {run_s:g} s of real time; steady: within a "
        "point of the coverage in the end; gap: least between two bodies; ms: processor time of a robot's decision and "
        "messages",
        head=("controller", "at rest", "steady from, s", *(f"covered % at {time_s:g} s" for time_s in TOLD_S),
              "covered % in the end", "gap m", "decisions a second", "ms, median", "ms, 95 %"),
        rows=(told, *rows),
    )  # fmt: skip


def _verdicts(flights: Sequence[Flight], together: Sequence[Outcome]) -> tuple[Verdict, ...]:
    """On RD; together: the same controller's runs in one program (Figure 23)."""
    steady = plus_minus([flight.steady_s for flight in flights], ".1f")
    end = plus_minus([100 * float(flight.shares[-1]) for flight in flights], ".1f")
    one = plus_minus([100 * run.coverage for run in together], ".1f")
    spreads = mostly([bool(flight.shares[-1] / flight.shares[0] > SPREAD) for flight in flights])
    by_then = mostly([flight.steady_s <= paper.GAZEBO_REST_S for flight in flights], ours=True)
    return (
        Verdict(
            "Each UAV is a node of its own, so that the swarm runs in a distributed way", "5.3, Figure 22",
            spreads.outcome,
            f"Sixteen processes that know what the others send spread to more than {SPREAD:g} times what they cover at "
            f"the start in {spreads.told}. In the end they cover {end} %, RD in one program {one} %, of at most "
            f"{MOST:.1%}.",
        ),
        Verdict(
            "Sixteen nodes are steady at 10 s", "5.3, Figures 22 and 23", by_then.outcome,
            f"Within a point of what they cover in the end by {paper.GAZEBO_REST_S:g} s in {by_then.told}: from "
            f"{steady} s on; that is not the most that they can. Start, step and delays are not told.",
        ),
    )  # fmt: skip
