"""Bytes to types and back: mission files, maps, plan files, and what robots read."""
