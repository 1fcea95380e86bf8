"""What makes one plan's loops better than another's: their length, and how much they turn."""

from __future__ import annotations

from collections.abc import Sequence

from rota.planners.patrol.driving.polylines import turns_rad
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.tolerances import ROUNDING
from rota.planners.patrol.tours.tour import Tour, nests, tour_length_m, unfold_nests


def loops_m(tours: Sequence[Tour]) -> float:
    """Metres of one round of every loop as it is driven, turning counted as the metres that take the same time."""
    return sum(tour_length_m(tour) for tour in unfold_nests(tours))


def turning_rad(tours: Sequence[Tour]) -> float:
    """By how much the direction changes in one round of every loop as it is driven, in all."""
    return float(sum(turns_rad(tour.vertices_m).sum() for tour in unfold_nests(tours)))


def rounds_of(tours: Sequence[Tour]) -> list[int]:
    """How often each tour (k) is driven in one round of its loop: a hub once for each petal that leads anywhere."""
    rounds = [1] * len(tours)
    for hub, *petals in nests(tours):
        rounds[hub] = max(1, sum(len(tours[k].vertices_m) > 1 for k in petals))
    return rounds


def is_too_long(tours: Sequence[Tour], old: Sequence[Tour]) -> bool:
    """Whether loops are so much longer than others that more rounds of repair will hardly make them shorter."""
    return loops_m(tours) > 1.005 * loops_m(old)  # later rounds of repair take half a percent back, hardly ever more


def is_better(new: Repaired, old: Repaired, *, fewest_turns: bool) -> bool:
    """Whether a plan that is met has no more robots, and shorter loops, or loops no longer that turn less."""
    if not new.met or new.robots > old.robots:
        return False
    length_m, least_m = loops_m(new.tours), loops_m(old.tours)
    if fewest_turns:
        return length_m <= least_m and turning_rad(new.tours) < turning_rad(old.tours)
    return length_m < least_m * (1 - ROUNDING)
