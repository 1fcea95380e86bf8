"""The methods of the planner: each makes a whole plan from a problem laid out."""
