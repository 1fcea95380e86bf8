"""What robots drive: routes without a clock out of trajectories, and trajectories out of routes."""
