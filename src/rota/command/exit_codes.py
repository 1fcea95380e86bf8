"""What the ``rota`` program's exit codes mean."""

from __future__ import annotations

# BAD_INPUT also for files that cannot be read or written
DONE, VIOLATED, BAD_INPUT, NO_PLAN, OUR_FAULT = 0, 1, 2, 3, 70
SIGNALLED = 128  # and the signal's number, as shells have it: 130 by Ctrl-C, 143 by SIGTERM, 129 by SIGHUP
NOBODY_READS = 141  # SIGPIPE: the program that read the output has ended
