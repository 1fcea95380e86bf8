"""Datagrams on a topic of ROS 2, which all robots of a swarm and its recorder have in common."""

from __future__ import annotations

import time
from array import array
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

from rota.planners.swarm.nodes.telling import SIZE
from rota.ros2.node import opened_node, require_rclpy, stay_on_loopback

TOPIC = "/rota_swarm"
MOST_KEPT = 4096  # datagrams that wait to be read; of more the oldest are lost
FOUND_S, LONGEST_S = 1.0, 10.0  # all are found when none was for so long; it is waited no longer than this


class TopicPort:
    """A publisher and a subscription of std_msgs/UInt8MultiArray, best effort; on this machine unless told otherwise.

    name: of the node. Opening it takes until the middleware finds no more others. Raises RotaError where ROS 2 is not
    installed or cannot be reached.
    """

    def __init__(self, name: str) -> None:
        load_ros()
        from rclpy.qos import QoSProfile, ReliabilityPolicy
        from std_msgs.msg import UInt8MultiArray

        self._closing = ExitStack()
        node = self._closing.enter_context(opened_node(name))
        quality = QoSProfile(depth=MOST_KEPT, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._kind = UInt8MultiArray
        self._publisher = node.create_publisher(UInt8MultiArray, TOPIC, quality)
        self._subscription = node.create_subscription(UInt8MultiArray, TOPIC, lambda _: None, quality)
        _wait_until_found(self._publisher)

    def receive(self) -> Iterator[bytes]:
        """What has arrived, also from itself, at most ``MOST_KEPT``."""
        handle = self._subscription.handle
        for _ in range(MOST_KEPT):
            # an executor would wait for each one by itself
            with handle:
                taken = handle.take_message(self._kind, False)
            if taken is None:
                return
            yield bytes(taken[0].data[: SIZE + 1])

    def send(self, datagram: bytes) -> None:
        """Publish it."""
        self._publisher.publish(self._kind(data=array("B", datagram)))

    def close(self) -> None:
        """End the node."""
        self._closing.close()


def load_ros() -> None:
    """Load what ports need, so that processes forked afterwards have it; RotaError where it is not installed."""
    stay_on_loopback()
    require_rclpy("std_msgs.msg")


def _wait_until_found(publisher: Any) -> None:
    """Return when the number of subscriptions has not changed for ``FOUND_S``."""
    began_s = changed_s = time.monotonic()
    found = 0
    while (now_s := time.monotonic()) - changed_s < FOUND_S and now_s - began_s < LONGEST_S:
        if (count := publisher.get_subscription_count()) != found:
            found, changed_s = count, now_s
        time.sleep(0.02)
