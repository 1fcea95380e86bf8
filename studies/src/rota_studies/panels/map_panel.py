"""A map with whatever lies on it: sensors and what they see, lines, a plan's routes; one panel of a study's picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, EllipseCollection, LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from rota.draw.mission_picture import demand_in_words, draw_mission, mission_legend, plain, zone_tints
from rota.draw.palette import ZONE_EDGE, LineStyle
from rota.draw.route_lines import draw_route_lines, route_legend
from rota.draw.routes import routes_of
from rota.draw.zone_labels import draw_zone_labels
from rota.model.mission import Mission
from rota.model.plan import Plan

Floats = NDArray[np.float64]


class Dots(NamedTuple):
    """Marks of one kind at places_m (n, 2) metres; with ``reach_m`` above 0 each in what it sees.

    That is a disc, or a ``square`` with twice the reach as its side. shade: how strongly it is filled, 0..1.
    """

    label: str
    places_m: Floats
    colour: str
    marker: str = "o"
    size_pt: float = 3.0
    reach_m: float = 0.0
    filled: bool = True
    shade: float = 0.07
    square: bool = False


class Strokes(NamedTuple):
    """Lines of one kind, each (k, 2) metres, k of any size."""

    label: str
    paths_m: tuple[Floats, ...]
    colour: str
    style: LineStyle = "solid"
    width_pt: float = 1.0


@dataclass(frozen=True, kw_only=True)
class MapPanel:
    """A mission's map under a title; on it strokes, then the routes of a plan, then dots. ``note``: below the title.

    named_zones: whether each zone carries its name and period, or its name alone (``brief_zones``).
    listed_zones: whether the legend tells them.
    """

    title: str
    mission: Mission
    note: str = ""
    strokes: tuple[Strokes, ...] = ()
    dots: tuple[Dots, ...] = ()
    plan: Plan | None = None
    named_zones: bool = False
    brief_zones: bool = False
    listed_zones: bool = False

    @property
    def entries(self) -> list[Artist]:
        """What the legend tells of it."""
        found: list[Artist] = [_stroke_entry(strokes) for strokes in self.strokes]
        found += [] if self.plan is None else route_legend(self.plan, brief=True)
        found += [_dots_entry(dots) for dots in self.dots]
        found += self._seen_entries()
        found += zone_legend(self.mission) if self.listed_zones else []
        return [*found, *mission_legend(self.mission)]

    def _seen_entries(self) -> list[Artist]:
        """A swatch for each reach, in the colour of those that have it, or grey where they have several."""
        found: list[Artist] = []
        for reach_m, square in sorted({(dots.reach_m, dots.square) for dots in self.dots if dots.reach_m > 0}):
            alike = [dots for dots in self.dots if (dots.reach_m, dots.square) == (reach_m, square)]
            label = f"seen, {2 * reach_m:g} m x {2 * reach_m:g} m" if square else f"seen, {reach_m:g} m"
            if len({dots.colour for dots in alike}) == 1:
                rgb = _rgb(alike[0].colour)
                face, edge = (*rgb, max(alike[0].shade, 0.15)), (*rgb, 0.55)
                found.append(Patch(facecolor=face, edgecolor=edge, label=label))
            else:
                found.append(Patch(facecolor="#DDDDDD", edgecolor="#777777", label=label))
        return found

    def draw(self, ax: Axes) -> None:
        """Draw it on ``ax``."""
        ground = draw_mission(self.mission, ax)
        for strokes in self.strokes:
            lines = LineCollection([*strokes.paths_m], colors=strokes.colour, linestyles=[strokes.style], zorder=3.6)
            lines.set_linewidth(strokes.width_pt)
            ax.add_collection(lines, autolim=False)
        if self.plan is not None:
            draw_route_lines(self.plan, ax)
        for dots in self.dots:
            if dots.reach_m > 0 and len(dots.places_m):
                seen = _seen(dots, ax)
                ax.add_collection(seen, autolim=False)
                seen.set_clip_path(ground)
            face = dots.colour if dots.filled else "white"
            ax.plot(
                *dots.places_m.T, linestyle="", marker=dots.marker, markersize=dots.size_pt, color=dots.colour,
                markerfacecolor=face, markeredgewidth=0.8 if not dots.filled else 0.3,
                markeredgecolor="white" if dots.filled else dots.colour, zorder=5,
            )  # fmt: skip
        if self.named_zones:
            draw_zone_labels(
                self.mission, ax, [] if self.plan is None else routes_of(self.plan), brief=self.brief_zones
            )


def _seen(dots: Dots, ax: Axes) -> Collection:
    """What the robots see, each a disc or a square round its place."""
    rgb = _rgb(dots.colour)
    look: dict[str, Any] = {
        "facecolors": [(*rgb, dots.shade)], "edgecolors": [(*rgb, 0.55)], "linewidths": 0.35, "zorder": 2.2,
    }  # fmt: skip
    if dots.square:
        corners = dots.reach_m * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        return PolyCollection(list(dots.places_m[:, None] + corners), **look)
    side_m = np.full(len(dots.places_m), 2 * dots.reach_m)
    at = {"offsets": dots.places_m, "offset_transform": ax.transData}
    return EllipseCollection(side_m, side_m, np.zeros(len(side_m)), units="xy", **at, **look)


def _rgb(colour: str) -> tuple[float, float, float]:
    red, green, blue = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return red, green, blue


def _stroke_entry(strokes: Strokes) -> Line2D:
    line = Line2D([], [], color=strokes.colour, linestyle=strokes.style, linewidth=max(strokes.width_pt, 0.8))
    line.set_label(strokes.label)
    line.set_path_effects([withStroke(linewidth=2.0, foreground="white", alpha=0.0)])
    return line


def _dots_entry(dots: Dots) -> Line2D:
    face = dots.colour if dots.filled else "white"
    return Line2D(
        [], [], linestyle="", marker=dots.marker, markersize=dots.size_pt + 1.5, color=dots.colour,
        markerfacecolor=face, label=dots.label,
    )  # fmt: skip


def zone_legend(mission: Mission) -> list[Patch]:
    """Legend entries for the zones, by their tints, with what they ask; for maps on which labels would hide much."""
    return [
        Patch(
            facecolor=tint,
            edgecolor=ZONE_EDGE,
            label=f"{plain(zone.name, 28)}, {demand_in_words(zone.period_s, zone.demand)}",
        )
        for zone, tint in zip(mission.zones, zone_tints(mission), strict=True)
    ]
