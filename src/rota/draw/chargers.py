"""The chargers on a map: a mark with a bolt, and the name beside it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.patheffects import withStroke

from rota.draw.mission_picture import FONT_PT, plain, points_per_metre
from rota.draw.palette import CHARGER, CHARGER_INK
from rota.model.arrays import Floats
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.routes.flights import has_flights

SIDE_PT, BOLT_PT, BESIDE_PT = 9.5, 7.0, 7.5
SPOT_PT = 18.0  # between robots on one charger, whose marks and bars are to stay apart
NEAR_PT = 40.0  # within which marks are in a name's way
NOWHERE: Floats = np.zeros((0, 2))
# a bolt from its upper end on, within -1 .. 1
BOLT = Path(np.array([(0.25, 1), (-0.65, -0.15), (-0.05, -0.15), (-0.25, -1), (0.65, 0.2), (0.05, 0.2), (0.25, 1)]))


def draw_chargers(mission: Mission, ax: Axes, *, named: bool = True, marks_m: Floats = NOWHERE) -> None:
    """A mark at each charger on ``ax``, whose limits are set, and its name on the side where there is more room.

    marks_m: (n, 2), where other marks are; a name keeps away from those nearby.
    """
    left, right = ax.get_xlim()
    near_m = NEAR_PT / points_per_metre(ax)
    for charger in mission.chargers:
        x, y = charger.at
        for marker, size_pt, face in (("s", SIDE_PT, CHARGER), (BOLT, BOLT_PT, CHARGER_INK)):
            ax.plot(
                [x], [y], linestyle="", marker=marker, markersize=size_pt, markerfacecolor=face,
                markeredgecolor=CHARGER_INK, markeredgewidth=0.9 if face == CHARGER else 0.0, zorder=6.5,
            )  # fmt: skip
        if not named:
            continue
        beside_m = marks_m[:, 0][np.hypot(*(marks_m - (x, y)).T) < near_m] - x
        # those right above or below are in no name's way
        crowded = np.sign(beside_m[np.abs(beside_m) > near_m / 4].sum())
        on_left = crowded > 0 or (crowded == 0 and x > left + 0.75 * (right - left))
        label = ax.annotate(
            plain(charger.name, 28),
            (x, y),
            xytext=(-BESIDE_PT if on_left else BESIDE_PT, 0.0),
            textcoords="offset points",
            fontsize=FONT_PT,
            ha="right" if on_left else "left",
            va="center",
            color=CHARGER_INK,
            zorder=6.4,
        )
        label.set_path_effects([withStroke(linewidth=2.4, foreground="white")])


def spots_of(plan: Plan, ax: Axes) -> list[Floats]:
    """Where each robot (2,) is shown when it charges: on rings round its charger, within the map."""
    scale = points_per_metre(ax)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    edge_m = SPOT_PT / 2 / scale
    low, high = np.array([left, bottom]) + edge_m, np.array([right, top]) - edge_m
    chargers = {charger.name: np.array(charger.at) for charger in plan.mission.chargers}
    rings = [
        ring * SPOT_PT * np.array([np.cos(turn), np.sin(turn)])
        for ring in range(1, 40)
        for turn in np.pi / 2 + np.arange(6 * ring) * 2 * np.pi / (6 * ring)
    ]
    taken: list[Floats] = []
    found = []
    for trajectory in plan:
        if not has_flights(trajectory):
            found.append(trajectory.positions_m[0, :2])
            continue
        centre_m = chargers[trajectory.charges[0].charger]
        tried = (centre_m + offset / scale for offset in rings)
        inside = (spot for spot in tried if (spot >= low).all() and (spot <= high).all())
        free = (spot for spot in inside if all(np.hypot(*(spot - other)) > 0.95 * SPOT_PT / scale for other in taken))
        taken.append(next(free, centre_m))
        found.append(taken[-1])
    return found


def charger_entry() -> Line2D:
    """Its line in a legend."""
    return Line2D([], [], linestyle="", marker="s", markersize=6.5, markerfacecolor=CHARGER, label="charger",
                  markeredgecolor=CHARGER_INK, markeredgewidth=0.9)  # fmt: skip
