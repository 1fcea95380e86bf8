"""Plans for what is seen from single places, with rounds that differ."""
