"""The methods by the names that a mission may give, and where each is: a new method is a module and a line here.

A method is a function of a search's context; see ``methods.method``. None is loaded before it is asked for. Other
distributions offer theirs by an entry point of the group ``rota.patrol_methods``.
"""

from __future__ import annotations

from rota.model.planner_registry import offers

METHODS = {
    "tours": "rota.planners.patrol.methods.tours:fewest_robots_anywhere",
    "sequential": "rota.planners.patrol.methods.sweeping.search:sweep_sequentially",
    "sun2019": "rota.planners.patrol.methods.sun2019.search:fewest_robots_by_stages",
    **offers("rota.patrol_methods"),
}

OTHERS = (
    ""
    if "parallel" in METHODS
    else "parallel and decomposition come with the distribution rota-studies, which is not installed;"
    " `pip install ./studies` in a checkout of Rota installs it"
)

# the settings that a method has of its own: a block with its name below those of patrol, in mission and plan files
METHOD_SETTINGS = {"sun2019": "rota.planners.patrol.methods.sun2019.mission_settings:Sun2019"}
