"""Whether zones name sensors that robots have, and no two of them ask for the same ground by different ones."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

from rota.model.fleet import Fleet


def sensor_faults(zones: Sequence[Any], fleet: Fleet) -> Iterator[tuple[str, str]]:
    """What is wrong with the sensors that a mission's zones name: the field at fault and a message.

    One that robots have unless said may be named where none of those listed has it: they may all be lost.
    """
    usual = () if fleet.kinds else (fleet,)
    known = {robot.sensor.name for robot in (*fleet.unlike_robots, *usual)} - {None}
    for k, zone in enumerate(zones):
        if zone.sensors and not known & set(zone.sensors):
            have = f"there are {', '.join(sorted(map(str, known)))}" if known else "give the sensor of one this name"
            yield f"zones[{k}].sensors", f"{', '.join(zone.sensors)}: no robot has such a sensor; {have}"
    asked = [(k, zone) for k, zone in enumerate(zones) if zone.period_s is not None and zone.demand == "every_point"]
    for (_, one), (k, other) in itertools.combinations(asked, 2):
        if set(one.sensors) != set(other.sensors) and one.shape.intersection(other.shape).area > 0:
            yield (
                f"zones[{k}].sensors",
                f"zone {other.name} overlaps zone {one.name}, for which other sensors count: where zones overlap the"
                " smallest period alone rules; let them lie side by side",
            )
