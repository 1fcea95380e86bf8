"""Robots of a swarm as processes of their own, which know only what the others send (Chen et al. 2018, Section 5.3)."""
