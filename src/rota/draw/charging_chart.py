"""A plan's flights and charging over its super-period: a row for each robot, with its battery as a line in it."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from rota.check.batteries import Battery, batteries_of
from rota.draw.mission_picture import FONT_PT, plain
from rota.draw.palette import (
    BATTERY,
    CHARGES,
    CHARGES_EDGE,
    DOCKED,
    FLOWN_ONCE,
    LANDS,
    RESERVE,
    RESTS,
    pale,
    route_style,
)
from rota.draw.route_lines import robot_colours
from rota.draw.routes import ONCE, flight_colour, serves_loops, service_in
from rota.draw.two_maps import Chart
from rota.model.plan import Plan, Trajectory
from rota.routes.flights import flights_of, has_flights
from rota.routes.served_loops import loop_letter

UNITS = ((3 * 3600.0, 3600.0, "h"), (300.0, 60.0, "min"), (0.0, 1.0, "s"))  # from which span on, its seconds, its name
STEPS = (1, 2, 5, 10, 15, 20, 30, 60, 100, 150, 200, 300, 500, 1000)
MOST_TICKS = 13
FILLED = 0.82  # of a row's height
LETTER_IN, NAME_ROW_IN = 0.16, 0.12  # what a letter takes of a bar's length, and names of a row's height
CHARACTER_IN = 0.062
FULL = 1 - 1e-9  # of a battery
SAME_ROUND = 1e-6  # share by which rounds may differ

Spans = list[tuple[float, float]]


def span_s(plan: Plan) -> float:
    """How long the chart is: until each robot has done its round once."""
    return max(float(trajectory.times_s[-1]) for trajectory in plan)


def charging_chart(plan: Plan) -> Chart:
    """The chart, as a part of the plan's picture."""
    rows = len(plan)
    row_in = float(np.clip(3.6 / rows, 0.16, 0.34)) if rows <= 40 else float(np.clip(6.4 / rows, 0.05, 0.16))
    longest = max(len(plain(trajectory.robot, 18)) for trajectory in plan)
    return Chart(
        title=_title(plan),
        height_in=rows * row_in,
        labels_in=max(0.55, 0.1 + CHARACTER_IN * longest),
        draw=lambda ax: draw_charging(plan, ax),
        legend=_legend(plan),
    )


def _title(plan: Plan) -> str:
    """What the chart shows; where rounds differ, the whole need not repeat with the longest one."""
    longest_s = span_s(plan)
    unit_s, unit = _unit(longest_s)
    told = f"{round(longest_s / unit_s, 1):g} {unit}"
    same = all(abs(each.times_s[-1] - longest_s) <= SAME_ROUND * longest_s and not each.loop_start_s for each in plan)
    return f"Flights and batteries, which repeat after {told}" if same else f"Flights and batteries for {told}"


def _unit(lasts_s: float) -> tuple[float, str]:
    return next((unit_s, unit) for least_s, unit_s, unit in UNITS if lasts_s >= least_s)


def draw_charging(plan: Plan, ax: Axes) -> None:
    """The rows on ``ax``: flights in the colour of the loop that is served, charging hatched, batteries as lines."""
    until_s = span_s(plan)
    unit_s, unit = _unit(until_s)
    ax.set_xlim(0, until_s / unit_s)
    ax.set_ylim(len(plan) - 0.5 + 0.05, -0.55)
    serves, colours = iter(service_in(plan).serves if serves_loops(plan) else ()), robot_colours(plan)
    batteries = batteries_of(plan)
    row_in = ax.get_window_extent().height / ax.figure.dpi / len(plan)
    for row, (trajectory, battery) in enumerate(zip(plan, batteries, strict=True)):
        flown: dict[int, Spans] = defaultdict(list)
        for flight in flights_of(trajectory) if has_flights(trajectory) else ():
            flown[next(serves, row)] += _within(flight.starts_s, flight.lasts_s, flight.every_s, until_s)
        for loop, spans in flown.items():
            told = [(a / unit_s, b / unit_s) for a, b in spans]
            if serves_loops(plan):
                _draw_flights(ax, row, told, flight_colour(loop))
                _draw_letters(ax, row, told if row_in >= LETTER_IN and loop != ONCE else [], loop)
            else:
                _draw_flights(ax, row, told, colours[row])
        _draw_stays(ax, row, trajectory, battery, until_s, unit_s)
        limits = plan.mission.fleet.robot(trajectory.robot).battery
        moves = _landings(trajectory, limits.landing_s, limits.climbing_s, until_s)
        told = [(begin / unit_s, lasts / unit_s) for begin, lasts in moves]
        ax.broken_barh(told, (row - FILLED / 2, FILLED), facecolors=LANDS, linewidth=0.0, zorder=1.6)
        if battery is not None:
            _draw_level(ax, row, battery, until_s, unit_s)
    _draw_axes(plan, ax, unit, row_in)


