"""A fleet watched live in a process of its own: what robots say, and how old every place is, for the page's map."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from rota.check import check_plan
from rota.errors import RotaError
from rota.exports import placed_plan
from rota.links.link import Link
from rota.links.link_settings import make_link
from rota.links.sending import routes_for, send_all, start_all
from rota.live.notices import Notice
from rota.live.ready import make_ready
from rota.live.session import Session
from rota.live.watch import Watch
from rota.model.arrays import Ints
from rota.model.plan import Plan
from rota.playback.cells import NO_CELL, SeenCells, seen_cells
from rota.web.refusal import Json
from rota.web.tasks.context import Context
from rota.web.tasks.show import kept_plan

STATE_EVERY_S, AGES_EVERY_S = 0.5, 1.0  # of the link's time, which is real time but for simulated vehicles

Tell = Callable[[Json, bytes], None]


def watch_fleet(context: Context, asked: Json, tell: Tell, stop: threading.Event) -> Json:
    """Watch until it is stopped; returns how it ended: {event: ended, state: ended | failed, message}."""
    try:
        plan = kept_plan(context, asked)
        if asked["origin"] is not None:
            plan = placed_plan(plan, asked["origin"])
        link = make_link(asked["link"], plan, asked["settings"])
        make_ready()
        fleet = _Fleet(plan, asked["cells"], tell)
        asyncio.run(_watch(plan, link, fleet, stop))
    except RotaError as error:
        return {"event": "ended", "state": "failed", "message": str(error)}
    return {"event": "ended", "state": "ended", "message": None}


async def _watch(plan: Plan, link: Link, fleet: _Fleet, stop: threading.Event) -> None:
    """Give vehicles that live in this process their routes, and follow all."""
    try:
        await link.open()
        if link.in_process:
            routes = routes_for(plan, link)
            await send_all(link, routes)
            await start_all(link, routes)
        await Session(fleet.watch, None, fleet.show).follow(link, should_stop=stop.is_set)
    finally:
        await link.close()


class _Fleet:
    """A watch whose notices and states are told, with ages for the cells of the plan's playback."""

    def __init__(self, plan: Plan, cells: int, tell: Tell) -> None:
        self.watch = Watch(plan)
        self._tell = tell
        self._number = {trajectory.robot: k for k, trajectory in enumerate(plan)}
        report = check_plan(plan)
        names = [demand.name for demand in report.demands]
        self._place = place_of_entries(self.watch, seen_cells(plan, report, cells), names)
        self._next_state_s = self._next_ages_s = -np.inf

    def show(self, notices: list[Notice]) -> None:
        """What the session calls at every tick."""
        for notice in notices:
            told = {"time_s": notice.time_s, "kind": notice.kind, "about": notice.about, "text": notice.text}
            self._tell({"event": "notice"}, json.dumps({**told, "is_alarm": notice.is_alarm}).encode())
        now_s = self.watch.now_s
        if now_s >= self._next_state_s:
            self._next_state_s = now_s + STATE_EVERY_S
            self._tell({"event": "state"}, json.dumps(self._state(now_s), allow_nan=False).encode())

    def _state(self, now_s: float) -> Json:
        """Where all robots are, how it stands with the demands, and once a second how old every cell is."""
        state = self.watch.state()
        told: Json = {"time_s": now_s, "known_s": state.known_s, "robots": [], "dropped": state.dropped}
        for robot in state.robots:
            x_m, y_m = robot.place_m or (None, None)
            values = {key: _finite(value) for key, value in asdict(robot).items() if key != "place_m"}
            lost = robot.standing == "lost"
            told["robots"].append({**values, "robot": self._number[robot.name], "x_m": x_m, "y_m": y_m, "lost": lost})
        told["demands"] = [{key: _finite(value) for key, value in asdict(d).items()} for d in state.demands]
        if now_s >= self._next_ages_s:
            self._next_ages_s = now_s + AGES_EVERY_S
            ages_s = np.maximum(now_s - self.watch.last_seen_s, 0.0)[self._place]
            told["ages"] = [
                None if place < 0 else age for place, age in zip(self._place, ages_s.round(1).tolist(), strict=True)
            ]
        return told


def place_of_entries(watch: Watch, seen: SeenCells, names: list[str]) -> Ints:
    """For each entry (n,) of a playback the place of the watch that is nearest and asked for alike; -1: none is."""
    places = watch.places
    left, _, bottom, _ = seen.cell_map.extent_m
    columns = seen.cell_map.inside.shape[1]
    rows, across = np.divmod(seen.index, columns)
    centres = np.column_stack(
        [left + (across + 0.5) * seen.cell_map.cell_m, bottom + (rows + 0.5) * seen.cell_map.cell_m]
    )
    found = np.full(len(seen.index), -1, np.int64)
    for k, demand in enumerate(places.demands):
        if demand.name not in names:
            continue
        entries = np.flatnonzero(seen.demand == names.index(demand.name))
        own = np.flatnonzero(places.demand == k)
        if not len(own) or not len(entries):
            continue
        if seen.index[entries[0]] == NO_CELL:
            found[entries] = own[0]
        else:
            found[entries] = own[cKDTree(places.points_m[own]).query(centres[entries])[1]]
    return found


def _finite(value: Any) -> Any:
    """A value, or None for a number that JSON does not have."""
    return None if isinstance(value, float) and not np.isfinite(value) else value
