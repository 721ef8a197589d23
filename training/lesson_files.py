"""Lessons of the network of map regions, as files: map_lessons.py and annotated_lessons.py write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

# By name, shape (h, w) each: free and occupied, of FINE_CELLS; classes as in pianta.layout.structure.evidence; rooms,
# 0 no room; counts, whether a cell counts in the loss.
Lesson = dict[str, NDArray]

# Fine cells of a cell of a lesson: the greatest number that is free or occupied.
FINE_CELLS = 4
# Class of the cells of annotated maps of which only the room is known.
UNKNOWN_CLASS = 255


def read_lesson(path: Path) -> Lesson:
    """The images of a lesson."""
    with np.load(path) as file:
        return dict(file)


def write_lesson(path: Path, lesson: Lesson) -> None:
    """Write the images of a lesson; a training that runs at the same time reads only complete files."""
    unfinished = path.with_suffix(".part")
    with unfinished.open("wb") as file:
        np.savez_compressed(file, **lesson)
    unfinished.rename(path)
