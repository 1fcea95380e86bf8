"""Posts: places at which robots stay that take turns, and places that need none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
import shapely

from rota.errors import NoPlanFound
from rota.model.mission import Charger
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.relief.slots import Slot
from rota.planners.patrol.verdict import Judge

SOONER = (1.0, 0.8, 0.65, 0.5)  # times the period of posts and circuits that serve others on their ways
MOST_POSTS = 3  # for which robots are tried that come past some of them
INSIDE = 0.01  # of how wide a zone is, that a post is from its border


def posts_of(problem: Problem, chargers: Sequence[Charger]) -> list[Trajectory]:
    """A robot that stays in each zone, where it is nearest to a charger; none where zones are many."""
    if len(problem.regions) > MOST_POSTS:
        return []
    places, chargers_m = [], shapely.MultiPoint([charger.at for charger in chargers])
    for region in problem.regions:
        room = shapely.intersection(region.shape, problem.space)
        inner = room.buffer(-INSIDE * np.sqrt(room.area))
        places.append(shapely.shortest_line(room if inner.is_empty else inner, chargers_m).coords[0])
    return [
        Trajectory(robot=f"post {k + 1}", times_s=np.zeros(1), positions_m=np.array([place]))
        for k, place in enumerate(places)
    ]


def with_fewer_posts(
    plan: Plan, slots: Sequence[Slot], plan_of: Callable[[Sequence[Slot], float], Plan], judge: Judge
) -> Plan:
    """The plan without posts past which others come on their ways often enough, if that takes fewer robots.

    Those that have other posts may come sooner for that, as long as it takes no robot more.
    """
    posts = [slot for slot in slots if slot.line.stays]
    for post in posts if len(slots) > 1 and len(posts) <= MOST_POSTS else ():
        for times in SOONER:
            rest = [
                replace(slot, most_s=times * slot.most_s) if slot.line.stays else slot
                for slot in slots
                if slot is not post
            ]
            with suppress(NoPlanFound):
                found = plan_of(rest, len(plan))
                if len(found) < len(plan) and judge(found).verdict == "met":
                    return with_fewer_posts(found, rest, plan_of, judge)
    return plan
