"""Growth is a decision: sizes.csv holds how large each package may be, row by row with the reason for each raise."""

from __future__ import annotations

import csv
from collections import Counter
from functools import cache
from pathlib import Path

from benchmarks.house import packages
from tests.sources import source_in, source_of

LEDGER = Path(__file__).with_name("sizes.csv")
LINES, KNOBS = 300, 10  # so much less a package may have than is allowed: what has left is taken off again


@cache
def sizes() -> dict[str, tuple[int, int]]:
    return packages(lambda file: (source_of(file).lines, source_of(file).knobs))


def rows() -> list[dict[str, str]]:
    with LEDGER.open(newline="") as file:
        return list(csv.DictReader(file))


def allowed() -> dict[str, tuple[int, int]]:
    """The most lines and knobs of each package: the sums of its rows."""
    lines, knobs = Counter[str](), Counter[str]()
    for row in rows():
        lines[row["package"]] += int(row["lines"])
        knobs[row["package"]] += int(row["knobs"])
    return {package: (lines[package], knobs[package]) for package in lines}


def test_knobs_are_constants_of_modules_and_fields_of_settings() -> None:
    text = "A, B = 1, 2\n_C: float = 3\nnames = {}\n\ndef f():\n    D = 4\n\n"
    text += "class S(Settings):\n    place: ClassVar[str] = 'a'\n    x: int = 1\n\nclass TSettings:\n    y: int\n\n"
    text += "class U:\n    z: int\n"
    assert source_in(text).knobs == 5


def test_every_raise_has_a_reason_of_its_own() -> None:
    for package in allowed():
        reasons = [row["reason"] for row in rows() if row["package"] == package]
        assert all(len(reason.split()) > 2 for reason in reasons), package
        assert len(set(reasons)) == len(reasons), package


def test_no_package_is_larger_than_was_decided() -> None:
    now, most = sizes(), allowed()
    assert set(now) == set(most)
    larger = {
        name: (size, most[name]) for name, size in now.items() if size[0] > most[name][0] or size[1] > most[name][1]
    }
    assert larger == {}, "(lines, knobs), allowed: take something away, or add a row with its reason to tests/sizes.csv"


def test_what_has_left_does_not_come_back_unseen() -> None:
    now, most = sizes(), allowed()
    room = {name: (most[name][0] - now[name][0], most[name][1] - now[name][1]) for name in now}
    loose = {name: rest for name, rest in room.items() if rest[0] > LINES or rest[1] > KNOBS}
    assert loose == {}, "(lines, knobs) beyond what is there: add a row that takes them off to tests/sizes.csv"
