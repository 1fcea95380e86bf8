"""The frames of a film of robots that spread and hold, where nothing is asked of the ground: what is in range now."""

from __future__ import annotations

import numpy as np
import shapely
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.patches import Patch

from rota.draw.deployment_maps import COVERED_ALPHA, covered_colour, path_of
from rota.draw.film_frames import BOTTOM, LEGEND, NUMBERED_ROBOTS, FilmFrames
from rota.draw.gif_file import Frame
from rota.draw.palette import COVERED, COVERED_EDGE, GROUND
from rota.model.arrays import Floats
from rota.planning.plan_summary import range_from
from rota.routes.flights import on_charger

MANY_MARK, FEW_MARK = 5.0, 85.0  # square points


class DeploymentFrames(FilmFrames):
    """Draws a plan that asks nothing at one time after another: discs now in range, with the share that they cover."""

    def _draw_robots(self) -> None:
        """Draw what robots have in range under their trails and marks, which are smaller when robots are many."""
        super()._draw_robots()
        mission = self._plan.mission
        self._free = mission.area.difference(shapely.union_all([o.shape for o in mission.obstacles if o.blocks_sight]))
        self._robots = [mission.fleet.robot(trajectory.robot) for trajectory in self._plan]
        many = len(self._colours) > NUMBERED_ROBOTS
        self._views.set(
            facecolor=to_rgba(COVERED, COVERED_ALPHA),
            edgecolor=to_rgba(COVERED_EDGE, 0.8),
            linewidth=0.4 if many else 0.8,
            zorder=1.3,
        )
        self._views.set_clip_path(self._ax.patches[0])
        self._trails.set(color=self._colours, linewidth=0.6 if many else 1.4)
        self._marks.set_sizes([MANY_MARK if many else FEW_MARK])
        self._marks.set_linewidth(0.2 if many else 0.6)
        for number in self._numbers:
            number.set_fontsize(6)
            number.set_visible(not many)
        self._image.set_visible(False)

    def _draw_scale(self, x: float) -> None:
        """Draw the legend of what is in range."""
        high = self._fig.get_figheight()
        entries = [
            Patch(facecolor=covered_colour(1), edgecolor=COVERED_EDGE, label="in range now"),
            Patch(facecolor=covered_colour(2), edgecolor=COVERED_EDGE, label="of two or more"),
            Patch(facecolor=GROUND, edgecolor="#888888", label="in nobody's range"),
            *([] if self._charging is None else self._charging.legend()),
        ]
        corner = (x, (BOTTOM - 0.42) / high)
        self._fig.legend(
            handles=entries, loc="upper left", bbox_to_anchor=corner, ncols=3, columnspacing=1.2, handlelength=1.6,
            **LEGEND,
        )  # fmt: skip

    def _show_ground(self, time_s: float, age: Floats) -> None:
        """Move what robots have in range, and measure its share of the ground."""
        times_s = np.array([time_s])
        places = [trajectory.at(times_s)[0] for trajectory in self._plan]
        discs = [
            shapely.Polygon() if docked else range_from(robot.sensor, place)
            for robot, place, docked in zip(self._robots, places, self._who_charges(times_s), strict=True)
            if robot.joins_s <= time_s and (robot.leaves_s is None or time_s < robot.leaves_s)
        ]
        self._views.set_paths([path_of(disc) for disc in discs])
        self._share = shapely.union_all(discs).intersection(self._free).area / self._free.area

    def _who_charges(self, times_s: Floats) -> list[bool]:
        """Whether each robot charges at a time (1,)."""
        return [bool(on_charger(trajectory, times_s)[0]) for trajectory in self._plan]

    def _move(self, time_s: float, age: Floats) -> None:
        super()._move(time_s, age)
        self._clock.set_text(f"{self._share:.1%} in range · {self._clock.get_text()}")

    def _ages(self, before_s: float, time_s: float) -> Floats:
        return self._sightings.last_seen_s  # not shown, so nobody looks

    def key_colours(self) -> Frame:
        """Colours that must not be mixed with others, (n, 3): the robots' own, black, white and those of the ground."""
        shades = [to_rgb(GROUND), *(covered_colour(times) for times in (1, 2, 3))]
        own = np.array([[round(255 * part) for part in shade] for shade in shades], dtype=np.uint8)
        return np.concatenate([super().key_colours(), own])
