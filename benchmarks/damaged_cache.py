"""Whether damage to the cache of compiled code changes a verdict."""

from __future__ import annotations

import hashlib
import os
import random
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from benchmarks.row import Options, Row
from benchmarks.small_plans import small_plans
from rota.compiled.code_cache import DIGEST_BYTES
from rota.files.plan_file import write_plan

RUNS = 100
WAYS = ("emptied", "halved", "one bit flipped")


def damaged_cache(options: Options) -> Iterator[Row]:
    """``rota check`` a hundred times, each time with one damaged file of its cache that it reads."""
    plan, cache = options.folder / "plan.json", options.folder / "damaged"
    write_plan(small_plans()[0], plan)
    asked = _checked(plan, cache)
    rng, other, unread = random.Random(0), Counter[str](), set[Path]()
    runs = 0
    while runs < RUNS:
        way = WAYS[runs % len(WAYS)]
        file = rng.choice(sorted(set((cache / "rota").glob("*.kernel")) - unread))
        whole = file.read_bytes()
        file.write_bytes(_damaged(whole, way, rng))
        same = _checked(plan, cache) == asked
        if same and file.exists() and not _verifies(file):
            file.write_bytes(whole)  # what calls it holds its code, so that nobody reads it
            unread.add(file)
            continue
        runs += 1
        if not same:
            other[way] += 1
            shutil.rmtree(cache)  # what is damaged must not count twice
            _checked(plan, cache)
    told = "; ".join(f"{count} others when {way}" for way, count in other.items())
    same_runs = RUNS - other.total()
    measured = f"{same_runs} of {RUNS}" + (f"; {told}" if told else "")
    yield Row("cache of compiled code damaged: same verdict", f"{RUNS} of {RUNS}", measured, same_runs == RUNS)


def _verifies(file: Path) -> bool:
    """Whether the file holds what was written: it begins with the digest of the rest."""
    kept = file.read_bytes()
    return hashlib.sha256(kept[DIGEST_BYTES:]).digest() == kept[:DIGEST_BYTES]


def _checked(plan: Path, cache: Path) -> tuple[int, str]:
    """What ``rota check`` of the plan ends with and prints, with its compiled code in ``cache``."""
    done = subprocess.run(
        [sys.executable, "-m", "rota", "check", plan],
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout


def _damaged(content: bytes, way: str, rng: random.Random) -> bytes:
    """A file's contents after the damage."""
    if way == "one bit flipped":
        at = rng.randrange(len(content))
        return content[:at] + bytes([content[at] ^ 1 << rng.randrange(8)]) + content[at + 1 :]
    return b"" if way == "emptied" else content[: len(content) // 2]
