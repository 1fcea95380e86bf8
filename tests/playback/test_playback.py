"""Playbacks against brute force and against the check."""

from __future__ import annotations

import re
from base64 import b64decode
from dataclasses import replace

import numpy as np
import pytest
from shapely import Point, box, union_all
from tests.files.with_mass import with_mass
from tests.live.two_robots import two_robots
from tests.playback.container_reader import unpack
from tests.playback.plans import spreading, yard
from tests.playback.reference import ages_looked_up_s, ages_s, centres_m

from rota import check_plan, replan
from rota.check.revisits import worst_gaps_s
from rota.model.mission import Obstacle
from rota.model.plan import Plan
from rota.playback import page
from rota.playback.cells import NO_CELL
from rota.playback.container import pack
from rota.playback.page import page_text
from rota.playback.playback import playback_of

STEP_S = 0.01


@pytest.mark.parametrize("plan", [yard(), spreading()], ids=["yard", "spreading"])
def test_ages_are_those_of_looking_all_the_time(plan: Plan) -> None:
    header, arrays = unpack(playback_of(plan, check_plan(plan), cells=300))
    points = arrays["cell_index"] != NO_CELL
    places_m = centres_m(header, arrays["cell_index"][points])
    assert len(places_m) > 100
    for time_s in (2.5, 31.7):
        exact, looked = ages_s(header, arrays, time_s)[points], ages_looked_up_s(plan, places_m, time_s, STEP_S)
        # a place may come into range between two looks, for less than a step
        with np.errstate(invalid="ignore"):
            near = np.where(np.isinf(exact) & np.isinf(looked), 0.0, looked - exact)
        assert np.isfinite(near).mean() > 0.99
        assert (near >= -1e-4).all()
        assert np.quantile(near, 0.98) <= STEP_S + 1e-4, time_s


def test_a_zone_that_names_a_sensor_is_seen_by_who_has_one() -> None:
    plan = two_robots(thermal=True)
    header, arrays = unpack(playback_of(plan, check_plan(plan), cells=300))
    names = [demand["name"] for demand in header["demands"]]
    heat = np.isin(arrays["cell_demand"], [names.index("left"), names.index("gate")])
    robots = [
        {
            header["robots"][k]["name"]
            for i in np.flatnonzero(own)
            for k in arrays["sight_robot"][slice(*bounds(arrays, i))]
        }
        for own in (heat, ~heat)
    ]
    assert robots == [{"b"}, {"a", "b"}]


def bounds(arrays: dict[str, np.ndarray], entry: int) -> tuple[int, int]:
    first, last = arrays["sight_offsets"][entry : entry + 2].tolist()
    return first, last


def test_ages_go_back_behind_the_change_where_a_plan_takes_over() -> None:
    before = two_robots()
    found = replan(before, at_s=107.0, lost=["b"], should_stop=lambda: True)
    header, arrays = unpack(playback_of(found.plan, found.report, cells=300))
    points = arrays["cell_index"] != NO_CELL
    looked = ages_looked_up_s(before, centres_m(header, arrays["cell_index"][points]), 107.0, STEP_S)
    assert np.isfinite(looked).all()
    near = looked + arrays["cell_before_s"][points]
    assert (near >= -1e-6).all()
    assert np.quantile(near, 0.98) <= STEP_S + 1e-6
    (gate,) = arrays["cell_before_s"][~points]
    assert gate == pytest.approx(90.4 - 107)  # both leave it, from x = 48 to 52, after 90.4 s at 5 m/s
    assert (header["seam"]["at_s"], header["seam"]["lost"]) == (107.0, ["b"])
    assert {way["robot"] for way in header["seam"]["ways"]} == {"a", "b"}


def test_robots_with_motion_are_played_where_they_are() -> None:
    plan = with_mass()
    moving = plan.trajectories[0]
    header, arrays = unpack(playback_of(plan, check_plan(plan), cells=300))
    first, end = arrays["corner_offsets"][:2]
    times_s = np.linspace(0, moving.times_s[-1], 3000)
    played = [
        np.interp(times_s, arrays["corner_time_s"][first:end], arrays[f"corner_{axis}_m"][first:end]) for axis in "xy"
    ]
    assert np.linalg.norm(np.column_stack(played) - moving.at(times_s), axis=1).max() < 0.05 + 1e-4
    assert (header["robots"][0]["loop_start_s"], header["robots"][0]["end_s"]) == (
        moving.loop_start_s,
        moving.times_s[-1],
    )


def test_worst_gaps_are_the_checks() -> None:
    plan = yard()
    report = check_plan(plan)
    header, arrays = unpack(playback_of(plan, report, cells=2000))
    points = arrays["cell_index"] != NO_CELL
    periods = np.array([demand["period_s"] for demand in header["demands"]])[arrays["cell_demand"]]
    gaps_s = worst_gaps_s(plan, centres_m(header, arrays["cell_index"][points])) / periods[points]
    assert arrays["cell_worst"][points] == pytest.approx(gaps_s, rel=1e-6)
    for k, demand in enumerate(report.demands):
        mine = arrays["cell_worst"][arrays["cell_demand"] == k] * demand.period_s
        assert mine.max(initial=0.0) <= demand.worst_gap_s * (1 + 1e-6)
    (visit,) = np.flatnonzero(~points)
    assert header["demands"][arrays["cell_demand"][visit]]["name"] == "shed"
    assert arrays["cell_worst"][visit] * 90 == pytest.approx(report.demands[2].worst_gap_s)


