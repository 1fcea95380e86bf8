"""The memory that a command takes."""

from __future__ import annotations

import ctypes
from contextlib import suppress

M_ARENA_MAX = -8  # of glibc's malloc.h


def use_one_heap() -> None:
    """Let all threads take memory from one heap, where the C library is glibc; nothing elsewhere.

    A search allocates in one thread at a time, and leaves holes in a heap of its own that no other thread fills.
    """
    with suppress(OSError, AttributeError, TypeError):  # another C library, or none that can be asked
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, 1)
