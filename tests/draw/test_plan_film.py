"""Films: frames, times, sizes, and what they show as seen."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image
from tests.files.with_mass import with_mass

from rota.draw import animate_plan
from rota.draw.film_frames import FilmFrames
from rota.draw.plan_film import film_times_s
from rota.errors import RotaError
from rota.model.plan import Plan, Trajectory


def stand_in(folder: Path, script: str) -> None:
    """A program called ffmpeg in ``folder``."""
    (folder / "ffmpeg").write_text(f"#!/bin/sh\n{script}\n")
    (folder / "ffmpeg").chmod(0o755)


def test_gif_has_the_frames_and_the_length_asked_for(yard: Plan, tmp_path: Path):
    path = tmp_path / "film.gif"
    animate_plan(yard, path, seconds=1.5, fps=12, speedup=4)
    assert path.read_bytes()[:6] == b"GIF89a"
    with Image.open(path) as film:
        assert film.n_frames == 18
        lengths = []
        for k in range(film.n_frames):
            film.seek(k)
            lengths.append(film.info["duration"])
    assert sum(lengths) == 1500
    assert set(lengths) <= {80, 90}
    assert list(tmp_path.iterdir()) == [path]


def test_default_is_one_round_of_the_longest_loop_in_twelve_seconds(yard: Plan, strip: Plan):
    times, speedup = film_times_s(strip, None, 12, None)
    assert (len(times), speedup) == (144, pytest.approx(160 / 12))
    np.testing.assert_allclose(times[[0, 1, -1]], [0, 160 / 144, 160 - 160 / 144])
    # a loop of 23 s and speed-up 0.1 would take 230 s of film; a minute is the most
    assert len(film_times_s(yard, None, 10, 0.1)[0]) == 600
    # short loops are shown in real time
    short = replace(yard, trajectories=yard.trajectories[3:4])
    assert film_times_s(short, 13, 10, None)[1] == 1
    assert len(film_times_s(short, 13, 10, None)[0]) == 130
    assert len(film_times_s(short, 3, 10, None)[0]) == 30


def test_frames_differ_only_where_something_moves_and_have_even_sizes(yard: Plan):
    film = FilmFrames(yard, 1.0)
    one, other = film.frames(np.array([0.0, 0.5]))
    assert film.size_px[0] % 2 == 0
    assert film.size_px[1] % 2 == 0
    assert one.shape == (film.size_px[1], film.size_px[0], 4)
    changed = (one != other).any(axis=2)
    assert 0 < changed.mean() < 0.2
    # the margin below the map and left of it stands still
    assert not changed[-60:].any()
    assert not changed[100:, :40].any()


def test_trails_follow_the_loop_round_its_corners_and_not_more_than_once(yard: Plan):
    film = FilmFrames(yard, 10.0)
    list(film.frames(np.array([0.0, 7.0, 50.0])))
    trails = [np.array(part) for part in film._trails.get_segments()]
    # a second of film is 10 s: 100 m
    for robot, length_m in ((0, 100.0), (1, 100.0), (2, 100.0)):
        assert np.hypot(*np.diff(trails[robot], axis=0).T).sum() == pytest.approx(length_m)
        onto_loop = shapely.distance(
            shapely.LinearRing(yard.trajectories[robot].positions_m), shapely.points(trails[robot])
        )
        assert onto_loop.max() < 1e-9
    np.testing.assert_allclose([trail[-1] for trail in trails], film._marks.get_offsets())
    short = FilmFrames(yard, 200.0)
    list(short.frames(np.array([0.0, 300.0])))
    lengths_m = [np.hypot(*np.diff(part, axis=0).T).sum() for part in short._trails.get_segments()]
    assert lengths_m[:3] == pytest.approx([230, 230, 230])


def test_the_robot_that_is_drawn_is_where_it_should_be(strip: Plan):
    film = FilmFrames(strip, 1.0)
    list(film.frames(np.array([0.0, 30.0, 170.0])))
    np.testing.assert_allclose(film._marks.get_offsets(), [(20, 2.5)])
    box = film._views.get_paths()[0].get_extents()
    np.testing.assert_allclose(box.bounds, (15, -2.5, 10, 10))


@pytest.mark.parametrize("name", ["film.avi", "film.png", "film"])
def test_another_suffix_is_refused(yard: Plan, tmp_path: Path, name: str):
    with pytest.raises(RotaError, match=r"format (for|of) a film; \.gif or \.mp4 is needed"):
        animate_plan(yard, tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"seconds": 0}, "seconds: 0 is not allowed"),
        ({"seconds": float("nan")}, "seconds: nan"),
        ({"fps": 61}, "fps: 61 is not allowed; must be greater than 0 and at most 60"),
        ({"speedup": -1.0}, "speedup: -1.0"),
    ],
)
def test_numbers_out_of_range_are_refused(yard: Plan, tmp_path: Path, wrong: dict[str, float], words: str):
    with pytest.raises(RotaError, match=words):
        animate_plan(yard, tmp_path / "film.gif", **wrong)
    assert not list(tmp_path.iterdir())


def test_mp4_without_ffmpeg_says_so(yard: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(RotaError, match="ffmpeg program, which is not on the PATH"):
        animate_plan(yard, tmp_path / "film.mp4")
    assert not list(tmp_path.iterdir())


def test_mp4_hands_every_frame_to_ffmpeg(strip: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    stand_in(tmp_path, f'echo "$@" > {tmp_path}/arguments; for last; do :; done; cat > "$last"')
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    animate_plan(strip, tmp_path / "film.mp4", seconds=1, fps=5)
    words = (tmp_path / "arguments").read_text().split()
    width, height = map(int, words[words.index("-video_size") + 1].split("x"))
    assert words[words.index("-framerate") + 1] == "5"
    assert (tmp_path / "film.mp4").stat().st_size == 5 * width * height * 4


def test_a_failing_ffmpeg_is_quoted_and_leaves_nothing(strip: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    stand_in(tmp_path, "echo no such encoder >&2; exit 3")
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    with pytest.raises(RotaError, match=r"^ffmpeg failed with code 3: no such encoder"):
        animate_plan(strip, tmp_path / "film.mp4", seconds=1, fps=5)
    assert [path.name for path in tmp_path.iterdir()] == ["ffmpeg"]


def test_mp4_plays(strip: Plan, tmp_path: Path):
    path = tmp_path / "film.mp4"
    if shutil.which("ffmpeg") is None:
        # the other half of the promise: without the program there is an error and no file
        with pytest.raises(RotaError, match="not on the PATH"):
            animate_plan(strip, path)
        return
    animate_plan(strip, path, seconds=1, fps=10)
    assert path.read_bytes()[4:8] == b"ftyp"
    listing = ["ffmpeg", "-loglevel", "error", "-i", str(path), "-f", "framecrc", "-"]
    lines = subprocess.run(listing, capture_output=True, text=True, check=True).stdout.splitlines()
    assert sum(not line.startswith("#") for line in lines) == 10


def test_a_plan_that_only_stays_makes_a_film(yard: Plan, tmp_path: Path):
    stays = Trajectory(robot="robot-1", times_s=[0], positions_m=[(30, 60)])
    for trajectories in ((stays,), ()):
        animate_plan(replace(yard, trajectories=trajectories), tmp_path / "film.gif", fps=4)
        with Image.open(tmp_path / "film.gif") as film:
            assert film.n_frames == 4


def test_robots_with_motion_are_drawn_where_they_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    plan, drawn = with_mass(), []

    def drawing(self: FilmFrames, given: Plan, speedup: float) -> None:
        drawn.append(given)
        films(self, given, speedup)

    films = FilmFrames.__init__
    monkeypatch.setattr(FilmFrames, "__init__", drawing)
    animate_plan(plan, tmp_path / "film.gif", seconds=0.3, fps=10)
    times_s = np.linspace(0, 200, 4001)
    (shown,) = drawn
    off_m = shown.trajectories[0].at(times_s) - plan.trajectories[0].at(times_s)
    assert np.hypot(*off_m.T).max() < 0.05 + 1e-9
