"""What a browser makes of a playback's bytes, in Python."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rota.model.field_values import Json
from rota.playback.container import HEAD, MAGIC, TYPES, VERSION


def unpack(data: bytes) -> tuple[Json, dict[str, NDArray[Any]]]:
    """The header and the arrays by name; ValueError for other bytes."""
    if len(data) < HEAD.size:
        raise ValueError(f"{len(data)} bytes are no playback")
    magic, version, length = HEAD.unpack_from(data)
    if magic != MAGIC or version != VERSION:
        raise ValueError(f"not a playback of version {VERSION}: it begins with {data[:12]!r}")
    header = json.loads(data[HEAD.size : HEAD.size + length])
    begin = HEAD.size + length
    arrays = {
        name: np.frombuffer(data, TYPES[told["type"]], told["length"], begin + told["offset"])
        for name, told in header["arrays"].items()
    }
    return header, arrays
