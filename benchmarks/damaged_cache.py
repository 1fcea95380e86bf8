"""Whether damage to the cache of compiled code changes a verdict."""

from __future__ import annotations

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
from rota.files.plan_file import write_plan

RUNS = 100
WAYS = ("emptied", "halved", "one bit flipped")


def damaged_cache(options: Options) -> Iterator[Row]:
    """``rota check`` a hundred times, each time with one file of its cache damaged that the time before has used."""
    plan, cache = options.folder / "plan.json", options.folder / "damaged"
    write_plan(small_plans()[0], plan)
    asked = _checked(plan, cache)
    rng, other = random.Random(0), Counter[str]()
    for run in range(RUNS):
        way = WAYS[run % len(WAYS)]
        file = rng.choice(sorted((cache / "rota").glob("*.kernel")))
        file.write_bytes(_damaged(file.read_bytes(), way, rng))
        if _checked(plan, cache) != asked:
            other[way] += 1
            shutil.rmtree(cache)  # what is damaged must not count twice
            _checked(plan, cache)
    told = "; ".join(f"{count} others when {way}" for way, count in other.items())
    same = RUNS - other.total()
    measured = f"{same} of {RUNS}" + (f"; {told}" if told else "")
    yield Row("cache of compiled code damaged: same verdict", f"{RUNS} of {RUNS}", measured, same == RUNS)


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
