"""What plans of a mission leave out since nobody can see it, told before the search begins."""

from __future__ import annotations

from rota.errors import NoPlanFound
from rota.geometry.free_space import demanded_regions, sight_walls
from rota.model.mission import Mission, inner_reach_m
from rota.planners.patrol.ground.problem import common_robot, range_margin
from rota.planners.patrol.ground.sight import Sight
from rota.planners.patrol.ground.standing import has_many_corners, space_for
from rota.planners.patrol.ground.unseeable import MOST_EXCLUDED, ground_asked_for, in_words, unseeable_ground


def sentence_of_what_is_left_out(mission: Mission) -> str | None:
    """How much nobody can see of what is asked, and where; None for none, and where planning ends with it in any case.

    None as well over ground with so many corners that to know takes as long as planning: the check tells of it.
    """
    if mission.unseeable == "refuse" or has_many_corners(mission):
        return None
    regions, robot = demanded_regions(mission), common_robot(mission.fleet)
    try:
        space = space_for(mission, regions, robot, range_margin(inner_reach_m(robot.sensor)))
    except NoPlanFound:
        return None
    asked = ground_asked_for(regions)
    found = unseeable_ground(asked, Sight(space.sure, sight_walls(mission), robot, 0.0))
    if not 0.01 <= found.m2 <= MOST_EXCLUDED * asked.area:  # less ground is not told of
        return None
    return f"{in_words(mission, found, asked.area)}; it is left out"
