"""Timed routes for teams of robots that must keep watching a whole area, and an independent check of every plan."""
