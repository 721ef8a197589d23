"""Sheets of rooms in rows and columns, with a name in each room, and the ground truth of every name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pianta._types import Colors
from pianta.errors import OptionError

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

# Font files of matplotlib.
FONTS = ("DejaVuSans", "DejaVuSerif", "DejaVuSansMono", "DejaVuSans-BoldOblique", "STIXGeneral")
ROTATIONS = (0, 90)
# Room names by language, as schools and offices print them.
NAMES = {
    "en": (
        "CLASSROOM 12",
        "Library",
        "STAFF ROOM",
        "Boys' Toilet",
        "Meeting Room",
        "STORAGE",
        "Reception",
        "204 French",
    ),
    "it": ("AULA 3", "Biblioteca", "PALESTRA", "Sala professori", "Segreteria", "RIPOSTIGLIO", "Corridoio", "Attività"),
    "de": ("KLASSE 4B", "Bücherei", "TURNHALLE", "Lehrerzimmer", "Büro", "Küche", "Abstellraum", "TREPPENHAUS"),
    "fr": ("SALLE 101", "Bibliothèque", "GYMNASE", "Réfectoire", "Bureau", "Salle de réunion", "Toilettes", "ENTRÉE"),
    "es": ("AULA 7", "Biblioteca", "GIMNASIO", "Sala de profesores", "Baño", "ALMACÉN", "Dirección", "Pasillo"),
}
# Free space around a name inside its walls; heights of a capital.
MARGIN = 1.0
# Thickness of walls; heights of a capital.
WALL = 0.35


@dataclass(frozen=True)
class LetteredName:
    """A name on a sheet.

    text: as it is printed. room: first row and col, last row and col (exclusive) of the room inside its walls, pixels.
    """

    text: str
    room: tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class LetteredSheet:
    """A sheet of rooms with their names.

    colors: shape (H, W, 3). names: of the rooms, row by row.
    """

    colors: Colors
    names: tuple[LetteredName, ...]


def letter_rooms(
    names: Sequence[str], *, font: str = FONTS[0], capital: int = 16, rotation: int = 0, columns: int = 4
) -> LetteredSheet:
    """A sheet of equal rooms, each with one of the names in its middle, black on white.

    font: one of FONTS. capital: height of a capital letter, pixels. rotation: 0, or 90 for names that run upwards.
    columns: number of rooms in a row.
    Raises OptionError for an unknown font or rotation, a capital below 4 pixels, and a sheet without names.
    """
    _check_options(names, font, capital, rotation, columns)
    letters = [_letter_name(name, font, capital) for name in names]
    if rotation:
        letters = [np.rot90(letter) for letter in letters]
    margin, wall = round(MARGIN * capital), max(2, round(WALL * capital))
    inner = np.max([letter.shape for letter in letters], axis=0) + 2 * margin
    pitch = inner + wall
    rows = -(-len(names) // columns)
    ink = np.full((rows * pitch[0] + wall + 2 * margin, columns * pitch[1] + wall + 2 * margin), 255, np.uint8)
    ink[margin:-margin, margin:-margin] = 0
    lettered = []
    for number, (name, letter) in enumerate(zip(names, letters, strict=True)):
        top, left = np.array(divmod(number, columns)) * pitch + margin + wall
        bottom, right = top + inner[0], left + inner[1]
        ink[top:bottom, left:right] = 255
        row, col = (top + bottom - letter.shape[0]) // 2, (left + right - letter.shape[1]) // 2
        ink[row : row + letter.shape[0], col : col + letter.shape[1]] = letter
        lettered.append(LetteredName(name, (int(top), int(left), int(bottom), int(right))))
    return LetteredSheet(np.repeat(ink[..., None], 3, axis=2), tuple(lettered))


def _check_options(names: Sequence[str], font: str, capital: int, rotation: int, columns: int) -> None:
    """Raise OptionError for no names, or for a font, capital (px), rotation (degrees) or columns out of range."""
    if not names:
        raise OptionError("there are no names to letter, give one at least")
    if font not in FONTS:
        raise OptionError(f"font is {font[:50]!r}, give one of {', '.join(FONTS)}")
    if rotation not in ROTATIONS:
        raise OptionError(f"rotation is {rotation}, give 0 or 90 degrees")
    if not 4 <= capital <= 200:
        raise OptionError(f"capital is {capital}, give a height of 4 to 200 pixels")
    if columns < 1:
        raise OptionError(f"columns is {columns}, give 1 or more")


def _letter_name(name: str, font: str, capital: int) -> Colors:
    """A line of letters, shape (height, width), 0 ink and 255 paper; cropped to its ink."""
    from PIL import Image, ImageDraw

    face = _load_font(font, capital)
    left, top, right, bottom = map(round, face.getbbox(name))
    image = Image.new("L", (right - left + 2, bottom - top + 2), 255)
    ImageDraw.Draw(image).text((1 - left, 1 - top), name, fill=0, font=face)
    return np.asarray(image)


@cache
def _load_font(font: str, capital: int) -> FreeTypeFont:
    """The font at the size at which an H has the height of a capital, in pixels."""
    from matplotlib import get_data_path
    from PIL import ImageFont

    path = str(Path(get_data_path()) / "fonts" / "ttf" / f"{font}.ttf")
    layout = ImageFont.Layout.BASIC
    _, top, _, bottom = ImageFont.truetype(path, 1000, layout_engine=layout).getbbox("H")
    return ImageFont.truetype(path, capital * 1000 / (bottom - top), layout_engine=layout)
