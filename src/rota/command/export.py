"""What `rota export` does once its plan is read: write it for maps or for robots, and say what they should know."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rota.check import compiled_packages
from rota.command.terminal import STANDARD_STREAM, say
from rota.command.without_mass import without_mass
from rota.compiled.compiled_cache import mention_compiling
from rota.errors import RotaError
from rota.exports import FORMATS, export_format, export_of, place_for
from rota.vehicles.presets import ARDUCOPTER

if TYPE_CHECKING:
    from rota.command.executed import Executed
    from rota.model.plan import Plan

FORMATS_HELP = f"One of {', '.join(FORMATS)}; see below."
# \b keeps the lines as they are
FORMATS_LIST = "\b\nFormats:\n" + "\n".join(
    f"  {name:<18}  {'a folder' if kind.folder or kind.is_folder else 'a file  '}  {kind.holds}"
    for name, kind in FORMATS.items()
)


def write_export(
    plan: Plan,
    source: str,
    to: str,
    output: str,
    *,
    origin: str | None = None,
    start_time: str | None = None,
    settings: Sequence[str] = (),
) -> tuple[str | Path, ...]:
    """Write the plan, read from ``source``, in a format; returns the paths written, none for stdout.

    output: a file for a format of one file (``-`` for stdout), else a folder. The others as in ``export_of``.
    """
    from rota.files.atomic_write import require_target
    from rota.files.flight_files import TABLE

    made = export_of(plan, to, origin=origin, start_time=start_time, settings=settings)
    kind = made.kind
    if (warning := kind.warning(made.plan)) is not None:
        say(f"warning: {warning}")
    if kind.is_text:
        return _write_text(made.text, source, output)
    if output == STANDARD_STREAM:
        if kind.folder is not None:
            raise RotaError(f"-: {to} makes files for each robot, not for stdout; the path of a folder is needed")
        raise RotaError(f"-: {to} cannot be written to stdout; a path is needed")
    if kind.timed is not None and not kind.is_folder:
        require_target(output, source)
    if kind.judges:
        mention_compiling(*compiled_packages(plan.mission))
    paths = made.write(output)
    if made.has_flights:
        say(f"a file is a single flight; {Path(output) / TABLE} says which robot flies it, and when it starts")
    elif kind.in_phase is not None:
        say(f"what keeps robots in phase: {kind.in_phase} (rota check --executed {to} judges that)")
    if to in ARDUCOPTER.formats and (told := without_mass(made.plan, is_flown=not made.has_flights)) is not None:
        say(f"the plan is {told}")
    return paths


def plan_as_executed(plan: Plan, name: str, in_phase_every_s: float | None, origin: str | None) -> Executed:
    """The plan as the files of a format drive it; says on stderr how far that is from the plan."""
    from rota.command.executed import executed_plan, in_phase_every

    export_format(name, "--executed")
    if origin is not None:
        plan = place_for(plan, origin, name)
    made = executed_plan(plan, name)
    say(made.told)
    if in_phase_every_s is not None:
        return replace(made, plan=in_phase_every(plan, made.plan, in_phase_every_s))
    if made.drifts:
        say("it is judged as if nobody ever corrected that; --in-phase-every SECONDS judges robots corrected so often")
    return made


def _write_text(text: Callable[[], str], source: str, output: str) -> tuple[str, ...]:
    """Write text to stdout or to a file; returns the path of the file."""
    from rota.files.atomic_write import require_target, write_atomically

    if output == STANDARD_STREAM:
        sys.stdout.write(text())
        sys.stdout.flush()
        return ()
    require_target(output, source)
    write_atomically(output, text())
    return (output,)
