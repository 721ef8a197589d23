"""A plan with the rooms and doors that were read from it, and the true ones."""

from __future__ import annotations

from colorsys import hls_to_rgb
from pathlib import Path

import cv2
import numpy as np
import shapely
from PIL import Image
from shapely import get_coordinates

from pianta._types import Colors
from pianta.floor import Floor
from pianta.io._files import atomic_file
from pianta.plan.symbols.drawings import BLACK, Color, Mark, paint_marks, pixel_matrix
from pianta.worlds.plans.lettering import Lettering, WrittenText, write_texts
from pianta_bench.harness.records import Figures
from pianta_bench.plans.plan_sets import TruePlan
from pianta_bench.segmentation.figures import ERROR_COLOR, GOLDEN_TURN, HUES

LONG_SIDE_PX, CAPTION_PX = 2000, 34
MAX_FACTOR = 3.0  # by which small plans are enlarged
PAINT_OPACITY, PLAN_OPACITY = 0.45, 0.75
DOOR_COLOR, TRUTH_COLOR = (0, 60, 220), ERROR_COLOR
# In the caption: labels by metric.
CAPTION = {
    "a_fc": "A_FC",
    "a_bc": "A_BC",
    "mean_iou": "IoU",
    "f1": "F1",
    "doors_f1": "doors F1",
    "edges_f1": "edges F1",
}


def save_plan_picture(plan: TruePlan, floor: Floor, figures: Figures, path: str | Path) -> None:
    """Write a PNG of a pale plan with the rooms of a floor in colours, its doors as blue lines, and the truth in red.

    floor: in the frame of the plan's truth, whose outlines are red lines; its doors are red circles, within which a
    door counts. figures: by metric, for the caption. Raises PiantaError if the file cannot be written.
    """
    factor = min(LONG_SIDE_PX / max(plan.grid.shape), MAX_FACTOR)
    picture = paint_plan(plan, floor, factor=factor)
    caption = write_caption(plan.name, figures, picture.shape[1])
    with atomic_file(path) as temporary:
        Image.fromarray(np.vstack([caption, picture])).save(temporary, format="PNG")


def paint_plan(plan: TruePlan, floor: Floor, *, factor: float) -> Colors:
    """The picture without its caption, shape (H, W, 3); factor: its pixels in one of the plan."""
    size = [max(round(side * factor), 1) for side in plan.grid.shape[::-1]]
    paper = cv2.resize(plan.colors, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR)
    rooms = cv2.resize(floor.label_image(plan.grid), size, interpolation=cv2.INTER_NEAREST)
    paints = np.array([(255, 255, 255), *map(_color_room, range(1, int(rooms.max(initial=0)) + 1))])
    opacity = np.where(rooms > 0, PAINT_OPACITY, 0)[:, :, None]
    pale = 255 - PLAN_OPACITY * (255.0 - paper)
    colors = np.asarray(np.round(pale * (1 - opacity) + paints[rooms] * opacity), np.uint8)
    _paint_lines(colors, plan, floor, factor)
    return colors


def _paint_lines(colors: Colors, plan: TruePlan, floor: Floor, factor: float) -> None:
    """True outlines and doors, then the doors of the floor."""
    outlines = [Mark(get_coordinates(room.polygon.exterior)[:-1], closed=True) for room in plan.truth.rooms]
    reaches = [shapely.centroid(door.line).buffer(door.width / 2) for door in plan.truth.doors if door.width]
    circles = [Mark(get_coordinates(reach)[:-1], closed=True) for reach in reaches]
    lines = [Mark(get_coordinates(door.line)) for door in floor.doors]
    matrix = factor * pixel_matrix(plan.grid)
    for marks, color, stroke in ((outlines, TRUTH_COLOR, 2), (circles, TRUTH_COLOR, 1), (lines, DOOR_COLOR, 4)):
        paint_marks(colors, marks, matrix, stroke_px=stroke, ink=color)


def write_caption(name: str, figures: Figures, width: int) -> Colors:
    """A strip with the name and some figures, shape (CAPTION_PX, width, 3)."""
    parts = [f"{label} {value:.0f}" for metric, label in CAPTION.items() if (value := figures.get(metric)) is not None]
    parts.append(f"{figures.get('found')} rooms, {figures.get('true')} true")
    text = f"{name}: {', '.join(parts)}"
    strip = np.full((CAPTION_PX, width, 3), 255, np.uint8)
    height = CAPTION_PX // 2
    while height > 6 and WrittenText(text, Lettering().face(height), (0, 0)).size[0] > width - 10:
        height -= 1
    face = Lettering().face(height)
    middle = CAPTION_PX / 2, WrittenText(text, face, (0, 0)).size[0] / 2 + 5
    return write_texts(strip, [WrittenText(text, face, middle)], ink=BLACK)


def _color_room(index: int) -> Color:
    """A colour that differs from those of neighbouring numbers, and is not red like the truth."""
    first, last = HUES
    red, green, blue = hls_to_rgb(first + (index * GOLDEN_TURN) % 1 * (last - first), 0.55, 0.8)
    return round(255 * red), round(255 * green), round(255 * blue)
