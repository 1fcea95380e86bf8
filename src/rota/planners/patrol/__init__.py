"""Closed routes, periods per zone, the fewest robots (Sun et al., Sensors 19(9):1994, 2019, and better)."""
