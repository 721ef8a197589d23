"""A floor as HTML in a notebook: the page without a server, in a frame that has no rights."""

from __future__ import annotations

from html import escape

from pianta.floor import Floor
from pianta.view.export import make_report
from pianta.view.result_sessions import PLAIN, describe_shapes

# Of the frame, pixels: a floor and its list of rooms in a notebook's cell; chosen by hand.
HEIGHT = 520


def show_in_frame(floor: Floor) -> str:
    """An iframe with the page, which may run its own scripts and reach nothing: no network, no notebook, no files."""
    name = floor.source or "floor"
    state = {
        "map": 0,
        "name": name,
        "version": "",
        "writable": False,
        "problem": None,
        **PLAIN,
        **describe_shapes(floor),
    }
    page = escape(make_report([state]))
    return (
        f'<iframe sandbox="allow-scripts" title="{escape(name)}" srcdoc="{page}" '
        f'style="width: 100%; height: {HEIGHT}px; border: 1px solid #cfd5dc"></iframe>'
    )
