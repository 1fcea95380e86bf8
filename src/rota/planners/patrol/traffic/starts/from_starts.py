"""A plan of loops led out from the robots' starts: who takes which loop, by which approach, and when all begin."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from rota.errors import MissionError, NoPlanFound
from rota.geometry.free_space import standing_space
from rota.model.arrays import Floats, Ints
from rota.model.mission import Mission, Robot, StartBox, StartPoints
from rota.model.plan import Plan
from rota.planners.patrol.driving.round_starts import start_without_cut
from rota.planners.patrol.driving.timed_line import TimedLine, round_of, start_at, steady
from rota.planners.patrol.traffic.starts.approaches import Approach, first_step_m, joined_trajectory, timed_approach
from rota.planners.patrol.traffic.starts.assignment import earliest_assignment, largest_matching, least_squares
from rota.planners.patrol.traffic.starts.departures import departures_s, together_s
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody
from rota.planners.patrol.traffic.starts.places import MOST_CANDIDATES, in_turn
from rota.planners.patrol.traffic.starts.run_ups import join_in_motion
from rota.planners.patrol.verdict import Judge, robots_in_words, worst_reached


@dataclass(frozen=True, kw_only=True)
class Starts:
    """Who can start where: robots[k] (by its own values) at places_m[k]; None: it is where it is needed."""

    robots: list[Robot]
    places_m: list[Floats | None]


def lead_from_starts(plan: Plan, mission: Mission, judge: Judge | None) -> Plan:
    """The plan's loops, kept in their phases, reached from the mission's starts; its mission becomes ``mission``.

    All loops begin at one moment, when the last robot has arrived; robots leave so as to arrive then. Some moments of
    the common timetable are tried, earliest last arrival first, until the judge passes the plan (None: whatever becomes
    of it). Robots whose jerk is limited join at legs of constant velocity; if no plan passes so, where others do.
    Raises NoPlanFound when a loop cannot be reached or there are too few starts, with the plan as it was; the same when
    bodies would touch on an approach or the judge passes no plan, with the plan that does so; MissionError when a fixed
    fleet does not fit into its box.
    """
    if mission.fleet.unlike_robots[0].motion.jerk_m_s3 is not None:
        with suppress(NoPlanFound):
            return _lead(plan, mission, judge, steadily=True)
    return _lead(plan, mission, judge, steadily=False)


def _lead(plan: Plan, mission: Mission, judge: Judge | None, *, steadily: bool) -> Plan:
    """The same; steadily: robots join loops where these are driven at a constant velocity, if they can."""
    rounds = [round_of(trajectory) for trajectory in plan]
    bare = replace(plan, mission=mission)
    if not rounds:
        return bare
    paths_by_body = PathsByBody(mission)
    starts = starts_of(mission, rounds, paths_by_body, bare)
    entries = entry_choices(rounds, starts)
    times_s = travel_times_s(starts, entries, paths_by_body)
    require_reachable(starts, rounds, times_s[0], bare)
    assignments = [earliest_assignment(times) for times in times_s]
    latest_s = [
        np.inf if who is None else max(times[k, i] for i, k in enumerate(who))
        for who, times in zip(assignments, times_s, strict=True)
    ]
    # the timetable as it was comes last: its phases are exact whatever else fails
    order = [*np.argsort(latest_s, kind="stable")[:5], 0]  # six are worked out and judged
    tried = [(int(s), who, True) for s in dict.fromkeys(order) if (who := assignments[s]) is not None]
    speeds_m_s = np.array([robot.ground_speed_m_s for robot in starts.robots])
    touching: Plan | None = None
    led: Plan | None = None
    while tried:
        shift, who, earliest = tried.pop(0)
        begun = [begin_later(round_, entries.shifts_s[shift], steadily=steadily) for round_ in rounds]
        begun, later_s, run_ups = join_in_motion(begun, starts.robots[0], paths_by_body, steadily=steadily)
        approaches, who = timed_approaches(starts, begun, run_ups, who, paths_by_body, anew=earliest)
        leaves_s = departures_s(approaches, [starts.robots[k].body_radius_m for k in who])
        if leaves_s is None:
            if touching is None:
                touching = with_approaches(bare, starts, who, approaches, together_s(approaches), begun, later_s)
            if earliest:
                tried.append((shift, least_squares(times_s[shift] * speeds_m_s[:, None]), False))
            continue
        led = with_approaches(bare, starts, who, approaches, leaves_s, begun, later_s)
        if judge is None or judge(led).verdict == "met":
            return led
    if led is None or judge is None:
        raise NoPlanFound(
            "from their starts the robots cannot reach their loops without bodies touching, in whatever order they"
            " leave: move the starts apart or away from the loops",
            best=touching,
        )
    raise NoPlanFound(
        f"with the ways from the starts the plan does not pass the check: {worst_reached(judge(led))}", best=led
    )


def with_approaches(
    plan: Plan,
    starts: Starts,
    who: Ints,
    approaches: Sequence[Approach],
    leaves_s: Floats,
    begun: Sequence[TimedLine],
    later_s: Sequence[float],
) -> Plan:
    """The plan whose robots leave their starts at these times and begin their loops at the same moment, or later.

    Robots of a fleet of as few as possible keep the names of their loops; those of a named fleet keep their own.
    """
    arrive_s = (
        float(leaves) + approach.duration_s + approach.runs_up_s - later
        for leaves, approach, later in zip(leaves_s, approaches, later_s, strict=True)
    )
    loops_s = max(0.0, *arrive_s)
    named = plan.mission.fleet.robots is not None
    joined = []
    for i, k in enumerate(who):
        name = starts.robots[k].name if named else plan.trajectories[i].robot
        joined.append(
            (
                k if named else i,
                joined_trajectory(name, approaches[i], float(leaves_s[i]), loops_s + later_s[i], begun[i]),
            )
        )
    return replace(plan, trajectories=tuple(trajectory for _, trajectory in sorted(joined, key=lambda pair: pair[0])))


# ---------------------------------------------------------------- starts


def starts_of(mission: Mission, rounds: Sequence[TimedLine], paths_by_body: PathsByBody, plan: Plan) -> Starts:
    """The robots and their starts; those in a box are spread over the parts of the ground where loops are."""
    fleet = mission.fleet
    robots = list(fleet.robots or (fleet.equal_robot(trajectory.robot) for trajectory in plan))
    if isinstance(fleet.start, StartPoints):
        points = fleet.start.points_m
        if len(points) < len(rounds):
            raise NoPlanFound(
                f"the plan needs {robots_in_words(len(rounds))}, but fleet.start has only {len(points)} of the points"
                " to start from: give more points, or a box",
                best=plan,
            )
        return Starts(
            robots=[fleet.equal_robot(f"start-{k + 1}") for k in range(len(points))],
            places_m=[np.array(point) for point in points],
        )
    places: list[Floats | None] = [None if robot.start is None else np.array(robot.start) for robot in robots]
    if isinstance(fleet.start, StartBox):
        waiting = [k for k, place in enumerate(places) if place is None]
        in_box = places_in_box(fleet.start, robots, places, rounds, paths_by_body, plan)
        for k, place in zip(waiting, in_box, strict=True):
            places[k] = place
    return Starts(robots=robots, places_m=places)


def places_in_box(
    box: StartBox,
    robots: list[Robot],
    places: list[Floats | None],
    rounds: Sequence[TimedLine],
    paths_by_body: PathsByBody,
    plan: Plan,
) -> Floats:
    """Places (n, 2) in the box for the robots that have none yet, as many in each part as loops there still need."""
    body_m = max(robot.body_radius_m for robot in robots)
    paths = paths_by_body.paths(body_m)
    needs = Counter(int(part) for part in paths.part_of(np.array([line.places_m[0] for line in rounds])))
    own = [place for place in places if place is not None]
    if own:
        needs -= Counter(int(part) for part in paths.part_of(np.array(own)))
    parts = sorted(part for part in needs if needs[part] > 0)
    taken_m = np.array(own).reshape(-1, 2)
    in_parts = in_turn(box, [paths.parts[part] for part in parts], [needs[part] for part in parts], body_m, taken_m)
    for part, there in zip(parts, in_parts, strict=True):
        if len(there) == needs[part]:
            continue
        x, y = paths.parts[part].representative_point().coords[0]
        where = f"in the part of the ground round ({x:.2f}, {y:.2f})" if len(paths.parts) > 1 else "in free ground"
        message = no_room(box, len(there), where, needs[part])
        message += ", or points in every part" if len(paths.parts) > 1 else ""
        raise NoPlanFound(message, best=plan) if plan.mission.fleet.robots is None else MissionError(message)
    every = np.vstack([np.zeros((0, 2)), *in_parts])
    short = sum(place is None for place in places) - len(every)
    if short > 0:
        raise NoPlanFound(f"{short} robots start in a part of the ground where there is nothing to do", best=plan)
    return every


def no_room(box: StartBox, room: int, where: str, needed: int) -> str:
    """That a box is too small for the robots that start in it."""
    (x0, y0), (x1, y1) = box.low_m, box.high_m
    return (
        f"fleet.start.box: [[{x0:.6g}, {y0:.6g}], [{x1:.6g}, {y1:.6g}]] has room for {robots_in_words(room)} {where},"
        f" where {needed} {'is' if needed == 1 else 'are'} needed; give a larger box"
    )


def require_room(mission: Mission) -> None:
    """MissionError when the fleet's box has no room for the robots that surely start in it, wherever they must go."""
    fleet = mission.fleet
    if not isinstance(fleet.start, StartBox):
        return
    robots = fleet.unlike_robots
    body_m = max(robot.body_radius_m for robot in robots)
    own_m = np.array([robot.start for robot in robots if robot.start is not None]).reshape(-1, 2)
    needed = len(robots) - len(own_m)
    parts = list(standing_space(mission, body_m).geoms)
    room = sum(len(places) for places in in_turn(fleet.start, parts, [needed] * len(parts), body_m, own_m))
    if room < needed:
        raise MissionError(no_room(fleet.start, room, "in free ground", needed))


