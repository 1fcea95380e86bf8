"""A small mission with a plan, made by the server's interface alone."""

from __future__ import annotations

import httpx
from tests.web.drawing import COMPILING_MS

SMALL = {
    "rota": 1,
    "name": "small",
    "area": [[0, 0], [40, 0], [40, 30], [0, 30]],
    "period_s": 60,
    "fleet": {"robots": "fewest", "speed_m_s": 5, "sensor": {"shape": "disc", "radius_m": 15}},
    "patrol": {"effort": "quick"},
}
_made: dict[str, str] = {}


def planned_mission(url: str) -> str:
    """The id of a mission on a server, which is planned there once; it is not to be changed."""
    if url not in _made:
        _made[url] = newly_planned(url)
    return _made[url]


def newly_planned(url: str, name: str = "small") -> str:
    """The id of another mission, of this name, that has a plan."""
    with httpx.Client(base_url=url, timeout=60) as client:
        mission = (
            client.post("/api/missions", json={"document": {**SMALL, "name": name}}).raise_for_status().json()["id"]
        )
        job = client.post("/api/jobs", json={"mission": mission}).raise_for_status().json()["id"]
        with client.stream("GET", f"/api/jobs/{job}/events", timeout=COMPILING_MS / 1000) as events:
            for _ in events.iter_lines():
                pass  # they end when the job ends
        assert client.get(f"/api/jobs/{job}").json()["state"] == "done"
    return str(mission)
