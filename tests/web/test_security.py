"""What the server refuses: other names, other sites, no token, too much, and what leads out of an upload."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest
from PIL import Image
from starlette.testclient import TestClient
from starlette.types import Message
from tests.web.serving import HOST, SQUARE, Server, kept, serving

from rota.web.limits import Limits

TOKEN = "right-token"


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    limits = Limits(document_bytes=200_000, upload_bytes=300_000, upload_files=3, vertices=500)
    with serving(tmp_path_factory.mktemp("open"), limits) as made:
        yield made


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with serving(tmp_path_factory.mktemp("guarded"), token=TOKEN) as made:
        yield made


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8321", "127.0.0.1", "127.0.0.1:80", "127.0.0.1:8321.x"])
@pytest.mark.parametrize("path", ["/", "/api/missions", "/static/icon.svg", "/nothing"])
def test_only_the_bound_names_are_answered(client: TestClient, host: str, path: str) -> None:
    answer = client.get(path, headers={"host": host})
    assert answer.status_code == 403
    assert "name" in answer.json()["error"]["message"]


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "https://127.0.0.1:8321"},
        {"origin": "http://127.0.0.1:9999"},
        {"origin": "null"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
        {"sec-fetch-site": "none"},
    ],
)
def test_other_sites_change_nothing(client: TestClient, headers: dict[str, str]) -> None:
    assert client.post("/api/missions", json={"document": SQUARE}, headers=headers).status_code == 403
    assert client.delete("/api/missions/x", headers=headers).status_code == 403


def test_the_page_itself_may_change_things(client: TestClient) -> None:
    headers = {"origin": f"http://{HOST}", "sec-fetch-site": "same-origin"}
    assert client.post("/api/missions", json={"document": SQUARE}, headers=headers).status_code == 201


@pytest.mark.parametrize("kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", ""])
def test_bodies_that_forms_of_other_sites_can_send_are_no_json(client: TestClient, kind: str) -> None:
    answer = client.post("/api/missions", content=b'{"example": "harbour"}', headers={"content-type": kind})
    assert answer.status_code == 415


@pytest.mark.parametrize("path", ["/", "/api/missions", "/static/js/main.js", "/openapi.json", "/docs", "/nothing"])
def test_where_a_token_is_needed_nothing_is_answered_without(guarded: TestClient, path: str) -> None:
    guarded.cookies.clear()
    for given in (
        {},
        {"authorization": "Bearer wrong"},
        {"authorization": f"Basic {TOKEN}"},
        {"cookie": "rota-token=x"},
    ):
        assert guarded.get(path, headers=given).status_code == 401
    assert guarded.get(f"{path}?token=wrong").status_code == 401
    assert guarded.get(path, headers={"authorization": b"Bearer \xe9"}).status_code == 401


def test_a_token_comes_as_bearer_or_by_the_address_that_turns_it_into_a_cookie(guarded: TestClient) -> None:
    guarded.cookies.clear()
    assert guarded.get("/api/missions", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 200
    led = guarded.get(f"/?token={TOKEN}&plan=1", follow_redirects=False)
    assert (led.status_code, led.headers["location"]) == (303, "/?plan=1")
    cookie = led.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert guarded.get("/api/missions").status_code == 200  # with the cookie
    guarded.cookies.clear()
    away = guarded.get(f"http://{HOST}//evil.example/?token={TOKEN}", follow_redirects=False)
    assert away.headers["location"] == "/evil.example/"


def test_every_answer_has_the_headers_that_browsers_heed(client: TestClient) -> None:
    for path in ("/", "/api/missions", "/api/missions/none", "/static/icon.svg", "/nothing", "/docs"):
        headers = client.get(path).headers
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        assert "unsafe" not in policy
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
    assert "content-security-policy" in client.get("/", headers={"host": "evil.example"}).headers


def test_bodies_beyond_the_limit_are_not_read(client: TestClient) -> None:
    asked = {"content-type": "application/json"}
    assert client.post("/api/missions", content=b"x" * 200_001, headers=asked).status_code == 413
    assert client.post("/api/validate", content=b"{}", headers={**asked, "content-length": "9" * 30}).status_code == 413
    big = {"files": ("a.geojson", b"x" * 300_001, "application/json")}
    assert client.post("/api/missions/read", files=big).status_code == 413


def test_a_body_that_does_not_tell_its_length_is_read_up_to_the_limit_only(client: TestClient) -> None:
    sent: list[Message] = []
    count = 0

    async def endless() -> Message:
        nonlocal count
        count += 1
        return {"type": "http.request", "body": b"x" * 1000, "more_body": True}

    async def keep(message: Message) -> None:
        sent.append(message)

    headers = [(b"host", HOST.encode()), (b"content-type", b"application/json")]
    scope = {"type": "http", "method": "POST", "path": "/api/validate", "query_string": b"", "headers": headers}
    anyio.run(client.app, {**scope, "app": client.app, "raw_path": b"/api/validate", "root_path": ""}, endless, keep)
    assert sent[0]["status"] == 413
    assert count == 201


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("[" * 100_000, "nested too deep"),
        ('{"document":' * 10_000, "nested too deep"),
        ('{"document": NaN}', "NaN"),
        ('{"document": 1e999}', "document"),
        ('{"document": ' + "9" * 10_000 + "}", "not JSON"),
        ("\xff\xfe", "not JSON"),
        ("", "not JSON"),
        ("[]", "object"),
        ('{"document": {}, "documents": 1}', "documents"),
    ],
)
def test_json_that_is_none_is_refused_in_words(client: TestClient, text: str, word: str) -> None:
    answer = client.post("/api/missions", content=text.encode("latin-1"), headers={"content-type": "application/json"})
    assert answer.status_code == 400
    assert word in answer.json()["error"]["message"]


def test_too_many_points_are_refused_before_they_are_read(client: TestClient) -> None:
    document = {**SQUARE, "area": [[0.0, k] for k in range(501)]}
    for path in ("/api/missions", "/api/validate"):
        assert client.post(path, json={"document": document}).status_code == 413


def upload(client: TestClient, *files: tuple[str, bytes]) -> tuple[int, str]:
    answer = client.post("/api/missions/read", files=[("files", (name, content)) for name, content in files])
    return answer.status_code, answer.text


@pytest.mark.parametrize("name", ["..", ".hidden", "a\0b.yaml", "con.yaml", "x" * 200, "a\nb.yaml", "é/.."])
def test_names_of_files_are_plain(client: TestClient, name: str) -> None:
    status, text = upload(client, (name, b"{}"))
    assert status == 400
    assert "Traceback" not in text


def test_paths_in_an_upload_stay_in_it(client: TestClient, tmp_path: Path) -> None:
    secret = tmp_path / "secret.geojson"
    secret.write_text('{"type": "Polygon", "coordinates": [[[8, 47], [8.1, 47], [8.1, 47.1], [8, 47]]]}')
    for path in (str(secret), f"../../..{secret}", "/etc/passwd", "\\\\host\\share\\a.geojson"):
        document = {**SQUARE, "coordinates": "wgs84", "area": {"geojson": path}}
        faults = client.post("/api/validate", json={"document": document}).json()["faults"]
        assert faults
        assert faults[0]["path"] == ["area", "geojson"]
        assert "secret" not in faults[0]["message"] or "leaves the mission's folder" in faults[0]["message"]
        text = f"rota: 1\nname: a\ncoordinates: wgs84\narea: {{geojson: {path!r}}}\n"
        status, body = upload(client, ("../../../etc/cron.d/mission.yaml", text.encode()))
        assert status == 200
        assert "8.1" not in body


def test_bombs_are_refused_before_they_burst(client: TestClient) -> None:
    aliases = "a0: &a0 [1,1,1,1,1,1,1,1,1]\n" + "".join(
        f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12)
    )
    status, text = upload(client, ("m.yaml", f"rota: 1\n{aliases}".encode()))
    assert status == 422
    assert "values" in text
    status, text = upload(client, ("m.json", b"[" * 50_000))
    assert status == 422
    sheet = b"image: m.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    status, text = upload(client, ("m.yaml", sheet), ("m.png", huge_png(100_000, 100_000)))
    assert status == 422
    assert "pixels" in text


def huge_png(columns: int, rows: int) -> bytes:
    """A small file that claims to be a large picture."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")
    )


