"""What the bounce planner knows of a plan beside the plan itself, as sentences for people."""

from __future__ import annotations

import numpy as np
from shapely import LineString, union_all

from rota.model.arrays import Floats
from rota.model.mission import DiscSensor, Mission
from rota.model.plan import Plan
from rota.planners.bounce.chosen_group import Choice
from rota.planners.bounce.coverage import Coverage
from rota.planners.bounce.group_count import TooMany, count_groups
from rota.planners.bounce.monitoring import Watch
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.bounce.rattles import rattling_robots

MOST_COUNTING = 1_000_000  # units of work to count groups, for a sentence


def groups_sentence(watch: Watch, robots: int) -> str:
    """How many ways bouncing robots have to monitor all zones without contact, if that is counted soon."""
    try:
        groups = count_groups(watch.cycles, watch.sees, most_work=MOST_COUNTING)
    except TooMany:
        return "Their periodic groups are not counted: that would take long."
    many = f"{groups:,} periodic group" + ("s" if groups != 1 else "")
    if robots == 1:
        return f"1 robot has {many} in which every zone is visited."
    return f"{robots} robots have {many} in which every zone is visited and no two meet, as long as turns are exact."


def proof_sentence(mission: Mission, choice: Choice) -> str | None:
    """Whether the worst gap is the shortest there is; None where another purpose was asked for."""
    if BounceSettings.of(mission).purpose != "worst_gap" or choice.chosen is None:
        return None
    among = (
        "of all groups"
        if BounceSettings.of(mission).method == "improved"
        else "of those that Algorithm 2 as printed keeps"
    )
    if len(choice.chosen.transient) or any(robot.start is not None for robot in mission.fleet.robots or ()):
        among = "of all groups that robots come to from their starts"
    if choice.proved:
        return f"The worst gap, in steps, is the shortest {among}, proved."
    return f"The worst gap, in steps, is the best found, not proved to be the shortest {among}: {choice.unproved}."


def entered_sentence(coverage: Coverage, robots: int, duration_s: float) -> str:
    """How many of their cells bouncing robots enter, and what that takes."""
    entered, count = int(coverage.covered.sum()), len(coverage.covered)
    who = f"{robots} robot" + ("s enter" if robots != 1 else " enters")
    touched, jumped = int(coverage.contacts.sum()), int((coverage.jumps >= 0).sum())
    contacts = f"{touched} contact" + "s" * (touched != 1) + " of two robots"
    turns = f"{jumped} turn" + "s" * (jumped != 1) + " by the clock"
    taken = f"{coverage.steps} steps, {duration_s:.1f} s, with {contacts} and {turns}"
    return f"{who} {entered} of {count} cells ({coverage.share:.1%}) in {taken}."


def pace_sentence(own_s: Floats, lasts_s: Floats) -> str:
    """What keeping in step costs. own_s: (t, m) what each robot needs for each step; lasts_s: (t,) what they last."""
    if not len(lasts_s):
        return "No robot moves."
    share = float((own_s / lasts_s[:, None]).mean())
    low, high = f"{lasts_s.min():.3g}", f"{lasts_s.max():.3g}"
    lasting = f"{low} s each" if low == high else f"{low} to {high} s"
    return f"Robots keep in step: steps last {lasting}, of which a robot needs {share:.0%} in the mean."


def swept_sentence(plan: Plan) -> str:
    """How much of the floor bodies pass over, and sensors come over: a cell counts as covered when it is entered."""
    mission = plan.mission
    blocking = union_all([obstacle.shape for obstacle in mission.obstacles if obstacle.blocks_motion])
    floor = mission.area.difference(blocking)
    ways = [LineString(np.vstack([t.positions_m[:, :2], t.positions_m[-1:, :2]])) for t in plan]
    robots = [mission.fleet.robot(trajectory.robot) for trajectory in plan]
    bodies = union_all([way.buffer(robot.body_radius_m) for way, robot in zip(ways, robots, strict=True)])
    sentence = f"Bodies pass over {bodies.intersection(floor).area / floor.area:.1%} of the floor"
    if all(isinstance(robot.sensor, DiscSensor) for robot in robots):
        discs = union_all([way.buffer(robot.sensor.reach_m) for way, robot in zip(ways, robots, strict=True)])
        sentence += f", discs of the sensors over {discs.intersection(floor).area / floor.area:.1%} (walls aside)"
    return f"{sentence}: a cell counts as covered when a robot comes to its centre."


def rattling_sentence(plan: Plan) -> str | None:
    """Which robots hardly leave their places on their loops, or go to and fro on one line; None: none does."""
    found = rattling_robots(plan)
    if not found:
        return None
    still = [name for name, extent_m in found.items() if extent_m == 0]
    moving = [f"{name} over {extent_m:.2g} m" for name, extent_m in found.items() if extent_m > 0]
    parts = []
    if still:
        predicate = "stay in one cell and turn" if len(still) > 1 else "stays in one cell and turns"
        parts.append(f"{', '.join(still)} {predicate} there for ever")
    if moving:
        parts.append(f"{', '.join(moving)} {'rattle' if len(moving) > 1 else 'rattles'} to and fro for ever")
    return (
        f"{'; '.join(parts)}: a limit cycle, too, but one that the first inexact turn may end; another bouncing angle"
        " or a robot more may do without."
    )
