"""What the search tells those who watch it."""

from __future__ import annotations

from collections.abc import Callable

from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planning.progress import SearchState


def progress_teller(context: Context, search: Annealing, points: SamplePoints) -> Callable[[int], None]:
    """What to call after every stretch of annealing: tells how the tours then stand, if anybody watches.

    points: the samples of the search, in its order.
    """
    watch = context.watch
    if watch is None:
        return lambda moves: None
    whole_m2 = float(points.area_m2.sum())
    robots = sum(tour.robots for tour in search.tours)

    def tell(moves: int) -> None:
        """Tell the watcher how the tours stand, whatever number of moves was made."""
        unseen_m2 = float(points.area_m2[search.unseen_samples].sum())
        watch(
            SearchState(
                stage="searched",
                robots=robots,
                unseen_share=unseen_m2 / whole_m2 if whole_m2 else 0.0,
                late_share=search.over_budget_share,
            )
        )

    return tell
