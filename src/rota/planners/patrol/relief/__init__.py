"""Robots that charge: whose loop each drives when, so that one is there before another one leaves."""
