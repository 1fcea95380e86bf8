"""The file of a playback: a header in JSON, then plain arrays that a browser takes as they are. Little endian.

8 bytes "ROTAPLAY", u32 version, u32 length of the header in bytes, the header (UTF-8, padded with spaces), the arrays.
The header's ``arrays`` tells of each its type, its offset in bytes from where the arrays begin, and how many numbers it
has. The arrays begin at a multiple of 8, and so does each of them.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rota.model.field_values import Json

Arrays = Mapping[str, NDArray[Any]]

MAGIC, VERSION = b"ROTAPLAY", 1
HEAD = struct.Struct("<8sII")
TYPES = {"f64": "<f8", "f32": "<f4", "u32": "<u4", "u16": "<u2", "u8": "u1"}
_NAMES = {np.dtype(code): name for name, code in TYPES.items()}
EDGE = 8


def pack(header: Json, arrays: Arrays) -> bytes:
    """The bytes of a playback. Each array has a dtype of ``TYPES``."""
    told: Json = {}
    blocks: list[bytes] = []
    offset = 0
    for name, array in arrays.items():
        data = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<"), copy=False)
        told[name] = {"type": _NAMES[data.dtype], "offset": offset, "length": int(data.size)}
        block = data.tobytes()
        blocks.append(block + bytes(-len(block) % EDGE))
        offset += len(blocks[-1])
    text = json.dumps({**header, "arrays": told}, allow_nan=False, ensure_ascii=False, separators=(",", ":")).encode()
    text += b" " * (-(HEAD.size + len(text)) % EDGE)
    return b"".join([HEAD.pack(MAGIC, VERSION, len(text)), text, *blocks])
