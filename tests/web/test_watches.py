"""Live fleets over HTTP: simulated vehicles of a plan, and how a watch ends."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.files.two_robots import two_robots
from tests.web.serving import Server

from rota.check import check_plan
from rota.files.plan_file import plan_text
from rota.live.watch import Watch
from rota.playback.cells import seen_cells
from rota.web.tasks.watching import place_of_entries


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    made = Server(tmp_path_factory.mktemp("watches") / "data")
    yield made
    made.end()


def kept_plan(client: Any) -> str:
    """The plan of two robots, by its id."""
    plan: str = client.post("/api/plans", files={"plan": ("two.rota.json", plan_text(two_robots()).encode())}).json()[
        "id"
    ]
    return plan


@pytest.mark.slow  # goes by real time
def test_a_simulated_fleet_is_watched_until_it_is_stopped(server: Server) -> None:
    with server.client() as client:
        asked = {"plan": kept_plan(client), "settings": {"clock": 20, "faults": "b:dies@15"}, "cells": 400}
        watch = client.post("/api/watches", json=asked).json()
        states, notices, ended, stopped = [], [], None, False
        with client.stream("GET", f"/api/watches/{watch['id']}/events") as stream:
            name = ""
            for line in stream.iter_lines():
                if line.startswith("event: "):
                    name = line[7:]
                elif line.startswith("data: "):
                    data = json.loads(line[6:])
                    {"state": states, "notice": notices}.get(name, []).append(data)
                    ended = data if name == "ended" else ended
                    lost = any(notice["kind"] == "lost" for notice in notices)
                    if lost and states and states[-1]["robots"][1]["lost"] and not stopped:
                        stopped = True
                        assert client.post(f"/api/watches/{watch['id']}/stop").status_code == 200
        assert ended is not None
        assert (ended["state"], ended["plan"]) == ("ended", asked["plan"])
        assert client.post(f"/api/watches/{watch['id']}/stop").status_code == 409
    lost = {robot["name"] for state in states for robot in state["robots"] if robot["lost"]}
    assert lost == {"b"}
    with_ages = [state for state in states if "ages" in state]
    entries = len(seen_cells(two_robots(), check_plan(two_robots()), 400).index)
    assert {len(state["ages"]) for state in with_ages} == {entries}
    assert all(age is None or 0 <= age <= state["time_s"] for state in with_ages for age in state["ages"])


def test_entries_of_a_playback_have_the_ages_of_places_beside_them() -> None:
    plan = two_robots()
    watch, report = Watch(plan), check_plan(plan)
    seen = seen_cells(plan, report, 400)
    place = place_of_entries(watch, seen, [demand.name for demand in report.demands])
    assert (place >= 0).all()
    rows, columns = np.divmod(seen.index, seen.cell_map.inside.shape[1])
    left, _, bottom, _ = seen.cell_map.extent_m
    centres = np.column_stack(
        [left + (columns + 0.5) * seen.cell_map.cell_m, bottom + (rows + 0.5) * seen.cell_map.cell_m]
    )
    away_m = np.hypot(*(watch.places.points_m[place] - centres).T)
    spacing_m = float(np.nanmax(watch.places.spacings_m))
    assert away_m.max() <= spacing_m + seen.cell_map.cell_m


@pytest.mark.parametrize(
    ("asked", "status", "word"),
    [
        ({"link": "smoke"}, 400, "link"),
        ({"plan": "none"}, 404, "no plan"),
        ({"settings": "x"}, 400, "settings"),
        ({"cells": 1}, 400, "cells"),
    ],
)
def test_a_watch_that_makes_no_sense_is_refused(server: Server, asked: Any, status: int, word: str) -> None:
    with server.client() as client:
        answer = client.post("/api/watches", json={"plan": kept_plan(client), **asked})
        assert answer.status_code == status
        assert word in answer.json()["error"]["message"]


def test_a_setting_that_a_link_does_not_take_ends_the_watch_in_words(server: Server, tmp_path: Path) -> None:
    with server.client() as client:
        watch = client.post("/api/watches", json={"plan": kept_plan(client), "settings": ["speed=3"]}).json()
        told = client.get(f"/api/watches/{watch['id']}/events").text
        assert '"state": "failed"' in told
        assert "speed=3" in told
