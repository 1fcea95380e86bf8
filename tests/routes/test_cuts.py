"""Points that cut a leg of a curve are left out, and those that part a curve from what follows stay."""

from __future__ import annotations

import numpy as np
import pytest

from rota import DiscSensor, Trajectory
from rota.routes.moments import earlier_by, go_on, join_ways, way_before, without_cuts

TANGENTS_S = np.array([0.25, 0.5, 0.5, 0.25])  # of a corner: halves at its ends


def rounded(sides_s: tuple[float, float]) -> Trajectory:
    """A rectangle at 2 m/s whose corners are parabolas of 1.5 s; sides of 0 s are none."""
    ways, legs = np.array([(2, 0), (0, 2), (-2, 0), (0, -2)], float), list[tuple[float, np.ndarray]]()
    for k, (way, after) in enumerate(zip(ways, np.roll(ways, -1, axis=0), strict=True)):
        legs += [(sides_s[k % 2], way)] if sides_s[k % 2] else []
        legs += [(lasts_s, way + (after - way) * part / 3) for part, lasts_s in enumerate(TANGENTS_S)]
    times_s = np.cumsum([0.0, *(lasts_s for lasts_s, _ in legs)])
    places_m = np.cumsum([np.zeros(2), *(lasts_s * way for lasts_s, way in legs)], axis=0)
    places_m[-1] = places_m[0]
    return Trajectory(robot="a", times_s=times_s, positions_m=places_m)


def two_rounds(loop: Trajectory) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    times_s = np.append(loop.times_s, loop.times_s[1:] + loop.loop_duration_s)
    return times_s, np.vstack([loop.positions_m, loop.positions_m[1:]]), np.zeros(len(times_s) - 1)


LOOPS = [rounded((4.0, 1.0)), rounded((4.0, 0.0))]


@pytest.mark.parametrize("loop", LOOPS)
def test_no_point_of_a_curve_is_left_out(loop: Trajectory) -> None:
    way = two_rounds(loop)
    assert all(np.array_equal(*both) for both in zip(without_cuts(way, range(len(way[0]))), way, strict=True))


@pytest.mark.parametrize("share", [1e-3, 0.2, 0.45, 0.93])
@pytest.mark.parametrize("loop", LOOPS)
def test_a_point_amid_a_tangent_is_left_out_amid_a_half_of_one_too(loop: Trajectory, share: float) -> None:
    times_s, places_m, changes_m_s2 = two_rounds(loop)
    legs = np.flatnonzero(np.isin(np.round(np.diff(times_s), 9), TANGENTS_S))
    left_out = 0
    for leg in legs[(legs > 3) & (legs < len(times_s) - 5)]:
        at_s = times_s[leg] + share * (times_s[leg + 1] - times_s[leg])
        cut = np.insert(times_s, leg + 1, at_s), np.insert(places_m, leg + 1, loop.at(at_s), axis=0)
        without = without_cuts((*cut, np.append(changes_m_s2, 0.0)), [int(leg) + 1])
        assert np.array_equal(without[0], times_s)
        assert np.array_equal(without[1], places_m)
        left_out += 1
    assert left_out > 20


@pytest.mark.parametrize("loop", LOOPS)
def test_moments_of_a_loop_that_began_amid_a_curve_are_those_of_one_that_did_not(loop: Trajectory) -> None:
    """What is driven from a second change of plan on, and what was driven before both, has no point of the first."""
    sensor, again_s, told_s, curves = DiscSensor(radius_m=1), 2.03, 12.0, 0
    for at_s in np.arange(0.03, loop.loop_duration_s, 0.11):
        leg = np.searchsorted(loop.times_s, at_s, side="right") - 1
        if loop.times_s[leg + 1] - loop.times_s[leg] >= 1:
            continue  # amid a side
        later = go_on(loop, at_s)
        assert len(go_on(later, again_s).times_s) == len(go_on(loop, at_s + again_s).times_s), at_s
        first = earlier_by(way_before(loop, sensor, at_s + loop.loop_duration_s, told_s), again_s)
        both = join_ways(first, way_before(later, sensor, again_s, again_s), told_s + again_s)
        plain = way_before(loop, sensor, at_s + again_s + loop.loop_duration_s, told_s + again_s)
        assert both.times_s == pytest.approx(plain.times_s, abs=1e-9), at_s
        curves += 1
    assert curves > 20