def require_reachable(starts: Starts, rounds: Sequence[TimedLine], times_s: Floats, plan: Plan) -> None:
    """NoPlanFound, naming a start and a loop between which no path leads, unless every loop can get a robot."""
    fixed = plan.mission.fleet.robots is not None
    lacking = np.setdiff1d(np.arange(len(rounds)), largest_matching(times_s, np.inf))
    if not len(lacking) and (not fixed or len(starts.robots) == len(rounds)):
        return
    if not len(lacking):
        raise NoPlanFound("there are more robots than loops that their starts can reach", best=plan)
    loop = int(lacking[0])
    x, y = rounds[loop].places_m[0]
    alike = [i for i in range(len(rounds)) if (np.isfinite(times_s[:, i]) == np.isfinite(times_s[:, loop])).all()]
    able = np.flatnonzero(np.isfinite(times_s[:, loop]))
    unable = [k for k in np.flatnonzero(~np.isfinite(times_s[:, loop])) if starts.places_m[k] is not None]
    told = ", ".join(
        f"({place[0]:.6g}, {place[1]:.6g})" for k in unable[:5] if (place := starts.places_m[k]) is not None
    )
    more = f" and {len(unable) - 5} more" if len(unable) > 5 else ""
    raise NoPlanFound(
        f"the part of the ground round ({x:.2f}, {y:.2f}) needs {len(alike)} robot{'s'[: len(alike) > 1]}, but"
        f" {len(able)} can reach it from where they start: no path leads there from {told}{more}",
        best=plan,
    )


