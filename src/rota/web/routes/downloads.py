"""Answers that browsers save as files."""

from __future__ import annotations

import re
from urllib.parse import quote

from starlette.responses import Response

_UNSAFE = re.compile(r"[^A-Za-z0-9._-]+")


def download(body: bytes, name: str, kind: str) -> Response:
    """A file of this name; it is never shown in the page's own place, whatever it holds."""
    plain = _UNSAFE.sub("-", name).strip("-.") or "file"
    disposition = f"attachment; filename=\"{plain}\"; filename*=UTF-8''{quote(name, safe='')}"
    headers = {"content-disposition": disposition, "content-security-policy": "sandbox"}
    return Response(body, media_type=kind, headers=headers)
