"""Where the annealing begins: places that see everything, in a short order, joined by shortest paths."""
