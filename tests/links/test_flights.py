"""A safe beginning and end, with robots that write down what they are told and are at once where they are to be."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest
from tests.links.fleets import ALTITUDE_M, loop_of, plan_of, routes_of

from rota.errors import LinkError
from rota.links.flights import Flights
from rota.links.link import Report
from rota.model.plan import Trajectory
from rota.routes.route import Place3

PAD = {"a": (0.0, 100.0, 0.0), "b": (3.0, 100.0, 0.0)}
LAYER = ALTITUDE_M + 3.0


class Copters:
    """Two on one pad. fails: what one of them does not do."""

    robots = ("a", "b")

    def __init__(self, fails: tuple[str, str] = ("", "")) -> None:
        self.at_m: dict[str, Place3] = dict(PAD)
        self.done: list[tuple[str, str, Any]] = []
        self.fails = fails

    def latest(self, robot: str) -> Report:
        return Report(robot=robot, time_s=0.0, position_m=self.at_m[robot])

    def is_in_air(self, robot: str) -> bool:
        return self.at_m[robot][2] > 0

    def home_m(self, robot: str) -> Place3:
        return PAD[robot]

    def _do(self, what: str, robot: str, given: Any, to_m: Place3) -> None:
        if (what, robot) == self.fails:
            raise LinkError(f"robot {robot}: {what}: it does not")
        self.done.append((what, robot, given))
        self.at_m[robot] = to_m

    async def climb(self, robot: str, height_m: float) -> None:
        await asyncio.sleep(0)
        self._do("climb", robot, height_m, (*self.at_m[robot][:2], height_m))

    async def go(self, robot: str, places_m: Sequence[Place3]) -> None:
        await asyncio.sleep(0)
        self._do("go", robot, list(places_m), places_m[-1])

    async def pause(self, robot: str) -> None:
        self._do("pause", robot, None, self.at_m[robot])

    async def land(self, robot: str) -> None:
        self._do("land", robot, None, (*self.at_m[robot][:2], 0.0))


def flights(copters: Copters, told: list[str]) -> Flights:
    return Flights(copters, plan_of(loop_of("a", 0.0), loop_of("b", 200.0)).mission, told.append)  # type: ignore[arg-type]


def routes() -> Any:
    return routes_of(plan_of(loop_of("a", 0.0), loop_of("b", 200.0)))


def test_all_climb_then_all_gather_in_layers_then_all_come_down() -> None:
    copters, told = Copters(), list[str]()
    asyncio.run(flights(copters, told).gather(routes()))
    assert told == ["climbing: a, b", "gathering: a, b", "descending: b"]
    assert copters.done == [
        ("climb", "a", ALTITUDE_M),
        ("climb", "b", LAYER),
        ("go", "a", [(-10.0, 0.0, ALTITUDE_M)]),
        ("go", "b", [(190.0, 0.0, LAYER)]),
        ("go", "b", [(190.0, 0.0, ALTITUDE_M)]),
    ]


def test_home_is_in_layers_and_the_lowest_lands_first() -> None:
    copters, told = Copters(), list[str]()
    copters.at_m = {"a": (50.0, 0.0, 25.0), "b": (250.0, 0.0, 25.0)}
    asyncio.run(flights(copters, told).bring_home())
    assert told == ["stopping: a, b", "to their layers: a, b", "flying home: a, b", "landing: a", "landing: b"]
    assert copters.done[2:] == [
        ("go", "a", [(50.0, 0.0, ALTITUDE_M)]),
        ("go", "b", [(250.0, 0.0, LAYER)]),
        ("go", "a", [(0.0, 100.0, ALTITUDE_M)]),
        ("go", "b", [(3.0, 100.0, LAYER)]),
        ("land", "a", None),
        ("land", "b", None),
    ]


def test_the_way_home_by_itself_is_to_the_nearest_rally_point() -> None:
    copters, told = Copters(), list[str]()
    ahead = flights(copters, told)
    copters.home_m = lambda _: (150.0, 300.0, 0.0)  # type: ignore[method-assign]
    way = Trajectory(robot="a", times_s=[0, 10, 20], positions_m=[[151, 0], [159, 0], [151, 0]], loop_start_s=0)
    assert ahead.blocked_home(way) > 0.5
    fleet = replace(ahead._mission.fleet, rally_points=((150.0, -10.0),))
    near = Flights(copters, replace(ahead._mission, fleet=fleet), told.append)  # type: ignore[arg-type]
    assert near.blocked_home(way) == 0.0


def test_one_that_does_not_get_there_brings_all_home() -> None:
    copters, told = Copters(("climb", "b")), list[str]()
    with pytest.raises(LinkError, match="robot b: climb: it does not\ncalled home along free ways: a, b"):
        asyncio.run(flights(copters, told).gather(routes()))
    assert copters.at_m == PAD
    assert copters.done[-1][:2] == ("land", "b")


def test_who_does_not_come_home_is_told_and_the_others_land() -> None:
    copters, told = Copters(("go", "a")), list[str]()
    copters.at_m = {"a": (50.0, 0.0, 25.0), "b": (250.0, 0.0, 25.0)}
    with pytest.raises(LinkError, match=r"^robot a: go: it does not$"):
        asyncio.run(flights(copters, told).bring_home())
    assert copters.at_m["b"] == PAD["b"]
    assert ("land", "a", None) not in copters.done
