"""The ground as a grid of cells: what is asked of each, what it is worth, which robots are in it."""
