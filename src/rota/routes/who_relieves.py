"""Which robots that charge relieve others: they come to a loop when somebody leaves it."""

from __future__ import annotations

import numpy as np

from rota.model.plan import Plan
from rota.routes.flights import flights_of, has_flights
from rota.routes.served_loops import service_of

AT_ONCE_S = 1.0  # between who leaves and who comes: a longer pause is one that the plan allows


def robots_that_relieve(plan: Plan) -> frozenset[str]:
    """The names of robots for which somebody holds a post: at one time another one is to leave their loop.

    Nobody holds a post for robots that are launched on circuits, or come to a loop that was left alone for a while.
    Robots whose rounds last unlike long are taken to relieve.
    """
    flights = [flight for way in plan if has_flights(way) for flight in flights_of(way) if flight.every_s > 0]
    if not flights:
        return frozenset()
    service = service_of(flights)
    starts_s, every_s = (np.array([getattr(one, name) for one in flights]) for name in ("starts_s", "every_s"))
    comes_s, leaves_s = starts_s + service.spans_s[:, 0], starts_s + service.spans_s[:, 1]
    loops, names = np.array(service.serves), np.array([one.robot for one in flights])
    apart_s = np.mod(comes_s[:, None] - leaves_s[None] + every_s / 2, every_s) - every_s / 2
    alike = np.abs(every_s[:, None] - every_s[None]) <= AT_ONCE_S / len(flights)
    relieves = (np.abs(apart_s) <= AT_ONCE_S) | ~alike
    relieves &= (loops[:, None] == loops[None]) & (names[:, None] != names[None])
    return frozenset(names[relieves.any(axis=1)].tolist())
