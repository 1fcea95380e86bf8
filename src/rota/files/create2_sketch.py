"""Plan of bouncing robots -> Arduino sketches, one per robot, for the iRobot Create 2 and its Open Interface.

The program's frame is ``create2_sketch.ino`` beside this file, with the robot's part, ``create2_robot.ino``. Its
opcodes, packets, stream frames and wiring follow iRobot's Create 2 Open Interface as it is known from programs that use
it; they have been run in a simulator of the chip, beside a model of the robot, and never on a robot.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from pathlib import Path

from rota.errors import PlanError, RotaError
from rota.files.atomic_write import require_short_names, require_writable_folder, write_atomically
from rota.files.create2_legs import BACK_OFF_SPEED_M_S, MOST_SLOWING, Drive, Leg, drives_of
from rota.model.plan import Plan, Trajectory

LEG_BYTES, KIND_BYTES = 8, 7
MOST_BYTES = 25_200  # of legs and their kinds; with the program they fill the 32 kB of an Uno
LONGEST_MS = (1 << 24) - 1  # of a leg
_FOLDER = Path(__file__).parent


def write_create2_sketches(
    plan: Plan, folder: str | os.PathLike[str], *, most_slowing: float = MOST_SLOWING
) -> tuple[Path, ...]:
    """Write ``ROBOT/ROBOT.ino`` for every robot into ``folder`` (made if missing), as the Arduino IDE wants it.

    most_slowing: by how much the plan's clock may be slowed at most, see ``create2_legs.drives_of``. Returns the
    sketches' paths. Raises PlanError for plans that Create 2 robots cannot drive or robots whose names give the same
    file name, RotaError when the folder cannot be written to. Nothing is written unless all could be made.
    """
    require_writable_folder(folder)
    return write_sketches(plan, sketch_texts(plan, most_slowing=most_slowing), folder)


def write_sketches(plan: Plan, made: tuple[str, ...], folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write the texts of a plan's robots, each in a folder of its own; returns the paths."""
    require_writable_folder(folder)
    texts: dict[str, str] = {}
    for trajectory, text in zip(plan.trajectories, made, strict=True):
        name = re.sub(r"[^A-Za-z0-9_-]+", "_", trajectory.robot).strip("_-") or "robot"
        if name.casefold() in (known.casefold() for known in texts):
            raise PlanError(f"robot {trajectory.robot}: another robot's file is called {name}.ino; rename one of them")
        texts[name] = text
    require_short_names(f"{name}.ino" for name in texts)
    paths = tuple(Path(folder) / name / f"{name}.ino" for name in texts)
    for path, text in zip(paths, texts.values(), strict=True):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RotaError(f"{path.parent}: cannot be made: {error.strerror or error}") from error
        write_atomically(path, text)
    return paths


def sketch_texts(plan: Plan, *, most_slowing: float = MOST_SLOWING) -> tuple[str, ...]:
    """The sketches' texts, in the plan's order of robots. Raises PlanError, see ``create2_legs.drives_of``."""
    drives = drives_of(plan, most_slowing=most_slowing)
    return tuple(_text(plan, t, drive) for t, drive in zip(plan.trajectories, drives, strict=True))


