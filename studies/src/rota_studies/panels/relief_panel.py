"""Hills seen from the side and above, with robots over them and what these see; one panel of a study's picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from rota.draw.palette import GROUND
from rota.model.mission import Mission

Floats = NDArray[np.float64]

ROWS = 33  # lines across the hills, and along them
POINTS = 129  # of a line
DEPTH = 0.45  # how long a metre to the north is drawn, and how far to the right it leans
LEAN = 0.35
LINE, FAR, NEAR = "#8A8A8A", 0.3, 0.7  # colour of the lines, their widths in points


@dataclass(frozen=True, kw_only=True)
class ReliefPanel:
    """The ground of a mission in parallel perspective, from the south; robots at places_m (n, 3) see squares below.

    ground_m: height in metres at (x, y). reach_m: half a square's side. colour: the robots'. note: below the title.
    """

    title: str
    mission: Mission
    ground_m: Callable[[float, float], float]
    places_m: Floats
    reach_m: float
    colour: str
    note: str = ""

    @property
    def entries(self) -> list[Artist]:
        """What the legend tells of it."""
        robot = Line2D([], [], linestyle="", marker="o", markersize=4.5, color=self.colour, label="robot")
        side = f"{2 * self.reach_m:g} m"
        seen = Line2D([], [], linewidth=1.0, color=self.colour, label=f"seen, {side} x {side}")
        return [robot, seen]

    @property
    def slope(self) -> float:
        """Height over width of what is drawn."""
        x, y = self._corners()
        return float(np.ptp(y) / np.ptp(x))

    def _corners(self) -> tuple[Floats, Floats]:
        """On the paper: the corners of the ground and the highest robot, with a rim."""
        left, bottom, right, top = self.mission.area.bounds
        x, y = np.array([left, right, left, right]), np.array([bottom, bottom, top, top])
        high = float(self.places_m[:, 2].max())
        u, v = on_paper(x, y, np.array([0.0, 0.0, high, high]))
        rim = 0.03 * np.ptp(u)
        return np.array([u.min() - rim, u.max() + rim]), np.array([v.min() - rim, v.max() + rim])

    def _heights(self, x: Floats, y: Floats) -> Floats:
        return np.array([self.ground_m(float(a), float(b)) for a, b in zip(x, y, strict=True)])

    def draw(self, ax: Axes) -> None:
        """Draw it on ``ax``, what is behind first."""
        left, bottom, right, top = self.mission.area.bounds
        across = np.linspace(left, right, POINTS)
        for y in np.linspace(top, bottom, ROWS):
            heights = self._heights(across, np.full(POINTS, y))
            u, v = on_paper(across, np.full(POINTS, y), heights)
            # what rises hides what is behind
            ax.fill_between(u, v, v - (heights - heights.min()), color=GROUND, linewidth=0, zorder=2)
            width = NEAR + (FAR - NEAR) * (y - bottom) / (top - bottom)
            ax.plot(u, v, color=LINE, linewidth=width, zorder=2)
        for x, y, z in self.places_m[np.argsort(-self.places_m[:, 1])]:
            self._draw_robot(ax, float(x), float(y), float(z))
        xs, ys = self._corners()
        ax.set_xlim(*xs)
        ax.set_ylim(*ys)
        ax.set_aspect("equal")
        ax.axis("off")

    def _draw_robot(self, ax: Axes, x: float, y: float, z: float) -> None:
        """One robot, the line down to the ground, and the square that it sees there."""
        r, along = self.reach_m, np.linspace(-1, 1, 21)
        side = np.ones(21)
        ring_x = x + r * np.concatenate([along, side, -along, -side])
        ring_y = y + r * np.concatenate([-side, along, side, -along])
        low_x, low_y, high_x, high_y = self.mission.area.bounds
        ring_x, ring_y = np.clip(ring_x, low_x, high_x), np.clip(ring_y, low_y, high_y)
        u, v = on_paper(ring_x, ring_y, self._heights(ring_x, ring_y))
        ax.fill(u, v, facecolor=self.colour, alpha=0.16, linewidth=0, zorder=3)
        ax.plot(u, v, color=self.colour, linewidth=0.7, zorder=3)
        u, v = on_paper(np.array([x, x]), np.array([y, y]), np.array([self.ground_m(x, y), z]))
        ax.plot(u, v, color=self.colour, linewidth=0.5, linestyle=(0, (2, 2)), zorder=4)
        ax.plot(
            u[1:], v[1:], "o", color=self.colour, markersize=4, markeredgecolor="white", markeredgewidth=0.3, zorder=5
        )


def on_paper(x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
    """Where places (n,) each, in metres, are drawn: across and up, in metres of the paper."""
    return x + LEAN * y, DEPTH * y + z
