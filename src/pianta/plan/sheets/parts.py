"""Parts of a sheet: pieces of drawing with blank paper between them, and the frame around all of them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pianta._types import Floats, Mask

CELLS_OF_DOOR = 8  # of the grid on which parts are found, as those of the network


@dataclass(frozen=True, kw_only=True)
class PartParameters:
    """Thresholds of `find_parts`; shares are of a side of the sheet. Chosen by hand on drawn sheets with frames."""

    gap: float = 0.6  # door widths of blank paper between two parts, at least
    frame_distance: float = 0.75  # door widths between a frame and the largest part, at least: walls are thinner
    frame_length: float = 0.75  # share that a line of a frame is long, at least
    frame_depth: float = 0.12  # share from the edge of the sheet within which frames are


PARAMETERS = PartParameters()


@dataclass(frozen=True, eq=False)
class SheetParts:
    """The parts of a sheet.

    numbers: shape (H, W) in cells, the part that encloses or draws each; 0 for blank paper, 1 for the largest part,
    and so on. frame: shape (H, W), the cells of the lines around all parts. cell_px: pixels of a cell.
    """

    numbers: NDArray[np.int32]
    frame: Mask
    cell_px: float

    def number_at(self, position: Floats) -> int:
        """The number of the part at a row and col, pixels of the sheet."""
        row, col = np.clip((position / self.cell_px).astype(int), 0, np.array(self.numbers.shape) - 1)
        return int(self.numbers[row, col])


def find_parts(ink: Mask, *, door_px: float) -> SheetParts:
    """The parts of a sheet; what a part encloses belongs to it. door_px: pixels of a door.

    ink: shape (H, W), what is drawn.
    """
    cell_px = max(1.0, door_px / CELLS_OF_DOOR)
    shape = tuple(max(1, round(side / cell_px)) for side in ink.shape)
    # A cell with any ink is drawn
    inked = np.asarray(cv2.resize(ink.astype(np.float32), shape[::-1], interpolation=cv2.INTER_AREA) > 0)
    reach = max(1, round(PARAMETERS.gap / 2 * door_px / cell_px))
    frame = _frame_lines(inked)
    numbers = _number_parts(inked & ~frame, reach)
    blank = max(1, round(PARAMETERS.frame_distance * door_px / cell_px) - reach)
    if (frame & (cv2.dilate((numbers == 1).view(np.uint8), np.ones((2 * blank + 1,) * 2, np.uint8)) > 0)).any():
        # The outer walls of a building that fills the sheet, or their outer faces
        frame = np.zeros_like(frame)
        numbers = _number_parts(inked, reach)
    elif frame.any():
        _close_at_frame(numbers, frame, reach)
    return SheetParts(numbers, frame, cell_px)


def _number_parts(inked: Mask, reach: int) -> NDArray[np.int32]:
    """The number of the part of each cell, shape (H, W), the largest first; parts are twice the reach apart, cells."""
    grown = cv2.dilate(inked.view(np.uint8), np.ones((2 * reach + 1,) * 2, np.uint8))
    outlines, _ = cv2.findContours(grown, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    numbers = np.zeros(inked.shape, np.int32)
    for number, outline in enumerate(sorted(outlines, key=cv2.contourArea, reverse=True), start=1):
        cv2.drawContours(numbers, [outline], -1, number, cv2.FILLED)
    return numbers


def _close_at_frame(numbers: NDArray[np.int32], frame: Mask, reach: int) -> None:
    """Fill the rectangle around each part that touches the frame, in place: a title block has sides in common with it.

    Not where the largest part is, and not where this is as large as that. Parts in the rectangle belong to it.
    """
    grown = cv2.dilate(frame.view(np.uint8), np.ones((2 * reach + 1,) * 2, np.uint8)) > 0
    touching = np.unique(numbers[grown & (numbers > 1)])
    windows, largest = ndimage.find_objects(numbers), np.count_nonzero(numbers == 1)
    for number in touching.tolist():
        cells = numbers[windows[number - 1]]
        if not (cells == 1).any() and 2 * cells.size <= largest:
            cells[:] = number


def _frame_lines(inked: Mask) -> Mask:
    """The cells of lines along the edges of the sheet that are nearly as long as it; shape (H, W)."""
    p, lines = PARAMETERS, np.zeros_like(inked)
    for sheet, frame in ((inked, lines), (inked.T, lines.T)):
        height, width = sheet.shape
        depth = max(1, round(p.frame_depth * height))
        for rows in (slice(0, depth), slice(height - depth, height)):
            strip = np.ascontiguousarray(sheet[rows]).view(np.uint8)
            # Scans are seldom straight, so a line may step over by a cell
            thick = cv2.dilate(strip, np.ones((3, 1), np.uint8))
            kernel = np.ones((1, max(3, round(p.frame_length * width))), np.uint8)
            frame[rows] |= (cv2.morphologyEx(thick, cv2.MORPH_OPEN, kernel) > 0) & (strip > 0)
    # Only what has such a line along each of its four sides is a frame
    height, width = lines.shape
    rows, cols = (max(1, round(p.frame_depth * side)) for side in lines.shape)
    sides = (lines[:rows], lines[height - rows :], lines[:, :cols], lines[:, width - cols :])
    return lines if all(_crosses(side, p.frame_length) for side in sides) else np.zeros_like(lines)


def _crosses(strip: Mask, share: float) -> bool:
    """Whether cells of a strip are found along a share of its longer side."""
    return bool(strip.any(axis=int(np.argmin(strip.shape))).mean() >= share)
