"""Plans for robots that keep to the lanes of a graph: fastest ways between places, rounds, and who drives which."""
