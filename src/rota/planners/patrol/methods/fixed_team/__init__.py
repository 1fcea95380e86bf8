"""A fixed team: plans for a given number of robots with the smallest worst ratio of gap to period."""
