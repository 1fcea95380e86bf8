"""The three traditional methods: parallel scanning, sequential scanning, area decomposition. The baselines."""
