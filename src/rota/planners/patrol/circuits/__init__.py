"""Robots that charge and fly circuits: out from a charger, once round ground of one period, and back."""
