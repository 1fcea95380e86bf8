"""Many plans in one go: missions by planners, settings and seeds, each planned and checked, into one table."""
