"""Tours as linear programs see them: vertices that move, legs between them, and who sees which sample from where."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.model.mission import DiscSensor, inner_reach_m
from rota.planners.patrol.driving.corner_costs import Slopes
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.repair.bending.sighting_kernels import SensingLegs, Sightings, best_sightings
from rota.planners.patrol.tours.tour import Tour, meeting, nests, rounds_more, tour_length_m, whole_budget_m


@dataclass(frozen=True, kw_only=True)
class Layout:
    """The legs of all tours, without their places.

    start, end (m,): vertices of each leg; a petal shares the vertex at which it begins with its hub. tour (m,): whose
    leg it is. before, after, share (n,): vertices that cut a long leg lie on the way between two others, so far along
    it; corners between themselves. counts (b, k): how often the length of each tour counts in each budget; budget_m
    (b,).
    """

    tours: list[Tour]
    start: Ints
    end: Ints
    tour: Ints
    before: Ints
    after: Ints
    share: Floats
    counts: Floats
    budget_m: Floats

    @property
    def slopes(self) -> tuple[Slopes, ...] | None:
        """Each tour's where all robots know them, and lengths are exact, corners included; None where one does not."""
        known = tuple(slopes for tour in self.tours if (slopes := driving_of(tour.robot).slopes) is not None)
        return known if len(known) == len(self.tours) else None

    def lengths_m(self, places_m: Floats) -> Floats:
        """Length (k,) of each tour with its vertices at these places (n, 2); without corners but for ``slopes``."""
        if self.slopes is not None:
            return np.array([tour_length_m(tour) for tour in self.tours_at(places_m)])
        legs_m = np.hypot(*(places_m[self.end] - places_m[self.start]).T)
        return np.asarray(np.bincount(self.tour, weights=legs_m, minlength=len(self.tours)), dtype=np.float64)

    def tours_at(self, places_m: Floats) -> list[Tour]:
        """The tours with their vertices at these places (n, 2)."""
        return [replace(tour, vertices_m=places_m[self.start[self.tour == k]]) for k, tour in enumerate(self.tours)]


def lay_out_tours(tours: Sequence[Tour], longest_m: float) -> tuple[Layout, Floats]:
    """The tours with legs of at most ``longest_m``, and the places (n, 2) of their vertices."""
    places: list[Floats] = []
    start, end, owner, ends, shares = [], [], [], [], []
    n = 0
    for nest in nests(tours):
        hub_m, first = cut_legs(tours[nest[0]].vertices_m, longest_m)[0], n
        for k in nest:
            ring, share = cut_legs(tours[k].vertices_m, longest_m)
            ids = np.arange(n, n + len(ring))
            if k != nest[0]:
                ids = np.concatenate([[first + meeting(hub_m, ring)], ids[:-1]])
                ring, share = ring[1:], share[1:]
            corners = np.flatnonzero(np.concatenate([[0.0], share] if k != nest[0] else [share]) == 0)
            which = np.searchsorted(corners, np.arange(len(ids)), side="right") - 1
            between = np.column_stack([ids[corners[which]], ids[corners[(which + 1) % len(corners)]]])
            if k != nest[0]:
                between = between[1:]
            between[share == 0, 1] = between[share == 0, 0]
            places.append(ring)
            ends.append(between)
            shares.append(share)
            n += len(ring)
            start.append(ids)
            end.append(np.roll(ids, -1))
            owner.append(np.full(len(ids), k))
    rows = list(budget_rows(tours))
    layout = Layout(
        tours=list(tours),
        start=np.concatenate(start).astype(np.int64),
        end=np.concatenate(end).astype(np.int64),
        tour=np.concatenate(owner).astype(np.int64),
        before=np.vstack(ends)[:, 0].astype(np.int64),
        after=np.vstack(ends)[:, 1].astype(np.int64),
        share=np.concatenate(shares),
        counts=np.array([counts for counts, _ in rows]),
        budget_m=np.array([budget_m for _, budget_m in rows]),
    )
    return layout, np.vstack(places)