# ---------------------------------------------------------------- where and when the loops begin


@dataclass(frozen=True, kw_only=True, eq=False)
class Entries:
    """Where each loop is at some moments of the common timetable: shifts_s (s,), places_m (s, loops, 2)."""

    shifts_s: list[float]
    places_m: Floats


def entry_choices(rounds: Sequence[TimedLine], starts: Starts) -> Entries:
    """Moments of the common timetable, its beginning first: when loops pass nearest to starts, and others evenly."""
    most = int(np.clip(MOST_CANDIDATES // len(rounds), 4, 64))  # moments at which the loops may begin
    longest_s = max(line.duration_s for line in rounds)
    placed = [place for place in starts.places_m if place is not None]
    shifts = [0.0]
    if longest_s > 0:
        if len(placed) * len(rounds) <= most // 2:
            shifts += [nearest_moment_s(round_, place) for round_ in rounds for place in placed]
        shifts += [float(s) for s in np.linspace(0, longest_s, most - len(shifts) + 1)[1:-1]]
    places = [[begin_later(round_, shift).places_m[0] for round_ in rounds] for shift in shifts]
    return Entries(shifts_s=shifts, places_m=np.array(places))


def nearest_moment_s(round_: TimedLine, place_m: Floats) -> float:
    """When a round comes nearest to a place, in a straight line; 0 for a robot that stays."""
    if round_.stays:
        return 0.0
    times_s, places_m, _ = round_
    steps = np.diff(places_m, axis=0)
    squares = (steps**2).sum(axis=1)
    share = np.clip(((place_m - places_m[:-1]) * steps).sum(axis=1) / np.where(squares > 0, squares, 1.0), 0.0, 1.0)
    k = int(np.argmin(np.hypot(*(places_m[:-1] + share[:, None] * steps - place_m).T)))
    return float(times_s[k] + share[k] * (times_s[k + 1] - times_s[k]))


def begin_later(round_: TimedLine, shift_s: float, *, steadily: bool = False) -> TimedLine:
    """The round begun so much later in the common timetable; steadily: without a row that cuts a leg of a curve."""
    begin = start_without_cut if steadily else start_at
    return round_ if round_.stays or shift_s == 0 else begin(round_, shift_s)


def travel_times_s(starts: Starts, entries: Entries, paths_by_body: PathsByBody) -> Floats:
    """Travelling times (s, m, n) in seconds from the m starts to the n loops at s moments, turns aside.

    inf where no path leads, 0 for robots that are where they are needed.
    """
    shifts, loops, _ = entries.places_m.shape
    times_s = np.zeros((shifts, len(starts.robots), loops))
    entries_m = entries.places_m.reshape(-1, 2)
    for body_m in {robot.body_radius_m for robot in starts.robots}:
        placed = {
            k: place
            for k, place in enumerate(starts.places_m)
            if place is not None and starts.robots[k].body_radius_m == body_m
        }
        if not placed:
            continue
        standing = np.array([paths_by_body.standing(starts.robots[k], place) for k, place in placed.items()])
        first_m = np.hypot(*(standing - np.array(list(placed.values()))).T)
        lengths = paths_by_body.paths(body_m).distances(standing, entries_m) + first_m[:, None]
        speeds = np.array([starts.robots[k].ground_speed_m_s for k in placed])
        each = (lengths / speeds[:, None]).reshape(len(placed), shifts, loops)
        times_s[:, list(placed), :] = np.moveaxis(each, 1, 0)
    return times_s


def timed_approaches(
    starts: Starts,
    begun: Sequence[TimedLine],
    run_ups: Sequence[TimedLine],
    who: Ints,
    paths_by_body: PathsByBody,
    *,
    anew: bool,
) -> tuple[list[Approach], Ints]:
    """The approach to each loop with its turns, and who takes it.

    anew: who takes which is chosen anew where turning takes time, unless there are too many approaches to time.
    """

    def approach_of(k: int, i: int) -> Approach:
        robot, start_m, entry_m = starts.robots[k], starts.places_m[k], run_ups[i].places_m[0]
        run_up = None if run_ups[i].stays else run_ups[i]
        if start_m is None:
            return Approach(line=steady(np.zeros(1), entry_m[None]), run_up=run_up)
        onward_m = first_step_m(begun[i].places_m)
        approach = timed_approach(paths_by_body.line(robot, start_m, entry_m, onward_m), robot, onward_m)
        return replace(approach, run_up=run_up)

    turning = not all(robot.turns_at_once for robot in starts.robots)
    if not anew or not turning or len(starts.robots) * len(begun) > 2_500:  # more take too long to be timed
        return [approach_of(int(k), i) for i, k in enumerate(who)], who
    every: dict[tuple[int, int], Approach] = {}
    times_s = np.full((len(starts.robots), len(begun)), np.inf)
    parts = [paths_by_body.paths(robot.body_radius_m) for robot in starts.robots]
    entries_m = np.array([line.places_m[0] for line in begun])
    for k, paths in enumerate(parts):
        start_m = starts.places_m[k]
        reach = np.ones(len(begun), dtype=bool)
        if start_m is not None:
            own = paths.part_of(paths_by_body.standing(starts.robots[k], start_m)[None])[0]
            reach = paths.part_of(entries_m) == own
        for i in np.flatnonzero(reach):
            every[k, int(i)] = approach_of(k, int(i))
            times_s[k, i] = every[k, int(i)].duration_s
    best = earliest_assignment(times_s)
    assert best is not None  # the given one is one
    return [every[int(k), i] for i, k in enumerate(best)], best
