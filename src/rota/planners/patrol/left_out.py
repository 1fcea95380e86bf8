"""What plans of a mission leave out since nobody can see it, told before the search begins."""

from __future__ import annotations

from rota.errors import NoPlanFound
from rota.geometry.free_space import demanded_regions, sight_walls
from rota.model.mission import Mission, inner_reach_m
from rota.planners.patrol.ground.fewer_corners import with_fewer_corners
from rota.planners.patrol.ground.problem import common_robot, range_margin
from rota.planners.patrol.ground.sight import Sight
from rota.planners.patrol.ground.standing import has_many_corners, space_for
from rota.planners.patrol.ground.unseeable import MOST_EXCLUDED, Unseeable, ground_asked_for, in_words, unseeable_ground

LEAST_TOLD_M2 = 0.01


def sentence_of_what_is_left_out(mission: Mission) -> str | None:
    """How much nobody can see of what is asked, and where; None for none, and where planning ends with it in any case.

    None as well over ground with so many corners that to know takes as long as planning: the check tells of it.
    """
    if mission.unseeable == "refuse" or has_many_corners(mission):
        return None
    asked_m2 = ground_asked_for(demanded_regions(mission)).area
    robot = common_robot(mission.fleet)
    # where robots keep a little farther off small obstacles they see no more, and that is sooner worked out
    roomy = with_fewer_corners(mission, inner_reach_m(robot.sensor), robot.body_radius_m)
    found = unseen_from_space_of(roomy, mission)
    if roomy is not mission and (found is None or found.m2 >= LEAST_TOLD_M2):
        found = unseen_from_space_of(mission, mission)
    if found is None or not LEAST_TOLD_M2 <= found.m2 <= MOST_EXCLUDED * asked_m2:
        return None
    return f"{in_words(mission, found, asked_m2)}; it is left out"


def unseen_from_space_of(drawn: Mission, mission: Mission) -> Unseeable | None:
    """What nobody sees of what the mission asks from where robots can be as drawn; None where they can be nowhere."""
    regions, robot = demanded_regions(mission), common_robot(mission.fleet)
    try:
        space = space_for(drawn, regions, robot, range_margin(inner_reach_m(robot.sensor)))
    except NoPlanFound:
        return None
    return unseeable_ground(ground_asked_for(regions), Sight(space.sure, sight_walls(mission), robot, 0.0))
