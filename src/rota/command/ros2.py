"""`rota ros2`: a plan played on ROS 2 topics, in real or scaled time."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from rota.command.arguments import PlanPath, read_plan_argument
from rota.command.interrupt import StopFlag, stop_on_interrupt
from rota.command.terminal import say
from rota.errors import PlanError

if TYPE_CHECKING:
    from rota.ros2.node import Publishers
    from rota.ros2.player import Player

AGES_HZ = 1.0
LONGEST_SLEEP_S = 0.1  # so that Ctrl-C is heard soon


def ros2(
    plan: PlanPath,
    speed: Annotated[
        float, typer.Option(min=0.001, max=1000, metavar="FACTOR", help="Seconds of the plan in one second.")
    ] = 1.0,
    rate: Annotated[
        float, typer.Option(min=0.1, max=100, metavar="HZ", help="Poses, transforms and footprints per second.")
    ] = 10.0,
    until: Annotated[
        float | None,
        typer.Option(min=0, max=1e10, metavar="SECONDS", help="Stop at this time of the plan; default: never."),
    ] = None,
    clock: Annotated[
        bool, typer.Option("--clock", help="Publish the plan's time on /clock, for nodes with use_sim_time.")
    ] = False,
    network: Annotated[
        bool, typer.Option("--network", help="Let other machines listen, too; default: this one alone.")
    ] = False,
) -> None:
    """Play a plan on ROS 2 topics, for RViz and Foxglove."""
    from rota.files.ros.library import require_rosbags
    from rota.ros2.node import Publishers, opened_node, require_rclpy, stay_on_loopback

    require_rosbags("rota ros2")
    answer = read_plan_argument(plan)
    if not answer.trajectories:
        raise PlanError("a plan without robots has nothing to play")
    require_rclpy("geometry_msgs.msg", "nav_msgs.msg")
    if not network:
        stay_on_loopback()
    with opened_node("rota") as node:
        from rota.ros2.player import Player

        player, publishers = Player(answer, speed, own_clock=clock), Publishers(node)
        with stop_on_interrupt(lambda by: say(f"stopping; {by} again ends at once")) as stop:
            where = "on the network" if network else "on this machine"
            say(f"playing {len(answer.trajectories)} robots {where}; Ctrl-C stops")
            _play(player, publishers, Pace(speed=speed, rate_hz=rate, until_s=until, has_clock=clock), stop)
    raise typer.Exit(stop.exit_code)


@dataclass(frozen=True, kw_only=True)
class Pace:
    """How fast a plan is played, how often it is told, and until when; and whether its time is told, too."""

    speed: float
    rate_hz: float
    until_s: float | None
    has_clock: bool


def _play(player: Player, publishers: Publishers, pace: Pace, stop: StopFlag) -> None:
    """Publish until the time is up or the flag; what the machine is too slow for is left out."""
    speed, until_s = pace.speed, pace.until_s
    begin_s, step, ages_due_s = time.monotonic(), 0, 0.0
    publishers.publish(player.begin(time.time_ns()))
    told: set[str] = set()
    while not stop():
        time_s = (time.monotonic() - begin_s) * speed
        last = until_s is not None and time_s >= until_s
        if last and until_s is not None:
            time_s = until_s
        if pace.has_clock:
            publishers.publish(player.clock(time_s))
        publishers.publish(player.poses(time_s))
        publishers.publish(player.footprints(time_s))
        if last or time_s >= ages_due_s:
            publishers.publish(player.ages(time_s))
            ages_due_s = time_s + speed / AGES_HZ
        for package in sorted(publishers.left_out - told):
            say(f"{package} is not installed: its messages are left out")
            told.add(package)
        if last:
            return
        step = max(step + 1, int((time.monotonic() - begin_s) * pace.rate_hz))
        _sleep_until(begin_s + step / pace.rate_hz, stop)


def _sleep_until(instant_s: float, stop: StopFlag) -> None:
    while not stop() and (left_s := instant_s - time.monotonic()) > 0:
        time.sleep(min(left_s, LONGEST_SLEEP_S))
