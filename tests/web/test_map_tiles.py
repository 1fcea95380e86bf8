"""Addresses of map tiles, and whose they are."""

from __future__ import annotations

import pytest

from rota.errors import RotaError
from rota.web.tiles import ITS_ATTRIBUTION, tiles_of

END = "/{z}/{x}/{y}.png"


@pytest.mark.parametrize(
    ("host", "given", "words"),
    [
        ("https://tile.openstreetmap.org", None, ITS_ATTRIBUTION),
        ("https://{s}.tile.openstreetmap.org", None, ITS_ATTRIBUTION),
        ("https://notopenstreetmap.org", None, ""),
        ("https://tiles.example", None, ""),
        ("https://tiles.example", "© us", "© us"),
        ("https://tile.openstreetmap.org", "", ""),
    ],
)
def test_tiles_say_whose_they_are(host: str, given: str | None, words: str) -> None:
    tiles = tiles_of(host + END, given)
    assert tiles is not None
    assert tiles.attribution == words
    assert tiles.origin == host.replace("{s}", "*")


@pytest.mark.parametrize(
    ("url", "words"),
    [(None, "© us"), ("ftp://tiles.example" + END, None), ("https://tiles.example/{z}.png", None)]
    + [("https://tiles.example" + END, text) for text in ("two\nlines", "x" * 301)],
)
def test_what_is_no_address_of_tiles_is_refused(url: str | None, words: str | None) -> None:
    with pytest.raises(RotaError, match="--tile-"):
        tiles_of(url, words)


def test_no_tiles_are_none() -> None:
    assert tiles_of(None, None) is None
