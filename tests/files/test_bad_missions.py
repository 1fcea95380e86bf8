"""Every faulty mission in missions_bad/, named after its fault, and the very words it is refused with."""

import copy
import json
import math
import random
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

from rota.errors import MissionError
from rota.files.example_mission import example_mission_text
from rota.files.mission_file import read_mission
from rota.files.yaml_text import parse_text

FOLDER = Path(__file__).parent.parent / "missions_bad"
FILES = sorted(
    path.name for path in FOLDER.iterdir() if path.suffix in (".yaml", ".json") and not path.name.endswith("_map.yaml")
)


def expected_lines() -> dict[str, list[str]]:
    lines: dict[str, list[str]] = defaultdict(list)
    for line in (FOLDER / "messages.txt").read_text(encoding="utf-8").splitlines():
        lines[line.split(":")[0]].append(line)
    return lines


EXPECTED = expected_lines()


@pytest.fixture(autouse=True)
def _in_the_folder(monkeypatch):
    monkeypatch.chdir(FOLDER)


@pytest.mark.parametrize("name", FILES)
def test_a_faulty_mission_is_refused_with_these_words(name):
    with pytest.raises(MissionError) as caught:
        read_mission(name)
    assert list(caught.value.faults) == EXPECTED[name]


def test_every_message_belongs_to_a_file():
    assert sorted(EXPECTED) == FILES


@pytest.mark.parametrize(
    ("name", "words"),
    [("nowhere.yaml", "no such file; a mission file is needed"), (".", "is a folder; a mission file is needed")],
)
def test_what_is_no_file_is_refused(name, words):
    with pytest.raises(MissionError, match=f": {words}"):
        read_mission(name)


def test_endless_aliases_are_refused_before_they_fill_memory(tmp_path):
    lines = ["a0: &a0 [0, 0, 0, 0, 0, 0, 0, 0, 0, 0]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 12)]
    path = tmp_path / "bomb.yaml"
    path.write_text("\n".join(lines))
    with pytest.raises(MissionError, match=r"more than 2,000,000 values"):
        read_mission(path)


def test_lists_nested_too_deep_are_refused(tmp_path):
    path = tmp_path / "deep.yaml"
    path.write_text("area: " + "[" * 20_000 + "]" * 20_000)
    with pytest.raises(MissionError, match="nested too deep"):
        read_mission(path)
    path = tmp_path / "deep.json"
    path.write_text('{"area": ' + "[" * 20_000 + "]" * 20_000 + "}")
    with pytest.raises(MissionError, match=r"not JSON|nested too deep"):
        read_mission(path)


@pytest.mark.parametrize("named", ["../outside.geojson", "/etc/hostname", "link.geojson", "a\\0b"])
def test_a_confined_mission_names_no_file_outside_its_folder(tmp_path, named):
    parcel = (FOLDER / "parcel.geojson").read_text()
    (tmp_path / "outside.geojson").write_text(parcel)
    folder = tmp_path / "upload"
    folder.mkdir()
    (folder / "inside.geojson").write_text(parcel)
    (folder / "link.geojson").symlink_to(tmp_path / "outside.geojson")
    mission = (FOLDER / "geojson_missing.yaml").read_text().replace("nowhere.geojson", f'"{named}"')
    without_places = mission.replace("  - [[10, 10], [20, 10], [20, 20], [10, 20]]", "  []")
    without_places = without_places.replace("ring: [[40, 20], [55, 20], [55, 35], [40, 35]]", "geojson: inside.geojson")
    path = folder / "mission.yaml"
    path.write_text(without_places)
    with pytest.raises(MissionError, match=r"area\.geojson: .* leaves the mission's folder"):
        read_mission(path, confine=True)
    path.write_text(without_places.replace(f'"{named}"', "inside.geojson"))
    assert read_mission(path, confine=True).mission.area.area > 0
    if named == "../outside.geojson":
        path.write_text(without_places)
        assert read_mission(path).mission.area.area > 0


def test_a_confined_map_has_its_image_inside_the_folder(tmp_path):
    folder = tmp_path / "upload"
    (folder / "maps").mkdir(parents=True)
    (tmp_path / "room.pgm").write_text((FOLDER / "small_map.pgm").read_text())
    map_text = (FOLDER / "small_map.yaml").read_text()
    (folder / "maps" / "small_map.yaml").write_text(map_text.replace("small_map.pgm", "../../room.pgm"))
    mission = (FOLDER / "map_missing.yaml").read_text().replace("nowhere.yaml", "maps/small_map.yaml")
    (folder / "mission.yaml").write_text(mission)
    with pytest.raises(MissionError, match=r"area\.map: '../../room.pgm' leaves the mission's folder"):
        read_mission(folder / "mission.yaml", confine=True)
    assert read_mission(folder / "mission.yaml").mission.area.area == pytest.approx(36 * 0.25**2)
    (folder / "room.pgm").write_text((FOLDER / "small_map.pgm").read_text())
    (folder / "maps" / "small_map.yaml").write_text(map_text.replace("small_map.pgm", "../room.pgm"))
    assert read_mission(folder / "mission.yaml", confine=True).mission.area.area == pytest.approx(36 * 0.25**2)


def test_links_in_a_circle_are_refused(tmp_path):
    (tmp_path / "nowhere.geojson").symlink_to(tmp_path / "nowhere.geojson")
    path = tmp_path / "mission.yaml"
    path.write_text((FOLDER / "geojson_missing.yaml").read_text())
    with pytest.raises(MissionError, match=r"area\.geojson: 'nowhere.geojson' cannot be followed"):
        read_mission(path, confine=True)
    with pytest.raises(MissionError, match=r"area\.geojson: .*nowhere.geojson: cannot be read: Too many levels"):
        read_mission(path)


def test_reading_a_mission_in_metres_loads_neither_pyproj_nor_scipy_nor_numba():
    code = (
        "import sys; from rota.files.mission_file import read_mission;"
        "read_mission('../../examples/sun2019-fig13.yaml');"
        "assert not {'pyproj', 'scipy', 'numba', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


JUNK = [None, True, 0, -1, 1e308, 5e-324, math.nan, "", "20", [], {}, [[]], [0, 0], [[0, 0]], {"ring": None}, "fewest"]
JUNK += [10**30, [None], {"geojson": "\0"}, {"geojson": "."}, {"circle": {"centre": [0, 0], "radius_m": 1e-300}}]


def places(value, place=()):
    if place:
        yield place
    inner = value.items() if isinstance(value, dict) else enumerate(value if isinstance(value, list) else [])
    for step, part in inner:
        yield from places(part, (*place, step))


@pytest.mark.filterwarnings("error")
def test_whatever_is_written_is_read_or_refused(tmp_path):
    rng = random.Random(5)
    good = parse_text(example_mission_text(), "example", "a mission file").value
    refused = 0
    for _ in range(150):
        value = copy.deepcopy(good)
        for _ in range(rng.choice([1, 1, 2])):
            *outer, last = rng.choice(list(places(value)))
            block = value
            for step in outer:
                block = block[step]
            block[last] = copy.deepcopy(rng.choice(JUNK))
        path = tmp_path / "mission.json"
        path.write_text(json.dumps(value))
        try:
            read_mission(path)
        except MissionError as error:
            refused += len(error.faults) > 0
    assert refused > 100
