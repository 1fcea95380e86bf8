"""Servers for tests: in this process by starlette's client, and as `rota serve` runs them, on a free port."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
from starlette.testclient import TestClient
from tests.warm_process import address_of_one
from tests.web.warm_workers import workers

from rota.web.app import make_app
from rota.web.limits import Limits
from rota.web.security import Guard

HOST = "127.0.0.1:8321"
ROOT = Path(__file__).parents[2]
Json = dict[str, Any]

# one robot sees all of it from where it stands
SQUARE: Json = {
    "rota": 1,
    "name": "square",
    "area": [[0, 0], [6, 0], [6, 6], [0, 6]],
    "period_s": 60,
    "fleet": {"robots": "fewest", "speed_m_s": 2, "sensor": {"shape": "disc", "radius_m": 5}},
    "planner": "patrol",
    "patrol": {"effort": "quick"},
}
# the search goes on for long after its first plan
YARD: Json = {
    **SQUARE,
    "name": "yard",
    "area": [[0, 0], [80, 0], [80, 60], [50, 60], [50, 40], [0, 40]],
    "obstacles": [[[20, 12], [32, 12], [32, 20], [20, 20]]],
    "zones": [{"name": "gate", "period_s": 20, "ring": [[65, 45], [80, 45], [80, 60], [65, 60]]}],
    "fleet": {"robots": "fewest", "speed_m_s": 5, "sensor": {"shape": "disc", "radius_m": 4}},
    "patrol": {"effort": "high"},
}


@contextmanager
def serving(
    data: Path, limits: Limits | None = None, token: str | None = None, *, usual: bool = False
) -> Iterator[TestClient]:
    """A client of a server of this folder, which loads nothing ahead; its workers are copies unless `usual`."""
    guard = Guard(hosts=frozenset([HOST]), token=token)
    app = make_app(data, guard, limits, prepares=False)
    with (
        workers(copied=not usual),
        TestClient(app, base_url=f"http://{HOST}", raise_server_exceptions=False) as client,
    ):
        yield client


def kept(client: TestClient | httpx.Client, document: Json) -> str:
    """A mission that is kept, by its id."""
    made = client.post("/api/missions", json={"document": document})
    assert made.status_code == 201, made.text
    mission: str = made.json()["id"]
    return mission


def started(client: TestClient | httpx.Client, document: Json, **asked: Any) -> str:
    """A job for a mission, by its id."""
    made = client.post("/api/jobs", json={"mission": kept(client, document), **asked})
    assert made.status_code == 201, made.text
    job: str = made.json()["id"]
    return job


def job_when(client: TestClient | httpx.Client, job: str, *states: str, within_s: float = 120.0) -> Json:
    """A job once it is in one of these states."""
    return waited(client, job, lambda shown: shown["state"] in states, within_s)


def job_with_plan(client: TestClient | httpx.Client, job: str, within_s: float = 120.0) -> Json:
    """A job once it has a first plan."""
    return waited(client, job, lambda shown: shown["best"] is not None, within_s)


def waited(client: TestClient | httpx.Client, job: str, holds: Any, within_s: float) -> Json:
    end_s = time.monotonic() + within_s
    while True:
        shown: Json = client.get(f"/api/jobs/{job}").json()
        if holds(shown):
            return shown
        assert time.monotonic() < end_s, f"{shown}"
        time.sleep(0.02)


# loading planning ahead of the first request is for people who wait
LEAN = """
import sys
from functools import partial
from rota.__main__ import main
from rota.web import app, serving
sys.path.insert(0, sys.argv.pop(1))
from tests.web.warm_workers import begin_with_copies
begin_with_copies(sys.argv.pop(1))
app.POOL_SIZE = 1
serving.make_app = partial(serving.make_app, prepares=False)
main()
"""


class Server:
    """`rota serve` as a process of its own, on a free port.

    Unless it is to be `usual`, it loads nothing ahead, its workers are copies of a process that has loaded what they
    need, and it reads, checks and draws one thing at a time.
    """

    def __init__(self, data: Path, *options: str, port: int = 0, usual: bool = False) -> None:
        program = ["-m", "rota"] if usual else ["-c", LEAN, str(ROOT), address_of_one()]
        serve = ["serve", "--no-open", "--port", str(port), "--data", str(data), *options]
        self.process = subprocess.Popen([sys.executable, *program, *serve], stderr=subprocess.PIPE, text=True)
        assert self.process.stderr is not None
        self.said: list[str] = []
        for line in self.process.stderr:
            self.said.append(line)
            if found := re.search(r"http://\S+?:\d+/", line):
                self.url = found[0].rstrip("/")
                self.token = (re.findall(r"token=(\S+)", line) or [None])[0]
                return
        raise AssertionError("".join(self.said))

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self.url.rsplit(":", 1)[1])

    def client(self) -> httpx.Client:
        """A client of it."""
        return httpx.Client(base_url=self.url, timeout=60)

    def end(self, how: int = signal.SIGTERM) -> int:
        """End it; returns its exit code."""
        self.process.send_signal(how)
        self.process.communicate(timeout=60)
        return self.process.returncode
