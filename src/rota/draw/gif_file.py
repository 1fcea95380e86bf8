"""Frames to a small GIF: few colours, one palette for all, and of each frame only what has changed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rota.model.arrays import Ints

Frame = NDArray[np.uint8]
Palette = NDArray[np.uint8]

FLAT, MIXED = 24, 16


def palette_of(sample: Frame, keys: Palette) -> Palette:
    """The palette (n, 3) of a film like ``sample`` (rows, columns, 4): ``keys`` (k, 3), its commonest colours, mixes.

    Large flat parts keep their very colours; mixed are those between them, the soft edges of lines and letters.
    """
    codes, counts = np.unique(_codes(sample), return_counts=True)
    colours = _colours(codes[np.argsort(-counts, kind="stable")])
    colours = colours[~(colours[:, None] == keys).all(axis=2).any(axis=1)]
    palette = np.concatenate([keys, colours[:FLAT]])
    if len(colours) > FLAT:
        mixed = Image.fromarray(colours[None, FLAT:]).quantize(MIXED, Image.Quantize.MEDIANCUT).getpalette() or []
        palette = np.append(palette, np.array(mixed[: 3 * MIXED], dtype=np.uint8).reshape(-1, 3), axis=0)
    return palette


def _codes(frame: Frame) -> Ints:
    """Each pixel's red, green and blue as one number, (rows, columns)."""
    red, green, blue = (frame[..., k].astype(np.int64) for k in range(3))
    return (red << 16) | (green << 8) | blue


def _colours(codes: Ints) -> Palette:
    """Red, green and blue (n, 3) of codes (n,)."""
    return np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=1).astype(np.uint8)


def _nearest(codes: Ints, palette: Palette) -> NDArray[np.uint8]:
    """The place in the palette (n,) of the colour nearest to each code (n,)."""
    unique, inverse = np.unique(codes, return_inverse=True)
    apart = ((_colours(unique).astype(np.int64)[:, None] - palette) ** 2).sum(axis=2)
    return np.asarray(apart.argmin(axis=1)[inverse], dtype=np.uint8)


def _changes(frames: Iterator[Frame], palette: Palette) -> Iterator[Image.Image]:
    """Each frame as places in the palette; where it shows what the one before showed: a place beyond the palette."""
    before = places = None
    for frame in frames:
        codes = _codes(frame)
        if before is None or places is None:
            shown = places = _nearest(codes.ravel(), palette).reshape(codes.shape)
        else:
            moved = places.copy()
            differs = codes != before
            moved[differs] = _nearest(codes[differs], palette)
            shown = np.where(moved != places, moved, np.uint8(len(palette)))
            places = moved
        before = codes
        picture = Image.fromarray(shown)
        picture.putpalette(np.append(palette, palette[:1], axis=0).tobytes())
        yield picture


def write_gif(frames: Iterator[Frame], count: int, palette: Palette, path: Path, fps: int) -> None:
    """Write ``count`` frames (rows, columns, 4) to ``path``; the film begins anew at its end, for ever."""
    # a GIF counts hundredths of a second; rounding their sum keeps the film's length
    ticks = np.diff(np.round(np.arange(count + 1) * 100 / fps)).astype(int)
    pictures = _changes(frames, palette)
    first = next(pictures)
    first.save(
        path,
        format="GIF",
        save_all=True,
        append_images=pictures,
        duration=[10 * int(n) for n in ticks],
        loop=0,
        disposal=1,
        transparency=len(palette),
        optimize=False,
    )