def test_uploads_have_few_files_each_with_its_own_name(client: TestClient) -> None:
    assert upload(client, *[(f"{k}.yaml", b"{}") for k in range(4)])[0] == 400
    assert upload(client, ("a.yaml", b"rota: 1"), ("b/a.yaml", b"rota: 1"))[0] == 400
    picture = io.BytesIO()
    Image.new("L", (4, 4)).save(picture, "PNG")
    status, text = upload(client, ("m.png", picture.getvalue()))
    assert status == 400
    assert ".yaml" in text


def test_static_files_are_those_of_the_page_only(client: TestClient) -> None:
    for path in (
        "/static/../app.py",
        "/static/%2e%2e/app.py",
        "/static/..%2fapp.py",
        "/static//etc/passwd",
        "/static/",
    ):
        assert client.get(path).status_code in (403, 404)


def test_no_fault_shows_its_traceback(client: TestClient) -> None:
    for path in (
        "/api/missions/%00",
        "/api/plans/'; DROP TABLE plans; --",
        "/api/jobs/..%2f",
        "/api/examples/../harbour",
    ):
        answer = client.get(path)
        assert answer.status_code == 404
        assert "Traceback" not in answer.text
    assert client.get(f"/api/missions/{kept(client, SQUARE)}").status_code == 200


def test_other_hosts_get_a_token_that_is_printed_once(tmp_path: Path) -> None:
    server = Server(tmp_path / "data", "--host", "0.0.0.0", usual=True)
    port = server.port
    try:
        with server.client() as client:
            client.base_url = f"http://127.0.0.1:{port}"  # type: ignore[assignment]
            assert client.get("/api/missions").status_code == 401
            assert client.get("/api/missions", headers={"authorization": f"Bearer {server.token}"}).status_code == 200
            bearer = {"authorization": f"Bearer {server.token}"}
            for host, status in ((f"192.168.7.7:{port}", 200), (f"evil.example:{port}", 403), ("192.168.7.7", 403)):
                assert client.get("/api/missions", headers={"host": host, **bearer}).status_code == status
    finally:
        assert server.end() == 0
    assert len(server.token or "") > 20
