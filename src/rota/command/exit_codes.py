"""What the ``rota`` program's exit codes mean."""

from __future__ import annotations

# BAD_INPUT also for files that cannot be read or written
DONE, VIOLATED, BAD_INPUT, NO_PLAN, OUR_FAULT = 0, 1, 2, 3, 70
INTERRUPTED, TERMINATED = 130, 143  # by Ctrl-C, by SIGTERM: 128 and the number of the signal, as shells have it
NOBODY_READS = 141  # SIGPIPE: the program that read the output has ended
