"""Robots with a bump sensor and a clock."""
