"""The methods by the names that a mission may give, and where each is: a new method is a module and a line here.

A method is a function of a search's context; see ``methods.method``. None is loaded before it is asked for.
"""

from __future__ import annotations

METHODS = {
    "tours": "rota.planners.patrol.methods.tours:fewest_robots_anywhere",
    "parallel": "rota.planners.patrol.methods.sweeping.search:sweep_in_parallel",
    "sequential": "rota.planners.patrol.methods.sweeping.search:sweep_sequentially",
    "decomposition": "rota.planners.patrol.methods.sweeping.search:sweep_decomposed",
    "sun2019": "rota.planners.patrol.methods.sun2019.search:fewest_robots_by_stages",
}

# the settings that a method has of its own: a block with its name below those of patrol, in mission and plan files
METHOD_SETTINGS = {"sun2019": "rota.planners.patrol.methods.sun2019.mission_settings:Sun2019"}
