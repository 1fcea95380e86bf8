"""Simulated annealing over all tours at once."""
