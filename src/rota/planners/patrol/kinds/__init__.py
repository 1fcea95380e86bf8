"""Fleets of unlike robots: the ground is divided among those that are alike, and each part is planned by itself."""
