"""What numba's compiled code has for the bits of a number; numba keeps it in a module that it may move."""

from numba.cpython.unsafe.numbers import trailing_zeros

__all__ = ["trailing_zeros"]
