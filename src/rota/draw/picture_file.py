"""Pictures as files: PNG, SVG or PDF, the same bytes for the same content."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rota.draw.house_style import house_style
from rota.files.atomic_write import replaced_file, require_suffix

DPI = 160
FORMATS = (".png", ".svg", ".pdf")
UNDATED: dict[str, dict[str, None]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None, "ModDate": None}}


def new_figure(width: float, height: float) -> Figure:
    """An empty figure, so many inches wide and high."""
    fig = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(fig)
    return fig


def write_picture(path: str | Path, make: Callable[[], Figure]) -> None:
    """Write what is made to a file, by its suffix; RotaError for another one and a folder that cannot be written to."""
    suffix = require_suffix(path, FORMATS, "a picture")
    with house_style():
        fig = make()
        with replaced_file(path) as partial:
            fig.savefig(partial, format=suffix[1:], dpi=DPI, metadata=UNDATED.get(suffix))
