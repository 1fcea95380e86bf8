"""Pictures and films of plans; the only place that imports matplotlib."""

from rota.draw.availability_picture import Availability, draw_availability
from rota.draw.cells_picture import draw_cells
from rota.draw.comparison_picture import Panel, draw_comparison
from rota.draw.least_left import LeastLeft
from rota.draw.plan_film import animate_plan
from rota.draw.plan_picture import draw_gaps, draw_plan, draw_routes
from rota.draw.sweep_picture import draw_sweep

__all__ = [
    "Availability",
    "LeastLeft",
    "Panel",
    "animate_plan",
    "draw_availability",
    "draw_cells",
    "draw_comparison",
    "draw_gaps",
    "draw_plan",
    "draw_routes",
    "draw_sweep",
]
