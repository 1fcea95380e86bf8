"""Robots that sense their neighbours, spread and hold (Chen, Xu, Li, Sensors 18(6):1864, 2018, and better)."""
