"""Names that ROS takes for a fleet's robots."""

from __future__ import annotations

import re

from rota.errors import PlanError
from rota.model.plan import Plan

MAP_FRAME = "map"
LONGEST_NAMESPACE = 200  # DDS counts 255 letters of a topic, of which the topic's own name takes some


def namespaces(plan: Plan) -> tuple[str, ...]:
    """A namespace for each robot, in the plan's order: its name, with _ for what ROS takes no names with.

    ROS 2 takes ASCII letters, digits and single underscores, and no digit first. Raises PlanError for robots whose
    names then are equal, or longer than 200 letters.
    """
    found: dict[str, str] = {}
    for trajectory in plan:
        name = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]", "_", trajectory.robot)).strip("_") or "robot"
        if name[0].isdigit():
            name = f"robot_{name}"
        if name in found:
            raise PlanError(
                f"robot {trajectory.robot}: ROS knows it as {name}, as it does robot {found[name]}; rename one of them"
            )
        if len(name) > LONGEST_NAMESPACE:
            raise PlanError(
                f"robot {trajectory.robot[:40]}...: a name of {len(name)} letters; at most {LONGEST_NAMESPACE} are"
                " allowed in ROS"
            )
        found[name] = trajectory.robot
    return tuple(found)


def body_frame(namespace: str) -> str:
    """The frame of a robot's body, of which tf tells where it is on the map."""
    return f"{namespace}/base_link"
