"""Map tiles that the page shows: where they come from, and whose they are."""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import urlsplit

from rota.errors import RotaError

OPEN_STREET_MAP = "openstreetmap.org"
ITS_ATTRIBUTION = "© OpenStreetMap contributors"
LONGEST = 300


@dataclass(frozen=True, kw_only=True)
class Tiles:
    """The address of tiles with {z}, {x} and {y}, and the words that stand beside them."""

    url: str
    attribution: str

    @property
    def origin(self) -> str:
        """Where browsers load them from, as policies write it."""
        parts = urlsplit(self.url.replace("{s}.", "*."))
        return f"{parts.scheme}://{parts.netloc}"


def tiles_of(url: str | None, attribution: str | None) -> Tiles | None:
    """Tiles of an address, or none. RotaError for what is no address of tiles, and for words without one.

    attribution None: what OpenStreetMap asks for where the tiles are its own, otherwise no words.
    """
    if url is None:
        if attribution is not None:
            raise RotaError("--tile-attribution: there are no tiles; give --tile-url, too")
        return None
    parts = urlsplit(url)
    marks = all(mark in url for mark in ("{z}", "{x}", "{y}"))
    bad = any(letter in url for letter in " ;,'\"\r\n")
    if parts.scheme not in ("http", "https") or not parts.netloc or not marks or bad:
        raise RotaError(f"--tile-url: {url!r} is not allowed; https://HOST/PATH with {{z}}, {{x}} and {{y}} is needed")
    if attribution is not None and (len(attribution) > LONGEST or not attribution.isprintable()):
        raise RotaError(f"--tile-attribution: {attribution[:40]!r} is not allowed; a line of at most {LONGEST} letters")
    host = (parts.hostname or "").lower()
    own = host == OPEN_STREET_MAP or host.endswith(f".{OPEN_STREET_MAP}")
    return Tiles(url=url, attribution=attribution if attribution is not None else ITS_ATTRIBUTION if own else "")
