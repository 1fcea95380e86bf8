"""Settings of the routes round the segments of the frame (Sun et al. 2019), and of their repair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from rota.model.planner_settings import Settings, setting
from rota.planners.patrol.methods.sun2019.mission_settings import SegmentRoutes


@dataclass(frozen=True, kw_only=True)
class RouteSettings(Settings):
    """How routes are led round the segments, and how many numbers of robots are tried.

    routes: "printed": the segment widened by r_s, cut to the free space, which is all the paper tells; "repaired":
    led to what they leave unseen, until the check passes, and given a further robot where that makes them too long;
    "shortened": bent besides by moves that lose nothing, where they are too long. The shortening is ours.
    arc_corners: of a quarter of a circle; 8 stay within 0.5 % of r_s.
    hole: ground that a route encloses but does not see is gone round too when it has this share of a disc of r_s;
    less is left to the repair.
    most_load: the segments' times by Eq. 26 over their periods, on average, beyond which so few robots are not tried:
    routes are shorter where lanes meet borders, and lanes may lie farther apart than sensors do (measured on the
    paper's cases, shortened: up to 1.28 came to pass, nothing from 1.30 to 1.66).
    repairs: rounds of judging and repair.
    recuts: how often a frame is cut anew for the same number of robots, by the lengths to which repair led the routes,
    when these are too long and are not shortened.
    """

    place: ClassVar[str] = "patrol.sun2019.routes"
    routes: SegmentRoutes = setting("shortened")
    arc_corners: int = setting(8, least=2)
    hole: float = setting(0.25, above=0)
    most_load: float = setting(1.4, above=0)
    repairs: int = setting(12, least=1)
    recuts: int = setting(4, least=0)