def _within(starts_s: float, lasts_s: float, every_s: float, until_s: float) -> Spans:
    """What repeats as spans (from, for how long) in seconds, as far as they lie between 0 and ``until_s``."""
    rounds = math.ceil(max(until_s - starts_s, 0.0) / every_s) if every_s else 1
    begins = [starts_s + k * every_s for k in range(rounds)]
    spans = [(max(begin, 0.0), min(begin + lasts_s, until_s)) for begin in begins]
    return [(begin, end - begin) for begin, end in spans if end > begin]


def _draw_flights(ax: Axes, row: int, spans: Spans, colour: str) -> None:
    """Bars in a colour."""
    ax.broken_barh(
        spans, (row - FILLED / 2, FILLED), facecolors=pale(colour), edgecolors=colour, linewidth=0.5, zorder=2
    )


def _draw_letters(ax: Axes, row: int, spans: Spans, loop: int) -> None:
    """A loop's letter in each bar that has room for it."""
    inch = ax.get_xlim()[1] / (ax.get_window_extent().width / ax.figure.dpi)
    for begin, lasts in spans:
        if lasts > LETTER_IN * len(loop_letter(loop)) * inch:
            text = ax.text(begin + 0.045 * inch, row + FILLED / 2 - 0.06, loop_letter(loop), fontsize=6.5, zorder=4)
            text.set(va="bottom", ha="left", weight="bold", color="black")
            text.set_path_effects([withStroke(linewidth=1.2, foreground=pale(flight_colour(loop)))])


def _draw_stays(
    ax: Axes, row: int, trajectory: Trajectory, battery: Battery | None, until_s: float, unit_s: float
) -> None:
    """Stays at chargers: hatched as long as the battery fills, plain when it is full."""
    fills, full = Spans(), Spans()
    times_s, shares = battery.line(until_s) if battery is not None else (np.zeros(0), np.zeros(0))
    for begin, lasts in _stays(trajectory, until_s):
        end = begin + lasts
        filled_s = times_s[(times_s >= begin) & (times_s < end) & (shares >= FULL)].min(initial=end)
        fills.append((begin / unit_s, (filled_s - begin) / unit_s))
        full.append((filled_s / unit_s, (end - filled_s) / unit_s))
    place = (row - FILLED / 2, FILLED)
    style: dict[str, Any] = {"edgecolors": CHARGES_EDGE, "linewidth": 0.0, "zorder": 1.5}
    ax.broken_barh([span for span in full if span[1] > 0], place, facecolors=RESTS, **style)
    ax.broken_barh([span for span in fills if span[1] > 0], place, facecolors=CHARGES, hatch="////", **style)


def _landings(trajectory: Trajectory, landing_s: float, climbing_s: float, until_s: float) -> Spans:
    """When a robot lands and climbs, until a time: at either end of its stays, but for one in which all begins."""
    whole: list[tuple[float, float]] = []
    for begin, lasts in sorted(_stays(trajectory, 2 * until_s)):  # beyond the chart, to see where the last one ends
        if whole and begin - whole[-1][1] <= SAME_ROUND * until_s:
            whole[-1] = (whole[-1][0], begin + lasts)
        else:
            whole.append((begin, begin + lasts))
    lands = [(begin, min(begin + landing_s, end)) for begin, end in whole if begin > 0]
    climbs = [(max(begin, end - climbing_s), end) for begin, end in whole if end < 2 * until_s]
    told = [(begin, min(end, until_s)) for begin, end in (*lands, *climbs)]
    return [(begin, end - begin) for begin, end in told if end > begin]


