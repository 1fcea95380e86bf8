"""A robot's process: it ticks at its own rate until it is stopped, leaves, or whoever started it is gone."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable

from rota.model.mission import Mission
from rota.planners.swarm.nodes.node import RobotNode
from rota.planners.swarm.nodes.scene import Scene, require_period, scene_of
from rota.planners.swarm.nodes.transport import clock_for, open_port
from rota.planning.robot_processes import ProcessSettings

READ_S = 0.005  # news are read so often where clocks are judged by them


def scene_for(mission: Mission, settings: ProcessSettings) -> Scene:
    """The scene that all processes of these settings have in common."""
    return scene_of(
        mission,
        seed=settings.seed,
        silent_s=settings.silent_s,
        clock_error_s=settings.clock_error_s,
        own_clocks=settings.own_clocks,
        radio_m=settings.radio_range_m,
        ground_m=settings.ground_m,
    )


def period_of(settings: ProcessSettings) -> int | None:
    """The time between a robot's decisions in nanoseconds; None: the mission's time step."""
    return None if settings.rate_hz is None else require_period(1 / settings.rate_hz, "rate")


def run_robot(
    scene: Scene,
    robot: int,
    settings: ProcessSettings,
    *,
    begin_ns: int | None = None,
    should_stop: Callable[[], bool] = lambda: False,
    parent: int | None = None,
) -> RobotNode:
    """Be a robot, by its number in the fleet, until it has left; returns it as it was in the end.

    begin_ns: when all begin, by the shared clock; None: as soon as it is announced. Once ``should_stop`` says so, or
    the process ``parent`` that started it is gone, it leaves, and tells so for as long as makes others forget. Raises
    LinkError where another process has its port, RotaError where ROS 2 is asked for and missing, MissionError for a
    rate at which others would forget it.
    """
    fleet = len(scene.mission.fleet.robots or ())
    clock = clock_for(settings, fleet)
    port = open_port(settings, fleet, robot)
    try:
        node = RobotNode(scene, robot, began_ns=clock(), begin_ns=begin_ns, period_ns=period_of(settings))
        while not node.has_left:
            if should_stop() or (parent is not None and os.getppid() != parent):
                node.leave()
            cpu_ns = time.thread_time_ns()
            datagrams = list(port.receive())  # before the clock is read, which none of them is ahead of then
            datagram = node.tick(clock(), datagrams)
            if datagram is not None:
                port.send(datagram)
            node.busy_us = (time.thread_time_ns() - cpu_ns) // 1000
            next_ns = clock() + scene.period_ns if node.next_ns is None else node.next_ns
            while (left_ns := next_ns - clock()) > 0:
                time.sleep(min(left_ns * 1e-9, READ_S if scene.own_clocks else math.inf))
                if scene.own_clocks:
                    arrived = list(port.receive())
                    node.hear(arrived, clock())
    finally:
        port.close()
    return node
