"""Plan <-> JSON, bit for bit. A plan file stands alone: anybody can check it without the mission's other files."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import NoReturn

from rota.errors import MissionError, PlanError, RotaError
from rota.files.atomic_write import write_atomically
from rota.files.blocks import make, read_block
from rota.files.json_text import digest_of, unique_keys
from rota.files.local_file import read_bytes
from rota.files.mission_json import block_to_json, mission_to_json
from rota.files.plan_schema import PLAN_VERSION, plan_block
from rota.model.field_values import Json
from rota.model.fields import fields_of
from rota.model.plan import Plan
from rota.model.refusals import path_of

MOST_FAULTS = 20
_OF_PLAN = {item.key or item.name for item in fields_of(Plan)}
MADE_BY = "'rota plan' writes one"


# ---------------------------------------------------------------- writing


def write_plan(plan: Plan, path: str | os.PathLike[str], *, meets_demand: bool = True) -> None:
    """Write ``plan`` to ``path``: whole or not at all. ``meets_demand`` False marks it as the best that was found.

    Raises RotaError when the path cannot be written.
    """
    write_atomically(path, plan_text(plan, meets_demand=meets_demand))


def plan_text(plan: Plan, *, meets_demand: bool = True) -> str:
    """The plan file's text: JSON, one line per field of the mission and per trajectory."""
    document = plan_to_json(plan, meets_demand=meets_demand)
    lines = [f"{json.dumps(key)}: {_line(document[key])}" for key in document if key not in ("mission", "robots")]
    fields = ",\n  ".join(f"{json.dumps(key)}: {_line(value)}" for key, value in document["mission"].items())
    lines.append('"mission": {\n  ' + fields + "}")
    lines.append('"robots": [\n  ' + ",\n  ".join(_line(robot) for robot in document["robots"]) + "]")
    return "{" + ",\n ".join(lines) + "}\n"


def _line(value: object) -> str:
    """A value on one line, with all its digits."""
    return json.dumps(value, allow_nan=False)


def plan_to_json(plan: Plan, *, meets_demand: bool = True) -> Json:
    """The plan as plain dicts, lists, strings and numbers, as the plan file holds it."""
    mission, told = mission_to_json(plan.mission), block_to_json(plan, without=("mission",))
    bound = {name: told.pop(name) for name in list(told) if name.startswith("lower_bound")}
    head = {"rota_plan": PLAN_VERSION, "seed": told.pop("seed"), "mission_sha256": digest_of(mission), **bound}
    return {
        **head,
        **({} if meets_demand else {"meets_demand": False}),
        **told,
        "mission": mission,
        "robots": told["robots"],
    }


# ---------------------------------------------------------------- reading


def read_plan(path: str | os.PathLike[str]) -> Plan:
    """Read a plan file. Raises PlanError naming the file, the field and what is allowed there."""
    try:
        text = read_bytes(Path(path), f"a plan file ({MADE_BY})")
    except MissionError as error:
        raise PlanError(str(error)) from None
    return plan_from_text(text, os.fspath(path))


def plan_from_text(text: str | bytes, source: str) -> Plan:
    """Read the text of a plan file; ``source`` names it in errors. Raises PlanError."""
    try:
        decoded = text.decode("utf-8-sig") if isinstance(text, bytes) else text
        document = json.loads(decoded, parse_constant=_refuse_constant, object_pairs_hook=unique_keys)
    except UnicodeDecodeError as error:
        raise PlanError(f"{source}: byte {error.start} is not UTF-8; a plan file is needed ({MADE_BY})") from error
    except json.JSONDecodeError as error:
        raise PlanError(
            f"{source}:{error.lineno}:{error.colno}: not JSON: {error.msg}; a plan file is needed ({MADE_BY})"
        ) from error
    except RecursionError as error:
        raise PlanError(f"{source}: brackets nested too deeply for a plan file") from error
    except (ValueError, PlanError) as error:  # also a number of more digits than Python converts
        raise PlanError(f"{source}: {error}") from error
    try:
        return plan_from_json(document)
    except PlanError as error:
        raise PlanError("\n".join(f"{source}: {line}" for line in str(error).splitlines())) from error


def _refuse_constant(constant: str) -> NoReturn:
    """For NaN and Infinity, which Python reads though JSON has none."""
    raise PlanError(f"{constant} is no number that a plan may hold; numbers must be finite")


def plan_from_json(document: object) -> Plan:
    """The plan that ``plan_to_json`` made; ``meets_demand`` is not believed but left to the check.

    Nor is anything made of ``mission_changes``: the plan is for the mission in the file.

    Raises PlanError: one line per fault, each with the field's path, its value and what is allowed.
    """
    if not isinstance(document, dict) or "rota_plan" not in document:
        raise PlanError('not a plan file: there is no "rota_plan" at the top; a plan file is needed (' + MADE_BY + ")")
    version = document["rota_plan"]
    if version != PLAN_VERSION or isinstance(version, bool):
        raise PlanError(f"rota_plan: version {version!r} is not known; this Rota reads version {PLAN_VERSION}")
    values, faults = read_block(plan_block(document), document)
    if faults:
        lines = [f"{path_of(fault.place) or 'plan'}: {fault.message}" for fault in faults]
        more = len(lines) - MOST_FAULTS
        raise PlanError("\n".join(lines[:MOST_FAULTS] + [f"and {more} more faults"] * (more > 0)))
    digest, told = digest_of(document["mission"]), values.get("mission_sha256")
    if told not in (None, digest):
        raise PlanError(
            f"mission_sha256: {told[:12]}... is not that of the mission, {digest[:12]}...: the mission"
            " was changed after the plan was made. Plan it again, or remove mission_sha256 to have the plan judged for"
            " the mission as it is now"
        )
    try:
        return make(Plan, **{name: value for name, value in values.items() if name in _OF_PLAN})
    except RotaError as error:
        raise PlanError(f"robots: {error}") from error
