"""The hills of the swarm's example: examples/hills.png, 128 x 128 heights that rise from black to white.

python -m docs.hills_picture
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from rota_studies.chen2018.maps import hills_m

PICTURE = Path(__file__).parents[1] / "examples" / "hills.png"
SIDE_M = 128
HIGHEST_M = 20.0  # that white stands for


def heights_m() -> np.ndarray:
    """(128, 128) metres, one for the middle of each square metre, the northern row first."""
    middles = np.arange(SIDE_M) + 0.5
    return np.array([[hills_m(x, y) for x in middles] for y in middles[::-1]])


def picture() -> Image.Image:
    """The heights as 16 bits of grey."""
    return Image.fromarray(np.round(heights_m() / HIGHEST_M * 65535).astype(np.uint16))


if __name__ == "__main__":
    picture().save(PICTURE, optimize=True)
