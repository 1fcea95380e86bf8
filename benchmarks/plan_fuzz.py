"""Mutated plan files through the reader and the check: ``python -m benchmarks.plan_fuzz [CASES] [FIRST]``, or the row.

Each must be refused by PlanError or judged; all else is a fault. A process of its own does the work, so that a
segmentation fault is noticed and the rest goes on. Faults are told with the number that makes them again.
"""

from __future__ import annotations

import json
import random
import resource
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, TimeoutError as TooLong
from concurrent.futures.process import BrokenProcessPool
from functools import cache
from typing import Any

from benchmarks.plan_mutations import mutated
from benchmarks.row import Options, Row
from benchmarks.small_plans import small_plans
from rota.check import check_plan, report_table, report_to_json
from rota.errors import PlanError
from rota.files.plan_file import plan_from_text, plan_to_json

LONGEST_S = 40  # a large area and a small sensor make the check work for minutes, as they should
TOO_LONG = f"took more than {LONGEST_S} s"
MEMORY_BYTES = 6 << 30


@cache
def base_documents() -> tuple[Any, ...]:
    """The plan files that are changed, as JSON values."""
    return tuple(plan_to_json(plan) for plan in small_plans())


def judged(case: int) -> str:
    """What becomes of a case: refused, or the verdict. Anything else is raised."""
    rng = random.Random(case)
    text = mutated(base_documents()[case % len(base_documents())], rng)
    try:
        plan = plan_from_text(text, "mutated")
    except PlanError as error:
        str(error).encode()
        return "refused"
    report = check_plan(plan)
    json.dumps(report_to_json(report), allow_nan=False)
    report_table(report).encode()
    return report.verdict


def _limit_memory() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))


def fuzz(cases: range) -> Counter[str]:
    """Outcomes of all cases; faults and cases that take too long are told as they come."""
    outcomes: Counter[str] = Counter()
    pool = ProcessPoolExecutor(1, initializer=_limit_memory)
    first = next((case for case in cases if pool.submit(judged, case).result() != "refused"), 0)
    for case in cases:
        try:
            outcome = pool.submit(judged, case).result(LONGEST_S)
        except (Exception, BrokenProcessPool) as fault:
            outcome = TOO_LONG if isinstance(fault, TooLong) else "crash"
            outcome = "fault" if outcome == "crash" and not isinstance(fault, BrokenProcessPool) else outcome
            print(f"case {case}: {outcome}: {type(fault).__name__}: {str(fault)[:200]}", flush=True)
            if outcome != "fault":
                for process in list(pool._processes.values()):
                    process.kill()
                pool = ProcessPoolExecutor(1, initializer=_limit_memory)
                pool.submit(judged, first).result()  # loads what is compiled
        outcomes[outcome] += 1
    return outcomes


def mutated_plans(options: Options) -> Iterator[Row]:
    """5,000 of them."""
    begin = time.monotonic()
    outcomes = fuzz(range(5000))
    told = ", ".join(f"{count:,} {outcome}" for outcome, count in outcomes.most_common())
    yield Row(
        "mutated plan files, read and checked",
        "refused with the place, or judged: no fault, no crash",
        f"{told}; {time.monotonic() - begin:.0f} s",
        not outcomes["fault"] + outcomes["crash"],
    )


def main() -> None:
    count, first = (int(sys.argv[k]) if len(sys.argv) > k else default for k, default in ((1, 5000), (2, 0)))
    begin = time.monotonic()
    outcomes = fuzz(range(first, first + count))
    print(
        f"{count} mutated plans in {time.monotonic() - begin:.0f} s: "
        + ", ".join(f"{n} {o}" for o, n in outcomes.items())
    )
    sys.exit(1 if outcomes["fault"] + outcomes["crash"] else 0)


if __name__ == "__main__":
    main()