def _text(plan: Plan, trajectory: Trajectory, drive: Drive) -> str:
    """The sketch of a robot; PlanError where its legs do not fit into the memory."""
    kinds = {kind: number for number, kind in enumerate(dict.fromkeys(_kind(leg) for leg in drive.legs))}
    needed = LEG_BYTES * len(drive.legs) + KIND_BYTES * len(kinds)
    if needed > MOST_BYTES:
        raise PlanError(
            f"robot {trajectory.robot}: its way has {len(drive.legs):,} legs, which take {needed:,} bytes; an Arduino"
            f" Uno has room for {MOST_BYTES:,}"
        )
    first_ms, loop_ms = round(drive.first_s * 1e3), math.floor(drive.loop_s * 1e3)
    first = drive.legs[0]
    others = ", ".join(other.robot for other in plan.trajectories if other is not trajectory)
    together = f"{others}; all must begin at the same moment, the plan relies on it" if others else "none"
    marks = {
        "TITLE": one_line(f"{trajectory.robot}: {plan.mission.name}"),
        "BEGIN": f"centre at x = {first.start_m[0]:.3f} m, y = {first.start_m[1]:.3f} m, facing"
        f" {_degrees(first.heading_rad):g} degrees (0 is along x, 90 along y)",
        "THEN": _ending(drive),
        "CLOCK": _clock(drive),
        "OTHERS": one_line(together),
        "BACK_OFF_MM_S": str(round(BACK_OFF_SPEED_M_S * 1e3)),
        "TURN_MM_S": str(round(drive.turn_speed_m_s * 1e3)),
        "KINDS": "\n".join(f"  {{ {kind} }},  // {number}" for kind, number in kinds.items()),
        "LEGS": "\n".join(_rows(trajectory.robot, drive, kinds, first_ms, loop_ms)),
        "LOOPS": "false" if drive.loop_from is None else "true",
        "LOOP_FROM": str(drive.loop_from or 0),
        "LOOP_MS": str(loop_ms),
        "LOOP_REST": str(min(round((drive.loop_s * 1e3 - loop_ms) * 65536), 65535)),
        "FIRST_MS": str(first_ms),
        "SIGNAL_EVERY_MS": str(round((plan.mission.bouncing.clock_signal_s or 0.0) * 1e3)),
    }
    return sketch_of("create2_sketch.ino", **marks)


def sketch_of(frame: str, **marks: str) -> str:
    """The text of a frame beside this file, with the robot's part in it and its ``@MARKS@`` filled in."""
    robot, text = ((_FOLDER / name).read_text(encoding="utf-8") for name in ("create2_robot.ino", frame))
    return re.sub(r"@([A-Z_]+)@", lambda mark: marks[mark[1]], text.replace("@ROBOT@", robot.rstrip(), 1))


def one_line(text: str) -> str:
    """A name that ends neither its line nor its comment."""
    return "".join(mark if mark.isprintable() and mark != "\\" else "_" for mark in text)


def _kind(leg: Leg) -> str:
    """Speed, way back, turn, and whether a bump ends it, as the table of kinds has them."""
    turn = round(math.degrees(leg.turn_rad) * 10)
    return f"{round(leg.speed_m_s * 1e3):3d}, {round(leg.back_off_m * 1e3):3d}, {turn:5d}, {int(leg.bumps)}"


def _rows(robot: str, drive: Drive, kinds: dict[str, int], first_ms: int, loop_ms: int) -> Iterator[str]:
    """A row for each leg. What legs last adds up to their times in whole milliseconds, and to that of the round."""
    begins_ms = [first_ms, *(round(leg.next_s * 1e3) for leg in drive.legs)]
    if drive.loop_from is not None:
        begins_ms[-1] = begins_ms[drive.loop_from] + loop_ms
    for number, leg in enumerate(drive.legs):
        due_ms = round((leg.length_m + leg.ahead_m if leg.bumps else leg.length_m) / leg.speed_m_s * 1e3)
        lasts_ms = begins_ms[number + 1] - begins_ms[number]
        if max(due_ms, lasts_ms) > LONGEST_MS:
            raise PlanError(f"robot {robot}: leg {number} lasts {lasts_ms / 1e3:.6g} s, and 16777 s are the most")
        where = f"({leg.start_m[0]:.2f}, {leg.start_m[1]:.2f})"
        values = f"{kinds[_kind(leg)]:3d}, {due_ms:6d}, {lasts_ms:6d}"
        yield f"  {{ {values} }},  // {number}: from {where} {leg.length_m:.2f} m towards {_degrees(leg.heading_rad):g}"


def _degrees(heading_rad: float) -> float:
    return round(math.degrees(heading_rad) % 360, 1) % 360


def _ending(drive: Drive) -> str:
    bumps = sum(leg.bumps for leg in drive.legs)
    clocked = len(drive.legs) - bumps
    timed = f", {clocked} of which the clock ends" if clocked else ""
    if drive.loop_from is None:
        return f"{len(drive.legs)} legs{timed}; then it stops"
    return f"{len(drive.legs)} legs{timed}; those from {drive.loop_from} on for ever, {drive.loop_s:.1f} s a round"


def _clock(drive: Drive) -> str:
    if drive.slowing == 1:
        return "the plan's"
    return f"{drive.slowing:.3g} times slower than the plan's: a Create 2 needs so long to bump, back off and turn"
