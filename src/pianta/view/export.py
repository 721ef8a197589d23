"""The page as one file without a server: read-only, with its scripts, styles, floors and maps."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pianta.io._files import atomic_file
from pianta.io._folders import check_output_file
from pianta.view.opened import AnySession, open_sessions
from pianta.view.result_sessions import ResultSession

STATIC = Path(__file__).parent / "static"
# The element in which the page looks for floors before it asks a server.
DATA_ID = "pianta-data"
# Nothing is loaded from anywhere, whatever the names of rooms are.
POLICY = "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; img-src data:"
# Modules of the page by names, since a relative address does not lead from a module in the file to another.
PREFIX = "pianta/"
_STYLE = re.compile(r'<link\b[^>]*\brel="stylesheet"[^>]*\bhref="static/([\w.-]+)"[^>]*>')
_SCRIPT = re.compile(r'<script\b(?P<before>[^>]*?)\s*src="static/(?P<name>[\w.-]+)"(?P<after>[^>]*)></script>')
_IMPORT = re.compile(r"""((?:\bfrom|\bimport)\s*\(?\s*)(["'])\./([\w.-]+\.js)\2""")


def save_report(folders: Mapping[str, Path], file: Path) -> None:
    """Write the page with floors as one file. folders: of the floors, by the names on the page.

    Raises PiantaError, in one line, for a folder that cannot be read, and a file that cannot be written.
    """
    check_output_file(file, "report")
    content = make_report(map(describe_for_report, open_sessions(folders)))
    with atomic_file(file) as temporary:
        temporary.write_text(content, encoding="utf-8")


def make_report(states: Iterable[Mapping[str, Any]]) -> str:
    """The page with floors inside, as HTML."""
    data = json.dumps({"maps": [*states]}, allow_nan=False, separators=(",", ":"))
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    page = _STYLE.sub(lambda match: f"<style>\n{_read(match[1])}</style>", page)
    page = _SCRIPT.sub(_inline_script, page)
    head = (
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n'
        f'<script type="importmap">{_map_modules()}</script>\n'
        f'<script type="application/json" id="{DATA_ID}">{escape_json(data)}</script>\n'
    )
    # Before every script and style, so that the policy holds for them.
    return re.sub(r"(<meta charset=[^>]*>\n?)", lambda match: match[1] + head, page, count=1)


def describe_for_report(session: AnySession) -> dict[str, Any]:
    """The state of a floor or of results, with their pictures and parts inside; it cannot be edited."""
    state = session.describe() | {"writable": False}
    if isinstance(session, ResultSession):
        # A picture is in the page once, with its part.
        parts = [
            _inline_picture(part, session.draw_background(number) if part.get("background") else None)
            for number, part in enumerate(session.list_parts())
        ]
        state |= {"facts": session.summarize().get("facts"), "parts": parts}
    return _inline_picture(state, session.draw_background() if state["background"] else None)


def _inline_picture(state: Mapping[str, Any], picture: bytes | None) -> dict[str, Any]:
    """A state whose picture is in it."""
    background = state.get("background")
    if not background or not picture:
        return dict(state)
    url = f"data:image/png;base64,{b64encode(picture).decode()}"
    return {**state, "background": {**background, "url": url}}


def escape_json(text: str) -> str:
    """JSON that ends no element of HTML, and opens no comment in it, whatever its strings have."""
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _inline_script(match: re.Match[str]) -> str:
    attributes = f"{match['before']}{match['after']}".strip()
    content = _read(match["name"])
    if "module" in attributes:
        content = _name_imports(content)
    opening = f"<script {attributes}>" if attributes else "<script>"
    return f"{opening}\n{escape_script(content)}</script>"


def escape_script(text: str) -> str:
    """A script in which no string ends its element."""
    return re.sub("<(/script|!--)", lambda match: f"\\x3c{match[1]}", text, flags=re.IGNORECASE)


def _map_modules() -> str:
    """The import map: each module of the page by its name."""
    modules = {}
    for file in sorted(STATIC.glob("*.js")):
        content = _name_imports(file.read_text(encoding="utf-8"))
        if re.search(r"^(import|export)\b", content, re.MULTILINE):
            modules[PREFIX + file.name] = f"data:text/javascript;base64,{b64encode(content.encode()).decode()}"
    return json.dumps({"imports": modules})


def _name_imports(content: str) -> str:
    return _IMPORT.sub(lambda match: f"{match[1]}{match[2]}{PREFIX}{match[3]}{match[2]}", content)


def _read(name: str) -> str:
    """A file of the page; its map for debuggers is not in the report."""
    return re.sub(r"\n//# sourceMappingURL=\S*", "", (STATIC / name).read_text(encoding="utf-8")) + "\n"
