"""The pictures of the studies: maps, cells and curves, panel by panel."""
