"""A fleet with a fixed number of robots: the smallest worst ratio of gap to period."""
