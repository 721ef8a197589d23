"""The laser scan that a robot would take in a cell of a map, and features of its shape (Mozos et al., ICRA 2005)."""

from __future__ import annotations

from math import tau

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.layout.rivals.patches import measure_clearance

BEAMS = 180
# Jumps between two neighbouring beams that count as gaps, metres; and as a share of the longer beam.
GAP, RELATIVE_GAP = 0.5, 0.5
# Beams are cut to these lengths for features that look at the near surroundings only, metres.
NEAR = (2.0, 5.0)


def scan_cells(free: NDArray[np.bool_], cells: NDArray[np.integer], resolution: float) -> Floats:
    """Metres that BEAMS beams go from each cell (row, col) to the first cell that is not free, shape (N, BEAMS)."""
    room = np.pad(measure_clearance(free), 1).astype(np.float32)
    angle = tau * np.arange(BEAMS) / BEAMS
    down, right = np.sin(angle).astype(np.float32), np.cos(angle).astype(np.float32)
    lengths = np.zeros((len(cells), BEAMS), np.float32)
    going = np.arange(lengths.size)
    starts = cells.astype(np.float32) + 1.5
    while len(going):
        cell, beam = np.divmod(going, BEAMS)
        length = lengths.ravel()[going]
        row = starts[cell, 0] + down[beam] * length
        col = starts[cell, 1] + right[beam] * length
        clear = room[row.astype(np.intp), col.astype(np.intp)]
        # Nothing blocks the beam within the clearance, less what cells are across.
        lengths.ravel()[going] += np.where(clear > 0, np.maximum(clear - 1.5, 0.5), 0)
        going = going[clear > 0]
    return lengths.astype(np.float64) * resolution


def describe_scans(lengths: Floats) -> dict[str, Floats]:
    """Features of scans, shape (N, BEAMS), by name, each of shape (N,); none depends on where the robot looks."""
    beside = np.roll(lengths, -1, axis=1)
    steps = np.abs(beside - lengths)
    features = {"mean length": lengths.mean(axis=1), "deviation of length": lengths.std(axis=1)}
    features |= {"mean step": steps.mean(axis=1), "deviation of steps": steps.std(axis=1)}
    for near in NEAR:
        cut = np.minimum(lengths, near)
        features[f"mean length to {near:g} m"] = cut.mean(axis=1)
        features[f"mean step to {near:g} m"] = np.abs(np.roll(cut, -1, axis=1) - cut).mean(axis=1)
        features[f"deviation of length to {near:g} m"] = cut.std(axis=1)
    longer = np.maximum(np.maximum(lengths, beside), 1e-6)
    features["gaps"] = (steps > GAP).sum(axis=1).astype(float)
    features["relative gaps"] = (steps > RELATIVE_GAP * longer).sum(axis=1).astype(float)
    features["mean ratio of beams"] = (np.minimum(lengths, beside) / longer).mean(axis=1)
    features["median to longest"] = np.median(lengths, axis=1) / np.maximum(lengths.max(axis=1), 1e-6)
    return features | _describe_minima(lengths) | _describe_outlines(lengths)


def _describe_minima(lengths: Floats) -> dict[str, Floats]:
    """The nearest obstacle, and the nearest one that lies on the other side: where a passage has its walls."""
    scans = np.arange(len(lengths))
    first = lengths.argmin(axis=1)
    away = (np.arange(BEAMS) - first[:, None]) % BEAMS
    other_side = np.abs(away - BEAMS / 2) <= BEAMS / 4
    second = np.where(other_side, lengths, np.inf).argmin(axis=1)
    near, far = lengths[scans, first], lengths[scans, second]
    turn = tau * np.abs(away[scans, second] - BEAMS / 2) / BEAMS
    across = near + far
    # How long the view is at a right angle to the passage's width
    along = lengths[scans, (first + BEAMS // 4) % BEAMS] + lengths[scans, (first - BEAMS // 4) % BEAMS]
    return {
        "shortest beam": near,
        "width": across,
        "angle off opposite": turn,
        "length of view": along,
        "length to width": along / np.maximum(across, 1e-6),
    }


def _describe_outlines(lengths: Floats) -> dict[str, Floats]:
    """The shape of the polygon that joins the ends of the beams."""
    angle = tau * np.arange(BEAMS) / BEAMS
    ends = lengths * np.exp(1j * angle)
    following = np.roll(ends, -1, axis=1)
    area = np.maximum((ends.conj() * following).imag.sum(axis=1) / 2, 1e-6)
    perimeter = np.maximum(np.abs(following - ends).sum(axis=1), 1e-6)
    from_centre = ends - ends.mean(axis=1, keepdims=True)
    reach = np.abs(from_centre)
    # Axes of the ellipse with the same second moments
    spread, lean = (reach**2).mean(axis=1), np.abs((from_centre**2).mean(axis=1))
    major, minor = np.sqrt(spread + lean), np.sqrt(np.maximum(spread - lean, 0))
    return {
        "area": area,
        "perimeter": perimeter,
        "compactness": area / perimeter**2,
        "mean reach": reach.mean(axis=1),
        "deviation of reach": reach.std(axis=1),
        "relative deviation of reach": reach.std(axis=1) / np.maximum(reach.mean(axis=1), 1e-6),
        "major axis": major,
        "minor axis": minor,
        "elongation": minor / np.maximum(major, 1e-6),
    }