def cut_legs(vertices_m: Floats, longest_m: float) -> tuple[Floats, Floats]:
    """The closed polyline with legs cut into equal pieces, and how far along its leg (n,) each vertex lies: 0 to 1."""
    ends_m = np.roll(vertices_m, -1, axis=0)
    pieces = np.maximum(1, np.ceil(np.hypot(*(ends_m - vertices_m).T) / longest_m)).astype(np.int64)
    which = np.repeat(np.arange(len(vertices_m)), pieces)
    share = (np.arange(len(which)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[which]
    return vertices_m[which] + share[:, None] * (ends_m - vertices_m)[which], share


def budget_rows(tours: Sequence[Tour]) -> Iterator[tuple[Floats, float]]:
    """How often each tour (k,) counts in each budget, and that: of each tour alone, each round of a nest and all.

    What corners add is taken from the budgets, but for ``Layout.slopes``.
    """
    for hub, *petals in nests(tours):
        whole = np.zeros(len(tours))
        for k in petals or [hub]:
            counts = np.zeros(len(tours))
            counts[[hub, k]] = 1.0
            whole += counts
            yield counts, tours[hub].budget_m - sum(corners_m(tours[j]) for j in {hub, k})
        if petals:
            whole[hub] += rounds_more(tours, petals)
            yield whole, whole_budget_m(tours, hub, np.array([petals[0], petals[-1] + 1]))


def corners_m(tour: Tour) -> float:
    """What corners add to a tour of a robot with mass: a step that moves them a little hardly changes it."""
    driving = driving_of(tour.robot)
    if not driving.has_mass or driving.slopes is not None:
        return 0.0
    legs_m = np.hypot(*(np.roll(tour.vertices_m, -1, axis=0) - tour.vertices_m).T)
    return tour_length_m(tour) - float(legs_m.sum())


def sightings(
    layout: Layout,
    places_m: Floats,
    samples: Samples,
    *,
    range_margin_m: float,
    further_m: float,
    handicap_m: Floats | float = 0.0,
    most: int = 1,
) -> Sightings:
    """Who sees which sample, the vertices at these places (n, 2); ``further_m``: how far beyond reach is looked.

    handicap_m: by how much more range to spare a leg of each tour (k,) must see a sample than others do, to have it.
    most: legs of each sample that are told.
    """
    handicap_m = np.broadcast_to(handicap_m, len(layout.tours))
    robots = [tour.robot for tour in layout.tours]
    reach_m = np.array([inner_reach_m(robot.sensor) for robot in robots]) - range_margin_m - handicap_m
    square = np.array([0 if isinstance(robot.sensor, DiscSensor) else 1 for robot in robots], dtype=np.int64)
    period_class = np.array([tour.period_class for tour in layout.tours], dtype=np.int64)
    driven = drive_legs(layout, places_m)
    of_tour = layout.tour[driven.leg]
    legs = SensingLegs(driven.ends_m, period_class[of_tour], reach_m[of_tour], square[of_tour])
    n = len(samples.x)
    best = Sightings(np.empty((n, most), dtype=np.int64), np.empty((n, most)), np.empty((n, most)))
    room = 1024
    while best_sightings(legs, further_m, samples, np.empty(room, dtype=np.int32), best):
        room *= 2
    # samples are many, and so are what they take: all is made where it lies
    share, leg = driven.share, driven.leg[best.leg]
    leg[best.leg < 0] = -1
    np.multiply(best.at, (share[:, 1] - share[:, 0])[best.leg], out=best.at)
    np.add(best.at, share[best.leg, 0], out=best.at)
    if handicap_m.any():
        best.range_deficit_m[leg >= 0] -= handicap_m[layout.tour[leg[leg >= 0]]]
    return Sightings(leg, best.at, best.range_deficit_m)


class Driven(NamedTuple):
    """The ways that robots drive: chords (m, 4), and the part of which leg (m,) each is beside, (m, 2) in 0..1."""

    ends_m: Floats
    leg: Ints
    share: Floats


def drive_legs(layout: Layout, places_m: Floats) -> Driven:
    """The legs as they are driven, with the vertices at these places (n, 2): corners are cut by robots with mass."""
    ends_m = np.hstack([places_m[layout.start], places_m[layout.end]])
    whole = Driven(ends_m, np.arange(len(ends_m)), np.tile([0.0, 1.0], (len(ends_m), 1)))
    if not any(driving_of(tour.robot).off_m > 0 for tour in layout.tours):
        return whole
    parts = []
    for k, tour in enumerate(layout.tours):
        own = np.flatnonzero(layout.tour == k)
        line_m, beside = driving_of(tour.robot).driven(places_m[layout.start[own]])
        if len(line_m) == 1:
            parts.append(Driven(ends_m[own], own, whole.share[own]))
            continue
        leg = np.floor(beside.mean(axis=1)).astype(np.int64)
        share = np.clip(beside - leg[:, None], 0.0, 1.0)
        parts.append(Driven(np.hstack([line_m[:-1], line_m[1:]]), own[leg % len(own)], share))
    return Driven(*(np.concatenate(values) for values in zip(*parts, strict=True)))
