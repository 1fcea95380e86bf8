"""Files that people give, as documents: missions with what they name, parcels, maps; and the files they get back."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient
from tests.web.serving import SQUARE, Json, kept, serving

from rota.files.mission_file import read_mission
from rota.files.yaml_text import parse_text

EXAMPLES = Path("examples")


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with serving(tmp_path_factory.mktemp("reading")) as made:
        yield made


def read(client: TestClient, *names: str, **more: bytes) -> Json:
    """The document of some files of the examples, and of others."""
    files = [(name, (EXAMPLES / name).read_bytes()) for name in names]
    files += [(name.replace("_yaml", ".yaml"), content) for name, content in more.items()]
    answer = client.post("/api/missions/read", files=[("files", file) for file in files])
    assert answer.status_code == 200, answer.text
    found: Json = answer.json()
    return found


def faults(client: TestClient, document: Json, **more: Any) -> list[Json]:
    answer = client.post("/api/validate", json={"document": document, **more})
    assert answer.status_code == 200, answer.text
    found: list[Json] = answer.json()["faults"]
    return found


@pytest.mark.slow  # every example
@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.yaml") if "rota:" in path.read_text()))
def test_every_example_can_be_kept_and_has_no_faults(client: TestClient, name: str) -> None:
    mission = client.post("/api/missions", json={"example": name}).json()
    assert faults(client, mission["document"], mission=mission["id"]) == []
    assert name in {entry["name"] for entry in client.get("/api/examples").json()}


def test_a_mission_brings_the_shapes_of_its_geojson_where_they_can_be_edited(client: TestClient) -> None:
    found = read(client, "parcel.yaml", "parcel.geojson")
    (field, pond) = json.loads((EXAMPLES / "parcel.geojson").read_text())["features"][:2]
    assert found["document"]["area"]["ring"] == field["geometry"]["coordinates"][0][:-1]
    assert found["document"]["obstacles"] == [{"ring": pond["geometry"]["coordinates"][0][:-1], "name": "pond"}]
    assert found["attachments"] == []
    ground = client.post("/api/validate", json={"document": found["document"]}).json()["ground"]
    area = read_mission(EXAMPLES / "parcel.yaml").mission.area.geoms[0]
    assert ground["area"][0][0] == [list(point) for point in area.exterior.coords[:-1]]


def test_a_parcel_alone_becomes_a_mission(client: TestClient) -> None:
    found = read(client, "parcel.geojson")
    assert found["document"]["coordinates"] == "wgs84"
    assert "guesses" in found["warnings"][0]
    assert faults(client, found["document"]) == []
    # all features are the area, as they are in a mission that names no feature
    assert "obstacles" not in found["document"]
    pond = json.loads((EXAMPLES / "parcel.geojson").read_text())["features"][1]
    assert [feature["name"] for feature in found["features"]] == ["field", "pond"]
    shown, given = (
        np.array(ring) for ring in (found["features"][1]["shape"][0][0], pond["geometry"]["coordinates"][0])
    )
    assert np.ptp(shown, axis=0) == pytest.approx(np.ptp(given, axis=0), rel=0.05)


def square(west: float, south: float, side: float, **properties: Any) -> Json:
    ring = [[west, south], [west + side, south], [west + side, south + side], [west, south + side], [west, south]]
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}


def collection(*features: Json) -> bytes:
    return json.dumps({"type": "FeatureCollection", "features": features}).encode()


PORT, QUAY = square(13.08, 54.36, 0.004, name="port"), square(13.081, 54.3605, 0.001, name="quay")
ISLE = square(13.09, 54.36, 0.001, name="isle", period_s=70)


@pytest.mark.parametrize("order", [["a.geojson", "b.geojson"], ["b.geojson", "a.geojson"]])
def test_features_of_several_files_are_all_the_area_in_any_order(client: TestClient, order: list[str]) -> None:
    contents = {"a.geojson": collection(QUAY), "b.geojson": collection(PORT, ISLE)}
    answer = client.post("/api/missions/read", files=[("files", (name, contents[name])) for name in order])
    assert answer.status_code == 200
    assert [(feature["file"], feature["name"]) for feature in answer.json()["features"]] == [
        ("a.geojson", "quay"),
        ("b.geojson", "port"),
        ("b.geojson", "isle"),
    ]
    read_ = answer.json()
    ground = client.post("/api/validate", json={"document": read_["document"], "upload": read_["upload"]}).json()
    sides = sorted(
        round(max(x for x, _ in rings[0]) - min(x for x, _ in rings[0])) for rings in ground["ground"]["area"]
    )
    # the port with the quay in it, and the isle: their degrees at this latitude, in metres
    metres = math.cos(math.radians(54.36)) * 111_320
    assert sides == [pytest.approx(0.001 * metres, rel=0.01), pytest.approx(0.004 * metres, rel=0.01)]


def test_each_feature_is_what_it_is_taken_for(client: TestClient) -> None:
    files = [("files", ("two.geojson", collection(PORT, QUAY, ISLE, QUAY)))]
    found = client.post("/api/missions/read?as=aozo", files=files).json()
    document = found["document"]
    assert "features" not in found
    assert document["area"]["ring"] == PORT["geometry"]["coordinates"][0][:-1]
    assert [obstacle["name"] for obstacle in document["obstacles"]] == ["quay", "quay 2"]
    assert document["obstacles"][0]["ring"] == QUAY["geometry"]["coordinates"][0][:-1]
    assert (document["zones"][0]["name"], document["zones"][0]["period_s"]) == ("isle", 70)
    left = client.post("/api/missions/read?as=a-o-", files=files).json()["document"]
    assert [obstacle["name"] for obstacle in left["obstacles"]] == ["isle"]
    assert "zones" not in left
    for wrong, told in {
        "oooo": "no feature is the area",
        "a": "a letter for each",
        "axoz": "a letter for each",
    }.items():
        answer = client.post(f"/api/missions/read?as={wrong}", files=files)
        assert answer.status_code in (400, 422)
        assert told in answer.text


def test_files_that_nothing_is_made_of_are_told(client: TestClient) -> None:
    found = read(client, "parcel.yaml", "parcel.geojson", **{"other.geojson": collection(PORT)})
    assert [text for text in found["warnings"] if "other.geojson is not used" in text]
    assert not [text for text in found["warnings"] if "parcel.geojson" in text]
    found = read(client, "building_map.yaml", "building_map.png", **{"other.geojson": collection(PORT)})
    assert [text for text in found["warnings"] if "not used" in text] == [
        "other.geojson is not used: the mission does not name it"
    ]


def test_a_ros_map_becomes_a_mission_with_its_picture_wherever_that_lay(client: TestClient) -> None:
    sheet = (EXAMPLES / "building_map.yaml").read_bytes().replace(b"building_map.png", b"/elsewhere/building_map.png")
    found = read(client, "building_map.png", floor_yaml=sheet)
    assert found["document"]["area"]["map"] == "floor.yaml"
    assert {entry["name"] for entry in found["attachments"]} == {"floor.yaml", "building_map.png"}
    assert faults(client, found["document"], upload=found["upload"]) == []
    mission = client.post("/api/missions", json={"document": found["document"], "upload": found["upload"]}).json()
    assert faults(client, mission["document"], mission=mission["id"]) == []
    packed = zipfile.ZipFile(io.BytesIO(client.get(f"/api/missions/{mission['id']}/mission.zip").content))
    assert sorted(packed.namelist()) == ["building_map.png", "floor-mission.yaml", "floor.yaml"]


def test_a_mission_file_that_is_downloaded_is_the_mission(client: TestClient, tmp_path: Path) -> None:
    answer = client.get(f"/api/missions/{kept(client, SQUARE)}/mission.yaml")
    assert parse_text(answer.text, "it.yaml", "a mission").value == SQUARE
    assert answer.headers["content-disposition"].startswith('attachment; filename="square.yaml"')
    (tmp_path / "square.yaml").write_text(answer.text)
    assert read_mission(tmp_path / "square.yaml").mission.name == "square"


def test_a_draft_with_faults_is_kept_and_its_faults_have_places(client: TestClient) -> None:
    draft = {**SQUARE, "area": [], "fleet": {**SQUARE["fleet"], "speed_m_s": -1}, "zones": [{"name": "a"}]}
    mission = kept(client, draft)
    assert client.get(f"/api/missions/{mission}").json()["document"] == draft
    told = {tuple(fault["path"]): fault["field"] for fault in faults(client, draft)}
    assert told[("fleet", "speed_m_s")] == "fleet.speed_m_s"
    assert told[("zones", 0, "period_s")] == "zones[0].period_s"
    assert ("area",) in told


def test_what_a_mission_asks_is_told_in_numbers(client: TestClient) -> None:
    told = client.post(
        "/api/validate", json={"document": {**SQUARE, "obstacles": [[[0, 0], [1, 0], [1, 1], [0, 1]]]}}
    ).json()
    assert told["free_m2"] == pytest.approx(35)
    assert told["asked_m2_s"] == pytest.approx(35 / 60)
    assert told["compiling"] or told["bound"]["robots"] == 1


@pytest.mark.parametrize(
    "files",
    [
        {"field.geojson": b'{"type": "FeatureCollection", "features": []}'},
        {"field.geojson": b'{"type": "Polygon", "coordinates": [['},
        {"floor.yaml": b"image: lost.png\nresolution: 0.05\norigin: [0, 0, 0]\n"},
        {"floor.yaml": b"image: floor.png\nresolution: 0.05\norigin: [0, 0, 0]\n", "floor.png": b"no picture"},
    ],
)
def test_files_are_named_in_errors_as_they_were_given(client: TestClient, files: dict[str, bytes]) -> None:
    answer = client.post("/api/missions/read", files=[("files", file) for file in files.items()])
    assert answer.status_code == 422
    assert "rota-" not in answer.text
    assert any(name in answer.text for name in files)
    named = {**SQUARE, "area": {"geojson": "gone.geojson"}}
    (fault,) = faults(client, named)
    assert fault["message"].startswith("gone.geojson: no such file")
