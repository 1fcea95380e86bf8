"""How much was left in batteries at the least, over many runs: a row for each robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rota.draw.mission_picture import FONT_PT, plain
from rota.draw.palette import BATTERY, RESERVE
from rota.draw.two_maps import Chart
from rota.model.arrays import Floats

MOST_ROWS = 40  # robots; of more those with the least to spare are shown
ROW_IN, HALF_ROW, NAME = 0.2, 0.32, 18
CHARACTER_IN = 0.062
RUNS = "#9BB7D4"


class LeastLeft(NamedTuple):
    """One robot's battery: levels_s (runs,) the least that was left in each run, its reserve and all that it holds."""

    robot: str
    levels_s: Floats
    reserve_s: float
    endurance_s: float


def least_left_chart(batteries: Sequence[LeastLeft]) -> Chart:
    """The chart, as a part of a picture; robots in their order, those with the least to spare where there are many."""
    by_spare = sorted(batteries, key=lambda each: float(each.levels_s.min()) - each.reserve_s)
    kept = {each.robot for each in by_spare[:MOST_ROWS]}
    shown = [each for each in batteries if each.robot in kept]
    more = "" if len(shown) == len(batteries) else f", of the {len(shown)} robots with the least to spare"
    longest = max(len(plain(each.robot, NAME)) for each in shown)
    return Chart(
        title=f"Least left in batteries{more}",
        height_in=max(0.5, ROW_IN * len(shown)),
        labels_in=max(0.55, 0.1 + CHARACTER_IN * longest),
        draw=lambda ax: _draw_rows(shown, ax),
        legend=_legend(max(len(each.levels_s) for each in shown) > 1),
    )


def _draw_rows(shown: Sequence[LeastLeft], ax: Axes) -> None:
    """A bar from the least to the most of all runs, a line at the median, and a red one at the reserve."""
    for row, each in enumerate(shown):
        low, middle, high = (float(value) for value in np.quantile(each.levels_s, [0.0, 0.5, 1.0]))
        ax.broken_barh([(low, high - low)], (row - HALF_ROW, 2 * HALF_ROW), facecolors=RUNS, zorder=2)
        ax.plot([middle, middle], [row - HALF_ROW, row + HALF_ROW], color=BATTERY, linewidth=1.6, zorder=3)
        ax.plot([each.reserve_s] * 2, [row - 0.5, row + 0.5], color=RESERVE, linewidth=1.0, zorder=2.5)
    least = min(0.0, min(float(each.levels_s.min()) for each in shown))
    ax.set_xlim(least, 1.05 * max(max(float(each.levels_s.max()), each.reserve_s) for each in shown))
    ax.set_ylim(len(shown) - 0.5, -0.5)
    ax.set_yticks(range(len(shown)), [plain(each.robot, NAME) for each in shown])
    ax.set_xlabel("seconds of driving", fontsize=FONT_PT, labelpad=1.5)
    ax.tick_params(labelsize=FONT_PT, length=2.5, pad=2)
    ax.grid(axis="x", color="#E4E4E4", linewidth=0.5)
    ax.set_axisbelow(True)


def _legend(several: bool) -> list[Artist]:
    entries: list[Artist] = [Patch(facecolor=RUNS, label="from the worst run to the best")] if several else []
    middle = "median of the runs" if several else "left at the least"
    entries.append(Line2D([], [], color=BATTERY, linewidth=1.6, label=middle))
    return [*entries, Line2D([], [], color=RESERVE, linewidth=1.0, label="reserve")]
