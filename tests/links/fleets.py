"""Plans by hand for the tests of links, and what they ask of reports."""

from __future__ import annotations

from shapely import MultiPolygon, box

from rota.links.link import Link, Report
from rota.model.mission import DiscSensor, Fleet, GeoPoint, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory
from rota.routes.route import Route, route_of

ORIGIN = GeoPoint(lat=48.1, lon=11.5)
ALTITUDE_M = 25.0


def loop_of(robot: str, x_m: float) -> Trajectory:
    """10 m to the loop at 5 m/s, then 60 m x 20 m at 4 m/s with a wait of 3 s at its second corner: 45 s in all."""
    return Trajectory(
        robot=robot,
        times_s=[0, 2, 17, 20, 25, 40, 45],
        positions_m=[[x_m - 10, 0], [x_m, 0], [x_m + 60, 0], [x_m + 60, 0], [x_m + 60, 20], [x_m, 20], [x_m, 0]],
        loop_start_s=2,
    )


def staying(robot: str) -> Trajectory:
    """20 m in 4 s, and there for ever."""
    return Trajectory(robot=robot, times_s=[0, 4], positions_m=[[0, 60], [20, 60]], loop_start_s=4)


def plan_of(*trajectories: Trajectory, origin: GeoPoint | None = ORIGIN) -> Plan:
    sensor = DiscSensor(radius_m=40)
    mission = Mission(
        name="quay",
        area=MultiPolygon([box(-300, -300, 900, 300)]),
        obstacles=(Obstacle(shape=box(150, 150, 160, 160), blocks="motion"),),
        zones=(Zone(name="gate", shape=box(0, 0, 50, 50), period_s=60),),
        origin=origin,
        fleet=Fleet(
            speed_m_s=8,
            sensor=sensor,
            robots=tuple(Robot(name=t.robot, speed_m_s=8, sensor=sensor) for t in trajectories),
            altitude_m=ALTITUDE_M,
        ),
    )
    return Plan(mission=mission, trajectories=trajectories)


def three() -> Plan:
    return plan_of(loop_of("a", 0.0), loop_of("b", 200.0), staying("c"))


def routes_of(plan: Plan) -> list[Route]:
    return [route_of(trajectory, ALTITUDE_M) for trajectory in plan]


async def send_and_start(link: Link, plan: Plan) -> None:
    await link.open()
    for route in routes_of(plan):
        await link.send_route(route)
        assert await link.differences(route) == ()
    for route in routes_of(plan):
        await link.start(route.robot)


async def reports_until(link: Link, time_s: float) -> list[Report]:
    taken = []
    async for report in link.reports():
        taken.append(report)
        if report.time_s >= time_s:
            break
    return taken


def dropped(link: Link) -> int:
    """How many messages a link has dropped."""
    return sum(rejected.messages for rejected in link.rejections.values())
