"""Tours moved as a whole by linear programs: the last metres, and the last slivers of ground."""
