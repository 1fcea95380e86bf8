"""Robots that take over where a plan is changed: who goes on as before, who takes which loop, and from when on."""
