"""All robots of a mission as processes on this machine, and a recorder beside them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterable
from multiprocessing.process import BaseProcess

from rota.errors import LinkError, RotaError
from rota.model.mission import Mission
from rota.planners.swarm.nodes.node import RobotNode
from rota.planners.swarm.nodes.process import period_of, run_robot
from rota.planners.swarm.nodes.recording import REST_S, Recorder
from rota.planners.swarm.nodes.scene import Scene
from rota.planners.swarm.nodes.transport import clock_for, open_port, prepare
from rota.planning.robot_processes import EVERYTHING, Launch, ProcessSettings, SwarmRecord

LEAVE_S = 5.0  # for the processes to end, after they were asked to
FAILED = 2  # exit code of a process that could not be its robot


def run_swarm(scene: Scene, settings: ProcessSettings, launch: Launch = EVERYTHING) -> SwarmRecord:
    """Start a process for each robot, record what they tell, end them, and return the record.

    Robots are at rest when ``Recorder.is_at_rest`` says so. Raises LinkError where a port is taken, and where a process
    does not start.
    """
    fleet = len(scene.mission.fleet.robots or ())
    numbers = range(fleet) if launch.robots is None else launch.robots
    clock, start_s = clock_for(settings, fleet), prepare(settings, len(numbers))
    # threads of a middleware do not survive a fork: its port is opened after that
    port = open_port(settings, fleet, fleet) if settings.transport == "udp" else None
    processes: dict[int, BaseProcess] = {}
    try:
        compile_for(scene, settings)
        begin_ns = clock() + 3 * scene.silent_ns + round(start_s * 1e9)
        until_ns = None if launch.time_limit_s is None else begin_ns + round(launch.time_limit_s * 1e9)
        for robot in numbers:
            processes[robot] = _start(scene, robot, settings, begin_ns, until_ns)
        launch.started({robot: process.pid or 0 for robot, process in processes.items()})
        port = port or open_port(settings, fleet, fleet)
        changes_s = last_change_s(scene.mission, numbers) if until_ns is not None else 0.0
        rests_from_ns = begin_ns + round((changes_s + REST_S) * 1e9)
        recorder, told = Recorder(scene, begin_ns, until_ns=until_ns), 0
        while True:
            now_ns = clock()
            recorder.hear(port.receive(), now_ns)
            for row in recorder.coverage[told:]:
                launch.measured(*row)
            told = len(recorder.coverage)
            _require_started(processes, scene, now_ns < begin_ns)
            over = until_ns is not None and now_ns >= until_ns
            if until_ns is None or launch.ends_at_rest:
                over = over or (now_ns > rests_from_ns and recorder.is_at_rest(now_ns))
            if (
                (stopped := launch.should_stop())
                or over
                or not any(process.is_alive() for process in processes.values())
            ):
                break
            time.sleep(scene.period_ns * 1e-9 / 4)
        at_rest = not stopped and recorder.is_at_rest(now_ns)
        ended_ns = now_ns if until_ns is None else min(now_ns, until_ns)
        return recorder.record(ended_ns, stopped=not at_rest)
    finally:
        _end(processes.values())
        if port is not None:
            port.close()


def compile_for(scene: Scene, settings: ProcessSettings) -> None:
    """Compile and load all that a robot's decision takes, so that processes forked afterwards have it.

    Raises MissionError for a rate at which robots would forget each other.
    """
    node = RobotNode(scene, 0, began_ns=-2 * scene.silent_ns, begin_ns=0, period_ns=period_of(settings))
    for now_ns in range(0, scene.silent_ns + 2 * scene.period_ns, scene.period_ns):
        node.tick(now_ns, ())


def last_change_s(mission: Mission, numbers: Iterable[int]) -> float:
    """When the last of these robots joins or leaves, in seconds after the begin."""
    robots = mission.fleet.robots or ()
    changes_s = [time_s for k in numbers for time_s in (robots[k].joins_s, robots[k].leaves_s) if time_s is not None]
    return max(changes_s, default=0.0)


def _start(scene: Scene, robot: int, settings: ProcessSettings, begin_ns: int, until_ns: int | None) -> BaseProcess:
    """The process of one robot: a fork, which is ready at once, where the system has that; else one that loads anew."""
    methods = multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("fork" if "fork" in methods else "spawn")
    process: BaseProcess = context.Process(  # type: ignore[attr-defined]
        target=_be_robot,
        args=(scene, robot, settings, begin_ns, until_ns, os.getpid()),
        name=f"robot {robot}",
        daemon=True,
    )
    process.start()
    return process


def _be_robot(
    scene: Scene, robot: int, settings: ProcessSettings, begin_ns: int, until_ns: int | None, parent: int
) -> None:
    """What the process of a robot does: be one until SIGTERM; Ctrl-C is for who started it.

    It leaves by itself when the time is over for so long that it has fallen silent in the record: who started it may
    come late to that on a busy machine.
    """
    asked: list[int] = []
    clock = clock_for(settings, len(scene.mission.fleet.robots or ()))
    end_ns = None if until_ns is None else until_ns + scene.silent_ns

    def is_over() -> bool:
        return bool(asked) or (end_ns is not None and clock() >= end_ns)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda number, _frame: asked.append(number))
    try:
        run_robot(scene, robot, settings, begin_ns=begin_ns, should_stop=is_over, parent=parent)
    except RotaError as error:
        print(f"rota: error: {error}", file=sys.stderr, flush=True)
        os._exit(FAILED)


def _require_started(processes: dict[int, BaseProcess], scene: Scene, before_begin: bool) -> None:
    """Raise LinkError where a process ended before the begin; later ones may die, and the others go on."""
    ended = [robot for robot, process in processes.items() if process.exitcode not in (None, 0)]
    if before_begin and ended:
        names = [(scene.mission.fleet.robots or ())[robot].name for robot in ended]
        raise LinkError(f"{', '.join(names)}: the process ended before the begin; what it said stands above")


def _end(processes: Iterable[BaseProcess]) -> None:
    """Ask all processes to leave, and end those that do not."""
    running = [process for process in processes if process.is_alive()]
    for process in running:
        process.terminate()
    until = time.monotonic() + LEAVE_S
    for process in running:
        process.join(max(until - time.monotonic(), 0.0))
        if process.is_alive():
            process.kill()
            process.join()
