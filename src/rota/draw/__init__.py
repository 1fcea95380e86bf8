"""Pictures and films of plans; the only place that imports matplotlib."""
