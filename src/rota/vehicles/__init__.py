"""What a vehicle's own firmware makes of a route: the way into it, timed motion out of it."""
