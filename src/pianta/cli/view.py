"""The verb view: floors over their maps in a browser, to look at and to correct."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from secrets import token_urlsafe
from typing import Annotated

import typer

from pianta.cli.terminal import print_result
from pianta.errors import OptionError
from pianta.io._files import count_noun, short_repr

EXAMPLES = (
    "pianta view building",
    "pianta view floors --port 8080 --no-browser",
    "pianta view building --html report.html",
)
# Bytes of randomness in the address, so that it cannot be guessed.
TOKEN_BYTES = 24
# Of the report, so that no floor is written over.
PAGE_SUFFIXES = (".html", ".htm")

Outs = Annotated[
    list[Path], typer.Argument(metavar="OUT...", help="Folders that `pianta read` has written, or folders of such.")
]
Port = Annotated[
    int | None, typer.Option(min=1, max=65535, help="Port at the loopback address.", show_default="a free one")
]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Print the address alone, and open no browser.")]
Html = Annotated[
    Path | None, typer.Option("--html", metavar="FILE", help="Write a page that needs no server, and end.")
]


def view_floors(outs: Outs, *, port: Port = None, no_browser: NoBrowser = False, html: Html = None) -> None:
    """Show floors over their maps in the browser, and correct them there.

    The page is at the loopback address, so that other machines do not see
    it; it loads nothing from the network. Ctrl+C ends it. Corrections are
    saved into the folders, as by `pianta correct`.
    """
    from pianta.view.folders import find_folders

    folders = find_folders(outs)
    if html is not None:
        from pianta.view.export import save_report

        if port is not None or no_browser:
            raise OptionError("--html writes a file and needs no server, leave out --port and --no-browser")
        if html.suffix.lower() not in PAGE_SUFFIXES:
            raise OptionError(f"report {short_repr(html)} is no page, give a name that ends in .html")
        save_report(folders, html)
        print_result(f"{count_noun(len(folders), 'floor')}, in {html}")
        return
    missing = [name for name in ("fastapi", "uvicorn") if find_spec(name) is None]
    if missing:
        raise OptionError(f"the page needs {' and '.join(missing)}, install them: pip install 'pianta[web]'")
    _serve(folders, port=port or 0, with_browser=not no_browser)


def _serve(folders: dict[str, Path], *, port: int, with_browser: bool) -> None:
    from pianta.view.server import LOOPBACK, listen, make_app, open_browser, serve

    token = token_urlsafe(TOKEN_BYTES)
    app = make_app(folders, token=token)
    with listen(port) as listener:
        address = f"http://{LOOPBACK}:{listener.getsockname()[1]}/{token}/"
        print_result(f"{count_noun(len(folders), 'floor')} at {address} (Ctrl+C ends it)")
        if with_browser:
            open_browser(address)
        serve(app, listener)
