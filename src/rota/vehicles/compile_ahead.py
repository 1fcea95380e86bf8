"""The vehicles' kernels compiled before anybody waits for them."""

from __future__ import annotations

from rota.routes.route import RouteStop
from rota.vehicles.models import model_of
from rota.vehicles.motion import Way, Wind
from rota.vehicles.presets import ARDUCOPTER


def fly_a_square() -> None:
    """One motion with its trajectory, and a round in closed form."""
    corners = [(50.0, 0.0), (50.0, 50.0), (0.0, 50.0), (0.0, 0.0)]
    stops = tuple(RouteStop(place_m=(x, y, 20.0), speed_m_s=8.0) for x, y in corners)
    way, model = Way(robot="first run", once=stops[-1:], every_round=stops), model_of(ARDUCOPTER)
    model.round_s(way)
    model.drive(way, Wind()).trajectory(flat=True)
