"""The hand-made plans of the tests of pictures serve the studies' pictures too."""

from tests.draw.conftest import yard

__all__ = ["yard"]
