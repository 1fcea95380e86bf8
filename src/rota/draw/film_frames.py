"""The frames of a film: robots, what they see now, their trails, and how long ago each place was last seen."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import Normalize, to_rgb, to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from rota.cells.cell_map import cell_map_of, neighbours
from rota.draw.charging_marks import FILM_COLOURS, ChargingMarks
from rota.draw.deployment_maps import path_of
from rota.draw.gif_file import Frame
from rota.draw.mission_picture import draw_mission, plain
from rota.draw.palette import NOT_SEEN_YET, OVER_PERIOD, gap_colours, ink_on
from rota.draw.route_lines import robot_colours
from rota.draw.routes import routes_of
from rota.draw.sightings import Sightings
from rota.draw.zone_labels import draw_zone_labels
from rota.model.arrays import Floats
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.routes.flights import takes_turns
from rota.routes.moments import corner_times_s

DPI = 100
# a GIF keeps each change of each cell: with few levels there are fewer
LEVELS, CELLS = 6, 16_000
TRAIL_FILM_S = 1.0
NUMBERED_ROBOTS = 40

LEGEND: dict[str, Any] = {"fontsize": 7.5, "frameon": False, "borderpad": 0, "borderaxespad": 0}

# inches
LEFT, RIGHT, TOP, BOTTOM = 0.62, 0.15, 0.62, 0.95


def _figure_size(mission: Mission) -> tuple[float, float]:
    """Width and height in inches, an even number of pixels each, as video codecs want."""
    left, bottom, right, top = mission.area.bounds
    pad_m = 0.05 * np.sqrt((right - left) * (top - bottom))
    slope = (top - bottom + pad_m) / (right - left + pad_m)
    width = min(5.0, 4.4 / slope) if slope > 0.4 else 7.5
    even = [2 * round(DPI * inches / 2) / DPI for inches in (max(width, 3.9), min(width * slope, 4.4))]
    return even[0] + 2 * round((LEFT + RIGHT) * DPI / 2) / DPI, even[1] + 2 * round((TOP + BOTTOM) * DPI / 2) / DPI


class FilmFrames:
    """Draws a plan at one time after another: what stands still is drawn once, the rest each time over a copy of it.

    size_px: width and height in pixels, both even.
    """

    def __init__(self, plan: Plan, speedup: float) -> None:
        self._plan = plan
        self._speedup = speedup
        self._sightings = Sightings(plan, cell_map_of(plan.mission, CELLS))
        self._shown = neighbours(self._sightings.cell_map)
        self._colours = robot_colours(plan)
        self._fig = Figure(figsize=_figure_size(plan.mission), dpi=DPI, facecolor="white")
        self._canvas = FigureCanvasAgg(self._fig)
        self._draw_ground()
        self._draw_robots()
        self._charging = ChargingMarks(plan, self._ax, self._marks, self._numbers) if takes_turns(plan) else None
        self._draw_margins()
        over = [*self._ax.patches[1:], *self._ax.texts]
        drawn = [self._image, *over, self._trails, self._views, self._marks]
        drawn += [] if self._charging is None else self._charging.artists
        self._moving = sorted(drawn, key=Artist.get_zorder)
        for artist in (*self._moving, self._clock):
            artist.set_animated(True)
        self._canvas.draw()  # type: ignore[no-untyped-call]
        self._background = self._canvas.copy_from_bbox(self._fig.bbox)  # type: ignore[no-untyped-call]
        self.size_px = self._canvas.get_width_height()

    def _draw_ground(self) -> None:
        """Draw the mission and the image of how long each place is unseen."""
        wide, high = self._fig.get_size_inches()
        place = (LEFT / wide, BOTTOM / high, 1 - (LEFT + RIGHT) / wide, 1 - (TOP + BOTTOM) / high)
        self._ax = self._fig.add_axes(place, anchor="W")
        area = draw_mission(self._plan.mission, self._ax, fill=False)
        draw_zone_labels(self._plan.mission, self._ax, routes_of(self._plan))
        self._image = self._ax.imshow(
            np.zeros(self._sightings.last_seen_s.shape),
            extent=self._sightings.cell_map.extent_m,
            origin="lower",
            interpolation="nearest",
            cmap=gap_colours(LEVELS).with_extremes(under=NOT_SEEN_YET, over=OVER_PERIOD, bad=(0, 0, 0, 0)),
            norm=Normalize(0.0, 1.0),
            zorder=1.2,
            clip_path=area,
        )

    def _draw_robots(self) -> None:
        """Draw footprints, trails, marks and numbers, which later frames move."""
        faces = [to_rgba("white", 0.3)] * len(self._colours)
        self._views = PathCollection([], facecolors=faces, edgecolors=self._colours, linewidths=1.0, zorder=4)
        # what a robot has just seen is dark, so the trail on it is pale
        inks = [tuple(0.4 * np.array(to_rgb(colour)) + 0.6) for colour in self._colours]
        self._trails = LineCollection([], colors=inks, linewidths=2.0, capstyle="butt", zorder=4.5)
        self._ax.add_collection(self._views, autolim=False)
        self._ax.add_collection(self._trails, autolim=False)
        nowhere = np.zeros(len(self._colours))
        self._marks = self._ax.scatter(nowhere, nowhere, s=95, c=self._colours, edgecolors="white", zorder=7)
        style: dict[str, Any] = {"fontsize": 7, "weight": "bold", "ha": "center", "va": "center_baseline", "zorder": 8}
        self._numbers = [
            self._ax.text(0, 0, str(k + 1), color=ink_on(colour), **style)
            for k, colour in enumerate(self._colours[:NUMBERED_ROBOTS])
        ]

    def _draw_margins(self) -> None:
        wide, high = self._fig.get_size_inches()
        x, name = LEFT / wide, plain(self._plan.mission.name)
        self._fig.text(x, 1 - 0.1 / high, name, fontsize=11, weight="bold", va="top")
        self._clock = self._fig.text(x, 1 - 0.34 / high, "", fontsize=9, va="top", color="#333333")
        self._draw_scale(x)

    def _draw_scale(self, x: float) -> None:
        """What the colours of the ground mean, below the map from ``x`` (a share of the width) on."""
        wide, high = self._fig.get_size_inches()
        bar_axes = self._fig.add_axes((x, 0.38 / high, 2.2 / wide, 0.12 / high))
        bar = self._fig.colorbar(self._image, cax=bar_axes, orientation="horizontal", extend="max", extendfrac=0.08)
        bar.set_ticks([0, 0.5, 1.0])
        bar_axes.tick_params(labelsize=7.5, length=2.5, pad=2)
        bar.set_label("time since last seen / period", fontsize=7.5, labelpad=1)
        yet = Patch(facecolor=NOT_SEEN_YET, label="not seen yet")
        corner = ((LEFT + 2.35) / wide, 0.52 / high)
        entries = [yet] if self._charging is None else [yet, *self._charging.legend()]
        self._fig.legend(handles=entries, loc="upper left", bbox_to_anchor=corner, **LEGEND)

    def _trail(self, trajectory: Trajectory, time_s: float) -> Floats:
        """The robot's way until now, (n, 2) metres, n > 1; not more than once round its loop."""
        length_s = TRAIL_FILM_S * self._speedup
        if trajectory.loop_duration_s > 0:
            length_s = min(length_s, trajectory.loop_duration_s)
        from_s = max(time_s - length_s, 0)
        way_s = np.concatenate([[from_s], corner_times_s(trajectory, from_s, time_s), [time_s]])
        return trajectory.at(way_s)[:, :2]

    def _move(self, time_s: float, age: Floats) -> None:
        """Move everything to a time."""
        self._show_ground(time_s, age)
        self._clock.set_text(f"t = {time_s:.1f} s · {self._speedup:.3g} × real time")
        trails, places_m = [], []
        for trajectory in self._plan:
            trails.append(self._trail(trajectory, time_s))
            places_m.append(trails[-1][-1])
        if self._charging is not None:
            self._charging.show(time_s, places_m)
            self._views.set_edgecolor(self._marks.get_facecolor())
        if trails:
            self._trails.set_segments(trails)
            self._marks.set_offsets(np.array(places_m))
            for number, place_m in zip(self._numbers, places_m, strict=False):
                number.set_position(place_m)

    def _show_ground(self, time_s: float, age: Floats) -> None:
        """What is seen now, and the time since each cell was seen in periods (rows, columns)."""
        # where it was not seen yet: below the scale, which has a colour of its own
        self._image.set_data(np.ma.masked_invalid(np.where(np.isinf(age), -1.0, age).ravel()[self._shown]))
        self._views.set_paths([path_of(shape) for shape in self._sightings.footprints(time_s)])

    def _draw_frame(self) -> Frame:
        self._canvas.restore_region(self._background)  # type: ignore[no-untyped-call]
        for artist in self._moving:
            self._ax.draw_artist(artist)
        self._fig.draw_artist(self._clock)
        return np.array(self._canvas.buffer_rgba(), dtype=np.uint8)  # type: ignore[no-untyped-call]

    def key_colours(self) -> Frame:
        """Colours that must not be mixed with others, (n, 3): the robots' own, black and white."""
        bars = () if self._charging is None else FILM_COLOURS
        named = dict.fromkeys([*self._colours, "black", "white", *bars])
        return np.array([[round(255 * part) for part in to_rgb(colour)] for colour in named], dtype=np.uint8)

    def sample(self) -> Frame:
        """Frames, one below the other, with the colours that the film can have; a GIF takes its palette from them."""
        cells = self._sightings.last_seen_s
        drawn = []
        for ages in (np.linspace(-0.1, 1.1, cells.size).reshape(cells.shape), np.zeros_like(cells)):
            self._move(TRAIL_FILM_S * self._speedup, ages)
            drawn.append(self._draw_frame())
        return np.concatenate(drawn)

    def frames(self, times_s: Floats) -> Iterator[Frame]:
        """One (height, width, 4) picture per time; ``times_s`` (n,) increases from 0 on."""
        before_s = 0.0
        for time_s in map(float, times_s):
            self._move(time_s, self._ages(before_s, time_s))
            before_s = time_s
            yield self._draw_frame()

    def _ages(self, before_s: float, time_s: float) -> Floats:
        """Time since each cell was seen in periods (rows, columns), after seeing what is seen between two times."""
        self._sightings.advance(before_s, time_s)
        return self._sightings.age_in_periods(time_s)
