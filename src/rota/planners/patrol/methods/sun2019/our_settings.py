"""Our settings of the method sun2019: by which set cover sensors are deployed.

Sun et al., Sensors 19(9):1994, 2019. Other distributions may bring a larger block, with algorithms of their own: see
``mission_settings``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from rota.model.planner_settings import Settings, setting
from rota.model.refusals import Where, inner

OTHERS = (
    "the paper's own algorithms, routes as printed, and their settings come with the distribution rota-studies,"
    " which is not installed; `pip install ./studies` in a checkout of Rota installs it"
)


@dataclass(frozen=True, kw_only=True)
class Sun2019(Settings):
    """How the stages of the method ``sun2019`` are done: by ours, which take fewest robots.

    ``deployment`` of virtual sensors: "greedy" or "exact" set cover; "best" of both, as far as the effort allows. The
    frame past them, ``tour``, is found by a local search, its ``partition`` exactly, and ``routes`` round the segments
    are led to what they leave unseen and shortened: what other distributions do instead has these names.
    """

    place: ClassVar[str] = "patrol.sun2019"
    elsewhere: ClassVar[str] = OTHERS
    deployment: Literal["best", "greedy", "exact"] = setting("best", "of virtual sensors", newer=True, elsewhere=OTHERS)
    tour: Literal["local_search"] = setting("local_search", "past all sensors", newer=True, elsewhere=OTHERS)
    partition: Literal["exact"] = setting("exact", "of the tour among the robots", newer=True, elsewhere=OTHERS)
    routes: Literal["shortened"] = setting("shortened", "round the segments", newer=True, elsewhere=OTHERS)

    @classmethod
    def refusals(cls, data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Sensors that are squares."""
        if inner(data, "fleet", "sensor", "shape") == "square":
            message = "square is not allowed: patrol.method sun2019 is made for discs; give disc"
            yield ("fleet", "sensor", "shape"), message

    @property
    def search(self) -> str:
        """Where the search by these stages is: a module, and a function of the context in it."""
        return "rota.planners.patrol.methods.sun2019.search:search_by_our_stages"

    def covers(self, effort: str) -> tuple[Any, ...]:
        """The set covers to be tried, greedy ones first: they stand in rows, which makes short frames."""
        if self.deployment != "best":
            return (self.deployment,)
        return ("greedy",) if effort == "quick" else ("greedy", "exact")
