"""Keys that stand twice, and digests of JSON values."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from rota.errors import MissionError, PlanError
from rota.files.geojson_shapes import read_features
from rota.files.json_text import digest_of, unique_keys
from rota.files.plan_file import plan_from_text


def test_a_key_that_stands_twice_is_named() -> None:
    assert json.loads('{"a": {"b": 1, "c": 2}}', object_pairs_hook=unique_keys) == {"a": {"b": 1, "c": 2}}
    with pytest.raises(ValueError, match='the key "b" stands twice'):
        json.loads('{"a": {"b": 1, "c": 2, "b": 1}}', object_pairs_hook=unique_keys)


def test_files_with_a_key_that_stands_twice_are_refused(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r'^a\.json: the key "seed" stands twice'):
        plan_from_text('{"rota_plan": 1, "seed": 0, "seed": 1}', "a.json")
    (tmp_path / "a.geojson").write_text('{"type": "Polygon", "coordinates": [], "coordinates": []}')
    with pytest.raises(MissionError, match='"coordinates" stands twice'):
        read_features(tmp_path / "a.geojson")


def test_a_digest_is_that_of_sorted_keys_and_floats() -> None:
    text = '{"a":[1.0,true,null,"x"],"b":{"c":0.1}}'
    expected = hashlib.sha256(text.encode()).hexdigest()
    assert digest_of({"b": {"c": 0.1}, "a": [1, True, None, "x"]}) == expected
    assert digest_of({"b": {"c": 0.1}, "a": [1.0, True, None, "x"]}) == expected
    assert digest_of({"b": {"c": 0.1}, "a": [2, True, None, "x"]}) != expected
