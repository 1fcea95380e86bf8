"""Links to robots: send a route, start, pause, come home, and hear where they are."""

from rota.links.link import Link, Report
from rota.route import Route, RouteStop

__all__ = ["Link", "Report", "Route", "RouteStop"]
