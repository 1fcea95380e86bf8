"""The hand-made plans of the tests of pictures serve the studies' pictures too."""

from tests import conftest as of_all_tests  # for its care for Ctrl-C, where tests of studies run alone
from tests.draw.conftest import yard

__all__ = ["of_all_tests", "yard"]
