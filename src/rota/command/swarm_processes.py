"""`rota swarm-node` and `rota swarm-launch`: robots of a swarm as processes of their own."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rota.command.arguments import read_and_warn, require_target
from rota.command.exit_codes import DONE
from rota.command.interrupt import stop_on_interrupt
from rota.command.terminal import say
from rota.compiled.compiled_cache import mention_compiling
from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.model.mission import Mission
    from rota.planning.robot_processes import ProcessSettings, RobotProcesses, RobotRecord, SwarmRecord

MissionPath = Annotated[Path, typer.Argument(metavar="MISSION", help="A mission file of a swarm, YAML or JSON.")]
Seed = Annotated[int, typer.Option(min=0, metavar="NUMBER", help="For starts that the mission leaves open.")]
Port = Annotated[int, typer.Option(metavar="PORT", help="Of the fleet's first robot; others and the recorder follow.")]
Hosts = Annotated[
    str, typer.Option(metavar="HOST,...", help="One for all, or one for each robot and then the recorder's.")
]
Rate = Annotated[float | None, typer.Option(metavar="HZ", help="Decisions in a second; default by the time step.")]
Silent = Annotated[
    float | None, typer.Option(metavar="SECONDS", help="Forget who was silent so long; default five time steps.")
]
ClockError = Annotated[float, typer.Option(metavar="SECONDS", help="By which clocks of several hosts may differ.")]
OwnClocks = Annotated[
    bool, typer.Option("--own-clocks", help="Hosts' clocks differ; --clock-error is how late the promptest news are.")
]
RadioRange = Annotated[
    float | None, typer.Option(metavar="METRES", help="Do not receive what is sent from farther away.")
]
HeightMap = Annotated[
    str | None, typer.Option(metavar="FILE", help="Heights of the ground: a GeoTIFF, or a PNG with --heights.")
]
Heights = Annotated[str | None, typer.Option(metavar="LOW,HIGH", help="Metres that black and white stand for.")]

Transport = Annotated[str, typer.Option(metavar="udp|ros2", help="How messages go; ros2: a topic of ROS 2.")]

SHARE_SHOWN = 95  # percent of a robot's decisions take no longer than what is shown beside the median


def _settings(
    mission: Mission,
    *,
    seed: Seed = 0,
    transport: Transport = "udp",
    port: Port = 47600,
    hosts: Hosts = "127.0.0.1",
    rate: Rate = None,
    silent: Silent = None,
    clock_error: ClockError = 0.0,
    own_clocks: OwnClocks = False,
    radio_range_m: RadioRange = None,
    height_map: HeightMap = None,
    heights: Heights = None,
) -> ProcessSettings:
    """What the options that both commands have ask of the processes."""
    from rota.planning.robot_processes import HeightAt, ProcessSettings, level

    ground_m: HeightAt = level
    if height_map is not None:
        from rota.files.height_map import read_height_map

        ground_m = read_height_map(height_map, mission, heights)
    elif heights is not None:
        raise RotaError(f"--heights: {heights!r} is not allowed without --height-map")
    return ProcessSettings(
        seed=seed,
        transport=transport,
        port=port,
        hosts=tuple(host.strip() for host in hosts.split(",")),
        rate_hz=rate,
        silent_s=silent,
        clock_error_s=clock_error,
        own_clocks=own_clocks,
        radio_range_m=radio_range_m,
        ground_m=ground_m,
    )


def _with_settings(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the options of ``_settings`` where it has ``options``, as typer reads its signature."""
    unloaded = {"Mission": Any, "ProcessSettings": Any}  # imported for type checkers alone
    options = inspect.signature(_settings, eval_str=True, locals=unloaded).parameters.values()
    own = inspect.signature(command, eval_str=True).parameters.values()
    parameters = [each.replace(kind=each.KEYWORD_ONLY) for each in own if each.kind is not each.VAR_KEYWORD]
    parameters += [each for each in options if each.kind is each.KEYWORD_ONLY]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {each.name: each.annotation for each in parameters}
    return command


@_with_settings
def swarm_node(
    mission: MissionPath,
    robot: Annotated[str, typer.Option(metavar="ROBOT", help="Its name, or its number from 1 on in the fleet.")],
    **options: Any,
) -> None:
    """Be one robot of a swarm; it knows only what others send."""
    asked = read_and_warn(mission)
    number = _number_of(asked, robot)
    settings = _settings(asked, **options)
    processes = _processes(asked, settings)
    where = f"port {settings.port + number}" if settings.transport == "udp" else "ROS 2"
    with stop_on_interrupt(lambda by: say(f"leaving; {by} again ends at once")) as stop:
        say(f"{(asked.fleet.robots or ())[number].name} listens on {where}; Ctrl-C lets it leave")
        dropped = processes.run_robot(number, stop)
    if dropped:
        say(f"{dropped} datagrams could not be read")
    raise typer.Exit(DONE)


