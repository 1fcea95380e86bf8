"""Documents as YAML files: what is written reads back, whatever text and numbers it holds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings, strategies as st

from rota.files.mission_text import LONGEST_LINE, mission_text
from rota.files.yaml_text import parse_text

EXAMPLES = sorted(path for path in Path("examples").glob("*.yaml") if "rota:" in path.read_text())

texts = st.text(max_size=20) | st.sampled_from(
    ["null", "Yes", "1e3", "0x1F", "a: b", "- a", "#", "...\n##.\n", "~", "é"]
)
numbers = st.integers(-(10**12), 10**12) | st.floats(allow_nan=False, allow_infinity=False)
values = st.recursive(
    st.none() | st.booleans() | numbers | texts,
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(texts, inner, max_size=4),
    max_leaves=20,
)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_read_back_and_their_lines_are_short(path: Path) -> None:
    document = parse_text(path.read_text(), "it.yaml", "a mission").value
    text = mission_text(document)
    assert parse_text(text, "it.yaml", "a mission").value == document
    assert max(map(len, text.splitlines())) <= LONGEST_LINE + 10


@settings(max_examples=60, deadline=None)
@given(st.dictionaries(texts, values, min_size=1, max_size=4))
def test_whatever_json_holds_reads_back(document: dict[str, Any]) -> None:
    assert parse_text(mission_text(document), "it.yaml", "a mission").value == document


def test_long_lists_of_points_are_broken_between_points() -> None:
    document = {"area": [[float(k), k / 7] for k in range(60)], "map": "..#.\n....\n"}
    text = mission_text(document)
    assert len(text.splitlines()) > 10
    assert "  ..#.\n" in text
    assert parse_text(text, "it.yaml", "a mission").value == document
