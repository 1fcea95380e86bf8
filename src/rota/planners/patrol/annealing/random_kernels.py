"""Random numbers in compiled loops, from a state that the caller keeps: numba's own generator belongs to a thread."""

from __future__ import annotations

from typing import Any

import numpy as np

from rota.compiled.kernel import allocation_free


@allocation_free
def uniform(rng: Any) -> float:
    """One number in [0, 1) of an xorshift64* sequence: the same on every machine and thread."""
    s = rng[0]
    s ^= s >> np.uint64(12)
    s ^= s << np.uint64(25)
    s ^= s >> np.uint64(27)
    rng[0] = s
    return float((s * np.uint64(2685821657736338717)) >> np.uint64(11)) * (1.0 / 9007199254740992.0)
