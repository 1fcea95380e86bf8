"""Plan <-> JSON, bit for bit. A plan file stands alone: anybody can check it without the mission's other files."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from pydantic import ValidationError

from rota.errors import MissionError, PlanError
from rota.files.atomic_write import write_atomically
from rota.files.json_text import digest_of, unique_keys
from rota.files.local_file import read_bytes
from rota.files.mission_json import mission_from_fields, mission_to_json
from rota.files.plan_faults import named_field, plan_faults
from rota.files.plan_schema import PLAN_VERSION, RunEndFields, TrajectoryFields, plan_fields_type
from rota.model.plan import Plan, RunEnd, Trajectory, Waypoints

Json = dict[str, Any]
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
    mark: Json = {} if meets_demand else {"meets_demand": False}
    reason = {} if plan.lower_bound_reason is None else {"lower_bound_reason": plan.lower_bound_reason}
    end, mission = plan.run_end, mission_to_json(plan.mission)
    ended = {} if end is None else {"run_end": _run_end_to_json(end)}
    return {
        "rota_plan": PLAN_VERSION,
        "seed": int(plan.seed),
        "mission_sha256": digest_of(mission),
        "lower_bound_robots": None if plan.lower_bound_robots is None else int(plan.lower_bound_robots),
        **reason,
        **mark,
        **ended,
        "mission": mission,
        "robots": [_trajectory_to_json(trajectory) for trajectory in plan.trajectories],
    }


def _run_end_to_json(end: RunEnd) -> Json:
    """How a swarm's run ended."""
    blocked = {"blocked": list(end.blocked)} if end.blocked else {}
    return {"at_rest": end.at_rest, "steps": end.steps, "reason": end.reason, **blocked}


def _trajectory_to_json(trajectory: Trajectory) -> Json:
    """One robot's trajectory."""
    headings, accelerations = trajectory.headings_rad, trajectory.accelerations_m_s2
    return {
        "name": trajectory.robot,
        "loop_start_s": trajectory.loop_start_s,
        "times_s": trajectory.times_s.tolist(),
        "positions_m": trajectory.positions_m.tolist(),
        "headings_rad": None if headings is None else headings.tolist(),
        **({} if accelerations is None else {"accelerations_m_s2": accelerations.tolist()}),
        **({} if trajectory.waypoints is None else {"waypoints": _waypoints_json(trajectory.waypoints)}),
    }


def _waypoints_json(told: Waypoints) -> Json:
    """What an autopilot is told."""
    return {"places_m": told.places_m.tolist(), "times_s": told.times_s.tolist(), "speed_m_s": told.speed_m_s}


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
    try:
        fields = plan_fields_type(document).model_validate(document)
    except ValidationError as error:
        raise PlanError("\n".join(plan_faults(error))) from error
    mission = mission_from_fields(fields.mission)
    digest = digest_of(document["mission"])
    if fields.mission_sha256 not in (None, digest):
        raise PlanError(
            f"mission_sha256: {fields.mission_sha256[:12]}... is not that of the mission, {digest[:12]}...: the mission"
            " was changed after the plan was made. Plan it again, or remove mission_sha256 to have the plan judged for"
            " the mission as it is now"
        )
    trajectories = tuple(_trajectory(robot, f"robots[{k}]") for k, robot in enumerate(fields.robots))
    with named_field("run_end"):
        end = None if fields.run_end is None else _run_end(fields.run_end)
    with named_field("robots"):
        return Plan(
            mission=mission,
            trajectories=trajectories,
            seed=fields.seed,
            lower_bound_robots=fields.lower_bound_robots,
            lower_bound_reason=fields.lower_bound_reason,
            run_end=end,
        )


def _run_end(fields: RunEndFields) -> RunEnd:
    """How a swarm's run ended. Raises PlanError where its fields contradict each other."""
    return RunEnd(at_rest=fields.at_rest, steps=fields.steps, reason=fields.reason, blocked=tuple(fields.blocked))


def _trajectory(fields: TrajectoryFields, field: str) -> Trajectory:
    """One robot's trajectory. Raises PlanError naming the field that makes none."""
    n, widths = len(fields.times_s), {len(position) for position in fields.positions_m}
    if len(widths) > 1:
        raise PlanError(f"{field}.positions_m: [x, y] and [x, y, z] mixed; all must have as many numbers")
    for name, values in (("positions_m", fields.positions_m), ("headings_rad", fields.headings_rad)):
        if values is not None and len(values) != n:
            raise PlanError(f"{field}.{name}: {len(values)} entries; {n} are needed, one per time in times_s")
    accelerations = fields.accelerations_m_s2
    if accelerations is not None and len(accelerations) != n - 1:
        raise PlanError(f"{field}.accelerations_m_s2: {len(accelerations)} entries; {n - 1} are needed, one per leg")
    with named_field(field):
        return Trajectory(
            robot=fields.name,
            times_s=np.array(fields.times_s, dtype=np.float64),
            positions_m=np.array(fields.positions_m, dtype=np.float64),
            headings_rad=None if fields.headings_rad is None else np.array(fields.headings_rad, dtype=np.float64),
            accelerations_m_s2=None if accelerations is None else np.array(accelerations, dtype=np.float64),
            waypoints=None if fields.waypoints is None else Waypoints(**dict(fields.waypoints)),
            loop_start_s=fields.loop_start_s,
        )
