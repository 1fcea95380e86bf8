"""Free space, line of sight and shortest paths; shared by the planners only."""
