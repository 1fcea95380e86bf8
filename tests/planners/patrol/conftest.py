"""Short searches for all tests of patrol; whether robots are as few as whole searches find is asked by others."""

from __future__ import annotations

from tests.short_searches import short_searches as short_searches
