"""The crowds of the swarm's example: examples/crowds.png, 120 x 80 pixels, the lighter the denser the crowd.

python -m docs.crowds_picture
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

PICTURE = Path(__file__).parents[1] / "examples" / "crowds.png"
SIDE_M = 2.0  # of a pixel
CROWDS = ((185, 125, 22, 1.0), (60, 120, 14, 0.7), (200, 40, 16, 0.6))  # x, y, spread in metres, height


def picture() -> Image.Image:
    """The crowds as 8 bits of grey, the northern row first."""
    x, y = np.meshgrid(SIDE_M * (np.arange(120) + 0.5), SIDE_M * (np.arange(80)[::-1] + 0.5))
    dense = sum(most * np.exp(-((x - at) ** 2 + (y - up) ** 2) / (2 * wide**2)) for at, up, wide, most in CROWDS)
    return Image.fromarray(np.round(255 * np.minimum(dense, 1)).astype(np.uint8))


if __name__ == "__main__":
    picture().save(PICTURE, optimize=True)
