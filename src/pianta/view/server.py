"""The server of `pianta view`: the page, and the floors that it shows, on the loopback address."""

from __future__ import annotations

import gc
import json
import os
import socket
import webbrowser
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Annotated, Any

import uvicorn
from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse
from fastapi.staticfiles import StaticFiles
from pydantic import BaseModel, ConfigDict, Field
from starlette.exceptions import HTTPException

from pianta.corrections.corrections_file import MAX_CORRECTIONS
from pianta.errors import OptionError, PiantaError
from pianta.io._files import one_line_reason, short_repr
from pianta.view.guard import App, Guard
from pianta.view.opened import AnySession, open_sessions
from pianta.view.result_sessions import ResultSession
from pianta.view.sessions import NOT_FOUND, RefusedError, Session

STATIC = Path(__file__).parent / "static"
LOOPBACK = "127.0.0.1"
# How long requests, such as a save, may go on after Ctrl+C; seconds.
GRACE = 30
# Characters of the path to a fault in a body; names in it may be as long as the body.
MAX_WHERE = 100
# The address of a picture has the version of its files.
KEEP_PICTURE = {"cache-control": "private, max-age=86400"}


class _Corrections(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    version: Annotated[str, Field(max_length=100)]
    corrections: Annotated[list[dict[str, Any]], Field(max_length=MAX_CORRECTIONS)]


class _Edit(_Corrections):
    edit: dict[str, Any]


def make_app(folders: Mapping[str, Path], *, token: str) -> App:
    """The app that answers requests. folders: as of `find_folders`. token: the start of paths.

    Raises PiantaError, in one line, for a single folder that cannot be read.
    """
    sessions = open_sessions(folders)
    if len(sessions) == 1:
        # A damaged folder is refused at once, and a floor is shown sooner
        sessions[0].describe()
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)
    for routes in (_make_page(), _make_reading(sessions), _make_parts(sessions), _make_editing(sessions)):
        app.include_router(routes, prefix=f"/{token}")
    app.mount(f"/{token}/static", StaticFiles(directory=STATIC))
    app.add_exception_handler(PiantaError, _answer_error)
    app.add_exception_handler(Exception, _answer_error)
    app.add_exception_handler(RequestValidationError, _answer_damaged_body)
    app.add_exception_handler(HTTPException, _answer_http_error)
    return Guard(app, token)


