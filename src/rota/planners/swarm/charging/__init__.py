"""Swarms whose robots leave for a charger in turns and rejoin, while the rest close the gap."""