def test_a_sight_ends_where_the_worst_gap_begins() -> None:
    # the largest age over two rounds of all loops is the worst gap
    plan = yard()
    header, arrays = unpack(playback_of(plan, check_plan(plan), cells=60))
    periods = np.array([demand["period_s"] for demand in header["demands"]])[arrays["cell_demand"]]
    clock, oldest = header["clock"], np.zeros(len(periods))
    for time_s in np.arange(clock["end_s"] - 253.0, clock["end_s"], 0.05):  # 253 = 11 * 23
        oldest = np.maximum(oldest, ages_s(header, arrays, float(time_s)))
    worst_s = arrays["cell_worst"] * periods
    seen = np.isfinite(worst_s)
    assert seen.any()
    assert (oldest[~seen] > 253).all()
    assert oldest[seen] == pytest.approx(worst_s[seen], abs=0.06)


def test_what_nobody_can_see_is_excluded_and_nothing_is_asked_where_no_period_is() -> None:
    plan = yard()
    pit = Obstacle(shape=box(76, 40, 90, 54).difference(box(80, 42, 81.6, 52)))  # no body fits in there
    fleet = replace(plan.mission.fleet, body_radius_m=1.0)
    walled = replace(plan, mission=replace(plan.mission, obstacles=(*plan.mission.obstacles, pit), fleet=fleet))
    header, arrays = unpack(playback_of(walled, check_plan(walled), 20_000))
    hidden_m = centres_m(header, arrays["excluded_index"])
    inside = ((hidden_m > [80, 42]) & (hidden_m < [81.6, 52])).all(axis=1)
    all_m = centres_m(header, np.arange(header["grid"]["columns"] * header["grid"]["rows"]))
    assert inside.sum() == ((all_m > [80, 42]) & (all_m < [81.6, 52])).all(axis=1).sum() > 20
    assert not set(arrays["excluded_index"].tolist()) & set(arrays["cell_index"].tolist())
    unasked = replace(plan, mission=replace(plan.mission, period_s=None))
    header, arrays = unpack(playback_of(unasked, check_plan(unasked), 2000))
    assert {header["demands"][k]["name"] for k in arrays["cell_demand"]} == {zone.name for zone in plan.mission.zones}


def test_the_share_in_range_over_time() -> None:
    plan = spreading()
    header, arrays = unpack(playback_of(plan, check_plan(plan), cells=20_000))
    times_s, shares = arrays["coverage_time_s"], arrays["coverage_share"]
    assert times_s[0] == 0
    assert times_s[-1] == 10
    ground = plan.mission.area
    at_first = box(2, 2, 8, 8).union(Point(8, 5).buffer(4, quad_segs=64)).area / 200  # a has not joined
    assert shares[0] == pytest.approx(at_first, abs=2e-3)
    ends = [Point(2, 8).buffer(4, quad_segs=64), box(9, 2, 15, 8), Point(17, 5).buffer(4, quad_segs=64)]
    assert shares[-1] == pytest.approx(union_all(ends).intersection(ground).area / 200, abs=2e-3)
    # b leaves later
    left = union_all([ends[0], ends[2]]).intersection(ground).area / 200
    assert header["coverage"]["at_rest"] == pytest.approx(left, abs=1e-4)


def test_a_page_has_fewer_cells_where_it_would_be_too_large(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = two_robots()
    report = check_plan(plan)
    whole = packed_bytes(page_text(plan, report, cells=8000))
    monkeypatch.setattr(page, "MOST_BYTES", whole // 2)
    assert whole // 3 < packed_bytes(page_text(plan, report, cells=8000)) <= whole // 2


def packed_bytes(text: str) -> int:
    found = re.search(r'id="playback">([^<]*)<', text)
    assert found
    return len(b64decode(found[1]))


def test_a_file_of_a_playback_is_read_as_it_was_written() -> None:
    arrays = {"a": np.array([1.5, np.inf]), "b": np.arange(3, dtype=np.uint16), "none": np.empty(0, np.float32)}
    data = pack({"name": "Löschplatz </script>"}, arrays)
    header, again = unpack(data)
    assert header["name"] == "Löschplatz </script>"
    assert all((again[name] == arrays[name]).all() and again[name].dtype == arrays[name].dtype for name in arrays)
    begin = len(data) - sum(-(-array.nbytes // 8) * 8 for array in arrays.values())
    assert begin % 8 == 0
    for wrong in (b"", b"ROTAPLAX" + data[8:], data[:8] + b"\x02" + data[9:]):
        with pytest.raises(ValueError, match="playback"):
            unpack(wrong)
