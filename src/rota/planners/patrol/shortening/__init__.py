"""Shorter or smoother loops for a plan that has as few robots as were found."""
