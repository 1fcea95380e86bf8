"""What a watch is made of: everything that happens to it, in order. Logs hold these, and nothing else decides."""

from __future__ import annotations

from typing import NamedTuple

from rota.links.link import Fault, Mode


class Heard(NamedTuple):
    """A report that holds: where robot number ``robot`` of the plan said it was at ``time_s``; it came at ``at_s``."""

    at_s: float
    robot: int
    time_s: float
    x_m: float
    y_m: float
    height_m: float
    battery: float | None
    mode: Mode | None


class Dropped(NamedTuple):
    """So many messages were dropped since the last tick, for one fault; ``example``: what the first of them held."""

    fault: Fault
    messages: int
    example: str


class Tick(NamedTuple):
    """It is ``now_s`` seconds since the plan's start; what came before is looked at."""

    now_s: float


Event = Heard | Dropped | Tick
