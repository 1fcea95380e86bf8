"""A rehearsal as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, overload

import numpy as np

from rota.model.plan import Plan
from rota.rehearsal.outcome import Rehearsal
from rota.rehearsal.table import conditions_text, percent_text

if TYPE_CHECKING:
    from rota.draw.availability_picture import Figure


@overload
def draw_rehearsal(plan: Plan, made: Rehearsal, path: str | Path) -> None: ...
@overload
def draw_rehearsal(plan: Plan, made: Rehearsal, path: None = None) -> Figure: ...
def draw_rehearsal(plan: Plan, made: Rehearsal, path: str | Path | None = None) -> Figure | None:
    """Draw a rehearsal of a plan to ``path`` as PNG, SVG or PDF by its suffix, or else as a figure to show.

    On the map each place has the share of the time in which it was within its period; beside it is that of all that is
    asked, hour by hour. Below them is how much was left in batteries at the least, where there are any. A file appears
    whole or not at all. Raises RotaError for another suffix or a folder that cannot be written to.
    """
    from rota.draw import Availability, LeastLeft, draw_availability

    visits = np.array([each.demand == "visit" for each in made.demands])[made.places_demand]
    runs = "1 run" if made.runs == 1 else f"{made.runs} runs"
    told = " · ".join(conditions_text(made).split(", "))
    availability = Availability(
        header=f"{runs} of {made.conditions.hours:g} h · {told}",
        points_m=made.places_m[~visits],
        shares=made.places_available[~visits],
        visits={
            made.demands[made.places_demand[place]].name: float(made.places_available[place])
            for place in np.flatnonzero(visits)
        },
        hours=made.parts_h,
        demands=tuple(
            (f"{each.name}: {percent_text(each.available)} %", shares.mean(axis=0))
            for each, shares in zip(made.demands, made.parts_available, strict=True)
        ),
        whole=(f"all: {percent_text(made.available)} %", made.over_time),
        batteries=()
        if made.charging is None
        else tuple(
            LeastLeft(each.robot, each.levels_s, each.reserve_s, each.endurance_s) for each in made.charging.robots
        ),
    )
    if path is None:
        return draw_availability(plan.mission, availability)
    draw_availability(plan.mission, availability, path)
    return None
