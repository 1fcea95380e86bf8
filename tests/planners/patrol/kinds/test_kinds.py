"""Plans for unlike robots: which fleet is the cheapest by closed forms, who gets what ground, and the check's word."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota import check_plan, make_plan
from rota.errors import MissionError, NoPlanFound
from rota.files.plan_file import plan_from_text, plan_text
from rota.geometry.free_space import demanded_regions
from rota.model.battery_limits import BatteryLimits
from rota.model.fleet import Kind, Robot
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, Zone
from rota.model.plan import Plan
from rota.planners.patrol import PatrolSettings
from rota.planners.patrol.kinds.cheapest import plan_cheapest
from rota.planners.patrol.kinds.cost_bound import cost_bound
from rota.planners.patrol.kinds.division import by_cuts, by_zones, load_of
from rota.planners.patrol.kinds.groups import differs, groups_of
from rota.planners.patrol.kinds.parts import Parts
from rota.planners.patrol.kinds.team import Team
from rota.planning.planner import Request

# as wide as the sensor sees: a robot goes to and fro, some 37 s at 10 m/s and 74 s at 5 m/s
CORRIDOR = Mission(
    name="corridor",
    area=MultiPolygon([box(0, 0, 200, 10)]),
    period_s=50,
    fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=10)),
    planning=PatrolSettings(effort="quick"),
)


def with_kinds(mission: Mission, *kinds: Kind, **values: Any) -> Mission:
    return replace(mission, fleet=replace(mission.fleet, kinds=kinds), **values)


@pytest.mark.parametrize(
    ("fast_cost", "most_slow", "names", "cost"),
    [
        (1.5, None, ["fast-1"], 1.5),
        (3.0, None, ["slow-1", "slow-2"], 2.0),
        (3.0, 1, ["fast-1"], 3.0),
    ],
)
def test_the_cheapest_of_two_kinds_is_taken(
    fast_cost: float, most_slow: int | None, names: list[str], cost: float
) -> None:
    kinds = (Kind(name="slow", cost=1, most=most_slow, speed_m_s=5), Kind(name="fast", cost=fast_cost))
    plan = make_plan(with_kinds(CORRIDOR, *kinds))
    assert [way.robot for way in plan] == names
    assert plan.lower_bound_cost is not None
    assert plan.lower_bound_cost <= cost
    assert check_plan(plan).verdict == "met"
    assert plan_text(plan_from_text(plan_text(plan), "a plan")) == plan_text(plan)
    claims = replace(plan, lower_bound_cost=cost * 1.01)
    assert [wrong.kind for wrong in check_plan(claims).violations] == ["claims that a cheaper fleet cannot do"]


@pytest.mark.parametrize("fails_in_full", [False, True])
def test_fleets_are_tried_with_the_least_effort_before_the_cheapest_is_planned_in_full(fails_in_full: bool) -> None:
    kinds = (Kind(name="slow", cost=1, speed_m_s=5), Kind(name="fast", cost=3))
    mission = with_kinds(CORRIDOR, *kinds).with_effort("normal")
    in_full_one_by_one, plans = [], []

    def search(part: Mission, *, in_full: bool, turns_s: np.ndarray | None = None) -> Plan:
        in_full_one_by_one.append(in_full)
        if in_full and fails_in_full:
            raise NoPlanFound("nothing else is found")
        plans.append(make_plan(part.with_effort("quick")))
        return plans[-1]

    request = Request(
        mission=mission, seed=0, judge=check_plan, progress=lambda share, doing: None, should_stop=lambda: False
    )
    team = Team(request, search)
    plan = plan_cheapest(team)
    assert [way.robot for way in plan] == ["slow-1", "slow-2"]
    assert in_full_one_by_one[0] is False
    assert in_full_one_by_one == sorted(in_full_one_by_one)
    assert True in in_full_one_by_one
    assert check_plan(plan).verdict == "met"


@pytest.mark.slow  # a whole search
def test_a_kind_that_is_too_few_to_do_it_alone_is_not_tried_alone() -> None:
    long = replace(CORRIDOR, area=MultiPolygon([box(0, 0, 800, 10)]))
    mission = with_kinds(long, Kind(name="slow", cost=1, most=1, speed_m_s=5), Kind(name="fast", cost=2))
    tried = []

    def search(part: Mission, *, in_full: bool, turns_s: np.ndarray | None = None) -> Plan:
        tried.append((part.fleet.speed_m_s, part.zones[0].shape.area))
        return make_plan(part)

    request = Request(
        mission=mission, seed=0, judge=check_plan, progress=lambda share, doing: None, should_stop=lambda: False
    )
    team = Team(request, search)
    plan_cheapest(team)
    whole_m2 = mission.area.area
    assert (10, whole_m2) in [(speed, pytest.approx(area_m2)) for speed, area_m2 in tried]
    assert not any(speed == 5 and area_m2 > 0.9 * whole_m2 for speed, area_m2 in tried)


def test_more_robots_than_there_are_of_a_kind_are_found() -> None:
    two = make_plan(with_kinds(CORRIDOR, Kind(name="slow", cost=1, speed_m_s=5)))
    scarce = replace(two.without_bound(), mission=with_kinds(CORRIDOR, Kind(name="slow", cost=1, speed_m_s=5, most=1)))
    (wrong,) = check_plan(scarce).violations
    assert (wrong.kind, wrong.who, wrong.value, wrong.limit) == ("more robots than there are", "slow", 2, 1)


def test_too_few_robots_of_all_kinds_are_refused_with_a_proof() -> None:
    wide = replace(CORRIDOR, area=MultiPolygon([box(0, 0, 2000, 1000)]))
    kinds = (Kind(name="slow", cost=1, most=2, speed_m_s=5), Kind(name="fast", cost=3, most=3))
    with pytest.raises(NoPlanFound, match=r"fleet.kinds: 2 slow, 3 fast cannot do what is asked, proved"):
        make_plan(with_kinds(wide, *kinds))


@pytest.mark.slow  # a whole search
def test_the_bound_on_the_cost_is_that_of_the_cheapest_fleet_that_sweeps_enough() -> None:
    rng = np.random.default_rng(3)
    for _ in range(2):
        cost, speed_m_s, radius_m = rng.uniform(1, 4, 2), rng.uniform(3, 12, 2), rng.uniform(10, 30, 2)
        kinds = [
            Kind(name=f"k{k}", cost=cost[k], speed_m_s=speed_m_s[k], sensor=DiscSensor(radius_m=radius_m[k]))
            for k in range(2)
        ]
        mission = with_kinds(replace(CORRIDOR, area=MultiPolygon([box(0, 0, 900, 700)]), period_s=100), *kinds)
        bound = cost_bound(mission, groups_of(mission.fleet), demanded_regions(mission))
        each_m2 = 2 * radius_m * speed_m_s * 100 + np.pi * radius_m**2  # in a window of a period, and before it
        enough = [
            float(cost @ fleet)
            for fleet in itertools.product(range(40), repeat=2)
            if each_m2 @ fleet >= 900 * 700 * (1 - 1e-9)
        ]
        # proofs of whole numbers of robots of the better kind may ask for more
        assert min(enough) * (1 - 1e-9) <= bound.cost <= min(enough) + cost.max()


def test_listed_robots_get_ground_by_what_they_can_see() -> None:
    area = MultiPolygon([box(0, 0, 300, 10)])
    robots = [Robot(name="slow", speed_m_s=1), Robot(name="fast")]
    mission = replace(CORRIDOR, area=area, period_s=55, fleet=replace(CORRIDOR.fleet, robots=robots))
    plan = make_plan(mission)
    assert {way.robot for way in plan} == {"slow", "fast"}
    assert check_plan(plan).verdict == "met"
    slow_m, fast_m = (np.ptp(plan[name].positions_m[:, 0]) for name in ("slow", "fast"))
    assert slow_m < fast_m / 2


def test_listed_robots_with_nothing_to_do_stay() -> None:
    zones = tuple(
        Zone(name=name, period_s=5, demand="visit", shape=MultiPolygon([box(x, 0, x + 2, 2)]))
        for name, x in (("a", 5), ("b", 190))
    )
    robots = [Robot(name="slow", speed_m_s=1), Robot(name="mid", speed_m_s=3), Robot(name="fast", start=(100, 5))]
    fleet = replace(CORRIDOR.fleet, robots=robots)
    mission = replace(CORRIDOR, zones=zones, period_s=None, fleet=fleet)
    parts = Parts(mission, groups_of(fleet), check_plan, lambda part, in_full: make_plan(part))
    idle = parts.idle(2)
    assert idle.is_met
    assert [(way.robot, way.positions_m.tolist()) for way in idle.plan or ()] == [("fast", [[100, 5]])]
    assert check_plan(make_plan(mission)).verdict == "met"


def test_bodies_of_unlike_robots_keep_to_ground_of_their_own() -> None:
    robots = [Robot(name="small"), Robot(name="large", speed_m_s=1, body_radius_m=1)]
    fleet = Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=10), body_radius_m=0.3, robots=robots)
    plan = make_plan(replace(CORRIDOR, fleet=fleet, area=MultiPolygon([box(0, 0, 240, 10)])))
    assert check_plan(plan).verdict == "met"
    low, high = sorted((plan[name].positions_m[:, 0] for name in ("small", "large")), key=lambda xs: float(xs.min()))
    assert low.max() + 1.3 <= high.min() + 1e-9


@pytest.mark.slow  # plans for each kind, and for both at one place
def test_kinds_that_charge_share_the_places_at_chargers() -> None:
    battery = BatteryLimits(endurance_s=500, recharge_s=500)
    kinds = (
        Kind(name="slow", cost=1, speed_m_s=5, battery=battery),
        Kind(name="fast", cost=5, most=1, battery=battery, sensor=DiscSensor(radius_m=10, name="thermal")),
    )
    zone = Zone(name="hot", period_s=200, shape=MultiPolygon([box(100, 0, 110, 10)]), sensors=("thermal",))
    chargers = (Charger(name="pad", at=(100, 5), places=6),)
    plan = make_plan(with_kinds(CORRIDOR, *kinds, zones=(zone,), chargers=chargers))
    assert check_plan(plan).verdict == "met"
    assert any(way.robot == "fast-1" and way.charges for way in plan)
    one = (replace(chargers[0], places=1),)
    with pytest.raises(NoPlanFound, match="they have 1 place for 2 kinds of robots that charge"):
        make_plan(with_kinds(CORRIDOR, *kinds, zones=(zone,), chargers=one))


def planned_at_one_place(recharge_s: float) -> Plan:
    """The cheapest fleet of a fast robot, dear, and two slow ones, cheap, beside a charger of one place."""
    battery = BatteryLimits(endurance_s=500, recharge_s=recharge_s)
    fast = Kind(name="fast", cost=2, battery=battery)
    slow = [Kind(name=f"slow{v}", cost=0.5, speed_m_s=v, most=1, battery=battery) for v in (5, 6)]
    plan = make_plan(with_kinds(CORRIDOR, fast, *slow, chargers=(Charger(name="pad", at=(100, 5), places=1),)))
    assert check_plan(plan).verdict == "met"
    return plan


def test_kinds_use_one_place_in_turn_where_that_costs_less() -> None:
    assert [way.robot for way in planned_at_one_place(recharge_s=50)] == ["slow5-1", "slow6-1"]


@pytest.mark.slow  # plans for both kinds together and each alone
def test_a_kind_alone_is_planned_where_several_need_more_places_than_there_are() -> None:
    """One robot charges as long as it is away: another kind has no time at the charger."""
    assert {way.robot.split("-")[0] for way in planned_at_one_place(recharge_s=450)} == {"fast"}


def test_the_ground_is_divided_by_what_groups_can_see() -> None:
    zones = tuple(
        Zone(name=name, period_s=10 * (k + 1), shape=MultiPolygon([box(60 * k, 0, 60 * k + 10, 10)]))
        for k, name in enumerate("abc")
    )
    mission = with_kinds(
        replace(CORRIDOR, zones=zones), Kind(name="slow", cost=1, speed_m_s=5), Kind(name="fast", cost=1)
    )
    regions, groups = demanded_regions(mission), groups_of(mission.fleet)
    whole = sum(map(load_of, regions))
    for capacity in (np.array([1.0, 2.0]), np.array([3.0, 1.0])):
        for angle_deg in (0.0, 90.0, 45.0):
            parts = by_cuts(regions, groups, capacity, mission.area, angle_deg, (0, 1))
            asked = np.array([part.asked_m2_s for part in parts])
            assert asked / whole == pytest.approx(capacity / capacity.sum(), rel=1e-6)


def test_zones_far_from_each_other_go_to_different_robots() -> None:
    places = {"a": (0, 20), "b": (15, 30), "c": (180, 20)}
    zones = tuple(
        Zone(name=name, period_s=period_s, shape=MultiPolygon([box(x, 0, x + 10, 10)]))
        for name, (x, period_s) in places.items()
    )
    kinds = Kind(name="slow", cost=1, speed_m_s=5), Kind(name="fast", cost=1)
    mission = with_kinds(CORRIDOR, *kinds, zones=zones, period_s=None)
    groups = groups_of(mission.fleet)
    parts = by_zones(demanded_regions(mission), groups, np.array([1.0, 1.0]), np.array([100.0, 200.0]))
    assert parts is not None
    assert sorted(sorted(region.name for region in part.regions) for part in parts) == [["a", "b"], ["c"]]


def test_only_fleets_whose_robots_differ_are_divided() -> None:
    named = replace(CORRIDOR.fleet, sensor=DiscSensor(radius_m=10, name="thermal"))
    hot = Zone(name="hot", period_s=20, shape=MultiPolygon([box(0, 0, 9, 9)]), sensors=("thermal",))
    assert not differs(CORRIDOR)
    assert not differs(replace(CORRIDOR, fleet=replace(CORRIDOR.fleet, robots=3)))
    assert not differs(replace(CORRIDOR, zones=(hot,), fleet=named))  # all of them are thermal
    unlike = [Robot(name="a"), Robot(name="b", sensor=DiscSensor(radius_m=9))]
    assert differs(replace(CORRIDOR, zones=(hot,), fleet=replace(named, robots=unlike)))


@pytest.mark.parametrize(
    ("fleet", "message"),
    [
        ({"robots": 2}, "fleet.robots: 2 is not allowed; leave it out: kinds are for the cheapest fleet"),
        ({"kinds": [Kind(name="a", cost=1), Kind(name="a", cost=2)]}, "fleet.kinds: 'a' is not allowed; names must be"),
    ],
)
def test_kinds_that_do_not_go_together_are_told(fleet: dict[str, Any], message: str) -> None:
    values: dict[str, Any] = {"speed_m_s": 1, "sensor": DiscSensor(radius_m=1), "kinds": [Kind(name="a", cost=1)]}
    with pytest.raises(MissionError, match=message):
        Fleet(**{**values, **fleet})
