"""Regions that are no rooms: what was hardly seen, what lies outside, what nothing leads to, what is too thin."""

from __future__ import annotations

import cv2
import numpy as np
from scipy import ndimage

from pianta._types import Floats, LabelImage, Mask
from pianta.layout._label_images import grow_mask, highest_of_labels, list_contacts
from pianta.layout._voronoi_doors import compute_clearance
from pianta.layout.structure.evidence import Probabilities

# A smaller room is a leak of rays through a window, m², ...
MAX_LEAK_AREA = 2.0
# ... if its mean probability to be outside is larger (chosen by hand).
MAX_OUTSIDE = 0.2
# A spot that is enclosed by one region is furniture if it is smaller; m².
MAX_ENCLOSED_AREA = 4.0
# Larger ones are taken away before the floor is cut, since they stand like walls in a hall; m².
MIN_BOX_AREA = 1.0
# It is enclosed if at least this share of the cells near it ...
MIN_SURROUNDED_SHARE = 0.3
# ... and at most this far from it are of a region; metres (chosen by hand).
ENCLOSURE_REACH = 0.5
# Least share of the cells of a room that are free (chosen by hand).
MIN_SEEN_SHARE = 0.1
# What was seen of a room holds a circle of this diameter: doors are wider than this, and the ends of rays beside one
# another, or the strip between a wall and its ghost, thinner; metres.
MIN_SEEN_WIDTH = 0.55
# Where nothing leads to, it is as wide as most doors are; metres.
MIN_CLOSED_WIDTH = 0.75
# A niche is thinner than this, metres, ...
MAX_NICHE_DEPTH = 1.0
# ... and open to one room along at least this multiple of its depth (all four chosen by hand).
MIN_NICHE_RATIO = 3.0
# A region that is too thin is a part of its neighbour if at least this share of its cells is free; else it is the space
# between rays (chosen by hand: few regions have a share between 0.4 and 0.8).
MIN_THIN_SHARE = 0.6


def drop_unseen_rooms(labels: LabelImage, free: Mask, outside: Probabilities, *, resolution: float) -> LabelImage:
    """The label image without rooms of which the robot saw little floor, and without small ones outside the building.

    free: shape (H, W). outside: probability of each cell to be outside, shape (H, W). resolution: metres per cell.
    """
    area = np.bincount(labels.ravel())
    is_observed = np.bincount(labels[free], minlength=len(area)) >= MIN_SEEN_SHARE * area
    is_outside = np.bincount(labels.ravel(), outside.ravel()) > MAX_OUTSIDE * area
    is_room = is_observed & ~(is_outside & (area * resolution**2 < MAX_LEAK_AREA))
    return np.where(is_room[labels], labels, 0).astype(np.int32)


def drop_enclosed_spots(labels: LabelImage, *, resolution: float) -> LabelImage:
    """The label image without small spots inside a room that nothing leads to: the space in a table or behind a rope.

    labels: shape (H, W). resolution: metres per cell.
    """
    reach = round(ENCLOSURE_REACH / resolution)
    linked = np.unique(list_contacts(labels)[0])
    area = np.bincount(labels.ravel()) * resolution**2
    is_large = area >= MAX_ENCLOSED_AREA
    is_large[linked] = True
    is_large[0] = False
    is_spot = np.zeros(len(area), bool)
    for number, window in enumerate(ndimage.find_objects(labels), start=1):
        if window is None or is_large[number]:
            continue
        around = tuple(slice(max(axis.start - reach - 1, 0), axis.stop + reach + 1) for axis in window)
        spot = labels[around] == number
        ring = grow_mask(spot, reach) & ~spot
        # Two tables side by side do not make each other rooms
        neighbours = np.unique(labels[around][ring & is_large[labels[around]]])
        surrounded = np.count_nonzero(labels[around][ring]) >= MIN_SURROUNDED_SHARE * np.count_nonzero(ring)
        if len(neighbours) == 1 and surrounded:
            is_spot[number] = True
    return np.where(is_spot[labels], 0, labels).astype(np.int32)


def find_boxes(free: Mask, *, resolution: float) -> Mask:
    """Free cells, shape (H, W), in closed boxes inside a region: tables and roped areas that the robot saw through.

    resolution: metres per cell.
    """
    _, regions, stats, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    is_large = stats[:, cv2.CC_STAT_AREA] * resolution**2 >= MIN_BOX_AREA
    labels = np.where(is_large[regions], regions, 0).astype(np.int32)
    return np.asarray((labels > 0) & (drop_enclosed_spots(labels, resolution=resolution) == 0))


def absorb_thin_rooms(labels: LabelImage, free: Mask, occupied: Mask, *, resolution: float) -> LabelImage:
    """The label image without rooms of which nothing was seen that is as wide as a door, and without shallow niches.

    Those that are mostly free belong to the neighbour with the longest contact; the others are the space between rays.
    Gaps of a cell or two between rays count as seen. free, occupied: shape (H, W). resolution: metres per cell.
    """
    width = _measure_seen_width(labels, free, occupied) * resolution
    area = np.bincount(labels.ravel())
    is_seen = np.bincount(labels[free], minlength=len(area)) >= MIN_THIN_SHARE * area
    pairs, lengths = list_contacts(labels)
    contact = np.zeros(len(area))
    np.maximum.at(contact, pairs, lengths[:, None] * resolution)
    is_niche = (width < MAX_NICHE_DEPTH) & (contact >= MIN_NICHE_RATIO * width)
    is_thin = (width < MIN_SEEN_WIDTH) | is_niche
    owner = np.arange(len(area))
    owner[is_thin & ~is_seen] = 0
    for room in np.argsort(area, kind="stable").tolist():
        if owner[room] != room or room == 0:
            continue
        ends = owner[pairs]
        touching = (ends == room).any(axis=1) & (ends[:, 0] != ends[:, 1]) & (ends > 0).all(axis=1)
        if not touching.any() and width[room] < MIN_CLOSED_WIDTH:
            owner[owner == room] = 0
        elif touching.any() and is_thin[room]:
            one, other = ends[touching][lengths[touching].argmax()]
            owner[owner == room] = other if one == room else one
    return np.asarray(owner[labels], np.int32)


def _measure_seen_width(labels: LabelImage, free: Mask, occupied: Mask) -> Floats:
    """Diameter of the largest circle in the seen part of each label 0 … max, in cells; shape (1 + max,)."""
    closed = cv2.morphologyEx(free.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)) > 0
    observed = (free | (closed & ~occupied)) & (labels > 0)
    # A circle lies in one room
    observed[:-1] &= (labels[:-1] == labels[1:]) | (labels[1:] == 0)
    observed[:, :-1] &= (labels[:, :-1] == labels[:, 1:]) | (labels[:, 1:] == 0)
    return 2 * highest_of_labels(compute_clearance(observed), labels, int(labels.max(initial=0)))
