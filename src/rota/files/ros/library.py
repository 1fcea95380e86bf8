"""Messages that the rosbags library serialises: those that come one at a time. It is the extra ``ros``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rota.errors import RotaError
from rota.files.ros.grids import GroundGrid
from rota.files.ros.names import MAP_FRAME
from rota.files.ros.wire import NS_PER_S, TRANSFORMS_KIND, Generation, Messages, Stamps

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

GRID_KIND = "nav_msgs/msg/OccupancyGrid"


def require_rosbags(what: str) -> None:
    """Raise RotaError where the library that writes bags is not installed."""
    try:
        import rosbags.interfaces  # noqa: F401
    except ImportError:
        raise RotaError(f"{what} needs the rosbags library: pip install 'rota[ros]'") from None


def types_of(generation: Generation) -> Typestore:
    """The message types of a generation of ROS."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    if generation == 2:
        return get_typestore(Stores.ROS2_HUMBLE)
    types = get_typestore(Stores.ROS1_NOETIC)
    types.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS_KIND))
    return types


def grid_message(topic: str, grid: GroundGrid, stamps: Stamps, generation: Generation, types: Typestore) -> Messages:
    """The OccupancyGrid of a grid, of the one time in ``stamps``."""
    kinds, header = types.types, header_of(int(stamps[0]), generation, types)
    x, y = grid.corner_m
    corner = kinds["geometry_msgs/msg/Pose"](
        position=kinds["geometry_msgs/msg/Point"](x=x, y=y, z=0.0),
        orientation=kinds["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
    )
    rows, columns = grid.values.shape
    about = kinds["nav_msgs/msg/MapMetaData"](
        map_load_time=header.stamp, resolution=grid.cell_m, width=columns, height=rows, origin=corner
    )
    message = kinds[GRID_KIND](header=header, info=about, data=grid.values.ravel())
    data = bytes((types.serialize_ros1 if generation == 1 else types.serialize_cdr)(message, GRID_KIND))
    return Messages(topic=topic, kind=GRID_KIND, stamps_ns=stamps, data=data, size=len(data), latched=True)


def header_of(stamp: int, generation: Generation, types: Typestore) -> Any:
    """A header on the map."""
    kinds: Mapping[str, Any] = types.types
    time = kinds["builtin_interfaces/msg/Time"](sec=stamp // NS_PER_S, nanosec=stamp % NS_PER_S)
    counted = {"seq": 0} if generation == 1 else {}
    return kinds["std_msgs/msg/Header"](**counted, stamp=time, frame_id=MAP_FRAME)
