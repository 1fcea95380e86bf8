"""The hills of the swarm's example: examples/hills.png, 128 x 128 heights that rise from black to white.

python -m docs.hills_picture
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

PICTURE = Path(__file__).parents[1] / "examples" / "hills.png"
SIDE_M = 128
# middle (x, y) as shares of the side, width in metres, height in metres
HILLS = [(0.25, 0.3, 26, 14), (0.7, 0.25, 20, 9), (0.55, 0.75, 30, 18), (0.15, 0.8, 18, 8), (0.9, 0.6, 16, 7)]
HIGHEST_M = 20.0  # that white stands for


def heights_m() -> np.ndarray:
    """(128, 128) metres, one for each square metre, the northern row first: five round hills."""
    middles = (np.arange(SIDE_M) + 0.5) / SIDE_M
    x, y = np.meshgrid(middles, middles[::-1])
    return sum(high * np.exp(-((x - a) ** 2 + (y - b) ** 2) * (SIDE_M / wide) ** 2) for a, b, wide, high in HILLS)


def picture() -> Image.Image:
    """The heights as 16 bits of grey."""
    return Image.fromarray(np.round(heights_m() / HIGHEST_M * 65535).astype(np.uint16))


if __name__ == "__main__":
    picture().save(PICTURE, optimize=True)
