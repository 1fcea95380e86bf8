"""What the ``rota`` program's exit codes mean."""

from __future__ import annotations

DONE, VIOLATED, BAD_INPUT, NO_PLAN, OUR_FAULT, INTERRUPTED = 0, 1, 2, 3, 70, 130
