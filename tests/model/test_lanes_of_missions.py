"""Lanes as the model takes them."""

from __future__ import annotations

import pytest
from shapely import MultiPolygon, box

from rota.errors import MissionError
from rota.model.mission import DiscSensor, Fleet, Lane, Mission, Obstacle, Zone


def mission_with(*lanes: Lane, body_m: float = 0.0, width_m: float = 2.0, **fields: object) -> Mission:
    zone = Zone(name="end", period_s=60, demand="visit", shape=MultiPolygon([box(9, -0.5, 10, 0.5)]))
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1), body_radius_m=body_m)
    area = MultiPolygon([box(-1, -width_m / 2, 11, width_m / 2)])
    told: dict[str, object] = {"zones": (zone,), "fleet": fleet, **fields}
    return Mission(name="m", area=area, lanes=lanes, **told)  # type: ignore[arg-type]


def test_what_a_lane_takes_is_its_length_at_the_robots_speed_and_no_less_than_it_says() -> None:
    line_m = ((0.0, 0.0), (3.0, 0.0), (3.0, 4.0))
    assert Lane(line_m=line_m).drawn_m == 7
    assert Lane(line_m=line_m).duration_s(2.0) == 3.5
    assert Lane(line_m=line_m, length_m=10).duration_s(2.0) == 5
    assert Lane(line_m=line_m, length_m=10, least_s=8).duration_s(2.0) == 8


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"line_m": ((0, 0),)}, "line_m: .*at least 2 entries"),
        ({"line_m": ((0, 0), (0, 0))}, r"line_m\[1\].*another place"),
        ({"line_m": ((0, 0), (10, 0)), "length_m": 9}, "length_m: 9.*10 m long; no way is shorter"),
        ({"line_m": ((0, 0), (float("nan"), 0))}, "finite number"),
        ({"line_m": ((0, 0), (1, 0)), "least_s": 0}, "least_s: 0 is not allowed"),
    ],
)
def test_a_lane_that_is_none_is_refused(fields: dict[str, object], message: str) -> None:
    with pytest.raises(MissionError, match=message):
        Lane(**fields)  # type: ignore[arg-type]


def test_lanes_lie_where_bodies_fit() -> None:
    along = Lane(line_m=((0, 0), (10, 0)))
    assert mission_with(along, body_m=1.0).lanes == (along,)
    with pytest.raises(MissionError, match=r"lanes\[0\].line_m: a body of 1.1 m does not fit at \(10, 0\)"):
        mission_with(along, body_m=1.1)
    wall = Obstacle(shape=MultiPolygon([box(4, -1, 5, 1)]))
    with pytest.raises(MissionError, match=r"lanes\[0\].line_m: robots cannot be at \(4, 0\)"):
        mission_with(along, obstacles=(wall,))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"period_s": 30.0}, "period_s: on lanes robots come to places"),
        ({"fleet": Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1), turn_radius_m=1)}, "turn_radius_m: on lanes"),
        ({"fleet": Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1), turn_rate_rad_s=1)}, "turn_rate_rad_s: on lanes"),
        (
            {"zones": (Zone(name="all", period_s=9, shape=MultiPolygon([box(9, -0.5, 10, 0.5)])),)},
            r"zones\[0\].demand: .*demand: visit",
        ),
    ],
)
def test_what_is_not_planned_for_on_lanes_is_refused(fields: dict[str, object], message: str) -> None:
    with pytest.raises(MissionError, match=message):
        mission_with(Lane(line_m=((0, 0), (10, 0))), **fields)
