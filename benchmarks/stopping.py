"""How soon ``rota plan`` ends once its time is over or SIGTERM comes, and with what, whatever it was doing."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

from benchmarks.row import Options, Row
from benchmarks.shell import Run, rota
from benchmarks.stopping_missions import MISSIONS

LIMIT_S, GRACE_S, PATIENCE_S = 20.0, 30.0, 900.0
WAYS = {"--time-limit 20": 0, "SIGTERM": signal.SIGTERM}  # the signal to send


def stopping(options: Options) -> Iterator[Row]:
    """Each mission stopped in both ways after twenty seconds; the plan, if there is one, is checked anew."""
    passed = 0
    asked = f"a plan or a sentence, at most {GRACE_S:.0f} s of processor time more"
    for name, write in MISSIONS.items():
        mission = write(options.folder)
        outcomes = [_stopped(mission, way) for way in WAYS]
        reached = all(good for good, _ in outcomes)
        passed += reached
        measured = "; ".join(f"{way}: {told}" for way, (_, told) in zip(WAYS, outcomes, strict=True))
        yield Row(f"{name}, stopped after {LIMIT_S:.0f} s", asked, measured, reached)
    whole = len(MISSIONS)
    yield Row("missions stopped in time, of eight", f"{whole} of {whole}", f"{passed} of {whole}", passed == whole)


def _stopped(mission: Path, way: str) -> tuple[bool, str]:
    """Whether it ended as it should, and what it came to."""
    plan, sends = mission.with_suffix(".rota.json"), WAYS[way]
    plan.unlink(missing_ok=True)
    limit: tuple[str, ...] = () if sends else ("--time-limit", f"{LIMIT_S:g}")
    run = rota(
        "plan", mission, *limit, "-o", plan, look_after_s=LIMIT_S, sends=sends, patience_s=PATIENCE_S
    )  # fmt: skip
    more_s = run.cpu_s_after or 0.0
    verdict = _outcome(run, plan, sends)
    return more_s <= GRACE_S and verdict is not None, f"{more_s:.1f} s, {verdict or run.failure()}"


def _outcome(run: Run, plan: Path, sends: int) -> str | None:
    """What there is, for people; None: neither a plan that passes nor a sentence that says why there is none."""
    stopped = 128 + sends if sends else 3
    if run.ended_early or run.code not in (0, stopped):
        return None
    if plan.exists():
        check = rota("check", plan, patience_s=PATIENCE_S)
        return f"a plan ({check.out.splitlines()[0].removeprefix('verdict: ')})" if check.code == 0 else None
    # a machine so busy that the command has not begun to read within the time says that alone
    says = "rota: no plan: " in run.err or run.err.endswith("rota: interrupted\n")
    return "a sentence" if run.code == stopped and says else None
