"""Lanes that leave room to turn, and rings with round corners: closed forms, and curves that stay in the space."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from shapely import LineString, MultiPolygon, Polygon, box

from rota.model.mission import DiscSensor
from rota.planners.patrol.driving.polylines import keeps_radius
from rota.planners.patrol.methods.sweeping.lanes import Swath
from rota.planners.patrol.methods.sweeping.wide_turn_pieces import (
    OUTSIDE,
    lanes_with_room,
    parts_near,
    pieces_round,
    rings,
)

RADIUS_M = 20.0
FIELD = MultiPolygon([box(0, 0, 200, 120)])
SWATH = Swath(sensor=DiscSensor(radius_m=5.0), angle_rad=0.0)


def test_a_ring_is_a_rectangle_with_round_corners() -> None:
    pieces = list(rings(FIELD, 10.0, RADIUS_M))
    inset_m = 2 * (10 + RADIUS_M * OUTSIDE)
    straight_m = 2 * (200 - inset_m) + 2 * (120 - inset_m)
    length_m = sum(LineString(piece).length for piece in pieces)
    assert length_m == pytest.approx(straight_m + 2 * math.pi * RADIUS_M, rel=1e-3)  # legs touch arcs from outside
    assert len(pieces) == 4  # cut in the middle of each side
    whole = np.vstack([piece[:-1] for piece in pieces])
    assert keeps_radius(whole, RADIUS_M * (1 - 1e-9))
    assert Polygon(whole).exterior.distance(FIELD.boundary) == pytest.approx(10 + (OUTSIDE - 1) * RADIUS_M)


def test_no_ring_lies_where_no_circle_does() -> None:
    assert not list(rings(MultiPolygon([box(0, 0, 200, 39)]), 0.0, RADIUS_M))


def test_rings_end_before_corners_that_turn_outwards() -> None:
    ell = MultiPolygon([Polygon([(0, 0), (300, 0), (300, 120), (150, 120), (150, 300), (0, 300)])])
    pieces = list(rings(ell, 0.0, RADIUS_M))
    lines = shapely.multilinestrings([LineString(piece) for piece in pieces])
    assert ell.buffer(1e-6).covers(lines)
    assert lines.distance(shapely.Point(150, 120)) > 0.9 * RADIUS_M
    assert lines.length > 0.8 * ell.length - 2 * math.pi * RADIUS_M


def test_a_ring_goes_once_round_a_polygon_with_a_corner_that_turns_outwards() -> None:
    middles = Polygon([(0, 0), (300, 0), (300, 120), (150, 120), (150, 300), (0, 300)])
    first, *_, last = pieces_round(middles, RADIUS_M)
    np.testing.assert_allclose(first[0], last[-1])


def test_lanes_end_where_a_circle_beside_them_still_fits() -> None:
    lanes = list(lanes_with_room(box(5, 5, 195, 115), FIELD, SWATH, RADIUS_M))
    assert len(lanes) == 11
    left, low, right, high = shapely.total_bounds([LineString(lane) for lane in lanes])
    assert (left, right) == pytest.approx((RADIUS_M * OUTSIDE, 200 - RADIUS_M * OUTSIDE))
    assert (low, high) == pytest.approx((10, 110))


def test_what_sees_the_ground_of_a_ring_ends_where_legs_touch_arcs() -> None:
    piece = next(piece for piece in rings(FIELD, 0.0, RADIUS_M) if piece[0, 0] > 199 and piece[-1, 1] > 119)
    (part,) = parts_near(piece, shapely.Point(197, 117).buffer(1), 5.0, RADIUS_M)
    assert 0 < LineString(part).length < LineString(piece).length

    for end, after in ((part[0], part[1]), (part[-1], part[-2])):
        middle = np.array([200 - RADIUS_M * OUTSIDE, 120 - RADIUS_M * OUTSIDE])
        along = (after - end) / np.hypot(*(after - end))
        off_m = abs(float(along[0] * (middle - end)[1] - along[1] * (middle - end)[0]))
        assert off_m == pytest.approx(RADIUS_M)  # it leaves along a tangent
