"""Compiled code in files that are named by what they hold: any number of processes and checkouts share them.

A name tells the kernel, its sources, its argument types and whatever else changes its code. So a file is never stale,
never written twice with different contents, and read without an index. A file begins with the SHA-256 of the rest: one
that is empty, cut short or changed is deleted, and its kernel compiled again. `NUMBA_CACHE_DIR` chooses the folder.
"""

from __future__ import annotations

import hashlib
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import BinaryIO
from uuid import uuid4

SUFFIX = ".kernel"
MOST_BYTES = 512_000_000
UNUSED_DAYS = 60
DAY_S = 86_400.0
LOCK = "lock"
DIGEST_BYTES = hashlib.sha256().digest_size


def cache_folder() -> Path:
    """Where compiled code is kept: below NUMBA_CACHE_DIR, or else in the user's folder for caches."""
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(chosen) / "rota"
    if sys.platform == "win32":
        root = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        root = Path.home() / "Library" / "Caches"
    else:
        root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return root / "rota" / "compiled"


def read_code(name: str) -> bytes | None:
    """What was written under this name; None where there is nothing, or something else: that is deleted.

    Files in use look new to ``clean``.
    """
    file = cache_folder() / (name + SUFFIX)
    try:
        kept = file.read_bytes()
    except OSError:
        return None
    data = kept[DIGEST_BYTES:]
    if hashlib.sha256(data).digest() != kept[:DIGEST_BYTES]:
        discard_code(name)
        return None
    with suppress(OSError):  # a folder that is read only
        if time.time() - file.stat().st_mtime > DAY_S:
            os.utime(file)
    return data


def discard_code(name: str) -> None:
    """Delete the file of this name, if it is there and can be deleted."""
    _delete(cache_folder() / (name + SUFFIX))


def kept_names() -> set[str]:
    """The names of all files of kernels."""
    folder = cache_folder()
    return {file.name for file in folder.glob(f"*-*{SUFFIX}")} if folder.is_dir() else set()


def is_writable(folder: Path) -> bool:
    """Whether compiled code can be kept there; makes the folder."""
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return folder.is_dir() and os.access(folder, os.W_OK)


def write_code(name: str, data: bytes) -> bool:
    """Keep the data, whole or not at all; False where the folder cannot be written."""
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        beside = folder / f"{uuid4().hex}.tmp"
        try:
            with beside.open("wb") as opened:
                opened.write(hashlib.sha256(data).digest() + data)
                opened.flush()
                os.fsync(opened.fileno())  # or a loss of power after the rename may leave an empty file of this name
            beside.replace(folder / (name + SUFFIX))
        except BaseException:
            _delete(beside)
            raise
    except OSError:
        return False
    _clean_once(folder)
    return True


@contextmanager
def hold(number: int) -> Iterator[None]:
    """Hold what has this number (63 bits) while it is compiled; other processes wait. Without locks nobody waits."""
    file = _lock_file(cache_folder())
    if file is None:
        yield
        return
    import fcntl

    try:
        fcntl.lockf(file, fcntl.LOCK_EX, 1, number)
    except OSError:
        yield
        return
    try:
        yield
    finally:
        fcntl.lockf(file, fcntl.LOCK_UN, 1, number)


@contextmanager
def claim(number: int) -> Iterator[bool]:
    """Hold what has this number unless another process does, and give whether; without locks it is always given."""
    file = _lock_file(cache_folder())
    if file is None:
        yield True
        return
    import fcntl

    try:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, number)
    except BlockingIOError:
        yield False
        return
    except OSError:
        yield True
        return
    try:
        yield True
    finally:
        fcntl.lockf(file, fcntl.LOCK_UN, 1, number)


@cache
def _lock_file(folder: Path) -> BinaryIO | None:
    # one file for all: locks hold bytes of it, and end with the process that holds them
    if sys.platform == "win32":
        return None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return open(folder / LOCK, "ab")
    except OSError:
        return None


@cache
def _clean_once(folder: Path) -> None:
    with suppress(OSError):
        clean(folder)


def clean(folder: Path, most_bytes: int = MOST_BYTES, now_s: float | None = None) -> None:
    """Delete what nobody has read for UNUSED_DAYS, and beyond ``most_bytes`` what was not read for longest."""
    now_s = time.time() if now_s is None else now_s
    kept = []
    for entry in os.scandir(folder):
        if entry.name == LOCK:
            continue
        facts = entry.stat()
        old_days = (now_s - facts.st_mtime) / DAY_S
        # the others: what a process wrote when it was killed, and files of older versions
        if old_days > (UNUSED_DAYS if entry.name.endswith(SUFFIX) else 1):
            _delete(entry.path)
        else:
            kept.append((facts.st_mtime, facts.st_size, entry.path))
    total = 0
    for _, size, path in sorted(kept, reverse=True):
        total += size
        if total > most_bytes:
            _delete(path)


def _delete(path: str | Path) -> None:
    with suppress(OSError):
        os.unlink(path)
