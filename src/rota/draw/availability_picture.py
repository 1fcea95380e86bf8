"""How much of what is asked is available: a map of each place's share of the time, and what it is hour by hour."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import overload

import numpy as np
import shapely
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.spatial import cKDTree

from rota.cells.cell_map import cell_map_of
from rota.draw.gap_map import colour_cells
from rota.draw.house_style import house_style
from rota.draw.least_left import LeastLeft, least_left_chart
from rota.draw.legends import BAR, scale_bar
from rota.draw.mission_picture import FONT_PT, draw_mission, mission_legend, plain
from rota.draw.palette import LineStyle, route_style
from rota.draw.picture_file import write_picture
from rota.draw.plan_picture import BAR_TEXT
from rota.draw.two_maps import Half, two_maps
from rota.draw.zone_labels import draw_zone_labels
from rota.model.arrays import Floats
from rota.model.mission import Mission

CELLS = 100_000
LOWEST = 0.9  # the scale of shares begins there at most
BAND = "#BBBBBB"
IN_BAND = (0.1, 0.9)  # of the runs


@dataclass(frozen=True, kw_only=True, eq=False)
class Availability:
    """Shares 0..1 of the time in which what is asked was within its period.

    header: of the picture. points_m: (n, 2) places with their shares, (n,). visits: the share of each zone to visit, by
    its name. hours: (b + 1,) borders of the parts of the time. demands: of each a label and its shares by part, (b,).
    whole: a label, and the shares (runs, b) of all that is asked. batteries: of each robot that has one.
    """

    header: str
    points_m: Floats
    shares: Floats
    visits: dict[str, float]
    hours: Floats
    demands: tuple[tuple[str, Floats], ...]
    whole: tuple[str, Floats]
    batteries: tuple[LeastLeft, ...] = ()


@overload
def draw_availability(mission: Mission, made: Availability, path: str | FilePath) -> None: ...
@overload
def draw_availability(mission: Mission, made: Availability, path: None = None) -> Figure: ...
def draw_availability(mission: Mission, made: Availability, path: str | FilePath | None = None) -> Figure | None:
    """Draw the map and the hours to ``path`` as PNG, SVG or PDF by its suffix, or else as a figure to show.

    A file appears whole or not at all. Raises RotaError for another suffix or a folder that cannot be written to.
    """
    if path is None:
        with house_style():
            return availability_figure(mission, made)
    write_picture(path, lambda: availability_figure(mission, made))
    return None


def availability_figure(mission: Mission, made: Availability) -> Figure:
    """The picture as a matplotlib figure: a map on the left (or top), the hours beside it, batteries below."""
    images: list[AxesImage] = []
    shares = Half(
        title="Share of the time within the period",
        draw=lambda ax: images.append(_draw_shares(mission, made, ax)),
        legend=mission_legend(mission),
        scale_in=BAR + BAR_TEXT,
        scale=lambda fig, x, y, width: _colour_bar(fig, images[0], (x, y - BAR, width)),
    )
    hours = Half(title="Available, hour by hour", draw=lambda ax: _draw_hours(made, ax), legend=_hours_legend(made))
    return two_maps(mission, made.header, shares, hours, least_left_chart(made.batteries) if made.batteries else None)


def _draw_shares(mission: Mission, made: Availability, ax: Axes) -> AxesImage:
    """The map: each cell as the place nearest to it, zones to visit as one."""
    cell_map = cell_map_of(mission, CELLS)
    shown: Floats = np.full(cell_map.period_s.shape, np.nan)
    if len(made.points_m) and cell_map.asked.any():
        shown[cell_map.asked] = made.shares[cKDTree(made.points_m).query(cell_map.points_m(cell_map.asked))[1]]
    centres_m, within = cell_map.points_m(cell_map.visit), shown[cell_map.visit]
    for zone in mission.zones:
        if zone.name in made.visits:
            inside = shapely.contains_xy(zone.shape, *centres_m.T)
            within[inside] = np.fmin(within[inside], made.visits[zone.name])
    shown[cell_map.visit] = within
    area = draw_mission(mission, ax, fill=False)
    least = min([*made.shares.tolist(), *made.visits.values()])
    lowest = min(LOWEST, math.floor(10 * least) / 10)
    image = colour_cells(cell_map, np.ma.masked_invalid(shown), ax, area, lowest)
    draw_zone_labels(mission, ax, brief=True)
    return image


def _colour_bar(fig: Figure, image: AxesImage, place_in: tuple[float, float, float]) -> None:
    bar = scale_bar(fig, image, place_in, "of the time, mean over the runs")
    bar.ax.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.4g} %")


def _draw_hours(made: Availability, ax: Axes) -> None:
    """All that is asked and each demand over the hours, means over the runs, and between which most runs lie."""
    hours, (_, whole) = np.repeat(made.hours, 2)[1:-1], made.whole
    low, high = np.quantile(whole, IN_BAND, axis=0)
    ax.fill_between(hours, 100 * np.repeat(low, 2), 100 * np.repeat(high, 2), color=BAND, linewidth=0, zorder=1)
    for (_, shares), (colour, style) in zip(made.demands, _styles(made), strict=True):
        ax.plot(hours, 100 * np.repeat(shares, 2), color=colour, linestyle=style, linewidth=1.2, zorder=2)
    ax.plot(hours, 100 * np.repeat(whole.mean(axis=0), 2), color="black", linewidth=2.2, zorder=3)
    ax.set_xlim(0, made.hours[-1])
    least = min(LOWEST, float(low.min()), *(float(shares.min()) for _, shares in made.demands))
    ax.set_ylim(100 * least - 1, 101)
    ax.set_xlabel("hours", fontsize=FONT_PT, labelpad=1.5)
    ax.set_ylabel("available (%)", fontsize=FONT_PT, labelpad=1.5)
    ax.tick_params(labelsize=FONT_PT, length=2.5, pad=2)
    ax.grid(color="#E4E4E4", linewidth=0.5)
    ax.set_axisbelow(True)


def _styles(made: Availability) -> list[tuple[str, LineStyle]]:
    """Colour and line style of each demand; the black one is that of all together."""
    return [route_style(k + (k >= 4)) for k in range(len(made.demands))]


def _hours_legend(made: Availability) -> list[Artist]:
    """Legend entries for the hours: all together, each demand, and the band of runs where there are several."""
    entries: list[Artist] = [Line2D([], [], color="black", linewidth=2.2, label=made.whole[0])]
    for (label, _), (colour, style) in zip(made.demands, _styles(made), strict=True):
        entries.append(Line2D([], [], color=colour, linestyle=style, linewidth=1.2, label=plain(label)))
    if len(made.whole[1]) > 1:
        entries.append(Patch(facecolor=BAND, label="all, in 8 of 10 runs"))
    return entries
