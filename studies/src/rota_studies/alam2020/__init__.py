"""Alam & Bobadilla, Robotics 9(2):47, 2020: its figures made again, and what it leaves open."""
