"""Templates: small pictures of the symbols that are matched with a plan, our own and those of a user's folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from unicodedata import normalize

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.errors import MapError, PlanError
from pianta.io._files import short_repr
from pianta.io.images import read_picture
from pianta.plan.symbols.drawings import GREEN, RED, SYMBOLS, Color, SymbolKind, draw_symbol, frame_symbol

Pixels = NDArray[np.uint8]

MIN_SIDE = 5  # px of a template of a folder
MAX_SIDE = 256  # px, for time
MAX_FILES = 500  # of a folder, for time
MIN_CONTRAST = 14  # grey levels that something drawn spans, as ink on a sheet
BUILTIN_DOOR_PX = 48.0  # px of a door of our own templates, which are reduced to match
BUILTIN_STROKE_PX = 3  # px of their lines
# A leaf alone is a line, of which every plan is full
UNMATCHED = ("leaf", "leaf 45")
# What names of files begin with, by the kind of their symbol
PREFIXES: Mapping[SymbolKind, tuple[str, ...]] = MappingProxyType(
    {
        "door": ("door", "porta", "tür", "tuer", "porte", "puerta"),
        "window": ("window", "finestra", "fenster", "fenêtre", "fenetre", "ventana"),
    }
)
FILL = "wall"


@dataclass(frozen=True, eq=False)
class Template:
    """A small picture of a symbol.

    image: shape (H, W) of greys, or (H, W, 3) of red, green, blue. jambs: shape (2, 2), row and col in the image in
    continuous pixels, of the ends of the gap in the wall; None if unknown. door_px: width of a single door at the scale
    of the image; None if the image has the scale of the sheets that it is for.
    """

    name: str
    kind: SymbolKind
    image: Pixels
    jambs: Floats | None = None
    door_px: float | None = None


@cache
def builtin_templates() -> tuple[Template, ...]:
    """The symbols of our own drawing."""
    templates = []
    for name in SYMBOLS.keys() - set(UNMATCHED):
        symbol = SYMBOLS[name]
        image = draw_symbol(name, size_px=BUILTIN_DOOR_PX, stroke_px=BUILTIN_STROKE_PX)
        _, matrix = frame_symbol(name, size_px=BUILTIN_DOOR_PX, stroke_px=BUILTIN_STROKE_PX)
        jambs = None if symbol.jambs is None else (symbol.jambs @ matrix[:, :2].T + matrix[:, 2])[:, ::-1]
        templates.append(Template(name, symbol.kind, image, jambs, BUILTIN_DOOR_PX))
    templates += [_draw_plain_sign(name, color) for name, color in (("red sign", RED), ("green sign", GREEN))]
    return tuple(sorted(templates, key=lambda template: template.name))


def _draw_plain_sign(name: str, color: Color) -> Template:
    """A square of a colour: signs correlate with it better than anything else on a plan."""
    margin, side = round(BUILTIN_DOOR_PX / 12), round(BUILTIN_DOOR_PX)
    image = np.full((side + 2 * margin, side + 2 * margin, 3), 255, np.uint8)
    image[margin:-margin, margin:-margin] = color
    return Template(name, "object", image, door_px=BUILTIN_DOOR_PX)


def read_symbol_folder(path: str | Path) -> tuple[Template, ...]:
    """The symbols of a user's folder of PNGs, cut out of sheets like those to be read, named by their files.

    Files whose names begin with door or window, in five languages, are doors and windows. A file that begins with wall
    replaces the door of the same suffix, and its black bar lies from jamb to jamb. All others are objects.
    Raises PlanError, in one line that names every fault: no PNG, unreadable, too large, too small, nothing drawn.
    """
    folder = Path(path)
    if not folder.is_dir():
        raise PlanError(f"symbols {short_repr(folder)} is no folder, give a folder of PNGs")
    try:
        files = sorted(file for file in folder.iterdir() if file.suffix.lower() == ".png")
    except OSError as error:
        raise PlanError(f"symbols {short_repr(folder)} cannot be opened, check its permissions") from error
    if not 1 <= len(files) <= MAX_FILES:
        raise PlanError(f"symbols {short_repr(folder)} has {len(files)} PNGs, give 1 to {MAX_FILES}")
    faults: list[str] = []
    images = {_symbol_name(file): _read_image(file, faults) for file in files}
    if faults:
        raise PlanError(f"symbols {short_repr(folder)} cannot be used: " + "; ".join(faults))
    pictures = {name: image for name, image in images.items() if image is not None}
    fills = {name.removeprefix(FILL): image for name, image in pictures.items() if name.startswith(FILL)}
    templates = []
    for name, image in pictures.items():
        if name.startswith(FILL):
            continue
        symbol_kind, suffix = _symbol_kind(name)
        fill = fills.pop(suffix, None) if symbol_kind == "door" else None
        if fill is not None and fill.shape[:2] != image.shape[:2]:
            faults.append(f"{FILL}{suffix}.png is not as large as {name}.png, draw it over a copy")
        templates.append(Template(f"{name}.png", symbol_kind, image, None if fill is None else _find_bar(fill)))
    faults += [f"{FILL}{suffix}.png fills no door, add door{suffix}.png" for suffix in fills]
    if faults or not templates:
        raise PlanError(f"symbols {short_repr(folder)} cannot be used: " + ("; ".join(faults) or "it has no symbols"))
    return tuple(templates)


def _symbol_name(file: Path) -> str:
    return normalize("NFC", file.stem).lower()


def _symbol_kind(name: str) -> tuple[SymbolKind, str]:
    """The kind of a symbol by its name, and what follows the word for it."""
    for symbol_kind, words in PREFIXES.items():
        for word in words:
            if name.startswith(word):
                return symbol_kind, name.removeprefix(word)
    return "object", name


def _read_image(file: Path, faults: list[str]) -> Pixels | None:
    """The picture of a symbol, of greys if it has no colours; None with a fault."""
    try:
        colors = read_picture(file, max_cells=16 * MAX_SIDE**2)
    except MapError as error:
        faults.append(str(error))
        return None
    height, width = colors.shape[:2]
    if not MIN_SIDE <= min(height, width) <= max(height, width) <= MAX_SIDE:
        faults.append(f"{short_repr(file.name)} has {width} × {height} px, give {MIN_SIDE} to {MAX_SIDE}")
        return None
    if np.ptp(colors.reshape(-1, 3), axis=0).max() < MIN_CONTRAST:
        faults.append(f"{short_repr(file.name)} has nothing drawn on it, cut it out again")
        return None
    grey = bool((colors == colors[:, :, :1]).all())
    return np.asarray(colors[:, :, 0] if grey else colors)


def _find_bar(fill: Pixels) -> Floats | None:
    """The ends of the axis of a black bar, row and col; None if nothing is black."""
    dark = fill < 128 if fill.ndim == 2 else (fill < 128).all(axis=2)
    rows, cols = np.nonzero(dark)
    if not len(rows):
        return None
    (top, bottom), (left, right) = ((axis.min(), axis.max() + 1) for axis in (rows, cols))
    if right - left >= bottom - top:
        return np.array([((top + bottom) / 2, left), ((top + bottom) / 2, right)], float)
    return np.array([(top, (left + right) / 2), (bottom, (left + right) / 2)], float)
