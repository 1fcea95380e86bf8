"""A watch on a terminal: a table of robots and demands that refreshes, and the notices above it."""

from __future__ import annotations

import time
from types import TracebackType

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from rota.live.notices import DemandState, FleetState, Notice, RobotState, notice_line, seconds
from rota.live.watch import Watch

REFRESH_S = 0.5
MOST_ROBOTS = 20  # those that are not all right come first
STYLES = {"ok": "green", "waiting": "yellow", "held up": "red", "off route": "red", "lost": "red bold"}
DEMAND_STYLES = {"ok": "green", "will lapse": "yellow bold", "lapsed": "red bold"}


class WatchTable:
    """Within the block it is on the terminal; what it showed last stays there."""

    def __init__(self, watch: Watch, console: Console | None = None) -> None:
        self._watch = watch
        self._console = console or Console()
        self._live = Live(console=self._console, auto_refresh=False)
        self._next_s = 0.0

    def __enter__(self) -> WatchTable:
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._watch.begun:
            self._live.update(table_of(self._watch.state()), refresh=True)
        self._live.stop()

    def show(self, notices: list[Notice]) -> None:
        """What a session calls at every tick."""
        for notice in notices:
            self._console.print(Text(notice_line(notice), style="red" if notice.is_alarm else ""))
        if (now_s := time.monotonic()) >= self._next_s:
            self._next_s = now_s + REFRESH_S
            self._live.update(table_of(self._watch.state()), refresh=True)


def table_of(state: FleetState) -> Group:
    """The fleet at a moment: demands, then robots, those first that are not all right."""
    demands = Table("demand", "now", "age s", "period s", "worst s", "lapses in", "could make it", box=None)
    for demand in state.demands:
        demands.add_row(*_demand_row(demand))
    robots = Table("robot", "now", "behind s", "beside m", "silent s", "battery", "must leave in", box=None)
    shown = sorted(state.robots, key=lambda robot: robot.standing == "ok")[:MOST_ROBOTS]
    for robot in shown:
        robots.add_row(*_robot_row(robot))
    hidden = len(state.robots) - len(shown)
    dropped = ", ".join(f"{count} {fault}" for fault, count in state.dropped.items())
    told = [f"t = {state.time_s:.1f} s", *([f"{hidden} more robots"] if hidden else [])]
    return Group(Text(", ".join([*told, *([f"dropped: {dropped}"] if dropped else [])])), demands, robots)


def _demand_row(demand: DemandState) -> list[Text]:
    lapses = "-" if demand.lapses_in_s is None else seconds(max(0.0, demand.lapses_in_s))
    cells = [demand.name, demand.standing, f"{demand.age_s:.0f}", f"{demand.period_s:g}", f"{demand.worst_s:.1f}"]
    return _style([*cells, lapses, ", ".join(demand.could[:3]) or "-"], DEMAND_STYLES[demand.standing])


def _robot_row(robot: RobotState) -> list[Text]:
    battery = "-" if robot.battery is None else f"{robot.battery:.0%}"
    leaves = "-" if robot.leaves_in_s is None else seconds(max(0.0, robot.leaves_in_s))
    lag = f"{-robot.lag_s:.1f} ahead" if robot.lag_s <= -0.05 else f"{abs(robot.lag_s):.1f}"
    numbers = [lag, f"{robot.away_m:.1f}", f"{robot.silent_s:.1f}"]
    return _style([robot.name, robot.standing, *numbers, battery, leaves], STYLES[robot.standing])


def _style(cells: list[str], style: str) -> list[Text]:
    """Cells as plain text, whatever signs names hold; the second one, how things are, in a style."""
    return [Text(cell, style=style if k == 1 else "") for k, cell in enumerate(cells)]
