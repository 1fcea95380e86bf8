"""Who may ask: the right Host, the page's own origin, the token where there is one; and the headers of every answer."""

from __future__ import annotations

import ipaddress
import secrets
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qsl, urlencode, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rota.web.refusal import Refusal
from rota.web.routes.answers import JsonAnswer
from rota.web.tiles import Tiles

COOKIE = "rota-token"
CHANGING = ("POST", "PUT", "PATCH", "DELETE")
LOOPBACK = ("127.0.0.1", "localhost", "[::1]")


@dataclass(frozen=True, kw_only=True)
class Guard:
    """What a request must show.

    hosts: the names by which the server is asked, with the port. token: None where none is needed. any_address: of a
    server that listens at all addresses of its machine the end of Hosts that are addresses, not names, which nobody can
    make lead here; None: only ``hosts`` are its names.
    """

    hosts: frozenset[str]
    token: str | None
    any_address: str | None = None

    def require_host(self, headers: Headers) -> str:
        """The Host that was asked; Refusal for any that the server was not bound to, as after DNS rebinding."""
        hosts = headers.getlist("host")
        if len(hosts) != 1 or not (hosts[0].lower() in self.hosts or self._is_address(hosts[0])):
            raise Refusal(403, "this server does not go by that name; use the address that rota serve printed")
        return hosts[0].lower()

    def _is_address(self, host: str) -> bool:
        if self.any_address is None or not host.endswith(self.any_address):
            return False
        try:
            ipaddress.ip_address(host.removesuffix(self.any_address).removeprefix("[").removesuffix("]"))
        except ValueError:
            return False
        return True

    def require_own_page(self, headers: Headers, method: str, host: str) -> None:
        """Refuse what another site's page sends: it could change things in the user's name."""
        site = headers.get("sec-fetch-site")
        if method in CHANGING and site not in (None, "same-origin"):
            raise Refusal(403, f"requests from other sites are not allowed (Sec-Fetch-Site: {site[:40]})")
        origin = headers.get("origin")
        if origin is not None and (method in CHANGING or origin != "null") and _netloc(origin) != host:
            raise Refusal(403, "requests from other origins are not allowed")

    def token_given(self, headers: Headers, query: bytes) -> str | None:
        """How the token was shown: "header", "cookie" or "address"; None: no token is needed. Refusal 401 otherwise."""
        if self.token is None:
            return None
        kind, _, bearer = headers.get("authorization", "").partition(" ")
        shown = {"address": dict(parse_qsl(query.decode("latin-1"))).get("token"), "cookie": _cookie(headers)}
        shown["header"] = bearer.strip() if kind.lower() == "bearer" else None
        for way, text in shown.items():
            if text is not None and secrets.compare_digest(text.encode(), self.token.encode()):
                return way
        raise Refusal(401, "a token is needed: open the address that rota serve printed, or send it as a Bearer token")


def _netloc(origin: str) -> str | None:
    try:
        parts = urlsplit(origin)
    except ValueError:
        return None
    return parts.netloc.lower() if parts.scheme == "http" else None


def _cookie(headers: Headers) -> str | None:
    try:
        cookie = SimpleCookie(headers.get("cookie", ""))
    except CookieError:
        return None
    return cookie[COOKIE].value if COOKIE in cookie else None


class Security:
    """Middleware that lets through what the guard allows, bodies up to a size, and puts headers on every answer."""

    def __init__(self, app: ASGIApp, guard: Guard, tiles: Tiles | None, json_bytes: int, upload_bytes: int) -> None:
        self._app, self._guard = app, guard
        self._headers = _headers(tiles)
        self._json_bytes, self._upload_bytes = json_bytes, upload_bytes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        sent = False

        async def send_with_headers(message: Message) -> None:
            nonlocal sent
            if message["type"] == "http.response.start":
                sent = True
                headers = MutableHeaders(scope=message)
                for name, value in self._headers.items():
                    headers.setdefault(name, value)
            await send(message)

        try:
            headers = Headers(scope=scope)
            host = self._guard.require_host(headers)
            self._guard.require_own_page(headers, scope["method"], host)
            way = self._guard.token_given(headers, scope["query_string"])
            if way == "address" and scope["method"] == "GET":
                await self._keep_token(scope, receive, send_with_headers)
                return
            most = self._most_bytes(headers)
            await self._app(scope, _limit(receive, headers, most), send_with_headers)
        except Refusal as refusal:
            if sent:
                raise
            answer = JsonAnswer(refusal.to_json(), refusal.status, headers={"connection": "close"})
            await answer(scope, receive, send_with_headers)

    def _most_bytes(self, headers: Headers) -> int:
        is_upload = headers.get("content-type", "").lower().startswith("multipart/form-data")
        return self._upload_bytes if is_upload else self._json_bytes

    async def _keep_token(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Put the token into a cookie and lead to the same address without it."""
        rest = [(key, value) for key, value in parse_qsl(scope["query_string"].decode("latin-1")) if key != "token"]
        path = "/" + scope["path"].lstrip("/\\")
        answer = JsonAnswer({}, 303, headers={"location": path + (f"?{urlencode(rest)}" if rest else "")})
        answer.set_cookie(COOKIE, self._guard.token or "", httponly=True, samesite="strict", path="/")
        await answer(scope, receive, send)


def _limit(receive: Receive, headers: Headers, most: int) -> Receive:
    """The body, up to so many bytes; Refusal 413 beyond, and before any is read where the length is told."""
    told = headers.get("content-length")
    if told is not None and (not told.isascii() or not told.isdigit() or int(told) > most):
        raise Refusal(413, f"the body is too large: at most {most:,} bytes are allowed")
    count = 0

    async def receive_limited() -> Message:
        nonlocal count
        message = await receive()
        count += len(message.get("body", b""))
        if count > most:
            raise Refusal(413, f"the body is too large: at most {most:,} bytes are allowed")
        return message

    return receive_limited


def _headers(tiles: Tiles | None) -> dict[str, str]:
    """What every answer says to browsers: nothing from elsewhere, nothing inline, nobody frames the page."""
    images = "" if tiles is None else f" {tiles.origin}"
    policy = (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; font-src 'self'; "
        f"manifest-src 'self'; img-src 'self' data: blob:{images}; base-uri 'none'; form-action 'self'; "
        "frame-ancestors 'none'"
    )
    return {
        "content-security-policy": policy,
        "x-content-type-options": "nosniff",
        "x-frame-options": "DENY",
        "referrer-policy": "no-referrer",
        "cross-origin-opener-policy": "same-origin",
        "cross-origin-resource-policy": "same-origin",
        "permissions-policy": "geolocation=(), camera=(), microphone=()",
        "cache-control": "no-store",
    }
