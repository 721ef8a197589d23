"""Compaction: free space that only corridors cross is taken out of a building, as layouts of circuits are compacted."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

import cv2
import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.generation.drawing.blocks import DOOR_CELLS, MARGIN_CELLS, NO_ROOM, Cells, find_contacts, find_runs
from pianta.generation.drawing.losses import count_inner_corners

Mask = NDArray[np.bool_]
Columns = NDArray[np.int64]
Scores = NDArray[np.float64]

TURNS = (0, 1, 0)  # quarter turns before seams are taken out; those along y make space for more along x
# Chosen by hand.
GAP = 0.1  # cells of rooms that a free cell between rooms of its row is worth
SHIFT = 0.01  # cells of rooms that a seam gives up to be a cell straighter
FAR = 1e6  # cells, more than any seam takes out


def compact(cells: Cells, graph: nx.Graph, areas: Mapping[int, float]) -> Cells:
    """Move the parts of a building towards each other where rooms are larger than they need to be.

    Seams are taken out (Avidan and Shamir 2007): of each row one cell, which is free or in a long part of a room with
    more cells than it needs, so that all beyond it moves by a cell. From row to row a seam goes along walls and through
    free space only, so that rooms keep their shapes, unless two parts of one meet. It leaves the walls that are as
    short as their doors. A room that a seam crosses several times may become smaller than its area by all crossings but
    one. A part beside which only free cells are taken out may move away from another one.

    cells: of all rooms. graph: of the doors. areas: of each room, in cells. The result has a margin of MARGIN_CELLS.
    """
    for turn in TURNS:
        turned = _crop(np.rot90(cells, turn))
        corners = count_inner_corners(turned)
        while (seam := find_seam(turned, graph, areas)) is not None:
            narrower = _crop(remove_seam(turned, seam))
            # Two parts of a room meet
            if count_inner_corners(narrower) > corners:
                break
            turned = narrower
        cells = np.rot90(turned, -turn)
    # One free cell is around it already
    return np.pad(cells, MARGIN_CELLS - 1, constant_values=NO_ROOM)


def remove_seam(cells: Cells, seam: Columns) -> Cells:
    """The cells without one of each row."""
    is_left = np.arange(cells.shape[1]) != seam[:, None]
    return np.asarray(cells[is_left].reshape(len(cells), -1), np.int32)


def find_seam(cells: Cells, graph: nx.Graph, areas: Mapping[int, float]) -> Columns | None:
    """The column, in each row, of the seam that gains most; None if none gains anything.

    Gains are cells of rooms, and a little for free cells between rooms; bends give up a little.
    """
    removable, passable = _find_ways(cells, graph, areas)
    is_room = cells != NO_ROOM
    is_between = np.logical_or.accumulate(is_room, axis=1) & np.logical_or.accumulate(is_room[:, ::-1], axis=1)[:, ::-1]
    gains = np.where(removable, np.where(is_room, 1.0, GAP * is_between), -inf)
    # Rows that are like the one before are crossed straight on
    starts = np.flatnonzero(np.append(True, (cells[1:] != cells[:-1]).any(axis=1)))
    first, *others = np.add.reduceat(gains, starts, axis=0)
    crossings = [_position_columns(passable[start - 1]) for start in starts[1:]]
    scores = [first]
    for gain, positions in zip(others, crossings, strict=True):
        scores.append(gain + _move_sideways(scores[-1], positions))
    if scores[-1].max() <= 0:
        return None
    seam = [int(np.argmax(scores[-1]))]
    for before, positions in zip(scores[-2::-1], crossings[::-1], strict=True):
        seam.append(int(np.argmax(before - np.abs(positions - positions[seam[-1]]))))
    return np.repeat(seam[::-1], np.diff(np.append(starts, len(cells))))


def _find_ways(cells: Cells, graph: nx.Graph, areas: Mapping[int, float]) -> tuple[Mask, Mask]:
    """The cells that a seam may take out, and those under which it may go sideways to the next row."""
    is_room = cells != NO_ROOM
    counts = np.bincount(cells[is_room])
    spare = counts - [areas.get(room, inf) for room in range(len(counts))]
    (_, lengths), (tops, widths) = _measure_runs(cells), (each.T for each in _measure_runs(cells.T))
    is_long = (lengths > widths) & (lengths > DOOR_CELLS)
    # A room keeps its shape if it goes on in the next column as it is in this one
    goes_on = np.zeros(cells.shape, bool)
    goes_on[:, :-1] = (
        (cells[:, :-1] == cells[:, 1:]) & (tops[:, :-1] == tops[:, 1:]) & (widths[:, :-1] == widths[:, 1:])
    )
    removable = ~is_room | (goes_on & is_long & (spare[cells] >= widths))
    passable = ~is_room[:-1] | (cells[:-1] != cells[1:])
    for (one, other), contact in find_contacts(cells).items():
        if contact.is_level and contact.length <= DOOR_CELLS and graph.has_edge(one, other):
            door = slice(contact.column, contact.column + contact.length)
            passable[contact.row, door] = False
            removable[contact.row : contact.row + 2, door] = False
    return removable, passable


def _position_columns(passable: Mask) -> Scores:
    """Where columns are on a line, so that the distance of two is what a seam gives up to go from one to the other."""
    return np.append(0, np.cumsum(np.where(passable[1:] & passable[:-1], SHIFT, FAR)))


def _move_sideways(scores: Scores, positions: Scores) -> Scores:
    """The best score at each column, of seams that come from any column before it or after it."""
    from_left = np.maximum.accumulate(scores + positions) - positions
    from_right = np.maximum.accumulate((scores - positions)[::-1])[::-1] + positions
    return np.maximum(from_left, from_right)


def _measure_runs(cells: Cells) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Of each cell, the first column and the length of the cells around it in its row that are in the same room."""
    starts, lengths = find_runs(cells)
    columns = starts % cells.shape[1]
    return np.repeat(columns, lengths).reshape(cells.shape), np.repeat(lengths, lengths).reshape(cells.shape)


def _crop(cells: Cells) -> Cells:
    """The cells of a building with one free cell around it."""
    x, y, width, height = cv2.boundingRect((cells != NO_ROOM).astype(np.uint8))
    return np.pad(cells[y : y + height, x : x + width], 1, constant_values=NO_ROOM)
