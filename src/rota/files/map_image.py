"""The image of a ROS map: how bright each pixel is, as map_server takes it."""

from __future__ import annotations

import io
import re
import struct
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rota.errors import MissionError
from rota.files.local_file import read_bytes
from rota.model.arrays import Floats

if TYPE_CHECKING:
    from PIL import Image

MOST_PIXELS = 100_000_000

_MOST_DIGITS = 9
_STRIP_ROWS = 64
_PGM_NUMBER = re.compile(rb"(?:\s|#[^\r\n]*)*(\d+)")


def read_brightness(path: Path, *, alpha_counts: bool) -> Floats:
    """(rows, columns) brightness in 0..255, the top row first.

    Channels are averaged; with ``alpha_counts`` opacity is one of them (map_server's trinary mode, map_io.cpp in nav2).
    Reads PGM (P2, P5, any maxval) and PNG. Raises MissionError for anything else and for damaged files.
    """
    data = read_bytes(path, "a .pgm or .png image")
    if data[:2] in (b"P2", b"P5"):
        return _read_pgm(path, data)
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        return _read_png(path, data, alpha_counts=alpha_counts)
    raise MissionError(f"{path}: neither PGM (P2 or P5) nor PNG; convert the image to one of them")


def _read_pgm(path: Path, data: bytes) -> Floats:
    """The grey values, 0 to 255, of a PGM image; MissionError for a damaged one."""
    at, header = 2, []
    for field in ("width", "height", "maxval"):
        number = _PGM_NUMBER.match(data, at)
        if number is None or len(number[1]) > _MOST_DIGITS:
            raise MissionError(f"{path}: damaged PGM: no {field} in the header")
        header.append(int(number[1]))
        at = number.end()
    columns, rows, brightest = header
    if not 0 < brightest < 65536 or not columns * rows:
        raise MissionError(f"{path}: damaged PGM: {columns} x {rows} pixels up to {brightest}; 1..65535 are allowed")
    _require_moderate(path, columns, rows)
    if data[:2] == b"P2":
        values = _plain_values(path, data[at:])
    else:
        depth = np.dtype(">u2" if brightest > 255 else "u1")
        # exactly one blank separates the header from the pixels
        raster = data[at + 1 :]
        values = np.frombuffer(raster[: len(raster) // depth.itemsize * depth.itemsize], dtype=depth)
    if len(values) < columns * rows:
        raise MissionError(f"{path}: damaged PGM: {len(values)} of {columns} x {rows} pixels are there")
    pixels = values[: columns * rows].astype(np.float64).reshape(rows, columns)
    if pixels.max() > brightest:
        raise MissionError(f"{path}: damaged PGM: a pixel of {pixels.max():.0f} where {brightest} is the greatest")
    return pixels if brightest == 255 else pixels * 255 / brightest


def _plain_values(path: Path, text: bytes) -> Floats:
    words = re.sub(rb"#[^\r\n]*", b"", text).split()
    if not all(word.isdigit() and len(word) <= _MOST_DIGITS for word in words):
        raise MissionError(f"{path}: damaged PGM: a P2 file holds whole numbers up to 65535 only")
    return np.array(words, dtype=np.float64)


def _read_png(path: Path, data: bytes, *, alpha_counts: bool) -> Floats:
    """The grey values, 0 to 255, of a PNG image; MissionError for a damaged one."""
    from PIL import Image

    if len(data) >= 24:
        # before Pillow sees them, which warns of large images and refuses larger ones in its own words
        _require_moderate(path, *struct.unpack(">II", data[16:24]))
    try:
        with warnings.catch_warnings(), Image.open(io.BytesIO(data), formats=["PNG"]) as image:
            warnings.simplefilter("ignore")
            image.load()
            if image.mode.startswith("I"):  # 16 bits a pixel
                return np.asarray(image, dtype=np.float64) * (255 / 65535)
            has_alpha = "A" in image.mode or "transparency" in image.info
            channels = 4 if has_alpha and alpha_counts else 3
            return _average(image, "RGBA" if has_alpha else "RGB", channels)
    except (OSError, SyntaxError, ValueError, KeyError, IndexError, struct.error) as error:
        raise MissionError(f"{path}: damaged PNG: {error}") from None


def _average(image: Image.Image, mode: str, channels: int) -> Floats:
    """The mean of an image's first channels in a mode, strip by strip: eight bytes a channel would not fit."""
    columns, rows = image.size
    mean = np.empty((rows, columns))
    for top in range(0, rows, _STRIP_ROWS):
        bottom = min(top + _STRIP_ROWS, rows)
        strip = np.asarray(image.crop((0, top, columns, bottom)).convert(mode), dtype=np.float64)
        mean[top:bottom] = strip[..., :channels].mean(axis=2)
    return mean


def _require_moderate(path: Path, columns: int, rows: int) -> None:
    if columns * rows > MOST_PIXELS:
        raise MissionError(f"{path}: {columns} x {rows} pixels; at most {MOST_PIXELS:,} are allowed: coarsen the map")