def _stays(trajectory: Trajectory, until_s: float) -> Iterator[tuple[float, float]]:
    """The robot's stays at chargers until a time."""
    round_s = trajectory.loop_duration_s
    for charge in trajectory.charges:
        every_s = round_s if charge.from_s >= trajectory.loop_start_s else 0.0
        yield from _within(charge.from_s, charge.until_s - charge.from_s, every_s, until_s)


def _draw_level(ax: Axes, row: int, battery: Battery, until_s: float, unit_s: float) -> None:
    """The battery's level between the lower and the upper end of a row, and its reserve."""
    low, high = row + FILLED / 2, row - FILLED / 2
    times_s, shares = battery.line(until_s)
    level = low + (high - low) * shares
    ax.plot(times_s / unit_s, level, color=BATTERY, linewidth=0.9, solid_joinstyle="round", zorder=3)
    if battery.reserve_s > 0:
        reserve = low + (high - low) * battery.reserve_s / battery.full_s
        ax.plot(
            [0, until_s / unit_s], [reserve, reserve], color=RESERVE, linewidth=0.7, linestyle=(0, (3, 1.5)), zorder=2.8
        )


def _draw_axes(plan: Plan, ax: Axes, unit: str, row_in: float) -> None:
    """Names on the left, time below."""
    every = max(1, math.ceil(NAME_ROW_IN / row_in))
    rows = range(0, len(plan), every)
    ax.set_yticks(list(rows), [plain(plan.trajectories[row].robot, 18) for row in rows])
    until = ax.get_xlim()[1]
    step = next((step for step in STEPS if until / step <= MOST_TICKS), until / MOST_TICKS)
    ax.set_xticks(np.arange(0, until * (1 + 1e-9), step))
    ax.ticklabel_format(axis="x", style="plain", useOffset=False)
    ax.tick_params(labelsize=FONT_PT, length=2.5, pad=2)
    ax.tick_params(axis="y", length=0)
    ax.set_xlabel(f"time ({unit})", fontsize=FONT_PT, labelpad=1.5)
    ax.grid(axis="x", color="#DDDDDD", linewidth=0.5, zorder=0.5)
    for spine in ax.spines.values():
        spine.set_linewidth(0.5)
        spine.set_color("#888888")


def _legend(plan: Plan) -> list[Artist]:
    """What bars and lines mean; loops have their letters as in the map."""
    if not serves_loops(plan):
        return [Patch(facecolor=DOCKED, label="flies, in its colour on the map"), *_battery_legend(plan)]
    service = service_in(plan)
    entries: list[Artist] = [
        Patch(
            facecolor=pale(route_style(k)[0]),
            edgecolor=route_style(k)[0],
            label=f"serves {loop_letter(k)}, ways included",
        )
        for k in range(len(service.loops))
    ]
    if ONCE in service.serves:
        entries.append(Patch(facecolor=pale(FLOWN_ONCE), edgecolor=FLOWN_ONCE, label="flown once, until loops begin"))
    return [*entries, *_battery_legend(plan)]


def _battery_legend(plan: Plan) -> list[Artist]:
    """What tells of chargers and batteries."""
    entries: list[Artist] = []
    entries.append(Patch(facecolor=CHARGES, edgecolor=CHARGES_EDGE, hatch="//////", label="charges"))
    entries.append(Patch(facecolor=RESTS, edgecolor=CHARGES_EDGE, label="at the charger, full"))
    if any(plan.mission.fleet.robot(trajectory.robot).battery.grounding_s for trajectory in plan):
        entries.append(Patch(facecolor=LANDS, label="lands, or climbs"))
    batteries = [battery for battery in batteries_of(plan) if battery is not None]
    if batteries:
        entries.append(Line2D([], [], color=BATTERY, linewidth=0.9, label="battery, from empty to full"))
    if any(battery.reserve_s > 0 for battery in batteries):
        entries.append(Line2D([], [], color=RESERVE, linewidth=0.7, linestyle=(0, (3, 1.5)), label="reserve"))
    return entries
