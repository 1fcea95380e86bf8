"""Closed tours and the timed rounds that robots drive on them: the types that all stages share."""
