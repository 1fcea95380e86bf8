import json

import pytest
from shapely import Polygon, box
from shapely.geometry import shape as shapely_shape

from rota.errors import MissionError
from rota.files.geojson_shapes import pick_feature, read_features

SQUARE = [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]
HOLED = [*SQUARE, [[0.2, 0.2], [0.2, 0.4], [0.4, 0.4], [0.2, 0.2]]]
FAR = [[[5, 5], [6, 5], [6, 6], [5, 5]]]


def write(tmp_path, document):
    path = tmp_path / "shapes.geojson"
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


def feature(geometry, **properties):
    return {"type": "Feature", "properties": properties, "geometry": geometry}


@pytest.mark.parametrize(
    "geometry",
    [
        {"type": "Polygon", "coordinates": SQUARE},
        {"type": "Polygon", "coordinates": HOLED},
        {"type": "MultiPolygon", "coordinates": [HOLED, FAR]},
    ],
)
def test_geometries_are_those_shapely_reads(tmp_path, geometry):
    expected = shapely_shape(geometry)
    for document in (geometry, feature(geometry), {"type": "FeatureCollection", "features": [feature(geometry)]}):
        (found,) = read_features(write(tmp_path, document)).features
        assert found.shape.equals(expected)
        assert found.shape.area == pytest.approx(expected.area)


def test_collections_unclosed_rings_heights_and_overlaps(tmp_path):
    lower = {"type": "Polygon", "coordinates": [[[0, 0, 9], [2, 0, 9], [2, 1, 9], [0, 1, 9]]]}
    upper = {"type": "Polygon", "coordinates": [[[0, 0.5], [2, 0.5], [2, 2], [0, 2]]]}
    line = {"type": "LineString", "coordinates": [[0, 0], [1, 1]]}
    document = {
        "type": "FeatureCollection",
        "features": [
            feature({"type": "GeometryCollection", "geometries": [lower, upper, line]}, Name="both"),
            feature(line),
            feature(None),
        ],
    }
    features, without_polygons = read_features(write(tmp_path, document))
    assert without_polygons == 2
    assert features[0].shape.equals(box(0, 0, 2, 2))


def test_features_are_picked_by_name_or_id(tmp_path):
    square = {"type": "Polygon", "coordinates": SQUARE}
    entries = [
        feature(square, name="a"),
        feature(square, Name="b"),
        {**feature(square), "id": 7},
        feature(square, name="a"),
    ]
    path = write(tmp_path, {"type": "FeatureCollection", "features": entries})
    features = read_features(path).features
    assert pick_feature(features, "b", path) is features[1]
    assert pick_feature(features, "7", path) is features[2]
    with pytest.raises(MissionError, match="2 features are called 'a'"):
        pick_feature(features, "a", path)
    with pytest.raises(MissionError, match=r"no feature is called 'c' in .*; it has 'a', 'b', '7', 'a'"):
        pick_feature(features, "c", path)


def test_all_faults_are_told_at_once(tmp_path):
    crossing = {"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]]}
    flat = {"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [0, 0]]]}
    document = {"type": "FeatureCollection", "features": [feature(crossing, name="x"), feature(flat)]}
    with pytest.raises(MissionError) as caught:
        read_features(write(tmp_path, document))
    first, second = caught.value.faults
    assert "features[0] (x): the ring crosses or touches itself at (0.5, 0.5)" in first
    assert "features[1]: a ring of 2 distinct points" in second


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ("[1, 2]", "not GeoJSON"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], [1, NaN], [1, 1]]]}', "finite numbers only"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], [1, 1e999], [1, 1]]]}', "no position"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], ["1", 0], [1, 1]]]}', r"\[\"1\", 0\] is no position"),
        ('{"type": "Polygon", "coordinates": [[0, 0], [1, 0], [1, 1]]}', "0 is no position"),
        ('{"type": "Polygon", "coordinates": []}', "outer one first"),
        ('{"type": "Polygon"}', "without a list of coordinates"),
        ('{"type": "Sphere", "coordinates": []}', '"Sphere" is no geometry type'),
        ('{"type": "FeatureCollection", "features": {}}', "must be a list of features"),
        ('{"type": "FeatureCollection", "features": []}', "holds no polygon"),
    ],
)
def test_what_is_no_geojson_is_refused(tmp_path, document, words):
    with pytest.raises(MissionError, match=words):
        read_features(write(tmp_path, document))


def test_the_old_crs_member_may_name_wgs84(tmp_path):
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    path = write(tmp_path, {"type": "Polygon", "coordinates": SQUARE, "crs": crs})
    assert read_features(path).features[0].shape.equals(Polygon(SQUARE[0]))
