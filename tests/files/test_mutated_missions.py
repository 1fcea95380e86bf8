"""Whatever stands in a mission's files is read, or refused with the place; nothing else escapes."""

from __future__ import annotations

import json
import struct
import tempfile
import zlib
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.missions import EXAMPLES
from benchmarks.mutated_missions import Place, mutated, places
from benchmarks.reader_process import require_same
from hypothesis import given, settings, strategies as st

from rota.errors import MissionError
from rota.files.geojson_shapes import read_features
from rota.files.map_image import read_brightness
from rota.files.mission_file import read_mission
from rota.files.text_map import text_map
from rota.files.yaml_text import parse_text

BOUNDED = settings(max_examples=60, deadline=None, derandomize=True, database=None)
numbers = st.integers(-(10**400), 10**400) | st.floats() | st.sampled_from([1e155, 1e7, 1e-3, 5e-324, 2**63])
scalars = (
    st.none() | st.booleans() | numbers | st.text(st.characters(), max_size=12) | st.sampled_from(["fewest", "null"])
)
trees = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
    max_leaves=8,
)


@cache
def examples() -> list[Any]:
    """The examples' missions as trees of values."""
    paths = sorted(EXAMPLES.glob("*.yaml"))
    return [parse_text(path.read_text(), path.name, "").value for path in paths if not path.name.endswith("_map.yaml")]


def faults_of(read: Callable[..., Any], *given: Any, **more: Any) -> tuple[str, ...]:
    """What a reader refuses, line by line; nothing where it reads. All else that it raises goes on to the test."""
    try:
        read(*given, **more)
    except MissionError as error:
        assert error.faults  # noqa: PT017 (all else may not pass for a refusal)
        return error.faults
    return ()


def read_and_kept(path: Path) -> None:
    require_same(read_mission(path).mission)


def test_mutated_missions_are_read_or_refused_where_they_are_wrong(tmp_path: Path) -> None:
    refused = 0
    for seed in range(120):
        folder = tmp_path / str(seed)
        folder.mkdir()
        name, files = mutated(seed)
        for path, data in files.items():
            (folder / path).write_bytes(data)
        faults = faults_of(read_and_kept, folder / name)
        assert all(fault.startswith(str(folder / name)) and fault.isprintable() for fault in faults), faults
        refused += len(faults) > 0
    assert 60 < refused < 115


@st.composite
def missions(draw: st.DrawFn) -> Any:
    """An example with one or two of its values drawn anew."""
    value = deepcopy(draw(st.sampled_from(examples())))
    for _ in range(draw(st.integers(1, 2))):
        place: Place = draw(st.sampled_from(list(places(value))))
        block = value
        for step in place[:-1]:
            block = block[step]
        block[place[-1]] = draw(trees)
    return value


@BOUNDED
@given(missions(), st.sampled_from([".json", ".yaml"]))
def test_any_value_anywhere_is_read_or_refused(value: Any, suffix: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "mission" + suffix)
        path.write_text(json.dumps(value))
        assert all(fault.startswith(str(path)) for fault in faults_of(read_and_kept, path))


@BOUNDED
@given(st.text(st.sampled_from("{}[]:,-?|>&*!%@#\"'\\\n\t 0x1e.~a\ufeff\u2028\x85\x00\ud800")) | st.text())
def test_any_text_is_yaml_or_refused_with_its_line(text: str) -> None:
    for name in ("text.yaml", "text.json"):
        assert all(fault.startswith(f"{name}:") for fault in faults_of(parse_text, text, name, "a file"))


def read_valid_features(path: Path) -> None:
    assert all(feature.shape.is_valid for feature in read_features(path).features)


shapes = st.sampled_from(["Polygon", "MultiPolygon", "Point", "GeometryCollection", "Sphere"])
rings = st.lists(st.lists(numbers, max_size=3) | scalars, max_size=6) | trees


@BOUNDED
@given(shapes, st.lists(rings, max_size=3) | trees, trees, st.booleans())
def test_any_geojson_is_read_or_refused(kind: str, coordinates: Any, name: Any, is_feature: bool) -> None:
    value: Any = {"type": kind, "coordinates": coordinates, "geometries": coordinates}
    if is_feature:
        value = {
            "type": "FeatureCollection",
            "features": [{"geometry": value, "properties": {"name": name}, "id": name}],
        }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "shape.geojson")
        path.write_text(json.dumps(value))
        assert all(fault.startswith(str(path)) for fault in faults_of(read_valid_features, path))


def png(width: int, height: int, depth: int, kind: int, pixels: bytes) -> bytes:
    parts = [
        (b"IHDR", struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)),
        (b"IDAT", zlib.compress(pixels)),
        (b"IEND", b""),
    ]
    chunks = [
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body)) for name, body in parts
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


sizes = st.integers(0, 9) | st.sampled_from([99_999, 2**31, 2**32 - 1])
some = st.binary(max_size=60)
words = st.sampled_from([b"1", b"3", b"255", b"65535", b"0", b"-1", b"9" * 400, b"#x\n", b"1e3", b"+2"])
heads = st.lists(words, max_size=5).map(lambda listed: b" " + b" ".join(listed) + b"\n")
kinds = st.sampled_from([b"P5", b"P2", b"P6", b"\x89PNG"])
images = st.one_of(
    st.builds(png, sizes, sizes, st.sampled_from([1, 2, 4, 8, 16, 0]), st.sampled_from([0, 2, 3, 4, 6, 1]), some),
    st.builds(lambda *parts: b"".join(parts), kinds, heads, some),
)


@BOUNDED
@given(images, st.booleans(), st.integers(0, 80))
def test_any_image_is_read_or_refused(data: bytes, alpha_counts: bool, cut: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "map.png")
        path.write_bytes(data[: max(0, len(data) - cut)] if cut < 20 else data)
        assert all(fault.startswith(str(path)) for fault in faults_of(read_in_range, path, alpha_counts=alpha_counts))


def read_in_range(path: Path, *, alpha_counts: bool) -> None:
    brightness = read_brightness(path, alpha_counts=alpha_counts)
    assert brightness.ndim == 2
    assert np.all((brightness >= 0) & (brightness <= 255))


@BOUNDED
@given(st.text(st.sampled_from(".#\n x\r\u2028"), max_size=40), st.floats(1e-3, 1e7))
def test_any_text_map_is_read_or_refused(text: str, cell_m: float) -> None:
    faults = faults_of(read_larger_than_walls, text, cell_m)
    assert all("line" in fault or "free" in fault for fault in faults)


def read_larger_than_walls(text: str, cell_m: float) -> None:
    area, walls = text_map(text, cell_m)
    assert area.area > walls.area
