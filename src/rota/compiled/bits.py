"""What compiled code has for the bits of a number; numba keeps it in a module that it may move."""

from __future__ import annotations

from typing import Any

from numba import config
from numba.cpython.unsafe import numbers


def lowest_bit(bits: int) -> int:
    """The place of the lowest bit that is set, for kernels that are not compiled."""
    return (int(bits) & -int(bits)).bit_length() - 1


trailing_zeros: Any = lowest_bit if config.DISABLE_JIT else numbers.trailing_zeros  # type: ignore[attr-defined]
