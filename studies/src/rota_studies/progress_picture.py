"""How a search went, as a picture: unseen ground above, robots below, both against seconds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator

from rota.draw.mission_picture import plain
from rota.draw.palette import ROUTE_COLOURS
from rota.draw.picture_file import new_figure, write_picture
from rota.planning.progress import SearchState
from rota_studies.progress_curve import ProgressPoint

SIZE = (8.0, 5.0)  # inches
LEAST_PERCENT = 0.01  # linear below, logarithmic above
PERCENTS = (0.0, 0.01, 0.1, 1.0, 10.0, 100.0)
SEARCHED, LATE, UNMET, MET = "searching", "searching, some late", "check: not met", "check: met"
KINDS = {SEARCHED: ("o", 2.4, True), LATE: ("o", 2.4, False), UNMET: ("s", 3.8, False), MET: ("D", 4.5, True)}
INK, GREY, FAINT = "#222222", "#777777", "#D9D9D9"


def progress_figure(points: Sequence[ProgressPoint], *, title: str, bound: int | None, search_s: float) -> Figure:
    """The picture as a matplotlib figure; without points only the axes and the bound.

    bound: robots below which no plan exists, or None. search_s: seconds until the search ended.
    """
    fig = new_figure(*SIZE)
    above, below = fig.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (2.2, 1), "hspace": 0.09})
    fig.subplots_adjust(left=0.085, right=0.78, top=0.9, bottom=0.1)
    fig.text(0.085, 0.965, plain(title), fontsize=11, fontweight="bold", va="top")
    _draw_unseen(above, points, search_s)
    _draw_robots(below, points, bound, search_s)
    for ax in (above, below):
        ax.grid(color=FAINT, linewidth=0.5)
        ax.set_axisbelow(True)
        ax.spines[["top", "right"]].set_visible(False)
    below.set_xlabel("seconds")
    below.set_xlim(0, max(search_s, 1e-3) * 1.01)
    return fig


def _kind(state: SearchState) -> str:
    if state.stage == "checked":
        return MET if state.met else UNMET
    return LATE if state.late_share > 0 else SEARCHED


def _draw_unseen(ax: Axes, points: Sequence[ProgressPoint], search_s: float) -> None:
    entries: list[Artist] = []
    for k, robots in enumerate(dict.fromkeys(point.state.robots for point in points)):
        colour = ROUTE_COLOURS[k % len(ROUTE_COLOURS)]
        label = "1 robot" if robots == 1 else f"{robots} robots"
        entries += [Line2D([], [], linestyle="", marker="o", markersize=4, color=colour, label=label)]
        for kind, (marker, size, filled) in KINDS.items():
            here = [p for p in points if p.state.robots == robots and _kind(p.state) == kind]
            ax.scatter(
                [point.time_s for point in here], [100 * point.state.unseen_share for point in here],
                s=size**2, marker=marker, linewidths=0.9, edgecolors=colour, facecolors=colour if filled else "white",
                clip_on=False, zorder=3 if kind == MET else 2.5,
            )  # fmt: skip
    for kind in dict.fromkeys(_kind(point.state) for point in points):
        marker, size, filled = KINDS[kind]
        face = GREY if filled else "white"
        entries += [
            Line2D([], [], linestyle="", marker=marker, markersize=size, mec=GREY, mfc=face, mew=0.9, label=kind)
        ]
    if points:
        entries += ax.step(
            [*(point.time_s for point in points), search_s],
            [100 * point.best.unseen_share for point in (*points, points[-1])],
            where="post", color=INK, linewidth=1.4, label="best so far", clip_on=False,
        )  # fmt: skip
        _legend_beside(ax, entries)
    ax.set_yscale("symlog", linthresh=LEAST_PERCENT, linscale=0.6)
    ax.set_ylim(0, 100)
    ax.set_yticks(PERCENTS, labels=[f"{percent:g} %" for percent in PERCENTS], minor=False)
    ax.set_yticks([], minor=True)
    ax.set_ylabel("asked ground never seen")


def _draw_robots(ax: Axes, points: Sequence[ProgressPoint], bound: int | None, search_s: float) -> None:
    entries: list[Artist] = []
    counts = [point.state.robots for point in points] + ([] if bound is None else [bound])
    if points:
        ends_s = [*(point.time_s for point in points), search_s]
        tried = [point.state.robots for point in points]
        entries += ax.plot(ends_s[:-1], tried, ".", color=GREY, markersize=3, label="tried")
        for met, style in ((False, (0.0, (1.5, 1.2))), (True, "solid")):
            robots = [point.best.robots if point.best.met is met else None for point in points]
            label = "best so far, met" if met else "best so far, not met"
            if any(count is not None for count in robots):
                entries += ax.step(
                    ends_s, [float("nan") if count is None else count for count in (*robots, robots[-1])],
                    where="post", color=INK, linewidth=1.6, linestyle=style, label=label,
                )  # fmt: skip
    if bound is not None:
        line = ax.axhline(bound, color=ROUTE_COLOURS[6], linewidth=1.2, linestyle=(0.0, (5.0, 2.0)))
        line.set_label("proved bound")
        entries += [line]
    if counts:
        ax.set_ylim(min(counts) - 0.6, max(counts) + 0.6)
        _legend_beside(ax, entries)
    ax.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=5))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0f}"))
    ax.set_ylabel("robots")


def _legend_beside(ax: Axes, entries: Sequence[Artist]) -> None:
    ax.legend(
        handles=list(entries), loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=7.5,
        borderaxespad=0,
    )  # fmt: skip


def draw_progress(
    points: Sequence[ProgressPoint], path: str | Path, *, title: str, bound: int | None, search_s: float
) -> None:
    """Draw how a search went to ``path`` as PNG, SVG or PDF, by its suffix; see ``progress_figure``.

    The file appears whole or not at all, and the same points give the same bytes. Raises RotaError for another suffix
    or a folder that cannot be written to.
    """
    write_picture(path, lambda: progress_figure(points, title=title, bound=bound, search_s=search_s))
