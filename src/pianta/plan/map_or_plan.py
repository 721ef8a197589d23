"""Whether a file is a robot's map or a plan."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from pianta.errors import MapError
from pianta.formats.files import MAX_CELLS, checked_input
from pianta.formats.image import IMAGE_SUFFIXES, PICTURE_SUFFIXES, read_colors, read_grey

Kind = Literal["map", "plan"]
VECTOR_SUFFIXES = (".dxf", ".svg", ".pdf", ".ifc")

# A map is grey. Colours of at least this chroma on more than this share of an image make it a plan,
CHROMA, COLORED = 40, 0.003
# and so does paper: greys from here on along most of its border,
PAPER, BORDER = 245, 0.5
# or so many greys that the three most frequent ones are less than this share, as on photos and scans.
FEW_GREYS = 0.5
# A transparent image is a map, whose unknown cells are left out, when this share of it is white.
WHITE = 0.05


def tell_kind(path: str | Path, *, max_cells: int = MAX_CELLS) -> Kind:
    """Whether a file is a robot's map or a plan: by its suffix, images by what they show.

    Maps are grey, have few greys, and do not end in free space; plans have paper, colours, or are photos.
    Raises MapError, in one line, for an image that cannot be read; other files are maps, whose reader says what is
    wrong with them.
    """
    suffix = Path(path).suffix.lower()
    if suffix in VECTOR_SUFFIXES or suffix in set(PICTURE_SUFFIXES) - set(IMAGE_SUFFIXES):
        return "plan"
    if suffix not in IMAGE_SUFFIXES or suffix == ".pgm":
        return "map"
    file = checked_input(path, "image", MapError)
    greys, transparent = read_grey(file, max_cells=max_cells)
    colors = read_colors(file, max_cells=max_cells)
    opaque = np.ones(greys.shape, bool) if transparent is None else ~transparent
    if ((colors.max(axis=2) - colors.min(axis=2) > CHROMA) & opaque).mean() > COLORED:
        return "plan"
    if transparent is not None:
        return "map" if ((greys >= PAPER) & opaque).mean() >= WHITE else "plan"
    border = np.concatenate([greys[0], greys[-1], greys[:, 0], greys[:, -1]])
    frequent = np.sort(np.bincount(greys.ravel(), minlength=256))[-3:].sum() / greys.size
    return "plan" if (border >= PAPER).mean() > BORDER or frequent < FEW_GREYS else "map"
