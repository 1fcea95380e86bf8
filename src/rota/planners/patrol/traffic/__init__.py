"""Who passes when: bodies kept apart, and the way from the starts to the loops."""
