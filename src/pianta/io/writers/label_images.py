"""Label images in colours: on each cell of the map the colour of its room."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pianta.building import Building, Storey
from pianta.errors import OptionError
from pianta.io.writers._formats import WriteOptions

# Odd, so that all ids up to 2 ** 24 have different colours, and close to the golden ratio, so that neighbours have
# very different ones.
STEP = 0x9E3779
MAX_PALETTE_ID = 255
OUTSIDE = (255, 255, 255)
COLUMNS = ("storey", "id", "red", "green", "blue", "name", "label")


def write_label_images(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """labels.png, or STOREY.png for each storey, and colors.csv with the colour of each room.

    A PNG has a palette if no id is above 255, and its pixels are then the ids; others have 24 bits a pixel.
    """
    notes = []
    for storey in building:
        name = f"{storey.name or 'labels'}.png"
        if any(room.id > MAX_PALETTE_ID for room in storey.floor):
            notes.append(f"{name} has 24-bit colours, as ids are above {MAX_PALETTE_ID}")
        paint_labels(storey).save(target / name, format="PNG")
    with (target / "colors.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for storey, room in building.list_rooms():
            writer.writerow([storey.name, room.id, *color_room(room.id), room.title, room.label])
    return notes


def color_room(room_id: int) -> tuple[int, int, int]:
    """Red, green and blue of a room: the three bytes of its id times STEP, modulo 2 ** 24; white outside of rooms."""
    if room_id == 0:
        return OUTSIDE
    red, green, blue = (room_id * STEP % 2**24).to_bytes(3, "big")
    return red, green, blue


def paint_labels(storey: Storey) -> Image.Image:
    """The label image of a storey."""
    if storey.grid is None:
        raise OptionError("a label image needs the map, read it again")
    ids = storey.floor.label_image(storey.grid)
    highest = int(ids.max(initial=0))
    if highest > MAX_PALETTE_ID:
        return Image.fromarray(_list_colors(highest)[ids])
    image = Image.fromarray(ids.astype(np.uint8), mode="P")
    image.putpalette(_list_colors(MAX_PALETTE_ID).tobytes())
    return image


def _list_colors(highest: int) -> NDArray[np.uint8]:
    return np.array([color_room(room_id) for room_id in range(highest + 1)], np.uint8)
