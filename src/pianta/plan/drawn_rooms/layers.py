"""Lines about the layers of a DXF, for people to check, and the drawing without its named walls."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from pianta.io._files import count_noun
from pianta.io.drawings._drawing import ROLES, PlanDrawing, Role

MAX_LISTED = 6  # layers of a kind
MAX_NAME = 60  # characters
_NOUNS: tuple[tuple[Role, str], ...] = (("wall", "walls"), ("door", "doors"), ("window", "windows"))


def describe_layers(drawing: PlanDrawing) -> tuple[str, ...]:
    """Two lines: the layers of walls, doors and windows with their lines, and what was skipped; empty if not known."""
    if not len(drawing.line_layers):
        return ()
    parts = [_describe_role(drawing, role, noun) for role, noun in _NOUNS]
    others = int((drawing.roles == ROLES.index("other")).sum())
    line = "; ".join([*filter(None, parts), f"other {count_noun(others, 'line')}"])
    skipped = ", ".join(
        f"{count} {_clean(entity_type)}" for entity_type, count in sorted(drawing.skipped.items())[:MAX_LISTED]
    )
    return (f"layers: {line}", *([f"skipped: {skipped}"] if skipped else []))


def forget_walls(drawing: PlanDrawing) -> PlanDrawing | None:
    """The drawing with no lines named as walls; None without any."""
    is_wall = drawing.roles == ROLES.index("wall")
    if not is_wall.any():
        return None
    return replace(drawing, roles=np.where(is_wall, ROLES.index("other"), drawing.roles))


def _describe_role(drawing: PlanDrawing, role: Role, noun: str) -> str:
    """Such as walls A-WALL 812 lines, A-WALL-2 4 lines."""
    layers = drawing.line_layers[drawing.roles == ROLES.index(role)]
    counts = Counter(dict(enumerate(np.bincount(layers).tolist()))) if len(layers) else Counter()
    listed = [(layer, count) for layer, count in counts.most_common() if count]
    named = [f"{_clean(drawing.layers[layer])} {count_noun(count, 'line')}" for layer, count in listed[:MAX_LISTED]]
    more = [f"{len(listed) - MAX_LISTED} more layers"] if len(listed) > MAX_LISTED else []
    return f"{noun} {', '.join([*named, *more])}" if named else ""


def _clean(name: str) -> str:
    return "".join(filter(str.isprintable, name))[:MAX_NAME]
