"""What the ``rota`` program's exit codes mean."""

from __future__ import annotations

DONE, VIOLATED, BAD_INPUT, NO_PLAN, OUR_FAULT = 0, 1, 2, 3, 70
INTERRUPTED, TERMINATED = 130, 143  # by Ctrl-C, by SIGTERM: 128 and the number of the signal, as shells have it
