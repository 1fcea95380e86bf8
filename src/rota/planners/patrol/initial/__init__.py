"""First tours: who shares which ground, where robots stand, in which order places are visited."""
