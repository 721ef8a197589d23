"""Guard: which requests are answered at all, before anything of them is read."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, MutableMapping
from secrets import compare_digest
from typing import Any, TypeAlias

Message: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[Message]]
Send: TypeAlias = Callable[[Message], Awaitable[None]]
App: TypeAlias = Callable[[Message, Receive, Send], Awaitable[None]]

# A list of corrections is far smaller; bytes.
MAX_BODY = 2 * 2**20
# Bodies up to this size are read to their end, so that the browser reads why they are refused; bytes.
MAX_DRAINED = 32 * 2**20
# Names of this machine that lead to the loopback address. Other names may lead there too, and are refused: a page
# elsewhere could have such a name (DNS rebinding).
HOSTS = ("127.0.0.1", "localhost")
HEADERS = {
    # Nothing from another host, and no script or style in the page itself: a name is never code.
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    # The address has the token.
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}


class Guard:
    """An app behind checks of each request: Host, Origin, the token at the start of the path, the size of the body."""

    def __init__(self, app: App, token: str) -> None:
        """token: the first part of each path."""
        self.app, self.token = app, token

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
        if scope["type"] != "http":
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                names = {name.lower() for name, _ in message["headers"]}
                headers = {"cache-control": "no-store", **HEADERS}
                added = [(name.encode(), value.encode()) for name, value in headers.items()]
                message["headers"] = [*message["headers"], *(each for each in added if each[0] not in names)]
            await send(message)

        refusal = self._find_refusal(scope)
        body = b"" if refusal else await _read_body(receive)
        if body is None:
            refusal = 413, f"the request has more than {MAX_BODY} bytes, save fewer corrections at once"
        if refusal:
            await _refuse(send_with_headers, *refusal)
            return
        messages = iter([{"type": "http.request", "body": body, "more_body": False}])

        async def replay() -> Message:
            return next(messages, None) or await receive()

        await self.app(scope, replay, send_with_headers)

    def _find_refusal(self, scope: Message) -> tuple[int, str] | None:
        headers = [(name.decode("latin-1").lower(), value.decode("latin-1")) for name, value in scope["headers"]]
        host = next((value for name, value in headers if name == "host"), "")
        name, _, port = host.partition(":")
        if name not in HOSTS or not (port.isdecimal() or host == name):
            return 403, "open the page at the address that `pianta view` has printed"
        if any(name == "origin" and value != f"http://{host}" for name, value in headers):
            return 403, "the request comes from another page"
        token = scope["path"].split("/")[1] if "/" in scope["path"] else ""
        if not compare_digest(token.encode(), self.token.encode()):
            return 404, "there is no such page, open the address that `pianta view` has printed"
        return None


async def _read_body(receive: Receive) -> bytes | None:
    """The body of a request; None if it is too large, or the browser has gone."""
    parts, size, more = [], 0, True
    while more and size <= MAX_DRAINED:
        message = await receive()
        part, more = message.get("body", b""), message.get("more_body", False)
        size += len(part)
        if size <= MAX_BODY:
            parts.append(part)
    return b"".join(parts) if size <= MAX_BODY else None


async def _refuse(send: Send, status: int, message: str) -> None:
    content = json.dumps({"error": message}).encode()
    headers = [(b"content-type", b"application/json"), (b"content-length", str(len(content)).encode())]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": content})
