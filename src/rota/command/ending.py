"""How a command ends: one exit code and a few words for whatever ended it.

Scripts take 1 for "the demand is not met". So nothing else ends with 1: no fault of ours, of the machine or of a
library, and none of what typer ends with 1 by itself (a broken pipe, input that ends too soon).
"""

from __future__ import annotations

import errno
import os
import sys
import traceback
from contextlib import suppress
from typing import NoReturn

import typer

from rota.command.exit_codes import BAD_INPUT, DONE, NO_PLAN, NOBODY_READS, OUR_FAULT, VIOLATED
from rota.command.interrupt import signalled_code
from rota.command.terminal import say
from rota.errors import NoPlanFound, RotaError
from rota.planning.stopping import work_left_running

# what the machine lacks, whatever Rota does: room on the disk, a disk that works, files that may be open
OF_THE_MACHINE = {
    errno.ENOSPC,
    errno.EDQUOT,
    errno.EFBIG,
    errno.EIO,
    errno.EROFS,
    errno.EMFILE,
    errno.ENFILE,
    errno.ENOMEM,
}


def exit_code_of(end: Exception | SystemExit) -> int:
    """The exit code of what ended a command; says on stderr what is to be said of it."""
    if isinstance(end, SystemExit):
        return _code_of_exit(end)
    if isinstance(end, NoPlanFound):
        say(f"no plan: {end}")
        return NO_PLAN
    if isinstance(end, RotaError):
        for line in str(end).splitlines():
            say(f"error: {line}")
        return BAD_INPUT
    if isinstance(end, BrokenPipeError):
        return _without_reader()
    if isinstance(end, OSError) and end.errno in OF_THE_MACHINE:
        say(f"error: {end.filename or 'output'}: {end.strerror}")
        return BAD_INPUT
    if isinstance(end, MemoryError):
        say("error: this machine has not enough memory for this")
        return BAD_INPUT
    traceback.print_exception(end)
    say(f"a fault in Rota, not in your input ({type(end).__name__}); please report it with the lines above")
    return OUR_FAULT


def _code_of_exit(end: SystemExit) -> int:
    """The exit code of a command that ended itself, or that typer ended."""
    behind = _causes_of(end)
    by = next((cause for cause in behind if isinstance(cause, KeyboardInterrupt)), None)
    if by is not None:
        say("interrupted")
        return signalled_code(by)
    code = DONE if end.code is None else end.code
    meant = code != VIOLATED or (len(behind) > 1 and isinstance(behind[1], typer.Exit))
    if isinstance(code, int) and meant:
        return code
    # typer ended it, not a command
    fault = next((cause for cause in behind if isinstance(cause, EOFError | OSError)), RuntimeError(f"exit {code!r}"))
    return exit_code_of(fault)


def _causes_of(end: BaseException | None) -> list[BaseException]:
    """What was raised, then what it came of, to the first cause."""
    causes = []
    while end is not None:
        causes.append(end)
        end = end.__cause__ or end.__context__
    return causes


def flush(code: int) -> int:
    """The exit code once all output is written; another one where it cannot be.

    Python writes what is left after the program has ended, and would end with 120 where that fails.
    """
    try:
        sys.stdout.flush()
    except Exception as error:
        _forget_output()
        return exit_code_of(error)
    return code


def leave(code: int) -> NoReturn:
    """End the program with this code, at once where work that nobody waits for any more still runs."""
    if not work_left_running():
        sys.exit(code)
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def _without_reader() -> int:
    """The end of a command whose output nobody reads on, as in ``rota check PLAN | head``: quiet."""
    _forget_output()
    return NOBODY_READS


def _forget_output() -> None:
    """Let Python end without trying to write again what could not be written."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
