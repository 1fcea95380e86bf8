"""From a mission to a checked plan: the door of every planner, the judge, stopping, progress, the summary."""
