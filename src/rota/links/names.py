"""The links by name: the module of each, and what it reaches."""

from __future__ import annotations

LINKS = {
    "simulated": ("rota.links.simulated", "vehicles in this process, which need nothing"),
    "mavlink": ("rota.links.mavlink", "ArduPilot and PX4 vehicles; needs rota[mavlink]"),
    "vda5050": ("rota.links.vda5050", "VDA 5050 vehicles over MQTT; needs rota[vda5050]"),
    "ros2": ("rota.links.ros2", "robots on ROS 2, by standard messages; needs rclpy"),
}
