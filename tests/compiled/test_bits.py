"""The place of the lowest bit, as kernels find it that are not compiled."""

from __future__ import annotations

import pytest

from rota.compiled.bits import lowest_bit


@pytest.mark.parametrize(("bits", "place"), [(1, 0), (6, 1), (2**63, 63), (2**64 - 1, 0)])
def test_the_lowest_bit(bits: int, place: int) -> None:
    assert lowest_bit(bits) == place
