"""Links to robots: send a route, start, pause, come home, and hear where they are."""
