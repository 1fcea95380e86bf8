"""How much memory a worker may take, where the system can be told."""

from __future__ import annotations

import sys


def limit_memory(most_bytes: int) -> None:
    """Let allocations beyond ``most_bytes`` fail. Data only is counted: compiled loops map far more than they use.

    Without effect on systems that know no such limit (Windows, macOS).
    """
    if sys.platform != "linux":
        return
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    soft = most_bytes if hard == resource.RLIM_INFINITY else min(most_bytes, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))
