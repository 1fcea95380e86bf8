"""Colours and line styles that survive colour blindness and a grey print."""

from __future__ import annotations

from typing import Literal

from matplotlib import colormaps
from matplotlib.colors import Colormap, to_rgb

LineStyle = Literal["solid"] | tuple[float, tuple[float, ...]]

# Okabe-Ito without yellow, which vanishes on white, and with wine from Paul Tol's muted set; dark and light in turn,
# so that neighbours in the list also differ in grey
ROUTE_COLOURS = ("#0072B2", "#E69F00", "#882255", "#009E73", "#000000", "#56B4E9", "#D55E00", "#CC79A7")
ROUTE_STYLES: tuple[LineStyle, ...] = ("solid", (0.0, (5.0, 1.2)), (0.0, (1.6, 1.0)), (0.0, (6.0, 1.2, 1.4, 1.2)))

GROUND = "#FDFDFB"
OUTSIDE = "#ECECEC"
IMPORTANT = "#B8A4C9"  # ground of the greatest importance; what matters less is nearer to GROUND
AREA_EDGE = "#333333"
OBSTACLE = "#4A4A4A"
NO_ENTRY = "#B3261E"
NO_SIGHT = "#2E7D32"
ZONE_EDGE = "#6B4E16"
# nearest to white: the longest period
ZONE_TINTS = ("#F9F1DD", "#F4E5BF", "#EED79C", "#E6C678")

OVER_PERIOD = "#E4003A"
NEVER_SEEN = "#FFB9C9"
NOTHING_ASKED = "#FFFFFF"
EXCLUDED = "#A8A8A8"
NOT_SEEN_YET = "#B9B9B9"
# what robots that hold have in range; it lets what lies beneath show
COVERED = "#009E73"
COVERED_EDGE = "#00664B"


CHARGER, CHARGER_INK = "#FFE45C", "#222222"
DOCKED = "#6E6E6E"  # a robot on a charger
CHARGES, RESTS, CHARGES_EDGE = "#E2E2E2", "#F4F4F4", "#9A9A9A"  # in charts: it fills, it is full
LANDS = "#8FA3B5"  # in charts: it lands, or climbs
FLOWN_ONCE = "#7A7A7A"  # flights that lead into those that repeat
BATTERY, RESERVE = "#222222", "#C4001A"
FILLED_WELL, FILLED_LOW = "#1F9E4B", "#E8A400"  # bars of batteries; below the reserve and a quarter more: RESERVE


def route_style(index: int) -> tuple[str, LineStyle]:
    """Colour and line style of the ``index``-th route; the pair repeats after 32, the colour after 8."""
    colours, styles = len(ROUTE_COLOURS), len(ROUTE_STYLES)
    return ROUTE_COLOURS[index % colours], ROUTE_STYLES[index // colours % styles]


def pale(colour: str, share: float = 0.5) -> tuple[float, float, float]:
    """A colour with so much white in it."""
    red, green, blue = ((1 - share) * part + share for part in to_rgb(colour))
    return red, green, blue


def ink_on(colour: str) -> str:
    """Black or white, whichever reads better on ``colour``."""
    red, green, blue = to_rgb(colour)
    return "white" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.55 else "black"


def gap_colours(levels: int = 256) -> Colormap:
    """Viridis for 0 to 1 in this many levels, a loud red above 1 (too late), nothing for cells without a value."""
    return colormaps["viridis"].resampled(levels).with_extremes(over=OVER_PERIOD, bad=(0, 0, 0, 0))
