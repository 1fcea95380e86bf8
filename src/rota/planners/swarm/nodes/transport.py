"""The ways by which robots' datagrams go: UDP, or a topic of ROS 2."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Protocol

from rota.planners.swarm.nodes.udp import UdpPort, addresses_of, clock_of
from rota.planning.robot_processes import ProcessSettings

UDP_START_S = 0.5
ROS2_START_S, ROS2_ROBOT_S = 3.0, 0.5  # nodes find each other, each time all the others


class Port(Protocol):
    """What a robot's process sends and receives by."""

    def receive(self) -> Iterator[bytes]:
        """The datagrams that have arrived, in a bounded number; of longer ones so much that their length tells them."""

    def send(self, datagram: bytes) -> None:
        """Send to all others; what cannot be sent is lost."""

    def close(self) -> None:
        """Let go of it."""


def open_port(settings: ProcessSettings, fleet: int, own: int) -> Port:
    """The port of a robot by its number in the fleet; number ``fleet`` is the recorder's, which only listens.

    Raises LinkError where it cannot be opened, RotaError where ROS 2 is not installed.
    """
    if settings.transport == "ros2":
        from rota.planners.swarm.nodes.topic import TopicPort

        return TopicPort("rota_recorder" if own == fleet else f"rota_robot_{own + 1}")
    addresses = addresses_of(settings, fleet)
    others = () if own == fleet else (*addresses[:own], *addresses[own + 1 :])
    return UdpPort(addresses[own], others)


def prepare(settings: ProcessSettings, robots: int) -> float:
    """Load what ports of forked processes need; returns the seconds that so many take to open them.

    Raises RotaError where ROS 2 is asked for and not installed.
    """
    if settings.transport == "udp":
        return UDP_START_S
    from rota.planners.swarm.nodes.topic import load_ros

    load_ros()
    return ROS2_START_S + ROS2_ROBOT_S * robots


def clock_for(settings: ProcessSettings, fleet: int) -> Callable[[], int]:
    """The clock in nanoseconds that processes of these settings go by; on ROS 2 that of the day, on any machine."""
    return time.time_ns if settings.transport == "ros2" else clock_of(addresses_of(settings, fleet))
