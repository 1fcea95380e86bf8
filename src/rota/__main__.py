"""The ``rota`` program, and ``python -m rota`` where it is not on the path."""

from __future__ import annotations

import sys
from typing import NoReturn


def main() -> NoReturn:
    """Run the command line with the arguments that the program was given."""
    # paths need not be UTF-8, and a terminal may know few letters: what cannot be printed is escaped
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    try:
        from rota.command.cli import run
        from rota.command.ending import leave
    except Exception as error:  # Python would end with 1, which says that a plan does not meet its demand
        fault = f"{type(error).__name__}: {error}"
        print(
            f"rota: a library that Rota needs is missing, too old or damaged ({fault}); install Rota anew",
            file=sys.stderr,
        )
        sys.exit(70)
    leave(run(sys.argv[1:]))


if __name__ == "__main__":
    main()
