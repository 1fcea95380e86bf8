"""How much memory a worker may take, where the system can be told."""

from __future__ import annotations

import sys

# memory that is asked for and not used yet counts here, and a library may loop where it gets none
ROOM_BYTES = 2**30


NO_ROOM = ("bad_alloc", "can't start new thread")  # how GEOS and Python's threads say what others call MemoryError


def is_out_of_memory(error: Exception) -> bool:
    """Whether an error says that memory was refused, whichever library was the one to ask for it."""
    return isinstance(error, MemoryError) or any(said in str(error) for said in NO_ROOM)


def limit_memory(most_bytes: int) -> None:
    """Let allocations beyond ``most_bytes``, and some room, fail; data only is counted, since loops map much more.

    The server ends planning processes that take more before that; this is for those that grow at a bound. Without
    effect on systems that know no such limit (Windows, macOS).
    """
    if sys.platform != "linux":
        return
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    most_bytes += ROOM_BYTES
    soft = most_bytes if hard == resource.RLIM_INFINITY else min(most_bytes, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))
