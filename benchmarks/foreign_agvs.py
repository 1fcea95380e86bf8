"""VDA 5050 vehicles of others, led in real time: Siemens' virtual AGVs beside the plan's clock."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.links.agv import broker
from tests.links.fast_time import FastTime
from tests.links.foreign_agvs import FOLDER, Shift, plan, with_foreign

from benchmarks.row import Options, Row
from rota.files.mission_file import read_mission
from rota.live.driving import Driving
from rota.live.keeping import Keeping
from rota.live.ready import make_ready
from rota.live.watch import Watch
from rota.model.plan import Plan
from rota.planning.make_plan import make_plan

ROUNDS, MOST_LATE_S = 10, 1.0
REAL_TIME = FastTime()
# robots that turn on the spot: the vehicles do so in no time, and lose some 0.3 s at every stop
HALL = """
rota: 1
name: hall
area: [[0, 0], [30, 0], [30, 12], [0, 12]]
obstacles: [[[8, 4], [10, 4], [10, 6], [8, 6]], [[18, 5], [20, 5], [20, 8], [18, 8]]]
period_s: 30
fleet: {robots: 3, speed_m_s: 1.5, turn_rate_rad_s: 1.0, sensor: {shape: disc, radius_m: 3}, body_radius_m: 0.3}
patrol: {effort: quick}
"""


def foreign_agvs(options: Options) -> Iterator[Row]:
    """Ten rounds in real time: how late each is at the first stop of a round, by its own clock; nothing is patched."""
    if not (FOLDER / "node_modules").exists():
        yield Row(_name("two waits a round"), _asked(), "not measured: npm ci --prefix tests/links/virtual_agv", None)
        return
    make_ready()
    mission = options.folder / "hall.yaml"
    mission.write_text(HALL)
    hall = make_plan(read_mission(mission).mission, seed=0)
    yield _row("two waits a round", plan(), options.folder)
    yield _row("two waits a round, by their action noop", plan(), options.folder, "wait_action=noop:duration")
    yield _row("a hall planned for robots that turn", hall, options.folder)


def _name(what: str) -> str:
    return f"Siemens' AGVs, three, {ROUNDS} rounds, {what}: errors, worst phase"


def _asked() -> str:
    return f"no error, within {MOST_LATE_S:g} s"


def _row(what: str, of: Plan, folder: Path, *given: str) -> Row:
    until_s = max(way.loop_start_s + (ROUNDS + 0.2) * way.loop_duration_s for way in of)

    async def drive(shift: Shift) -> None:
        driving = Driving(shift.link, Watch(of), Keeping(of, {}), None, lambda notice: shift.told.append(notice.text))
        await shift.start(REAL_TIME)
        await driving.drive(until_s=until_s, should_stop=lambda: False)

    with broker(folder) as port:
        shift = with_foreign(port, REAL_TIME, drive, *given, of=of)
    late_s = [abs(late) for way in of for late in shift.late_s(way.robot)]
    measured = f"{len(shift.errors)} errors, mean {sum(late_s) / len(late_s):.2f} s, worst {max(late_s):.2f} s"
    if shift.told:
        measured += f"; told: {'; '.join(shift.told)}"
    reached = not shift.errors and len(late_s) >= 3 * ROUNDS and max(late_s) < MOST_LATE_S
    return Row(_name(what), _asked(), measured, reached)
