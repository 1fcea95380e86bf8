"""Keeping bodies apart: phases, directions, waits, and lanes beside each other."""
