"""Tables as Markdown and as plain text."""

from __future__ import annotations

import pytest

from rota_studies.tables import Table, counted, joined, number


def test_markdown_has_a_title_a_rule_and_escaped_bars() -> None:
    table = Table(title="Robots", head=("case", "paper"), rows=(("a|b", "5"), ("c", "11")))
    assert table.markdown.splitlines() == [
        "**Robots**", "", "| case | paper |", "|---|---:|", r"| a\|b | 5 |", "| c | 11 |",
    ]  # fmt: skip


def test_plain_text_lines_up_and_goes_on_below() -> None:
    times = "11.11, 22.22, 33.33, 44.44, 55.55"
    table = Table(title="Times", head=("zone", "s"), rows=(("1", times), ("rest", "7.00")))
    assert table.text.splitlines() == [
        "Times",
        "zone                     s",
        "1     11.11, 22.22, 33.33,",
        "              44.44, 55.55",
        "rest                  7.00",
    ]


def test_a_row_of_another_length_is_refused() -> None:
    with pytest.raises(ValueError, match=r"rows: \('x',\) has 1 cells; must be 2"):
        Table(title="Robots", head=("case", "paper"), rows=(("x",),))


def test_words() -> None:
    assert [counted(1, "robot"), counted(1200, "robot")] == ["1 robot", "1,200 robots"]
    assert [joined([]), joined(["a"]), joined(["a", "b", "c"])] == ["", "a", "a, b and c"]
    assert [number(None), number(3, "d")] == ["–", "3"]
