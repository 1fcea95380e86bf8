"""The heaps that the threads of a command take memory from, as glibc counts them."""

from __future__ import annotations

import platform
import subprocess
import sys

import pytest

COUNT_HEAPS = """
import ctypes, os, re, sys, tempfile, threading
if sys.argv[1] == "one":
    from rota.command.memory import use_one_heap
    use_one_heap()
together = threading.Barrier(4)
def work():
    kept = [bytearray(1000) for _ in range(1000)]
    together.wait()
threads = [threading.Thread(target=work) for _ in range(4)]
[thread.start() for thread in threads], [thread.join() for thread in threads]
libc = ctypes.CDLL(None)
libc.fdopen.restype, libc.fdopen.argtypes = ctypes.c_void_p, [ctypes.c_int, ctypes.c_char_p]
libc.malloc_info.argtypes, libc.fflush.argtypes = [ctypes.c_int, ctypes.c_void_p], [ctypes.c_void_p]
with tempfile.TemporaryFile() as file:
    stream = libc.fdopen(file.fileno(), b"w")
    libc.malloc_info(0, stream), libc.fflush(stream)
    file.seek(0)
    print(len(re.findall(rb"<heap nr", file.read())), flush=True)
    os._exit(0)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries have no such heaps")
@pytest.mark.parametrize(("heaps", "least", "most"), [("one", 1, 1), ("many", 2, 5)])
def test_all_threads_of_a_command_have_one_heap(heaps: str, least: int, most: int) -> None:
    run = subprocess.run([sys.executable, "-c", COUNT_HEAPS, heaps], capture_output=True, text=True, check=False)
    assert run.stderr == ""
    assert least <= int(run.stdout) <= most
