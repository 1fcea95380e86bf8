"""Short searches for all tests of replanning."""

from __future__ import annotations

from tests.short_searches import short_searches as short_searches
