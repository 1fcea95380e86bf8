"""A node of ROS 2 that publishes messages which are bytes already; on loopback unless told otherwise."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from rota.errors import RotaError
from rota.files.ros.wire import Messages

LOOPBACK_PROFILE = Path(__file__).with_name("loopback.xml")
# who has set one of these has chosen a network
CHOSEN_BY = (
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_LOCALHOST_ONLY",
    "FASTDDS_DEFAULT_PROFILES_FILE",
    "FASTRTPS_DEFAULT_PROFILES_FILE",
    "CYCLONEDDS_URI",
)
BEFORE_RANGES = ("foxy", "galactic", "humble")  # know ROS_LOCALHOST_ONLY alone
WHEELS = " ".join(f"ros-kilted-{name}" for name in (
    "rclpy", "rmw-fastrtps-cpp", "nav-msgs", "sensor-msgs", "std-srvs", "visualization-msgs"
))  # fmt: skip


def stay_on_loopback() -> None:
    """Let this process's nodes be heard on this machine alone, unless the environment has chosen a network.

    To be called before the first node is made.
    """
    if any(os.environ.get(name) for name in CHOSEN_BY):
        return
    if os.environ.get("ROS_DISTRO") in BEFORE_RANGES:
        os.environ["ROS_LOCALHOST_ONLY"] = "1"
        return
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    # the range keeps discovery here, but sockets listen everywhere
    os.environ["FASTDDS_DEFAULT_PROFILES_FILE"] = str(LOOPBACK_PROFILE)


class Publishers:
    """A node's publishers, made as topics come up. ``left_out``: the packages of messages that are not installed."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._publishers: dict[str, Any] = {}
        self.left_out: set[str] = set()

    def publish(self, messages: Iterable[Messages]) -> None:
        """Publish them all; those of packages that are not installed are left out."""
        for each in messages:
            if each.topic not in self._publishers:
                self._publishers[each.topic] = self._make(each)
            publisher = self._publishers[each.topic]
            if publisher is not None:
                for number in range(len(each.stamps_ns)):
                    publisher.publish(each.data[number * each.size : (number + 1) * each.size])

    def _make(self, message: Messages) -> Any:
        """The publisher of a topic; None where the package of its messages is not installed."""
        from rclpy.qos import DurabilityPolicy, QoSProfile

        package, _, name = message.kind.split("/")
        try:
            kind = getattr(import_module(f"{package}.msg"), name)
        except ImportError:
            self.left_out.add(package)
            return None
        if not message.latched:
            return self._node.create_publisher(kind, message.topic, 10)
        # the static transforms of all robots are messages of their own, all of them to be kept
        quality = QoSProfile(depth=1000 if message.topic == "/tf_static" else 1)
        quality.durability = DurabilityPolicy.TRANSIENT_LOCAL
        return self._node.create_publisher(kind, message.topic, quality)


def require_rclpy(*packages: str) -> None:
    """Raise RotaError where rclpy or one of these packages of messages is not installed."""
    try:
        for package in ("rclpy", *packages):
            import_module(package)
    except ImportError as error:
        raise RotaError(
            f"ROS 2 cannot be reached: {error}. Source a ROS 2 installation, or pip install {WHEELS}"
        ) from None


@contextmanager
def opened_node(name: str, *, use_sim_time: bool = False) -> Iterator[Any]:
    """A node that is gone after the block, with signals left to the program. RotaError where ROS 2 cannot be used.

    use_sim_time: its clock is that of /clock.
    """
    require_rclpy()
    import rclpy
    from rclpy.parameter import Parameter
    from rclpy.signals import SignalHandlerOptions

    try:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = rclpy.create_node(name, parameter_overrides=[Parameter("use_sim_time", value=use_sim_time)])
    except Exception as error:  # rclpy's own errors have no common base
        raise RotaError(f"ROS 2 cannot be reached: {error}") from error
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
