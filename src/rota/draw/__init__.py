"""Pictures and films of plans; the only place that imports matplotlib."""

from rota.draw.plan_film import animate_plan
from rota.draw.plan_picture import draw_gaps, draw_plan, draw_routes

__all__ = ["animate_plan", "draw_gaps", "draw_plan", "draw_routes"]