def listen(port: int = 0) -> socket.socket:
    """A socket at the loopback address. port: 0 for a free one.

    Raises OptionError, in one line, for a port that is taken or not allowed.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if os.name == "posix":
        # A port can be used again at once; on Windows the option would share a port that is taken
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((LOOPBACK, port))
        listener.listen()
    except OSError as error:
        listener.close()
        reason = one_line_reason(error)
        raise OptionError(f"port={port} cannot be used: {reason}; leave it out for a free one") from None
    return listener


def make_server(app: App) -> uvicorn.Server:
    """A server for an app, without a log of addresses, which have the token."""
    return uvicorn.Server(
        uvicorn.Config(
            app,
            ws="none",
            log_level="error",
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=GRACE,
        )
    )


def serve(app: App, listener: socket.socket) -> None:
    """Answer requests until the process is interrupted."""
    # What was imported stays; to scan it for garbage takes a fifth of a second, in which an edit would wait (measured).
    gc.freeze()
    with suppress(KeyboardInterrupt):
        make_server(app).run(sockets=[listener])


def open_browser(address: str) -> None:
    """Open a page in the browser of the user, if there is one; some browsers return only when they are closed."""

    def open_page() -> None:
        with suppress(webbrowser.Error, OSError):
            webbrowser.open(address)

    Thread(target=open_page, daemon=True).start()


def _make_page() -> APIRouter:
    routes = APIRouter(default_response_class=Response)

    @routes.get("/")
    def get_page() -> Response:
        return FileResponse(STATIC / "index.html", media_type="text/html")

    return routes


def _find(sessions: Sequence[AnySession], number: int) -> AnySession:
    """The session of a map; raises RefusedError for an unknown number."""
    if not 0 <= number < len(sessions):
        raise RefusedError(NOT_FOUND, f"there is no map {number}, the page has {len(sessions)}")
    return sessions[number]


def _make_reading(sessions: Sequence[AnySession]) -> APIRouter:
    """The addresses of what is on disk."""
    routes = APIRouter(default_response_class=Response)

    @routes.get("/api/maps")
    def get_maps() -> Response:
        return _answer({"maps": [session.summarize() for session in sessions]})

    @routes.get("/api/maps/{number}")
    def get_map(number: int) -> Response:
        return _answer(_find(sessions, number).describe())

    @routes.get("/api/maps/{number}/version")
    def get_version(number: int) -> Response:
        return _answer({"version": _find(sessions, number).version()})

    @routes.get("/api/maps/{number}/background.png")
    def get_background(number: int) -> Response:
        picture = _find(sessions, number).draw_background()
        if picture is None:
            raise RefusedError(NOT_FOUND, f"map {number} has no picture")
        return Response(picture, media_type="image/png", headers=KEEP_PICTURE)

    return routes


def _make_parts(sessions: Sequence[AnySession]) -> APIRouter:
    """The addresses of the parts of results: steps, samples and buildings."""
    routes = APIRouter(default_response_class=Response)

    def find(number: int) -> ResultSession[Any]:
        session = _find(sessions, number)
        if isinstance(session, Session):
            raise RefusedError(NOT_FOUND, f"map {number} is a floor, which has no parts")
        return session

    @routes.get("/api/maps/{number}/parts/{part}")
    def get_part(number: int, part: int) -> Response:
        return _answer(find(number).part(part))

    @routes.get("/api/maps/{number}/parts/{part}/background.png")
    def get_background_of_part(number: int, part: int) -> Response:
        picture = find(number).draw_background(part)
        if picture is None:
            raise RefusedError(NOT_FOUND, f"part {part} of map {number} has no picture")
        return Response(picture, media_type="image/png", headers=KEEP_PICTURE)

    return routes


def _make_editing(sessions: Sequence[AnySession]) -> APIRouter:
    """The addresses of corrections."""
    routes = APIRouter(default_response_class=Response)

    @routes.post("/api/maps/{number}/edit")
    def edit(number: int, body: _Edit) -> Response:
        return _answer(_find(sessions, number).edit(body.version, body.corrections, body.edit))

    @routes.post("/api/maps/{number}/apply")
    def apply(number: int, body: _Corrections) -> Response:
        return _answer(_find(sessions, number).apply(body.version, body.corrections))

    @routes.post("/api/maps/{number}/save")
    def save(number: int, body: _Corrections) -> Response:
        return _answer(_find(sessions, number).save(body.version, body.corrections))

    return routes


def _answer(content: Mapping[str, Any], status: int = 200) -> Response:
    return Response(json.dumps(content, allow_nan=False), status, media_type="application/json")


async def _answer_error(_: Request, error: Exception) -> Response:
    status = error.status if isinstance(error, RefusedError) else 500
    return _answer({"error": one_line_reason(error)}, status)


async def _answer_damaged_body(request: Request, error: Exception) -> Response:
    faults = error.errors() if isinstance(error, RequestValidationError) else []
    where = {".".join(map(str, fault["loc"]))[:MAX_WHERE]: fault["msg"] for fault in faults[:3]}
    listed = "; ".join(f"{path}: {message}" for path, message in where.items())
    if any(fault["loc"][0] == "path" for fault in faults):
        return _answer({"error": f"there is no page {short_repr(request.url.path.split('/', 2)[-1])}"}, NOT_FOUND)
    return _answer({"error": f"the request is damaged: {listed}"}, 400)


async def _answer_http_error(_: Request, error: Exception) -> Response:
    status = error.status_code if isinstance(error, HTTPException) else 500
    return _answer({"error": f"the request cannot be answered: {getattr(error, 'detail', status)}"}, status)
