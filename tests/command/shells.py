"""`rota` in processes of their own, as in shells beside each other, and a watch that is read until all goes well."""

from __future__ import annotations

import asyncio
import json
import shlex
import signal
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from rota.command.cli import run
from rota.live.watch_log import LogReader
from rota.model.plan import Plan

PATIENCE_S = 120.0


@asynccontextmanager
async def shell(folder: Path, *words: str, stdin: int | None = asyncio.subprocess.DEVNULL) -> AsyncIterator[Process]:
    """A process of `rota` in a folder; it is ended with the block."""
    command = (sys.executable, "-m", "rota", *words)
    process = await asyncio.create_subprocess_exec(*command, cwd=folder, stdin=stdin, stdout=PIPE, stderr=PIPE)
    try:
        async with asyncio.timeout(PATIENCE_S):
            yield process
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()


async def line_with(process: Process, text: str) -> str:
    """The next line of its stdout that holds a text."""
    assert process.stdout is not None
    async for line in process.stdout:
        if text in line.decode():
            return line.decode()
    raise AssertionError(f"no line with {text!r}; it said {await said(process)}")


async def said(process: Process) -> str:
    """All the rest of what it says on stderr."""
    assert process.stderr is not None
    return (await process.stderr.read()).decode()


async def interrupted(process: Process, by: signal.Signals = signal.SIGINT) -> tuple[int, str]:
    """Its exit code and stderr after Ctrl-C."""
    process.send_signal(by)
    told = await said(process)
    return await process.wait(), told


def goes_well(robot: Any) -> bool:
    """Whether a robot of a state has been heard and is on its route."""
    return robot["place_m"] is not None and robot["standing"] == "ok"


async def watch_for_a_while(folder: Path, plan: Plan, command: str) -> tuple[list[Any], str]:
    """Watch by the command that `rota fly` prints until all goes well after a second or more; then Ctrl-C.

    Returns the robots of that state, and all that was printed. The log must end as it should.
    """
    name = "shells.rota-log"
    _, *words = shlex.split(command)
    async with shell(folder, *words, "--json", "--every", "0.2", "--log", name) as watching:
        printed = [await line_with(watching, "{")]
        state = first = json.loads(printed[0])
        while state["time_s"] < first["time_s"] + 1.0 or not all(map(goes_well, state["robots"])):
            printed.append(await line_with(watching, "{"))
            read = json.loads(printed[-1])
            state = read if "robots" in read else state
        code, told = await interrupted_with_stdout(watching, printed)
        assert code == 0, told
    log = LogReader.of(folder / name, plan)
    assert len(list(log.events())) > 10
    assert log.fault is None
    return state["robots"], "".join(printed)


async def interrupted_with_stdout(process: Process, printed: list[str]) -> tuple[int, str]:
    """The same as ``interrupted``; what it still prints is added to ``printed``."""
    process.send_signal(signal.SIGINT)
    assert process.stdout is not None
    printed += [line.decode() async for line in process.stdout]
    told = await said(process)
    return await process.wait(), told


def replayed(folder: Path, plan_file: str) -> int:
    """What `rota watch --replay` comes to; it prints to this process's stdout."""
    words = [str(folder / plan_file), "--replay", str(folder / "shells.rota-log"), "--json", "--every", "0.2"]
    return run(["watch", *words])
