"""Uploaded files: few, small together, kept by what they hold under plain names."""

from __future__ import annotations

from starlette.concurrency import run_in_threadpool
from starlette.datastructures import UploadFile
from starlette.formparsers import MultiPartException
from starlette.requests import Request

from rota.web.names import safe_name
from rota.web.refusal import Refusal
from rota.web.routes.answers import state_of
from rota.web.store.missions import keep_upload


async def uploaded_files(request: Request, most_files: int) -> str:
    """Keep the files of a multipart body; returns the upload's id."""
    contents = await uploaded_contents(request, most_files)
    return await run_in_threadpool(keep_upload, state_of(request).database, contents)


async def uploaded_contents(request: Request, most_files: int) -> dict[str, bytes]:
    """What the files of a multipart body hold, by their plain names."""
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind != "multipart/form-data":
        raise Refusal(415, f"content-type {kind[:80]!r} is not allowed here; multipart/form-data is needed")
    contents: dict[str, bytes] = {}
    try:
        async with request.form(max_files=most_files, max_fields=0) as form:
            for _, part in form.multi_items():
                if not isinstance(part, UploadFile):
                    continue
                name = safe_name(part.filename or "")
                if name in contents:
                    raise Refusal(400, f"two files are called {name!r}; rename one")
                contents[name] = await part.read()
    except MultiPartException as error:
        raise Refusal(400, f"the upload cannot be read: {error.message}") from None
    if not contents:
        raise Refusal(400, "there is no file in the upload")
    return contents
