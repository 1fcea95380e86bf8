"""Arrays of one kind of number, as annotations name them; what counts cells and states is short."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rota.model.arrays import Flags as Flags, Floats as Floats, Ints as Longs

__all__ = ["Flags", "Floats", "Ints", "Longs"]

Ints = NDArray[np.int32]
