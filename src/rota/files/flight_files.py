"""Files for the single flights of a plan whose robots charge, and the table that says when each is to start."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path

import numpy as np

from rota.files.atomic_write import write_atomically
from rota.files.spreadsheet_cells import as_cells
from rota.model.plan import Plan
from rota.routes.flights import Flight, plan_of_flights
from rota.routes.served_loops import loop_letter, service_of

TABLE = "flights.csv"
COLUMNS = (
    "files", "robot", "number", "starts_s", "every_s", "lasts_s", "length_m", "serves", "from_charger", "charger",
    "charges_s",
)  # fmt: skip
TAKES_OFF = "takes_off_s"  # one more, where robots take time to climb or to land


def write_flights(
    plan: Plan, folder: str | os.PathLike[str], write: Callable[..., tuple[Path, ...]], *clock: datetime
) -> tuple[Path, ...]:
    """Write the single flights of a plan by ``write``, and ``flights.csv`` beside them; returns all paths.

    clock: the instant of the plan's start, for a ``write`` that takes it, and the flights.

    starts_s: seconds after the plan's start at which the flight first begins. It is below 0 for flights under way at
    that time. It begins again every ``every_s`` seconds; empty: it is flown once. serves: the loop's letter in
    pictures. charges_s leaves out what it takes to land and to climb. Robots that do not charge have their files as
    ever, and no row. Raises as ``write``.
    """
    made, flights = plan_of_flights(plan)
    paths = write(made, folder, *clock, flights=flights) if clock else write(made, folder)
    of_one = len(paths) // max(len(made), 1)  # files
    names = {one.robot: paths[k * of_one : (k + 1) * of_one] for k, one in enumerate(made)}
    own = [files for name, files in names.items() if made[name].charges]
    table = Path(folder) / TABLE
    write_atomically(table, flights_table(plan, flights, own))
    return (*paths, table)


def time_in_table(time_s: float) -> float:
    """A time as the table has it, to the millisecond."""
    return round(time_s, 3)


def flights_table(plan: Plan, flights: Sequence[Flight], files: Sequence[Sequence[Path]]) -> str:
    """The text of the table: a row for each flight, in the order in which they begin; times in seconds to the ms.

    Where robots take time to climb or to land ``takes_off_s`` comes last: when the robot has to leave the ground.
    """
    serves = service_of(flights).serves
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    batteries = [plan.mission.fleet.robot(flight.robot).battery for flight in flights]
    climbs = any(battery.grounding_s > 0 for battery in batteries)
    rows.writerow((*COLUMNS, TAKES_OFF) if climbs else COLUMNS)
    for k in sorted(range(len(flights)), key=lambda k: flights[k].starts_s):
        flight = flights[k]
        length_m = float(np.linalg.norm(np.diff(flight.positions_m, axis=0), axis=1).sum())
        rows.writerow(
            as_cells(
                [
                    " ".join(path.name for path in files[k]),
                    flight.robot,
                    flight.number,
                    time_in_table(flight.starts_s),
                    time_in_table(flight.every_s) or "",
                    time_in_table(flight.lasts_s),
                    round(length_m, 3),
                    loop_letter(serves[k]),
                    flight.from_charger or "",
                    flight.charger,
                    time_in_table(max(flight.charges_s - batteries[k].grounding_s, 0.0)),
                    *([time_in_table(flight.starts_s - batteries[k].climbing_s)] if climbs else []),
                ]
            )
        )
    return text.getvalue()
