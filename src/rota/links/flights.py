"""A safe beginning and end for robots that fly: up, to where their routes begin, and home again, never across anything.

All climb before anybody sets out, each to its own layer where ways come close; all have arrived before anybody
descends. On the way home they land layer by layer, the lowest first.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial

import numpy as np
import shapely

from rota.errors import LinkError
from rota.links.free_ways import LayeredWay, layered_ways
from rota.links.link import Link
from rota.model.mission import Mission
from rota.model.plan import Trajectory
from rota.routes.route import Route

Calls = Mapping[str, Callable[[], Awaitable[None]]]

LOOKED_FROM = 500  # moments of a trajectory
CALLED_HOME = "called home along free ways: "


class Flights:
    """The beginning and the end of a mission's flights over a link whose robots fly.

    tell: called with a sentence when a stage begins.
    """

    def __init__(self, link: Link, mission: Mission, tell: Callable[[str], None]) -> None:
        self._link, self._mission, self._tell = link, mission, tell

    def ways_to(self, routes: Sequence[Route]) -> tuple[LayeredWay, ...]:
        """The ways from where robots are to where their routes begin. LinkError for those that have not said where."""
        ends = {}
        for route in routes:
            x, y, _ = route.start_m
            ends[route.robot] = (self._place_m(route.robot), (x, y))
        return layered_ways(self._mission, ends)

    def blocked_home(self, trajectory: Trajectory) -> float:
        """The share of its time, 0 to 1, from which a straight way home crosses what blocks motion.

        Home is where it took off, or the rally point that is nearer.
        """
        home_m = self._link.home_m(trajectory.robot)
        blocking = [obstacle.shape for obstacle in self._mission.obstacles if obstacle.blocks_motion]
        if home_m is None or not blocking:
            return 0.0
        times_s = np.linspace(0.0, float(trajectory.times_s[-1]), LOOKED_FROM)
        from_m = trajectory.at(times_s)[:, :2]
        homes_m = np.array([home_m[:2], *self._mission.fleet.rally_points])
        far_m = np.hypot(*np.moveaxis(homes_m - from_m[:, None], -1, 0))
        ways = shapely.linestrings(np.stack([from_m, homes_m[far_m.argmin(axis=1)]], axis=1))
        return float(np.mean(shapely.intersects(ways, shapely.union_all(blocking))))

    async def gather(self, routes: Sequence[Route]) -> None:
        """Let all hover where their routes begin.

        Raises LinkError where one does not get there, and CancelledError: all others are brought home before.
        """
        ways, link = self.ways_to(routes), self._link
        at_m = {way.robot: way.height_m for way in ways}
        high = [route for route in routes if at_m[route.robot] != route.start_m[2]]
        stages = {
            "climbing": {way.robot: partial(link.climb, way.robot, way.height_m) for way in ways},
            "gathering": {way.robot: partial(link.go, way.robot, way.stops_m) for way in ways if way.stops_m},
            "descending": {route.robot: partial(link.go, route.robot, [route.start_m]) for route in high},
        }
        try:
            for told, calls in stages.items():
                if faults := (await self._stage(told, calls))[1]:
                    raise LinkError("\n".join((*faults, *await self._brought_home())))
        except asyncio.CancelledError:
            raise asyncio.CancelledError("\n".join(await self._brought_home())) from None

    async def bring_home(self) -> None:
        """Let all that fly stop, fly home in layers and land, the lowest layer first.

        Raises LinkError with a line for each that did not come home; the others do all the same.
        """
        link = self._link
        standing = [name for name in link.robots if link.latest(name) is not None and not link.is_in_air(name)]
        fly = [name for name in link.robots if name not in standing]
        homes_m = {name: link.home_m(name) for name in fly if link.latest(name) is not None}
        known_m = {name: home_m[:2] for name, home_m in homes_m.items() if home_m is not None}
        lost = [f"robot {name}: it has not said where it or its home is" for name in fly if name not in known_m]

        async def stage(told: str, calls: Calls) -> set[str]:
            done, faults = await self._stage(told, calls)
            lost.extend(faults)
            return done

        able = await stage("stopping", {name: partial(link.pause, name) for name in known_m})
        ways = layered_ways(
            self._mission, {name: (self._place_m(name), known_m[name]) for name in known_m if name in able}
        )
        up = {way.robot: [(*way.places_m[0], way.height_m)] for way in ways}
        able = await stage("to their layers", {name: partial(link.go, name, to_m) for name, to_m in up.items()})
        far = {way.robot: way.stops_m for way in ways if way.stops_m}
        able -= far.keys() - await stage(
            "flying home", {name: partial(link.go, name, to_m) for name, to_m in far.items() if name in able}
        )
        for height_m in sorted({way.height_m for way in ways}):
            lands = [way.robot for way in ways if way.robot in able and way.height_m == height_m]
            await stage("landing", {name: partial(link.land, name) for name in lands})
        # whoever is on the ground may be armed
        await stage("landing", {name: partial(link.land, name) for name in standing})
        if lost:
            raise LinkError("\n".join(lost))

    async def _brought_home(self) -> list[str]:
        """What came of bringing all home, as lines."""
        called = CALLED_HOME + ", ".join(self._link.robots)
        try:
            await self.bring_home()
        except LinkError as error:
            return [called, *str(error).splitlines()]
        return [called]

    async def _stage(self, told: str, calls: Calls) -> tuple[set[str], list[str]]:
        """Let all do something at once; who did it, and what became of the others."""
        if calls:
            self._tell(f"{told}: {', '.join(calls)}")
        outcomes = await asyncio.gather(*(call() for call in calls.values()), return_exceptions=True)
        for outcome in outcomes:
            if isinstance(outcome, BaseException) and not isinstance(outcome, LinkError):
                raise outcome
        pairs = dict(zip(calls, outcomes, strict=True))
        return {name for name, outcome in pairs.items() if outcome is None}, [str(o) for o in pairs.values() if o]

    def _place_m(self, robot: str) -> tuple[float, float]:
        report = self._link.latest(robot)
        if report is None:
            raise LinkError(f"robot {robot}: it has not said where it is")
        return report.position_m[0], report.position_m[1]
