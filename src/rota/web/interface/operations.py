"""Every operation of the HTTP interface, once: the document is made of them, and tests hold the routes against them."""

from __future__ import annotations

from dataclasses import dataclass

from rota.web.interface.values import ANYTHING, COUNT, NUMBER, TEXT, Schema, an_object, list_of, or_null, ref

JSON, BYTES, EVENTS = "application/json", "application/octet-stream", "text/event-stream"
UPLOAD = "multipart/form-data"


@dataclass(frozen=True, kw_only=True)
class Operation:
    """What can be asked at a path.

    query: parameters of the address with their schemas. body: of JSON; uploads: files as multipart instead. status and
    gives: of success, with the kind of its content; None: an empty answer. refuses: the statuses of errors beside those
    that every operation has.
    """

    method: str
    path: str
    what: str
    gives: Schema | None = None
    kind: str = JSON
    status: int = 200
    body: Schema | None = None
    uploads: bool = False
    query: tuple[tuple[str, Schema, str], ...] = ()
    refuses: tuple[int, ...] = ()

    @property
    def subject(self) -> str:
        """The part of the interface that it belongs to."""
        return self.path.split("/")[2] if self.path.startswith("/api/") else "page"


_SET = ("set", TEXT, "KEY=VALUE, a setting of the format; may be given often")
_DOCUMENT = {**ANYTHING, "description": "a mission file as JSON"}
_LIMIT = {**NUMBER, "exclusiveMinimum": 0}
_REVISION = {**COUNT, "minimum": 1, "description": "the one that is meant; 409 where the mission has changed since"}
_START_JOB = an_object(
    {"mission": TEXT},
    {
        "planner": or_null(TEXT),
        "effort": or_null(TEXT),
        "seed": or_null(COUNT),
        "time_limit_s": or_null(_LIMIT),
        "revision": or_null(_REVISION),
    },
)
_REPLAN = an_object(
    {"at_s": {**NUMBER, "minimum": 0}, "lost": {**list_of(TEXT), "minItems": 1}},
    {"seed": or_null(COUNT), "time_limit_s": or_null(_LIMIT)},
)
_NEW_MISSION = {
    "oneOf": [
        an_object({"document": _DOCUMENT}, {"upload": or_null(TEXT)}),
        an_object({"example": TEXT}),
    ]
}
_START_WATCH = an_object(
    {"plan": TEXT},
    {
        "link": or_null(TEXT),
        "settings": {"description": "of the link: texts KEY=VALUE, or an object"},
        "origin": or_null(TEXT),
        "cells": or_null(COUNT),
    },
)

