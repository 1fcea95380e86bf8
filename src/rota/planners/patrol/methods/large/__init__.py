"""Large ground in districts: planned each by itself, so that the work grows with the area."""
