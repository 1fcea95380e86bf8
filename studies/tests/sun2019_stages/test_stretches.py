"""Stretches of a frame: the waypoints that they hold, and the legs that join them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely import LineString, MultiPolygon, box

from rota.geometry.shortest_path import ShortestPaths
from rota_studies.sun2019_stages.partition import partition_frame
from rota_studies.sun2019_stages.stretches import segment_line
from rota_studies.sun2019_stages.tour import find_frame

OPEN = ShortestPaths(MultiPolygon([box(-100, -100, 100, 100)]))
R = 5.0


def test_segments_hold_their_waypoints_and_join_where_asked() -> None:
    angles = np.arange(12) * 2 * np.pi / 12
    places = 30 * np.column_stack([np.cos(angles), np.sin(angles)])
    frame = find_frame(places, np.zeros(12, np.int64), OPEN, virtual_radius_m=10, seed=0)
    partition = partition_frame(frame.legs_m, np.full(12, 8.0), speed_m_s=20, sensor_radius_m=R, segments=3)
    leg = 2 * 30 * math.sin(math.pi / 12)
    seen: list[tuple[float, float]] = []
    for k in range(3):
        line = segment_line(frame, partition, k, joining_legs=False)
        count = len(partition.places(k, 12))
        assert LineString(line).length == pytest.approx((count - 1) * leg)
        joined = segment_line(frame, partition, k, joining_legs=True)
        assert LineString(joined).length == pytest.approx(count * leg)
        assert joined[1:].tolist() == line.tolist()
        seen += [(round(x, 6), round(y, 6)) for x, y in line]
    assert sorted(seen) == sorted((round(x, 6), round(y, 6)) for x, y in places)