OPERATIONS = (
    Operation(method="GET", path="/", what="The page.", gives=TEXT, kind="text/html"),
    Operation(method="GET", path="/docs", what="This document as a page.", gives=TEXT, kind="text/html"),
    Operation(method="GET", path="/openapi.json", what="This document.", gives=ANYTHING),
    Operation(method="GET", path="/api/about", what="Version, planners, formats, links, limits.", gives=ref("About")),
    Operation(method="GET", path="/api/schema/mission", what="The JSON Schema of mission files.", gives=ANYTHING),
    Operation(method="GET", path="/api/examples", what="All examples.", gives=list_of(ref("Example"))),
    Operation(
        method="GET", path="/api/examples/{name}", what="An example as a document.", gives=ref("ReadMission"),
        refuses=(404,),
    ),
    Operation(
        method="POST", path="/api/missions/read", uploads=True, gives=ref("ReadMission"), refuses=(413, 415, 422),
        what="Files as a document to be edited: a mission with what it names, GeoJSON, or a ROS map with its picture.",
        query=(("as", TEXT, "of GeoJSON a letter for each feature: a area, o obstacle, z zone, - left out"),),
    ),
    Operation(
        method="GET", path="/api/missions", what="All missions, the one changed last first.",
        gives=list_of(ref("MissionEntry")),
    ),
    Operation(
        method="POST", path="/api/missions", status=201,
        what="Keep a mission, which may have faults, or an example; one that is kept unchanged is not kept again.",
        body=_NEW_MISSION, gives=ref("Mission"), refuses=(404, 409, 413, 415),
    ),
    Operation(method="GET", path="/api/missions/{id}", what="A mission.", gives=ref("Mission"), refuses=(404,)),
    Operation(
        method="PUT", path="/api/missions/{id}", what="Replace a mission; files of an upload come to those it has.",
        body=an_object(
            {"document": _DOCUMENT}, {"upload": or_null(TEXT), "name": or_null(TEXT), "revision": or_null(_REVISION)},
        ),
        gives=ref("Mission"), refuses=(404, 409, 413, 415),
    ),
    Operation(
        method="DELETE", path="/api/missions/{id}", what="Delete a mission; its plans and jobs stay.", status=204,
        refuses=(404,),
    ),
    Operation(
        method="GET", path="/api/missions/{id}/mission.yaml", what="The mission file.", gives=TEXT,
        kind="application/yaml", refuses=(404,),
    ),
    Operation(
        method="GET", path="/api/missions/{id}/mission.zip", what="The mission file with the files that it names.",
        gives=TEXT, kind="application/zip", refuses=(404,),
    ),
    Operation(
        method="POST", path="/api/validate", gives=ref("Validation"), refuses=(404, 409, 413, 415, 422),
        what="What is wrong with a document, its ground in metres, and the robots that it needs at least.",
        body=an_object({"document": _DOCUMENT}, {"mission": or_null(TEXT), "upload": or_null(TEXT)}),
        query=(("tab", TEXT, "of requests of one tab that wait, only the newest is answered; others get 409"),),
    ),
    Operation(
        method="POST", path="/api/jobs", what="Plan a mission as it is now, when its turn comes.", status=201,
        body=_START_JOB, gives=ref("Job"), refuses=(404, 409, 415, 422),
    ),
    Operation(method="GET", path="/api/jobs", what="All jobs, the newest first.", gives=list_of(ref("Job"))),
    Operation(method="GET", path="/api/jobs/{id}", what="A job.", gives=ref("Job"), refuses=(404,)),
    Operation(
        method="DELETE", path="/api/jobs/{id}", what="Delete a job that is over; its plan stays.", status=204,
        refuses=(404, 409),
    ),
    Operation(
        method="GET", path="/api/jobs/{id}/events", gives=TEXT, kind=EVENTS, refuses=(404,),
        what="Events job (a Job, at each change) and better (plan, robots, met, elapsed_s) until the job is over.",
    ),
    Operation(
        method="POST", path="/api/jobs/{id}/stop", what="Stop a job with its best plan so far.", gives=ref("Job"),
        refuses=(404, 409),
    ),
    Operation(
        method="POST", path="/api/jobs/{id}/again", what="Ask what a job asked once more.", status=201,
        gives=ref("Job"), refuses=(404, 409),
    ),
    Operation(method="GET", path="/api/plans", what="All plans, the newest first.", gives=list_of(ref("Plan"))),
    Operation(
        method="POST", path="/api/plans", what="Check and keep a plan file.", uploads=True, status=201,
        gives=ref("Plan"), refuses=(409, 413, 415, 422),
    ),
    Operation(
        method="GET", path="/api/plans/{id}", what="A plan with the check's report.", gives=ref("Plan"), refuses=(404,)
    ),
    Operation(method="DELETE", path="/api/plans/{id}", what="Delete a plan.", status=204, refuses=(404,)),
    Operation(
        method="POST", path="/api/plans/{id}/replan", status=201, body=_REPLAN, gives=ref("Job"),
        what="Replan from a moment of a plan on without robots that are lost then, as a job.",
        refuses=(404, 409, 415, 422),
    ),
    Operation(
        method="GET", path="/api/plans/{id}/playback", what="What players need: ROTAPLAY, arrays behind a header.",
        gives=TEXT, kind=BYTES, refuses=(404,),
        query=(("cells", {**COUNT, "minimum": 100, "maximum": 200_000}, "about so many cells of the heat map"),),
    ),
    Operation(
        method="GET", path="/api/plans/{id}/plan.rota.json", what="The plan file.", gives=ref("PlanFile"),
        refuses=(404,),
    ),
    Operation(
        method="GET", path="/api/plans/{id}/picture.png", what="The plan drawn.", gives=TEXT, kind="image/png",
        refuses=(404,),
    ),
    Operation(
        method="GET", path="/api/plans/{id}/page.html", what="The plan as one page that plays it anywhere.",
        gives=TEXT, kind="text/html", refuses=(404,),
    ),
    Operation(
        method="GET", path="/api/plans/{id}/export/{format}", gives=TEXT, kind="*/*", refuses=(404, 422),
        what="The plan in a format; several files come as a .zip.",
        query=(
            ("origin", TEXT, "LAT,LON of (0, 0), for missions that do not say it"),
            ("start_time", TEXT, "ISO 8601, for formats with a clock"),
            _SET,
        ),
    ),
    Operation(method="GET", path="/api/watches", what="All live fleets.", gives=list_of(ref("Watch"))),
    Operation(
        method="POST", path="/api/watches", what="Watch the fleet of a plan live, simulated unless a link is named.",
        status=201, body=_START_WATCH, gives=ref("Watch"), refuses=(404, 415, 422),
    ),
    Operation(method="GET", path="/api/watches/{id}", what="A live fleet.", gives=ref("Watch"), refuses=(404,)),
    Operation(
        method="GET", path="/api/watches/{id}/events", gives=TEXT, kind=EVENTS, refuses=(404,),
        what="Events state (positions and ages), notice and ended, while the fleet is watched.",
    ),
    Operation(
        method="POST", path="/api/watches/{id}/stop", what="End a watch.", gives=ref("Watch"), refuses=(404, 409)
    ),
)  # fmt: skip
