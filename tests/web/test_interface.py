"""The OpenAPI document tells what the server does: every route, and every answer to whatever is sent."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import jsonschema
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from starlette.testclient import TestClient
from tests.web.serving import SQUARE, Json, job_when, kept, serving, started

from rota.web.app import all_routes
from rota.web.interface.document import document
from rota.web.interface.operations import OPERATIONS, Operation
from rota.web.limits import Limits

DOCUMENT = document()
LONG = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]}

texts = st.text(max_size=12) | st.sampled_from(["harbour", "patrol", "quick", "metres", "wgs84", "../x", "\0", "ß"])
numbers = st.integers(-3, 70) | st.floats(allow_nan=False, allow_infinity=False) | st.integers()
values = st.recursive(
    st.none() | st.booleans() | numbers | texts,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(texts, inner, max_size=4),
    max_leaves=12,
)


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with serving(tmp_path_factory.mktemp("interface"), Limits(planning_jobs=1)) as made:
        yield made


@pytest.fixture(scope="module")
def ids(client: TestClient) -> dict[str, list[str]]:
    """Ids that there are, by subject."""
    job = started(client, SQUARE)
    plan = job_when(client, job, "done")["plan"]
    return {"missions": [kept(client, SQUARE)], "jobs": [job], "plans": [plan], "watches": ["none"]}


def test_the_document_has_every_route_and_no_other() -> None:
    routed = {(method, route.path) for route in all_routes() for method in (route.methods or set()) - {"HEAD"}}
    assert {(operation.method, operation.path) for operation in OPERATIONS} == routed


def test_the_document_keeps_to_openapi_and_its_schemas_to_json_schema() -> None:
    for schema in DOCUMENT["components"]["schemas"].values():
        jsonschema.Draft202012Validator.check_schema(schema)
    named = set(DOCUMENT["components"]["schemas"])
    for found in _refs(DOCUMENT):
        assert found.removeprefix("#/components/schemas/") in named
    operations = [told for methods in DOCUMENT["paths"].values() for told in methods.values()]
    assert len({told["operationId"] for told in operations}) == len(operations)
    for told in operations:
        assert told["summary"].endswith(".")
        assert any(status.startswith("2") for status in told["responses"])


def _refs(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        if isinstance(value.get("$ref"), str):
            yield value["$ref"]
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from _refs(item)


def answered(client: TestClient, operation: Operation, path: str, **sent: Any) -> None:
    """Send a request, and hold the answer against the document."""
    answer = client.request(operation.method, path, **sent)
    told = DOCUMENT["paths"][operation.path][operation.method.lower()]["responses"]
    assert str(answer.status_code) in told, (
        f"{operation.method} {path} {sent}: {answer.status_code} {answer.text[:500]}"
    )
    assert answer.status_code < 500  # 503 is in the document: for a server that is full, which this one never is
    assert "Traceback" not in answer.text[:2000]
    content = told[str(answer.status_code)].get("content", {})
    if "application/json" in content:
        schema = {**content["application/json"]["schema"], "components": DOCUMENT["components"]}
        jsonschema.Draft202012Validator(schema).validate(answer.json())
    elif not content:
        assert answer.content == b""


READING = [o for o in OPERATIONS if o.method == "GET" and "{" not in o.path]
WITH_ID = [o for o in OPERATIONS if "{id}" in o.path and not o.path.startswith("/api/watches")]


@pytest.mark.parametrize("operation", READING, ids=lambda o: o.path)
def test_what_takes_nothing_answers_as_written(client: TestClient, operation: Operation) -> None:
    answered(client, operation, operation.path)


@pytest.mark.parametrize("operation", [o for o in WITH_ID if o.method == "GET"], ids=lambda o: o.path)
def test_what_is_there_is_answered_as_written(
    client: TestClient, ids: dict[str, list[str]], operation: Operation
) -> None:
    path = operation.path.replace("{id}", ids[operation.subject][0]).replace("{format}", "geojson")
    answered(client, operation, path)
    assert client.get(path).status_code == 200


@pytest.mark.parametrize("operation", [o for o in OPERATIONS if "{" in o.path], ids=lambda o: f"{o.method} {o.path}")
def test_what_is_not_there_is_answered_as_written(client: TestClient, operation: Operation) -> None:
    path = operation.path.replace("{id}", "none").replace("{name}", "none").replace("{format}", "none")
    sent = {} if operation.body is None else {"json": {"document": {}}}
    answered(client, operation, path, **sent)
    assert client.request(operation.method, path, **sent).status_code == 404


def mutated(document: Json) -> st.SearchStrategy[Json]:
    """A document with one field of any depth replaced by anything, or left out, or one more."""
    places = list(_places(document))
    return st.tuples(st.sampled_from(places), values, st.booleans()).map(lambda how: _changed(document, *how))


def _places(value: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if isinstance(value, dict):
        yield (*place, "more")
        for key, inner in value.items():
            yield (*place, key)
            yield from _places(inner, (*place, key))
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            yield (*place, k)
            yield from _places(inner, (*place, k))


def _changed(document: Json, place: tuple[Any, ...], value: Any, left_out: bool) -> Json:
    made = json.loads(json.dumps(document))
    block = made
    for step in place[:-1]:
        block = block[step]
    if left_out and (isinstance(block, list) or place[-1] in block):
        del block[place[-1]]
    else:
        block[place[-1]] = value
    return made


VALIDATE = next(o for o in OPERATIONS if o.path == "/api/validate")
KEEP = next(o for o in OPERATIONS if o.method == "POST" and o.path == "/api/missions")
START = next(o for o in OPERATIONS if o.method == "POST" and o.path == "/api/jobs")
UPLOADS = [o for o in OPERATIONS if o.uploads]
bodies = values | st.fixed_dictionaries({}, optional={"document": values, "example": values, "upload": values})
jobs = st.fixed_dictionaries(
    {}, optional={"mission": values, "planner": values, "effort": values, "seed": values, "time_limit_s": values}
)
names = st.sampled_from(["a.yaml", "b.json", "c.geojson", "d.png", "e.pgm", "f.rota.json"]) | texts
files = st.lists(st.tuples(names, st.binary(max_size=200) | values.map(lambda v: json.dumps(v).encode())), max_size=4)


def _send_anything(client: TestClient, examples: int) -> None:
    @settings(max_examples=examples, **LONG)
    @given(mutated(SQUARE))
    def documents(changed: Json) -> None:
        answered(client, VALIDATE, VALIDATE.path, json={"document": changed})

    @settings(max_examples=examples, **LONG)
    @given(bodies)
    def any_body(body: Any) -> None:
        for operation in (VALIDATE, KEEP):
            answered(client, operation, operation.path, json=body)

    @settings(max_examples=examples, **LONG)
    @given(jobs)
    def any_job(body: Any) -> None:
        answered(client, START, START.path, json=body)

    @settings(max_examples=examples, **LONG)
    @given(files)
    def any_file(uploaded: list[tuple[str, bytes]]) -> None:
        for operation in UPLOADS:
            sent = [("files", (name, content)) for name, content in uploaded]
            answered(client, operation, operation.path, files=sent or {"none": ("", b"")})

    @settings(max_examples=examples, **LONG)
    @given(st.sampled_from(OPERATIONS), st.text(min_size=1, max_size=12), st.dictionaries(texts, texts, max_size=3))
    def any_address(operation: Operation, key: str, query: dict[str, str]) -> None:
        from urllib.parse import quote

        path = operation.path
        for name in ("{id}", "{name}", "{format}"):
            path = path.replace(name, quote(key, safe=""))
        if "." in key or "/" in key or operation.body is not None or operation.uploads:
            return
        answered(client, operation, path, params=query)

    for send in (documents, any_body, any_job, any_file, any_address):
        send()


def test_whatever_is_sent_the_answer_is_as_written(client: TestClient) -> None:
    _send_anything(client, 20)


@pytest.mark.slow  # a thousand requests of each kind
def test_whatever_is_sent_for_long_the_answer_is_as_written(client: TestClient) -> None:
    _send_anything(client, 1000)


def test_exported_text_is_what_the_command_line_writes(client: TestClient, ids: dict[str, list[str]]) -> None:
    from rota.files.geojson import geojson_text
    from rota.files.plan_file import plan_from_text

    (plan,) = ids["plans"]
    text = client.get(f"/api/plans/{plan}/plan.rota.json").text
    assert client.get(f"/api/plans/{plan}/export/geojson").text == geojson_text(plan_from_text(text, "it"))
    refused = client.get(f"/api/plans/{plan}/export/kml")
    assert refused.status_code == 422
    assert "origin" in refused.json()["error"]["message"]
    placed = client.get(f"/api/plans/{plan}/export/kml?origin=48.1,11.5")
    assert placed.status_code == 200
    assert 'filename="square.kml"' in placed.headers["content-disposition"]