@_with_settings
def swarm_launch(
    mission: MissionPath,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="PLAN", help="What was done; default MISSION.rota.json.")
    ] = None,
    robots: Annotated[
        str | None, typer.Option(metavar="NUMBERS", help="Only these, such as 1-12,15; others may join by swarm-node.")
    ] = None,
    time_limit: Annotated[
        float | None,
        typer.Option(min=0, metavar="SECONDS", help="Run so long at most, or until all rest; default no limit."),
    ] = None,
    coverage: Annotated[
        str | None, typer.Option(metavar="FILE.csv", help="Write what was covered at which time, as a table.")
    ] = None,
    **options: Any,
) -> None:
    """Start a swarm's robots as processes; write what they did."""
    from rota.files.atomic_write import require_suffix, write_atomically
    from rota.files.plan_file import write_plan
    from rota.planning.robot_processes import Launch

    target = output if output is not None else f"{mission.stem}.rota.json"
    require_target(target, source=mission)
    if coverage is not None:
        require_suffix(coverage, (".csv",), "a table")
        require_target(coverage, source=mission)
    asked = read_and_warn(mission)
    chosen = None if robots is None else _numbers_of(asked, robots)
    processes = _processes(asked, _settings(asked, **options))
    fleet = asked.fleet.robots or ()

    def tell_start(ids: dict[int, int]) -> None:
        say(", ".join(f"{fleet[number].name} is process {pid}" for number, pid in ids.items()))

    def tell_measure(time_s: float, share: float, count: int) -> None:
        typer.echo(f"{time_s:5.0f} s  {share:6.1%} covered by {count} robots")

    with stop_on_interrupt(lambda by: say(f"ending with what was recorded; {by} again ends at once")) as stop:
        launch = Launch(
            robots=chosen, time_limit_s=time_limit, ends_at_rest=True, should_stop=stop, started=tell_start,
            measured=tell_measure,
        )  # fmt: skip
        record = processes.run_all(launch)
    write_plan(record.plan, target)
    if coverage is not None:
        rows = [f"{time_s!r},{share!r},{count}\n" for time_s, share, count in record.coverage]
        write_atomically(coverage, "time_s,coverage,robots\n" + "".join(rows))
    _tell(record)
    typer.echo(target)
    raise typer.Exit(stop.exit_code or DONE)


def _tell(record: SwarmRecord) -> None:
    """Say how the robots ran."""
    import numpy as np

    for warning in record.warnings:
        say(f"warning: {warning}")
    for robot in record.robots:
        typer.echo(_line(robot))
    busy_ms = np.concatenate([robot.busy_ms for robot in record.robots])
    if len(busy_ms):
        typer.echo(
            f"all: {np.median(busy_ms):.2f} ms of processor time for decision and messages in the median,"
            f" {np.percentile(busy_ms, SHARE_SHOWN):.2f} ms in {SHARE_SHOWN} %"
        )
    if record.plan.run_end is not None:
        typer.echo(f"the run was {record.plan.run_end.text()}")


def _line(robot: RobotRecord) -> str:
    lost = f", {robot.lost} tellings lost" if robot.lost else ""
    dropped = f", {robot.dropped} datagrams that it could not read" if robot.dropped else ""
    ends = {"runs": "to the end", "left": "until it left", "silent": "until it fell silent"}
    return f"{robot.robot}: {robot.ticks} decisions at {robot.rate_hz:.1f} Hz {ends[robot.end]}{lost}{dropped}"


def _processes(mission: Mission, settings: ProcessSettings) -> RobotProcesses:
    """The mission's robots, once it is said that compiling takes long."""
    from rota.planning.planner import planner_of

    planner = planner_of(mission)
    mention_compiling(*planner.compiled_packages(mission))
    return planner.robot_processes(mission, settings)


def _number_of(mission: Mission, robot: str) -> int:
    """The place in the fleet of a robot given by its name or its number from 1 on; RotaError for others."""
    names = [each.name for each in mission.fleet.robots or ()]
    if robot in names:
        return names.index(robot)
    if robot.isascii() and robot.isdigit() and len(robot) < 10 and 1 <= int(robot) <= len(names):
        return int(robot) - 1
    raise RotaError(f"{robot!r} is no robot of the mission; one of its names or a number, 1 to {len(names)}, is needed")


def _numbers_of(mission: Mission, text: str) -> list[int]:
    """The places in the fleet of robots given as 1-12,15 or by names; RotaError for others."""
    chosen: set[int] = set()
    for part in text.split(","):
        names = {each.name for each in mission.fleet.robots or ()}
        first, dash, last = part.partition("-")
        if dash and part not in names:
            chosen.update(range(_number_of(mission, first), _number_of(mission, last) + 1))
        else:
            chosen.add(_number_of(mission, part))
    return sorted(chosen)
