# mypy: disable-error-code="no-any-return"
"""Compiled decisions of robots that know others from messages: late ones, some of which are lost.

Every robot tells its place and velocity at every step. What it told at step s reaches another one ``delay`` steps
later, or never; lost messages are drawn for each pair and step from the seed, and of ``MOST_LOST_IN_ROW`` + 1 in a row
one arrives. A robot heeds the last message it has of each other one, as old as it is, and its own place as it is.

Where the last filter watches and news may be late, no robot gains more than ``MOST_SPEED_GAIN`` of its top speed from
one step to the next. All know that: one that told of standing still cannot have gone far since. So heaps open, in which
nobody could stir as long as everybody may be anywhere within steps at full speed.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free
from rota.model.arrays import Floats
from rota.planners.swarm.baseline_kernels import decide_virtual_force, decide_voronoi
from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.free_ground_kernels import clear_load, load_with_disc
from rota.planners.swarm.kernels import cell_of
from rota.planners.swarm.reciprocal_kernels import decide_reciprocal, sample_key
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.state import Decisions, Grid, Hearing, Robots, Snapshot

MOST_LOST_IN_ROW = 8
MOST_SPEED_GAIN = 0.15  # of the top speed, from one step to the next
OWN, RECIPROCAL, VORONOI, VIRTUAL_FORCE, SETTLE = -1, 0, 1, 2, 3
NUMBER_OF = {
    decide_reciprocal: RECIPROCAL,
    decide_voronoi: VORONOI,
    decide_virtual_force: VIRTUAL_FORCE,
    decide_settle: SETTLE,
}


class Belief(NamedTuple):
    """Room of one thread for what one robot believes of itself and of the robots near it, as controllers take it.

    robots: m of them, itself first. grid: in which these stand in one cell. spread_m: (m,) how far each may have gone
    since it told of itself. out: (3, 1) what is decided.
    """

    robots: Robots
    grid: Grid
    spread_m: Floats
    out: Floats


class DelayedNews(NamedTuple):
    """What robots have told each other.

    past: (h, 4, n) x, y, vx, vy by number in the fleet, those told at step s at s modulo h. step_m: (n,) the longest
    step of each robot. belief: room of the thread that decides.
    """

    hearing: Hearing
    past: Floats
    step_m: Floats
    belief: Belief


class Filtering(NamedTuple):
    """Whether the last filter is applied, and how far off it must look.

    widest_m: the largest body, the longest step of any robot and the farthest that one may have gone unheard.
    """

    safe: bool
    widest_m: float


@allocation_free
def is_lost(seed: int, listener: int, teller: int, step: int, lost: float) -> bool:
    """Whether what one robot told another at a step never arrives."""
    key = sample_key(seed ^ (listener + 1) * 0x5851F42D, teller, step)
    return bool(np.float64(key >> np.uint64(11)) * (1.0 / 9007199254740992.0) < lost)


@allocation_free
def age_of(seed: int, listener: int, teller: int, step: int, hearing: Any) -> int:
    """How many steps ago the news was told that the listener has of the teller at a step."""
    age = hearing.delay_steps
    if hearing.lost > 0.0:
        oldest = hearing.delay_steps + MOST_LOST_IN_ROW
        while age < oldest and is_lost(seed, listener, teller, step - age, hearing.lost):
            age += 1
    return age


@allocation_free
def gone_m(age: int, told_m: float, most_m: float) -> float:
    """How far a robot may have gone in ``age`` steps since it told of a step of told_m; no step exceeds most_m."""
    gone = 0.0
    for k in range(1, age + 1):
        gone += min(most_m, told_m + k * MOST_SPEED_GAIN * most_m)
    return gone


@allocation_free
def no_faster(vx: float, vy: float, speed: float) -> tuple[float, float]:
    """The velocity, made as short as the speed where it is longer: the filter allows every share of what it allows."""
    length = math.sqrt(vx * vx + vy * vy)
    return (vx * speed / length, vy * speed / length) if length > speed else (vx, vy)


@allocation_free
def most_round(grid: Any) -> int:
    """The most robots in any cell and those beside it."""
    most, stride = 0, grid.columns + 2
    for j in range(1, grid.rows + 1):
        for i in range(1, grid.columns + 1):
            c, count = j * stride + i, 0
            for row in range(-1, 2):
                count += grid.start[c + row * stride + 2] - grid.start[c + row * stride - 1]
            most = max(most, count)
    return most


@allocation_free
def look_round(i: int, snapshot: Any, news: Any) -> None:
    """Write robot i and what it has heard of robots near it into its belief, as if all stood in its cell alone."""
    robots, grid, rule, belief = snapshot.robots, snapshot.grid, snapshot.rule, news.belief
    known, start, spread_m, past = belief.robots, belief.grid.start, belief.spread_m, news.past
    known.x[0], known.y[0], known.vx[0], known.vy[0] = robots.x[i], robots.y[i], robots.vx[i], robots.vy[i]
    known.kind[0], known.name[0] = robots.kind[i], robots.name[i]
    spread_m[0] = 0.0
    count, stride, listener = 1, grid.columns + 2, robots.name[i]
    c = cell_of(robots.x[i], robots.y[i], grid)
    for row in range(-1, 2):
        for j in range(grid.start[c + row * stride - 1], grid.start[c + row * stride + 2]):
            if j == i:
                continue
            teller = robots.name[j]
            age = age_of(rule.seed, listener, teller, snapshot.step, news.hearing)
            news_then = past[(snapshot.step - age) % past.shape[0]]
            known.x[count], known.y[count] = news_then[0, teller], news_then[1, teller]
            known.vx[count], known.vy[count] = news_then[2, teller], news_then[3, teller]
            known.kind[count], known.name[count] = robots.kind[j], teller
            told_m = math.sqrt(news_then[2, teller] ** 2 + news_then[3, teller] ** 2) * rule.time_step_s
            spread_m[count] = gone_m(age, told_m, news.step_m[teller])
            count += 1
    start[c - stride - 1], start[c - stride + 2] = 0, 0
    start[c - 1], start[c + 2] = 0, count
    start[c + stride - 1], start[c + stride + 2] = count, count


@allocation_free
def load_with_told(snapshot: Any, hearing: Any, past: Any) -> None:
    """Load the places with robots' discs as messages tell of them; the keepers of the places listen as a single robot.

    past: as in ``DelayedNews``.
    """
    robots, graph = snapshot.robots, snapshot.grid.place_graph
    listener = robots.x.shape[0]
    clear_load(graph)
    for i in range(robots.x.shape[0]):
        sensor = snapshot.kinds.sensor_m[robots.kind[i]]
        if sensor > 0.0:
            teller = robots.name[i]
            age = age_of(snapshot.rule.seed, listener, teller, snapshot.step, hearing)
            news_then = past[(snapshot.step - age) % past.shape[0]]
            load_with_disc(news_then[0, teller], news_then[1, teller], sensor, graph)


@allocation_free
def decide_from_delayed_news(
    begin: int, end: int, controller: int, filtering: Any, snapshot: Any, news: Any, decisions: Any, room: Any
) -> None:
    """New velocities of the robots begin..end - 1 from what each of them has heard, filtered as ``Filtering`` says.

    controller OWN: what stands in the decisions is filtered. news: ``DelayedNews``; room: of one thread.
    """
    robots, kinds, belief = snapshot.robots, snapshot.kinds, news.belief
    known = Snapshot(snapshot.step, belief.robots, kinds, belief.grid, snapshot.moving, snapshot.rule)
    own = Decisions(belief.out[0], belief.out[1], belief.out[2])
    for i in range(begin, end):
        look_round(i, snapshot, news)
        own.vx[0], own.vy[0], own.nearest2[0] = decisions.vx[i], decisions.vy[i], 0.0
        if controller == RECIPROCAL:
            decide_reciprocal(0, 1, known, own, room)
        elif controller == VORONOI:
            decide_voronoi(0, 1, known, own, room)
        elif controller == VIRTUAL_FORCE:
            decide_virtual_force(0, 1, known, own, room)
        elif controller == SETTLE:
            decide_settle(0, 1, known, own, room)
        if filtering.safe:
            filter_velocities(0, 1, known, filtering.widest_m, belief.spread_m, own, room)
            if news.hearing.delay_steps > 0 or news.hearing.lost > 0.0:
                speed = math.sqrt(robots.vx[i] * robots.vx[i] + robots.vy[i] * robots.vy[i])
                most = speed + MOST_SPEED_GAIN * kinds.speed_m_s[robots.kind[i]]
                own.vx[0], own.vy[0] = no_faster(own.vx[0], own.vy[0], most)
        decisions.vx[i], decisions.vy[i] = own.vx[0], own.vy[0]
