"""Values as JSON and back: what is built is what was made plain, to seven digits."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from rota.errors import RotaError
from rota_studies.plain import alike, built, changes, plain


class Pair(NamedTuple):
    name: str
    number: float


@dataclass(frozen=True, kw_only=True)
class Inner:
    weight: float = 2.0
    way: Literal["near", "far"] = "near"


@dataclass(frozen=True, kw_only=True, eq=False)
class Outer:
    places: NDArray[np.float64]
    order: NDArray[np.int64]
    flags: NDArray[np.bool_]
    pairs: tuple[Pair, ...]
    both: tuple[int, float]
    by_name: dict[str, int]
    inner: Inner | None = None


def test_what_is_built_is_what_was_made_plain() -> None:
    made = Outer(
        places=np.array([[1.0, 2.5], [math.inf, math.nan]]), order=np.array([3, 1]), flags=np.array([True, False]),
        pairs=(Pair("a", 1.5), Pair("b", math.inf)), both=(2, 0.25), by_name={"x": 1}, inner=Inner(way="far"),
    )  # fmt: skip
    found = built(Outer, json.loads(json.dumps(plain(made), allow_nan=False)))
    np.testing.assert_array_equal(found.places, made.places)
    assert (found.order.tolist(), found.flags.tolist()) == ([3, 1], [True, False])
    assert (found.order.dtype, found.flags.dtype) == (np.int64, np.bool_)
    assert (found.pairs, found.both, found.by_name, found.inner) == (made.pairs, made.both, made.by_name, made.inner)
    assert plain(found) == plain(made)


@pytest.mark.parametrize(("value", "kept"), [(61025.994, 61025.99), (1 / 3, 0.3333333), (5.0, 5), (1e-9, 1e-9)])
def test_numbers_keep_seven_digits(value: float, kept: float) -> None:
    assert plain(value) == kept
    assert plain(np.array([value])) == [kept]


def test_only_fields_that_are_not_at_their_defaults_are_told() -> None:
    @dataclass(frozen=True)
    class Settings:
        inner: Inner = field(default_factory=Inner)
        steps: int = 3

    assert changes(Settings()) == {}
    assert changes(Settings(inner=Inner(weight=3.0), steps=4)) == {"inner": {"weight": 3}, "steps": 4}


@pytest.mark.parametrize("value", [{"name": "a"}, {"name": "a", "number": "many"}, 5, {"name": 5, "number": 1}])
def test_what_cannot_be_is_refused(value: object) -> None:
    with pytest.raises(RotaError, match="a record holds no Pair"):
        built(Pair, value)


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ({"a": [1, 2.0]}, {"a": [1, 2.00000001]}, True),
        ({"a": [1, 2.0]}, {"a": [1, 2.001]}, False),
        ({"a": [1]}, {"a": [1, 2]}, False),
        ({"a": 1}, {"b": 1}, False),
        ({"a": 1, "b": []}, {"a": 1}, True),
        ({"a": 1, "b": 0}, {"a": 1}, False),
        ([1], [1.0], True),
        (["1"], [1.0], False),
        ("inf", "inf", True),
    ],
)
def test_alike_but_for_rounding(one: object, other: object, *, same: bool) -> None:
    assert alike(one, other) is same
