"""The state of an annealing: all tours, what their legs see, and how often each sample is seen."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.compiled.by_reference import by_reference
from rota.model.arrays import Floats, Ints


# numba up to 0.65 takes no members of enumerations as places in arrays; numbers in a tuple it does
class _Most(NamedTuple):
    """Places in ``Tours.most``."""

    WEIGHT: int = 0  # the greatest weight of a sample
    RANGE: int = 1  # the farthest that any is seen from, in x or in y
    VERTEX: int = 2  # what a vertex more costs now


Most = _Most()


class _Count(NamedTuple):
    """Places in ``Tours.ints``."""

    SLOTS_LEFT: int = 0
    UNSEEN: int = 1
    ACCEPTED: int = 2
    VERTICES_LEFT: int = 3
    VERTICES: int = 4
    TRIED_NEW: int = 5
    TRIED_OLD: int = 6
    FULL: int = 7


Count = _Count()


@by_reference
class Tours(NamedTuple):
    """All tours, what their legs see, and how often each sample is seen; laid out by ``annealing/search.py``."""

    x: Floats  # by vertex v: its place in metres
    y: Floats
    after: Ints  # the next vertex of its ring
    before: Ints
    tour: Ints
    slot: Ints  # where it is kept what leg v sees
    in_use: Ints  # the vertices in use, ints[Count.VERTICES] of them
    place: Ints  # by vertex: its place in in_use
    free_vertices: Ints  # the others, ints[Count.VERTICES_LEFT] of them
    bucket: Ints  # by bucket: its first vertex, or -1
    bucket_after: Ints  # by vertex: the next one in its bucket, or -1
    bucket_before: Ints  # the one before it, or -1 - its bucket
    grid: Floats  # of the buckets: x and y of the first corner, and their side
    grid_n: Ints  # columns and rows
    anchor: Ints  # by tour k: a vertex of it; of a petal the one where it meets its hub
    n: Ints  # how many vertices
    length: Floats  # metres, turning included
    reach_m: Floats
    square: Ints  # 1 where the sensor is a square
    period_class: Ints  # the period class
    turn_m: Floats  # metres in the time of a turn by 1 rad
    arc_m: Floats  # the turn radius; 0 where robots turn on the spot
    corners: Floats  # what corners cost robots with mass that keep no limits, see ``CornerCosts.table``
    corner_leg_m: Floats  # (2,) the leg of its last column, and what a metre adds of legs that end at no corner
    costly: Ints  # 1 where corners cost anything
    blind_m: Floats  # of a leg's end at a right angle, from where nothing counts as seen: the corner is cut there
    limits: Floats  # of robots that speed up and brake, see ``speed_kernels.py``; (0,) of others
    trims: Floats  # metres of legs' ends that see nothing, at the places of a move
    window: Floats  # the vertices whose speeds are looked at, see there
    sine: Floats  # by vertex: of half its turn
    speed2: Floats  # the square of the speed there
    leg_cost: Floats  # metres at the pace that its leg costs, but for its rounded ends
    corner_cost: Floats  # those that its corner costs
    length_weight: Floats  # of a metre
    budget_m: Floats
    budget_penalty: Floats  # of a metre over budget
    hub: Ints  # the tour that it is a petal of, or itself
    petals: Ints  # of a hub: the first petal, and one past the last
    meets: Ints  # of a petal: the vertex of its hub at which it begins
    more: Ints  # of a hub: rounds beyond one for each petal
    whole_m: Floats  # of a hub: the budget of all its rounds together
    seen: NDArray[np.int32]  # by slot: what a leg sees, as runs of samples
    seen_n: Ints  # how many numbers these are
    free_slots: Ints  # ints[Count.SLOTS_LEFT] of them
    times_seen: NDArray[np.uint64]  # by word of 64 samples: by how many legs, see ``count_kernels.py``
    unseen_item: Ints  # the unseen samples, ints[Count.UNSEEN] of them
    unseen_place: Ints  # by sample: its place in unseen_item
    bucket_of_sample: NDArray[np.int32]
    unseen_in: Ints  # by bucket: how many unseen samples
    most: Floats
    ints: Ints
    unseen: Floats  # (1,) the weight of all unseen samples
    new_legs: Floats  # legs that a move would make: begin, way, and 1 / length squared
    tried_new: Ints  # slots of the legs that the trial makes
    tried_old: Ints  # of those that it takes away
    rng: NDArray[np.uint64]  # the state of the random numbers
    new_x: Floats  # the new places of a move, in metres
    new_y: Floats
    scratch: Floats  # room for the places of a short ring
