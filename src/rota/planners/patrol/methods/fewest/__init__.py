"""Tours with as few robots as the search finds: team sizes tried upwards and downwards."""
