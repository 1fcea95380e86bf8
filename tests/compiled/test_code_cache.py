"""Files of compiled code: whole or absent, used again wherever they can be read, cleaned when nobody uses them."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rota.compiled.code_cache import (
    DAY_S,
    DIGEST_BYTES,
    UNUSED_DAYS,
    cache_folder,
    clean,
    hold,
    read_code,
    write_code,
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    return cache_folder()


def test_what_is_written_is_read_again(folder: Path) -> None:
    assert read_code("f-1") is None
    assert write_code("f-1", b"machine code")
    assert read_code("f-1") == b"machine code"
    assert [file.name for file in folder.iterdir()] == ["f-1.kernel"]


@pytest.mark.parametrize("length", range(DIGEST_BYTES + len(b"machine code")))
def test_a_file_that_is_cut_short_is_deleted(folder: Path, length: int) -> None:
    write_code("f-1", b"machine code")
    file = folder / "f-1.kernel"
    file.write_bytes(file.read_bytes()[:length])
    assert read_code("f-1") is None
    assert not file.exists()


@pytest.mark.parametrize("place", range(DIGEST_BYTES + len(b"machine code")))
def test_a_file_with_a_bit_changed_is_deleted(folder: Path, place: int) -> None:
    write_code("f-1", b"machine code")
    file = folder / "f-1.kernel"
    kept = bytearray(file.read_bytes())
    kept[place] ^= 1 << place % 8
    file.write_bytes(kept)
    assert read_code("f-1") is None
    assert not file.exists()


def test_what_older_versions_and_killed_processes_left_goes(folder: Path) -> None:
    write_code("f-1", b"1")
    for name in ("f-1.code", "0123.tmp", "lock"):
        (folder / name).write_bytes(b"1")
    clean(folder, now_s=time.time() + 2 * DAY_S)
    assert sorted(file.name for file in folder.iterdir()) == ["f-1.kernel", "lock"]


def test_a_folder_that_cannot_be_made_keeps_nothing_and_hinders_nobody(tmp_path: Path, folder: Path) -> None:
    folder.write_text("a file stands in its place")
    assert not write_code("f-1", b"machine code")
    assert read_code("f-1") is None
    with hold(7):
        assert folder.is_file()


def test_code_that_nobody_reads_goes_and_what_is_read_stays(folder: Path) -> None:
    for name in ("used", "unused"):
        write_code(name, b"1")
        long_ago_s = time.time() - (UNUSED_DAYS - 1) * DAY_S
        os.utime(folder / f"{name}.kernel", (long_ago_s, long_ago_s))
    read_code("used")
    clean(folder, now_s=time.time() + 2 * DAY_S)
    assert (read_code("used"), read_code("unused")) == (b"1", None)


def test_beyond_its_size_what_was_not_read_for_longest_goes(folder: Path) -> None:
    for age_s, name in enumerate(("new", "older", "oldest")):
        write_code(name, b"12345")
        when_s = time.time() - 10 * age_s
        os.utime(folder / f"{name}.kernel", (when_s, when_s))
    clean(folder, most_bytes=2 * (DIGEST_BYTES + 5))
    assert [read_code(name) for name in ("new", "older", "oldest")] == [b"12345", b"12345", None]


@pytest.mark.skipif(sys.platform == "win32", reason="processes do not wait for each other there")
def test_two_processes_do_not_hold_the_same(folder: Path) -> None:
    program = (
        "from rota.compiled.code_cache import hold\n"
        "with hold(2**62 + 5):\n    print('held', flush=True)\n    input()\nprint('given back', flush=True)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdin is not None
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with hold(2**62 + 6):  # another one is free
            assert other.poll() is None
        other.stdin.write("\n")
        other.stdin.flush()
        with hold(2**62 + 5):
            assert other.stdout.readline() == "given back\n"
