"""From an annealed plan to one that passes the check: bending, detours, further robots."""
