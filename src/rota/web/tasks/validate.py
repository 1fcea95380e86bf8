"""What is wrong with a mission that is being edited, what it asks for, and the robots that it needs at least."""

from __future__ import annotations

import json
from pathlib import Path

import shapely
from shapely import unary_union

from rota.errors import RotaError
from rota.files.mission_file import JudgedDocument, judge_document
from rota.files.mission_ground import Ground
from rota.files.mission_json import obstacle_to_json, polygons_to_json
from rota.model.mission import Mission
from rota.model.polygons import polygons_of
from rota.planning.planner import planner_of
from rota.web.documents import document_from, require_few_vertices
from rota.web.refusal import Json, Refusal
from rota.web.store.jobs import document_for_planner
from rota.web.store.missions import mission_files, mission_source, upload_contents
from rota.web.tasks.context import Context, as_document, fault_json, lay_out
from rota.web.tasks.feasibility import doubtful, hopeless
from rota.web.tasks.preparing import is_ready


def validate(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """What POST /api/validate answers."""
    asked = document_from(body)
    document = asked.get("document")
    if not isinstance(document, dict):
        raise Refusal(400, "document: is missing; a mission as JSON is needed")
    require_few_vertices(document, context.vertices)
    with lay_out(attachments(context, asked)) as folder:
        judged = judged_document(document, folder, context.vertices)
    return {}, json.dumps(_answer(judged), allow_nan=False).encode()


def require_plannable(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """Refuse a job for a mission with faults, all told at once; the message says what was asked."""
    document, *_ = mission_source(context.database, given["mission"])
    document = document_for_planner(document, given["planner"])
    with lay_out(mission_files(context.database, given["mission"])) as folder:
        judged = judged_document(document, folder, context.vertices)
    if judged.mission is None:
        raise Refusal(422, "the mission has faults", faults_json(judged))
    faults: list[Json] = []
    # to prove a bound takes seconds on large ground, and only starts are held against it
    bound = _prove_bound(judged.mission, faults) if judged.mission.fleet.start and is_ready(judged.mission) else None
    if faults := [*faults, *hopeless(judged.mission, _least(bound))]:
        raise Refusal(422, "the mission cannot work", faults)
    if given["effort"] is not None:
        judged.mission.with_effort(given["effort"])
    return {}, b""


def attachments(context: Context, asked: Json) -> dict[str, bytes]:
    """The files of the mission and of the upload that a request names; the upload's count where both have one."""
    files: dict[str, bytes] = {}
    for key, contents in (("mission", mission_files), ("upload", upload_contents)):
        named = asked.get(key)
        if named is not None:
            if not isinstance(named, str):
                raise Refusal(400, f"{key}: an id is needed")
            files |= contents(context.database, named)
    return files


def judged_document(document: Json, folder: Path, most_vertices: int) -> JudgedDocument:
    """The document's mission or faults; files are looked for in the folder and nowhere else."""
    judged = judge_document(as_document(document), folder, confine=True)
    if judged.ground is not None and (count := _vertices(judged.ground)) > most_vertices:
        raise Refusal(413, f"the shapes have {count:,} vertices; at most {most_vertices:,} are allowed: simplify them")
    return judged


def faults_json(judged: JudgedDocument) -> list[Json]:
    """All faults of a document, each once."""
    faults = [fault_json(fault.place, fault.message) for fault in judged.faults]
    faults += [fault_json((), contradiction) for contradiction in judged.contradictions]
    return list({json.dumps(fault): fault for fault in faults}.values())


def _answer(judged: JudgedDocument) -> Json:
    """Faults and warnings, the ground in metres, and what is asked of how many robots at least."""
    mission, faults = judged.mission, faults_json(judged)
    compiling = mission is not None and not is_ready(mission)
    bound = None if mission is None or compiling else _prove_bound(mission, faults)
    warnings = [fault_json(warning.place, warning.message) for warning in judged.warnings]
    if mission is not None:
        faults += hopeless(mission, _least(bound))
        warnings += doubtful(mission, _least(bound))
    return {
        "faults": faults,
        "warnings": warnings,
        "ground": None if judged.ground is None else ground_json(judged.ground),
        "bound": bound,
        "compiling": compiling,
        "free_m2": None if mission is None else _free_m2(mission),
        "asked_m2_s": None if mission is None else _asked_m2_s(mission),
    }


def _prove_bound(mission: Mission, faults: list[Json]) -> Json | None:
    """Robots that any plan needs, and why; None where nothing is proved. Adds a fault where no plan is possible."""
    try:
        found = planner_of(mission).hasty_bound(mission)
    except RotaError as error:
        faults.append(fault_json((), str(error)))
        return None
    return None if found is None else {"robots": found[0], "reason": found[1]}


def _least(bound: Json | None) -> int:
    """Robots that any plan needs for sure."""
    return 1 if bound is None else max(int(bound["robots"]), 1)


def _free_m2(mission: Mission) -> float:
    """The area without what blocks motion, in square metres."""
    blocked = unary_union([obstacle.shape for obstacle in mission.obstacles if obstacle.blocks_motion])
    return float(mission.area.difference(blocked).area)


def _asked_m2_s(mission: Mission) -> float:
    """Square metres to be seen in each second: the sum of ground over its period, the shortest where zones overlap."""
    zones = sorted(mission.zones, key=lambda zone: zone.period_s or float("inf"))
    free = mission.area.difference(unary_union([o.shape for o in mission.obstacles if o.hides_demand]))
    asked, taken = 0.0, shapely.MultiPolygon()
    for zone in zones:
        ground = polygons_of(zone.shape.intersection(free)).difference(taken)
        if zone.period_s is not None and zone.demand == "every_point":
            asked += ground.area / zone.period_s
        taken = taken.union(zone.shape)
    rest = free.difference(taken).area
    return float(asked + (rest / mission.period_s if mission.period_s else 0.0))


def ground_json(ground: Ground | Mission) -> Json:
    """Area, obstacles and zones as polygons in local metres, and where on the globe they lie."""
    origin = ground.origin
    return {
        "area": polygons_to_json(ground.area),
        "obstacles": [obstacle_to_json(obstacle) for obstacle in ground.obstacles],
        "zones": [
            {"name": z.name, "period_s": z.period_s, "demand": z.demand, "shape": polygons_to_json(z.shape)}
            for z in ground.zones
        ],
        "origin": None if origin is None else {"lat": origin.lat, "lon": origin.lon},
    }


def _vertices(ground: Ground) -> int:
    """Points of all shapes."""
    shapes = [ground.area, *(o.shape for o in ground.obstacles), *(z.shape for z in ground.zones)]
    return int(sum(shapely.get_num_coordinates(shape) for shape in shapes))
