"""The texts of a drawn plan: names of rooms, legend, title, dimensions and scale bar."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import cos, radians, sin
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from shapely import Polygon, maximum_inscribed_circle

from pianta._types import Colors
from pianta.errors import OptionError
from pianta.gridmap import GridMap
from pianta.plan.sheets.sheet import PlacedText

Color = tuple[int, int, int]

DEFAULT_FONT = "DejaVuSans"
# Names in small rooms are written smaller, down to this share of the usual height, ...
MIN_HEIGHT_SHARE = 0.6
# ... and to this height; pixels.
MIN_HEIGHT_PX = 8
# Distance between lines, as a multiple of the height of the font.
LINE_SPACING = 1.25


@dataclass(frozen=True)
class Lettering:
    """Style of the names. font: a file of matplotlib. height_px: of the em. angle: degrees, counter-clockwise."""

    font: str = DEFAULT_FONT
    height_px: int = 14
    angle: float = 0.0

    def face(self, height_px: int | None = None) -> ImageFont.FreeTypeFont:
        """The font at a height; raises OptionError for a font that does not come with matplotlib."""
        import matplotlib as mpl

        file = Path(mpl.get_data_path(), "fonts", "ttf", f"{Path(self.font).name}.ttf")
        if not file.is_file():
            raise OptionError(f"font is {self.font!r}, give the name of one of matplotlib's, such as {DEFAULT_FONT}")
        return ImageFont.truetype(file, height_px or self.height_px, layout_engine=ImageFont.Layout.BASIC)


@dataclass(frozen=True, eq=False)
class WrittenText:
    """A line of text with its font, and its middle, row and col in continuous pixels."""

    text: str
    face: ImageFont.FreeTypeFont
    middle: tuple[float, float]
    angle: float = 0.0

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of its ink, pixels."""
        left, top, right, bottom = self.face.getbbox(self.text)
        return right - left, bottom - top

    def to_placed(self) -> PlacedText:
        """The text with the corners of its ink."""
        width, height = self.size
        turn = radians(self.angle)
        along, down = np.array([-sin(turn), cos(turn)]), np.array([cos(turn), sin(turn)])
        steps = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        corners = [np.array(self.middle) + x * width / 2 * along + y * height / 2 * down for x, y in steps]
        return PlacedText(self.text, np.array(corners))


def write_texts(colors: Colors, texts: Iterable[WrittenText], *, ink: Color) -> Colors:
    """The picture, shape (H, W, 3), with texts on it."""
    image = Image.fromarray(colors)
    for text in texts:
        width, height = text.size
        left, top, *_ = text.face.getbbox(text.text)
        mask = Image.new("L", (round(width) + 2, round(height) + 2))
        ImageDraw.Draw(mask).text((1 - left, 1 - top), text.text, fill=255, font=text.face)
        if text.angle:
            mask = mask.rotate(text.angle, Image.Resampling.BICUBIC, expand=True)
        row, col = text.middle
        image.paste(ink, (round(col - mask.width / 2), round(row - mask.height / 2)), mask)
    return np.asarray(image).copy()


def letter_room(name: str, room: Polygon, grid: GridMap, lettering: Lettering) -> list[WrittenText]:
    """A name in the middle of a room, else at its widest point, on several lines if it is too long for one.

    Empty if it does not fit even in the smallest letters.
    """
    points = [room.centroid.coords[0], maximum_inscribed_circle(room).coords[0]]
    middles = [tuple(float(value) for value in grid.map_to_pixel(*point)) for point in points]
    smallest = max(round(MIN_HEIGHT_SHARE * lettering.height_px), MIN_HEIGHT_PX)
    for height in range(max(lettering.height_px, smallest), smallest - 1, -1):
        face = lettering.face(height)
        for lines, (row, col) in product(_break_lines(name), middles):
            texts = _stack_lines(lines, face, (row, col), lettering.angle)
            if all(_is_inside(text, room, grid) for text in texts):
                return texts
    return []


def _break_lines(name: str) -> list[list[str]]:
    """The name on one line, then on two lines of the most similar length, then with one word per line."""
    words = name.split()
    broken = [[" ".join(words)]]
    if len(words) > 2:
        halves = [[" ".join(words[:cut]), " ".join(words[cut:])] for cut in range(1, len(words))]
        broken.append(min(halves, key=lambda lines: max(map(len, lines))))
    if len(words) > 1:
        broken.append(words)
    return broken


def _stack_lines(
    lines: Sequence[str], face: ImageFont.FreeTypeFont, middle: tuple[float, float], angle: float
) -> list[WrittenText]:
    """Lines one below the other, centred on a middle and rotated by an angle."""
    down = np.array([cos(radians(angle)), sin(radians(angle))]) * face.size * LINE_SPACING
    texts = []
    for index, line in enumerate(lines):
        row, col = np.array(middle) + down * (index - (len(lines) - 1) / 2)
        texts.append(WrittenText(line, face, (float(row), float(col)), angle))
    return texts


def _is_inside(text: WrittenText, room: Polygon, grid: GridMap) -> bool:
    corners = text.to_placed().corners
    return bool(room.buffer(-2 * grid.resolution).contains(Polygon(np.column_stack(grid.pixel_to_map(*corners.T)))))


def write_legend(
    names: Mapping[int, str], corner: tuple[float, float], face: ImageFont.FreeTypeFont
) -> list[WrittenText]:
    """Lines such as "1 Office" below "Legend", from the upper left corner, row and col."""
    lines = ["Legend", *(f"{number} {name}" for number, name in names.items())]
    texts = []
    for index, line in enumerate(lines):
        width = WrittenText(line, face, (0, 0)).size[0]
        row = corner[0] + (index + 0.5) * face.size * LINE_SPACING
        texts.append(WrittenText(line, face, (row, corner[1] + width / 2)))
    return texts


def measure_legend(names: Mapping[int, str], face: ImageFont.FreeTypeFont) -> float:
    """Width of a legend, pixels."""
    return max(float(text.to_placed().corners[:, 1].max()) for text in write_legend(names, (0, 0), face))
