"""Robots of a swarm as real processes: their rate and processor time, what they cover when some die, and noise."""

from __future__ import annotations

import os
import random
import signal
import socket
import statistics
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from shapely import MultiPolygon, box

from benchmarks.row import Options, Row
from rota.model.fleet import DiscSensor, Fleet, Robot, SquareSensor, StartBox
from rota.model.mission import Mission
from rota.planners.swarm.nodes.launch import run_swarm
from rota.planners.swarm.nodes.process import scene_for
from rota.planners.swarm.nodes.telling import SIZE
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planning.robot_processes import Launch, ProcessSettings, SwarmRecord

PORT = 48_600
MOST_MS, RATE_HZ, SLACK_HZ, WITHIN = 5.0, 10.0, 0.05, 0.02
KILLED_AT_S, SETTLED_S = 12, 15
MALFORMED, AT_ONCE, MOST_GROWTH_BYTES = 100_000, 10_000, 1_000_000
SEEDS = 3
PUBLISHED = SquareSensor(side_m=30.0)
SCENES = {
    "in the paper's scene": (128.0, PUBLISHED),
    "in a square of 90 m, discs of 15 m": (90.0, DiscSensor(radius_m=15.0)),
}


def swarm_processes(options: Options) -> Iterator[Row]:
    """All rows; each run takes as long as it shows."""
    for name, (side_m, sensor) in SCENES.items():
        runs = [_flown(_mission(16, side_m, sensor), KILLED_AT_S + SETTLED_S, seed, kill=4) for seed in range(SEEDS)]
        if sensor == PUBLISHED:
            yield _rate_row(runs)
        fresh = [_flown(_mission(12, side_m, sensor), SETTLED_S, seed).coverage[-1][1] for seed in range(SEEDS)]
        yield _killed_row(name, runs, fresh)
    yield _noise_row()


def _rate_row(runs: list[SwarmRecord]) -> Row:
    """How often robots decided, those that were killed until then, and what it cost."""
    robots = [robot for run in runs for robot in run.robots]
    busy_ms = np.concatenate([robot.busy_ms for robot in robots])
    rates = [robot.rate_hz for robot in robots]
    median, most = float(np.median(busy_ms)), float(np.percentile(busy_ms, 95))
    return Row(
        "16 robots as processes on two cores: decisions a second; processor time of decision and messages",
        f"{RATE_HZ:g} Hz, < {MOST_MS:g} ms",
        f"{statistics.mean(rates):.2f} Hz, the slowest {min(rates):.2f}; {median:.2f} ms in the median, {most:.2f} in"
        f" 95 %, {busy_ms.max():.2f} at most",
        statistics.mean(rates) > RATE_HZ - SLACK_HZ and most < MOST_MS,
    )


def _killed_row(name: str, runs: list[SwarmRecord], fresh: list[float]) -> Row:
    """What is covered after some were killed, and by as few fresh ones; the worst seed decides."""
    shares = [{round(time_s): share for time_s, share, _ in run.coverage} for run in runs]
    before, low = (statistics.mean(share[KILLED_AT_S + after] for share in shares) for after in (0, 1))
    ends = [run.coverage[-1] for run in runs]
    worst = min(end[1] - new for end, new in zip(ends, fresh, strict=True))
    end, new = statistics.mean(end[1] for end in ends), statistics.mean(fresh)
    return Row(
        f"4 of 16 processes killed {name}, {len(runs)} seeds: coverage beside that of 12 fresh ones",
        "within 2 points",
        f"{before:.1%} before, {low:.1%} a second after, {end:.1%} in the end; 12 fresh: {new:.1%}; the worst seed"
        f" {100 * worst:+.1f} points",
        worst > -WITHIN and all(robots == 12 for _, _, robots in ends),
    )


def _mission(robots: int, side_m: float, sensor: DiscSensor | SquareSensor) -> Mission:
    """Robots of 20 m/s that start in a box of 40 m in the middle of a square."""
    like = {"speed_m_s": 20.0, "sensor": sensor, "body_radius_m": 0.5}
    low, high = side_m / 2 - 20, side_m / 2 + 20
    named = tuple(Robot(name=f"robot-{k + 1}", **like) for k in range(robots))
    return Mission(
        name=f"{robots} robots",
        area=MultiPolygon([box(0, 0, side_m, side_m)]),
        fleet=Fleet(robots=named, start=StartBox(low_m=(low, low), high_m=(high, high)), **like),
        planning=SwarmSettings(time_step_s=1 / RATE_HZ),
    )


def _flown(mission: Mission, time_s: float, seed: int, kill: int = 0) -> SwarmRecord:
    """The record of a run in real time; ``kill`` of its robots get SIGKILL."""
    settings = ProcessSettings(port=PORT, seed=seed)
    ids: dict[int, int] = {}

    def measured(at_s: float, _share: float, _robots: int) -> None:
        if kill and round(at_s) == KILLED_AT_S:
            for robot in range(kill):
                os.kill(ids[robot], signal.SIGKILL)

    launch = Launch(time_limit_s=time_s + 0.5, started=ids.update, measured=measured)
    return run_swarm(scene_for(mission, settings), settings, launch)


def _noise_row() -> Row:
    """A robot's process under malformed datagrams, ten thousand a second."""
    mission = _mission(2, 60.0, DiscSensor(radius_m=15.0))
    settings, rng = ProcessSettings(port=PORT), random.Random(0)
    noise = [rng.randbytes(rng.choice([SIZE, rng.randrange(2 * SIZE)])) for _ in range(1000)]
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    ids: dict[int, int] = {}
    sent, memory = 0, []

    def measured(_time_s: float, _share: float, _robots: int) -> None:
        memory.append(_resident_bytes(ids[0]))

    def keep_sending() -> bool:
        nonlocal sent
        if memory and sent < 2 * MALFORMED:
            for datagram in noise[:250]:
                sender.sendto(datagram, ("127.0.0.1", settings.port))
            sent += 250
        return False

    launch = Launch(time_limit_s=18.0, should_stop=keep_sending, started=ids.update, measured=measured)
    record = run_swarm(scene_for(mission, settings), settings, launch)
    sender.close()
    robot, growth = record.robots[0], max(memory[3:]) - memory[2]
    return Row(
        f"{MALFORMED:,} malformed datagrams to a robot's process: whether it goes on, and growth of its memory",
        "no crash, no growth",
        f"{robot.dropped:,} read and dropped of {sent:,}; it {robot.end} at {robot.rate_hz:.1f} Hz, {robot.lost}"
        f" tellings lost; {growth / 1e6:+.2f} MB",
        robot.dropped >= MALFORMED and robot.end == "runs" and growth < MOST_GROWTH_BYTES,
    )  # fmt: skip


def _resident_bytes(process: int) -> int:
    """The memory that a process has in use."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
