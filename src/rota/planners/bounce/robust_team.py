"""The team that keeps most of its plan when turns are off: candidates, simulated with stated errors and compared."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from rota.model.plan import Plan
from rota.planners.bounce.chosen_group import Chosen, begin_there, sampled_basins, ways_from_starts
from rota.planners.bounce.group_search import best_group
from rota.planners.bounce.inexact_plan import Inexact, with_errors
from rota.planners.bounce.kernels import Team
from rota.planners.bounce.monitoring import Watch
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planning.planner import Request

CANDIDATES = 24  # that are simulated
FIRST_RUNS, SECOND_RUNS, IN_SECOND = 40, 200, 4  # runs of each, and of the best of them once more
AS_GOOD = 0.02  # share of the time by which two candidates count as equally watched
FEW_NODES = 2_000  # partial teams looked at for the one with the shortest worst gap
TRIES = 2000  # random teams


def most_robust(plans: Sequence[Plan], request: Request) -> int:
    """The number of the plan that keeps most of its visits, and whose bodies touch last among those as good.

    Each plan is simulated with the mission's turning error (see ``with_errors``), the best of them more often. Of plans
    whose zone that is least watched is so for nearly the same share of the time, the one counts whose bodies first
    touch latest, in half of the runs.
    """
    places = list(range(len(plans)))
    for runs, left in ((FIRST_RUNS, IN_SECOND), (SECOND_RUNS, 1)):
        if len(places) == 1:
            break
        found: dict[int, Inexact] = {}
        for k, place in enumerate(places):
            if found and request.should_stop():
                break
            request.progress(k / len(places), f"inexact turns, {runs} runs of team {k + 1} of {len(places)}")
            found[place] = with_errors(plans[place], most_runs=runs, exact=False)
        places = rank(found)[:left]
    return places[0]


def rank(found: dict[int, Inexact]) -> list[int]:
    """Plans by number, the most robust first."""
    left, order = dict(found), []
    while left:
        top = max(inexact.least_share for inexact in left.values())
        pool = [place for place, inexact in left.items() if inexact.least_share >= top - AS_GOOD]
        best = max(pool, key=lambda place: (*_contact(left[place]), left[place].least_share, -place))
        order.append(best)
        del left[best]
    return order


def _contact(inexact: Inexact) -> tuple[float, float]:
    """When bodies first touch in half and in a tenth of the runs."""
    first_s, half_s, _ = inexact.met_s or (np.inf, np.inf, np.inf)
    return half_s, first_s


def candidates(
    watch: Watch, team: Team, begun: Chosen | None, at: Sequence[int], settings: BounceSettings, seed: int
) -> list[Chosen]:
    """Different groups that meet all periods, CANDIDATES at most; ``begun``, which was found first, where none does.

    at: the cells in which robots are to begin, if they are given. Otherwise groups come from the search for the
    shortest gap, from random starts (those that most of these come to, first) and from random choices.
    """
    if begun is None or begun.ratio > 1:
        return [] if begun is None else [begun]
    found = {begun.nodes: begun}
    more = ways_from_starts(watch, team, at, settings, seed) if at else _groups(watch, team, settings, seed)
    for chosen in more:
        if chosen.ratio <= 1:
            found.setdefault(chosen.nodes, chosen)
        if len(found) == CANDIDATES:
            break
    return list(found.values())


def _groups(watch: Watch, team: Team, settings: BounceSettings, seed: int) -> Iterator[Chosen]:
    """Groups that begin on their cycles; half of them those that random starts come to, the rest drawn."""
    hits = sampled_basins(watch, team, free=settings.contact_free == "trajectory", seed=seed)
    shortest = best_group(watch, most_nodes=FEW_NODES).group
    nodes = itertools.chain(
        [] if shortest is None else [shortest.nodes], itertools.islice((group for group, _ in hits), CANDIDATES)
    )
    kept = 0
    for group in nodes:
        ratio = watch.ratio(group)
        kept += ratio <= 1
        if kept <= CANDIDATES // 2:
            yield begin_there(watch, group, ratio)
    rng = np.random.default_rng(seed)
    for _ in range(TRIES):
        drawn = _draw_team(watch, rng)
        if drawn is not None:
            yield begin_there(watch, drawn, watch.ratio(drawn))


def _draw_team(watch: Watch, rng: np.random.Generator) -> tuple[int, ...] | None:
    """Random periodic states that go together, each in a zone that nobody enters so far; None: it ends in none."""
    cycles = watch.cycles
    free, nodes = np.ones(len(cycles.state), np.bool_), []
    missed = np.ones(watch.sees.shape[1], np.bool_)
    entered = np.logical_or.reduceat(watch.sees, cycles.start, axis=0)[cycles.cycle]
    for kind in cycles.kind_of_robot:
        possible = free & (cycles.kind == kind)
        helpful = possible & (entered & missed).any(axis=1)
        room = np.flatnonzero(helpful if helpful.any() else possible)
        if not len(room):
            return None
        node = int(rng.choice(room))
        nodes.append(node)
        free, missed = free & cycles.compatible[node], missed & ~entered[node]
    return None if missed.any() else tuple(nodes)
