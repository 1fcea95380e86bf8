"""A plan as a film: robots moving, what they see, and how long ago each place was last seen."""

from __future__ import annotations

import math
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from rota.draw.deployment_frames import DeploymentFrames
from rota.draw.deployment_maps import is_deployment
from rota.draw.film_frames import FilmFrames
from rota.draw.gif_file import Frame, palette_of, write_gif
from rota.draw.house_style import house_style
from rota.errors import RotaError
from rota.files.atomic_write import replaced_file, require_suffix
from rota.model.arrays import Floats
from rota.model.plan import Plan
from rota.routes.constant_speeds import plan_at_constant_speeds

# frames per second: a GIF grows with each, an MP4 hardly
FORMATS = {".gif": 8, ".mp4": 20}
USUAL_S, LONGEST_S = 12.0, 60.0


def _positive(name: str, value: float | None, most: float) -> None:
    if value is not None and not (math.isfinite(value) and 0 < value <= most):
        raise RotaError(f"{name}: {value!r} is not allowed; must be greater than 0 and at most {most:g}")


def film_times_s(plan: Plan, seconds: float | None, fps: int, speedup: float | None) -> tuple[Floats, float]:
    """The plan's time (n,) in seconds at each frame, and the speed-up.

    What is shown begins at 0 and lasts to the end of the first round of every loop, unless ``seconds`` and ``speedup``
    say otherwise; without them the film takes 12 s, or less where the loops are done earlier in real time.
    """
    span_s = max((float(trajectory.times_s[-1]) for trajectory in plan), default=0.0) or 1.0
    if speedup is None:
        speedup = max(1.0, span_s / (USUAL_S if seconds is None else seconds))
    if seconds is None:
        seconds = min(span_s / speedup, LONGEST_S)
    frames = max(2, round(seconds * fps))
    return np.arange(frames, dtype=np.float64) * (speedup / fps), speedup


def animate_plan(
    plan: Plan, path: str | Path, *, seconds: float | None = None, fps: int | None = None, speedup: float | None = None
) -> None:
    """Animate a plan to ``path`` as GIF or MP4, by its suffix; the file appears whole or not at all.

    seconds: length of the film, at most 3600; default: one round of the longest loop, in about 12 s, at most 60 s.
    fps: frames per second, 1 to 60; default: 8 for a GIF, 20 for an MP4. speedup: seconds of the plan per second of
    film; default: what makes both fit, at least 1. Ground is coloured by the time since it was last seen, in periods of
    the place, from a start at which nothing has been seen; where nothing is asked and robots hold in the end, the film
    shows what is in range. Raises RotaError for another suffix, numbers out of range, a
    folder that cannot be written to, or an MP4 without the ffmpeg program or with one that fails.
    """
    path = Path(path)
    suffix = require_suffix(path, tuple(FORMATS), "a film")
    _positive("seconds", seconds, 3600)
    _positive("fps", fps, 60)
    _positive("speedup", speedup, 1e6)
    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise RotaError(f"{path}: an MP4 needs the ffmpeg program, which is not on the PATH; a .gif needs nothing")
    fps = FORMATS[suffix] if fps is None else fps
    times_s, speedup = film_times_s(plan, seconds, fps, speedup)
    plan = plan_at_constant_speeds(plan)
    with house_style(), replaced_file(path) as partial:
        film = DeploymentFrames(plan, speedup) if is_deployment(plan) else FilmFrames(plan, speedup)
        if suffix == ".gif":
            write_gif(film.frames(times_s), len(times_s), palette_of(film.sample(), film.key_colours()), partial, fps)
        else:
            _write_mp4(film.frames(times_s), film.size_px, partial, fps)


def _write_mp4(frames: Iterator[Frame], size_px: tuple[int, int], path: Path, fps: int) -> None:
    """Encode frames by ffmpeg; RotaError with its complaint when it fails."""
    raw = ["-f", "rawvideo", "-pixel_format", "rgba", "-video_size", f"{size_px[0]}x{size_px[1]}"]
    # yuv420p and the index in front: what browsers and phones can play
    coded = ["-an", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-fflags", "+bitexact", "-f", "mp4"]
    command = ["ffmpeg", "-loglevel", "error", "-y", *raw, "-framerate", str(fps), "-i", "-", *coded, str(path)]
    with tempfile.TemporaryFile() as complaints:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=complaints)
        assert process.stdin is not None
        try:
            for frame in frames:
                process.stdin.write(frame.tobytes())
        except BrokenPipeError:
            pass  # its complaint says more than ours
        except BaseException:
            process.kill()
            raise
        finally:
            with suppress(BrokenPipeError):
                process.stdin.close()
            code = process.wait()
        if code:
            complaints.seek(0)
            words = complaints.read().decode(errors="replace").strip()
            raise RotaError(f"ffmpeg failed with code {code}: {words or 'no reason given'}")
