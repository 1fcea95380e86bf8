"""GIFs: what is stored is what was drawn, in one palette, and only where it changed."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from PIL import Image

from rota.draw.film_frames import FilmFrames
from rota.draw.gif_file import FLAT, MIXED, palette_of, write_gif
from rota.draw.house_style import house_style
from rota.draw.palette import ROUTE_COLOURS
from rota.model.plan import Plan


def written(frames: np.ndarray, palette: np.ndarray, path: Path) -> list[np.ndarray]:
    """What a reader of GIFs shows, (rows, columns, 3), in each tenth of a second."""
    write_gif(iter(frames), len(frames), palette, path, fps=10)
    shown = []
    with Image.open(path) as film:
        for k in range(film.n_frames):
            film.seek(k)
            shown += [np.asarray(film.convert("RGB"))] * (film.info["duration"] // 100)
    return shown


def nearest(frame: np.ndarray, palette: np.ndarray) -> np.ndarray:
    """The frame in colours of the palette."""
    red, green, blue = np.moveaxis(frame[..., :3].astype(int), 2, 0)
    codes, places = np.unique((red * 256 + green) * 256 + blue, return_inverse=True)
    colours = np.column_stack([codes // 65536, codes // 256 % 256, codes % 256])
    apart = np.stack([((colours - colour) ** 2).sum(axis=1) for colour in palette.astype(int)])
    return palette[apart.argmin(axis=0)][places.reshape(frame.shape[:2])]


def test_every_frame_is_shown_in_the_nearest_colours(tmp_path: Path):
    rng = np.random.default_rng(3)
    frames = np.repeat(rng.integers(0, 256, (1, 30, 40, 4), dtype=np.uint8), 6, axis=0)
    for k in range(1, 6):
        frames[k:, 2 * k : 2 * k + 9, 3 * k : 3 * k + 11] = rng.integers(0, 256, 4, dtype=np.uint8)
    frames[3] = frames[2] = frames[1]
    frames[5, 0, 0] ^= 1  # a change too small for another colour
    palette = rng.integers(0, 256, (20, 3), dtype=np.uint8)
    shown = written(frames, palette, tmp_path / "film.gif")
    assert len(shown) == len(frames)
    for picture, frame in zip(shown, frames, strict=True):
        np.testing.assert_array_equal(picture, nearest(frame, palette))


def test_the_palette_keeps_key_colours_and_large_flat_parts(yard: Plan):
    with house_style():
        film = FilmFrames(yard, 1.0)
        sample = film.sample()
        palette = palette_of(sample, film.key_colours())
    kept = {tuple(int(part) for part in colour) for colour in palette}
    # the yard has routes in the first three colours
    for colour in (*ROUTE_COLOURS[:3], "#000000", "#FFFFFF"):
        assert tuple(bytes.fromhex(colour[1:])) in kept
    assert len(palette) <= len(film.key_colours()) + FLAT + MIXED < 256
    colours, counts = np.unique(sample[..., :3].reshape(-1, 3), axis=0, return_counts=True)
    large = [tuple(map(int, colour)) for colour in colours[counts > 0.005 * counts.sum()]]
    assert len(large) >= 8
    assert set(large) <= kept


def test_a_film_of_few_colours_needs_no_mixes():
    sample = np.zeros((4, 4, 4), dtype=np.uint8)
    sample[0, 0] = 200
    keys = np.uint8([[0, 0, 0], [9, 9, 9]])
    assert palette_of(sample, keys).tolist() == [[0, 0, 0], [9, 9, 9], [200, 200, 200]]


def test_only_changes_are_stored(yard: Plan, tmp_path: Path):
    with house_style():
        film = FilmFrames(yard, 1.0)
        palette = palette_of(film.sample(), film.key_colours())
        frames = np.array(list(film.frames(np.arange(12) / 8)))
    written(frames, palette, tmp_path / "film.gif")
    whole = 0
    for frame in frames:
        picture = Image.fromarray(nearest(frame, palette)).quantize(len(palette), dither=Image.Dither.NONE)
        picture.save(buffer := io.BytesIO(), format="GIF")
        whole += len(buffer.getvalue())
    assert (tmp_path / "film.gif").stat().st_size < whole / 3
