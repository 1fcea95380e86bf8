"""Robots that charge in a film: grey marks round their charger, and a bar of its battery below each robot."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.lines import Line2D
from matplotlib.text import Text

from rota.check.batteries import batteries_of
from rota.draw.chargers import draw_chargers, spots_of
from rota.draw.mission_picture import points_per_metre
from rota.draw.palette import CHARGER, DOCKED, FILLED_LOW, FILLED_WELL, RESERVE, ink_on
from rota.draw.route_lines import robot_colours
from rota.draw.routes import flight_colour, serves_loops, service_in
from rota.model.arrays import Floats
from rota.model.plan import Plan
from rota.routes.flights import flights_of, has_flights, on_charger

FILM_COLOURS = (DOCKED, CHARGER, FILLED_WELL, FILLED_LOW, RESERVE)
BAR_PT, BAR_HIGH_PT, BELOW_PT = 10.5, 2.2, 7.4
LOW_SHARE = 0.25  # of what may be used: less is shown as low


class ChargingMarks:
    """Moves what tells of charging: who is on a charger stands round it, each robot always in the same spot.

    artists: what is drawn anew in each frame.
    """

    def __init__(self, plan: Plan, ax: Axes, marks: PathCollection, numbers: list[Text]) -> None:
        self._plan, self._marks, self._numbers = plan, marks, numbers
        self._batteries = batteries_of(plan)
        before = len(ax.lines)
        draw_chargers(plan.mission, ax, named=False)
        self._scale = points_per_metre(ax)
        self._spots_m = spots_of(plan, ax)
        self._colours = _colours_by_flight(plan) if serves_loops(plan) else [[] for _ in plan]
        self._own = robot_colours(plan)
        style: dict[str, Any] = {"capstyle": "butt", "zorder": 7.5}
        self._frames = LineCollection([], colors="black", linewidths=BAR_HIGH_PT + 1.2, **style)
        self._empty = LineCollection([], colors="white", linewidths=BAR_HIGH_PT, **style)
        self._bars = LineCollection([], linewidths=BAR_HIGH_PT, **style)
        for collection in (self._frames, self._empty, self._bars):
            ax.add_collection(collection, autolim=False)
        self.artists: list[Artist] = [*ax.lines[before:], self._frames, self._empty, self._bars]

    def show(self, time_s: float, places_m: list[Floats]) -> None:
        """Move marks and bars to a time; ``places_m``: one (2,) for each robot, changed for those on chargers."""
        colours = []
        for k, trajectory in enumerate(self._plan):
            docked = bool(on_charger(trajectory, np.array([time_s]))[0])
            colours.append(DOCKED if docked else self._colour(k, time_s))
            if docked:
                places_m[k] = self._spots_m[k]
        self._marks.set_facecolor(colours)
        for number, colour in zip(self._numbers, colours, strict=False):
            number.set_color(ink_on(colour))
        self._show_bars(time_s, places_m)

    def _show_bars(self, time_s: float, places_m: list[Floats]) -> None:
        """Move the bars to below the marks, as long and in the colours as batteries are full at a time."""
        half_m, below_m, edge_m = BAR_PT / 2 / self._scale, BELOW_PT / self._scale, 0.6 / self._scale
        frames, empty, bars, inks = [], [], [], []
        for place_m, battery in zip(places_m, self._batteries, strict=True):
            if battery is None:
                continue
            (x, y), share = place_m - (0.0, below_m), battery.share_at(time_s)
            reserve = battery.reserve_s / battery.full_s
            frames.append([(x - half_m - edge_m, y), (x + half_m + edge_m, y)])
            empty.append([(x - half_m, y), (x + half_m, y)])
            bars.append([(x - half_m, y), (x - half_m + 2 * half_m * min(max(share, 0.0), 1.0), y)])
            usable = (share - reserve) / (1 - reserve)
            inks.append(RESERVE if usable < 0.05 else FILLED_LOW if usable < LOW_SHARE else FILLED_WELL)
        self._frames.set_segments(frames)
        self._empty.set_segments(empty)
        self._bars.set_segments(bars)
        self._bars.set_color(inks)

    def _colour(self, robot: int, time_s: float) -> str:
        """That of the loop that a robot serves at a time when it is not on a charger."""
        for starts_s, lasts_s, every_s, colour in self._colours[robot]:
            since_s = time_s - starts_s
            if every_s and since_s >= 0:
                since_s %= every_s
            if 0 <= since_s <= lasts_s:
                return colour
        return self._colours[robot][0][3] if self._colours[robot] else self._own[robot]

    def legend(self) -> list[Line2D]:
        """What its marks mean."""
        style: dict[str, Any] = {"linestyle": "", "markeredgecolor": "white"}
        docked = Line2D(
            [], [], marker="o", markersize=8, markerfacecolor=DOCKED, label="on a charger, sees nothing", **style
        )
        bar = Line2D([], [], color=FILLED_WELL, linewidth=BAR_HIGH_PT + 0.8, label="battery")
        return [docked, bar]


def _colours_by_flight(plan: Plan) -> list[list[tuple[float, float, float, str]]]:
    """Of each robot's flights when they start, how long they take, after how long they repeat, and their colours."""
    serves = iter(service_in(plan).serves)
    return [
        [
            (flight.starts_s, flight.lasts_s, flight.every_s, flight_colour(next(serves)))
            for flight in (flights_of(trajectory) if has_flights(trajectory) else ())
        ]
        for trajectory in plan
    ]
