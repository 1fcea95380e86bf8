"""Who comes to which places: as few robots as can be, each with places of its own or sharing a round with others."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.cycles.one_robot import is_surely_too_much, stretch_of, visit_for_ever
from rota.planners.patrol.cycles.subset_kernels import cheapest_sharing, round_trips

# places over whose subsets a team is looked for, or of which it is asked whether one robot can serve them; more are
# cut into parts again and again
MOST_TOGETHER = 12
SHORTER = (
    1e-3  # of a robot: what all of the shortest round trips are worth, so that of two teams the nearer one is taken
)


class Share(NamedTuple):
    """What some robots do: the order (m,) of places in a round, which they share at equal headways.

    round_s: what it takes. headway_s: the most that they may be apart. times_s (m,): when the robot is at each place,
    if it keeps in step with others, after the beginning of a round of all of them.
    """

    order: Ints
    robots: int
    round_s: float
    headway_s: float
    times_s: Floats | None = None

    @property
    def is_plain(self) -> bool:
        """Whether the round comes to each place once, whenever others do."""
        return self.times_s is None and len(np.unique(self.order)) == len(self.order)


def share_places(
    leg_s: Floats,
    period_s: Floats,
    *,
    most_states: int,
    rounds: int,
    seed: int,
    should_stop: Callable[[], bool] = lambda: False,
    begin: list[Share] | None = None,
) -> list[Share]:
    """The team with the fewest robots found that comes to all places (n,) for ever, each within its period.

    leg_s (n, n): from place to place in seconds, 0 on the diagonal and more elsewhere, inf where there is no way. With
    at most ``MOST_TOGETHER`` places it is the best of all teams in which a place belongs to one robot, or to robots
    that share a plain round, but for questions that ``most_states`` leaves open. With more, parts of the team are made
    anew so many ``rounds``, unless the search is to stop. begin: the team to begin with; None: neighbours together.
    """
    if len(period_s) <= MOST_TOGETHER:
        return best_team(leg_s, period_s, most_states=most_states)
    random = np.random.default_rng(seed)
    team = begin
    if team is None:
        groups = neighbours_together(leg_s)
        team = [share for group in groups for share in team_for(group, leg_s, period_s, most_states)]
    for _ in range(rounds):
        if should_stop():
            break
        chosen = some_near_each_other(team, leg_s, random)
        if not chosen:
            continue  # one round with more places
        places = np.unique(np.concatenate([team[k].order for k in chosen]))
        anew = team_for(places, leg_s, period_s, most_states)
        if worth(anew) <= worth([team[k] for k in chosen]):
            team = [share for k, share in enumerate(team) if k not in chosen] + anew
    return team


def worth(team: Sequence[Share]) -> tuple[int, float]:
    """What is better less of: robots, then the share of their time in which they drive."""
    return sum(share.robots for share in team), sum(share.round_s / share.headway_s for share in team)


def team_for(places: Ints, leg_s: Floats, period_s: Floats, most_states: int) -> list[Share]:
    """The best team for some of the places (k,), at most ``MOST_TOGETHER``."""
    own = best_team(leg_s[np.ix_(places, places)], period_s[places], most_states=most_states)
    return [share._replace(order=places[share.order]) for share in own]


def neighbours_together(leg_s: Floats) -> Iterator[Ints]:
    """All places in groups of ``MOST_TOGETHER``: always the one farthest from all that is left, with those near it."""
    left = np.arange(len(leg_s))
    while len(left):
        far = np.minimum(leg_s[left], leg_s[np.isfinite(leg_s)].max()).sum(axis=1)
        first = left[int(np.argmax(far))]
        group = left[np.argsort(leg_s[first, left], kind="stable")[:MOST_TOGETHER]]
        left = np.setdiff1d(left, group)
        yield group


def some_near_each_other(team: Sequence[Share], leg_s: Floats, random: np.random.Generator) -> list[int]:
    """The numbers of a share, by chance, and of those nearest to it, with ``MOST_TOGETHER`` places or fewer."""
    first = int(random.integers(len(team)))
    away_s = [leg_s[np.ix_(team[first].order, share.order)].min() for share in team]
    chosen, count = list[int](), 0
    for k in np.argsort(away_s, kind="stable"):
        count += len(np.unique(team[k].order))
        if count > MOST_TOGETHER or not math.isfinite(away_s[k]):
            break
        chosen.append(int(k))
    return chosen


def best_team(leg_s: Floats, period_s: Floats, *, most_states: int) -> list[Share]:
    """The same for few places, over all of their subsets."""
    trip_s, way_s = round_trips(np.minimum(leg_s, 1e3 * period_s.max()))
    cost, orders = costs_of_subsets(leg_s, period_s, trip_s, most_states)
    part = cheapest_sharing(cost)
    team, left = list[Share](), len(cost) - 1
    while left:
        subset = int(part[left])
        left ^= subset
        team.append(orders.get(subset) or plain_share(subset, leg_s, period_s, way_s))
    return team


def costs_of_subsets(
    leg_s: Floats, period_s: Floats, trip_s: Floats, most_states: int
) -> tuple[Floats, dict[int, Share]]:
    """Robots that each subset (2^n,) takes as one part, and the rounds that come to places more than once.

    What one robot cannot do it cannot do with more places either: subsets are asked from the small to the large.
    """
    n = len(period_s)
    cost, alone = np.full(1 << n, np.inf), np.zeros(1 << n, dtype=bool)
    cost[0], alone[0] = 0.0, True
    shares: dict[int, Share] = {}
    for subset in sorted(range(1, 1 << n), key=int.bit_count):
        places = np.array([i for i in range(n) if subset >> i & 1])
        shortest_s = float(period_s[places].min())
        robots = max(1, math.ceil(trip_s[subset] / shortest_s))
        if robots > 1 and all(alone[subset ^ 1 << int(i)] for i in places):
            share = round_of_one(places, leg_s, period_s, most_states)
            if share is not None:
                shares[subset], robots = share, 1
        alone[subset] = robots == 1
        load = shares[subset].round_s / shares[subset].headway_s if subset in shares else trip_s[subset] / shortest_s
        cost[subset] = robots + SHORTER * min(load, float(n))
    return cost, shares


def round_of_one(places: Ints, leg_s: Floats, period_s: Floats, most_states: int) -> Share | None:
    """A round in which one robot comes to some of these places more than once; None where none was found."""
    legs_s, periods_s = leg_s[np.ix_(places, places)], period_s[places]
    if is_surely_too_much(legs_s, periods_s):
        return None
    order = visit_for_ever(legs_s, periods_s, most_states=most_states).order
    if order is None:
        return None
    round_s, stretch = stretch_of(order, legs_s, periods_s)
    return Share(places[order], 1, round_s, stretch * round_s)


def plain_share(subset: int, leg_s: Floats, period_s: Floats, way_s: Floats) -> Share:
    """The shortest round trip through a subset, with as many robots as come by within the shortest period."""
    places = [i for i in range(len(period_s)) if subset >> i & 1]
    low, order, left = places[0], list[int](), subset
    onward_s = leg_s[:, low]
    while left:
        last = min((i for i in places if left >> i & 1), key=lambda i: way_s[left, i] + onward_s[i])
        order.append(last)
        left ^= 1 << last
        onward_s = leg_s[:, last]
    order = order[::-1]
    shortest_s = float(period_s[places].min())
    round_s = float(leg_s[order, np.roll(order, -1)].sum()) if len(order) > 1 else 0.0
    return Share(np.array(order), max(1, math.ceil(round_s / shortest_s)), round_s, shortest_s)
