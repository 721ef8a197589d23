"""NAME_gt_segmentation.png: the true rooms of the survey of room segmentation (Bormann et al., ICRA 2016)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta.io.images import read_grey

ROOM_ABOVE_GREY = 250  # grey of 0 to 255; rooms are white, lines are anti-aliased
MIN_ROOM_PX = 400  # pixels: 1 m² at 0.05 m per pixel


def read_survey_truth(path: str | Path) -> NDArray[np.int32]:
    """True rooms of a survey map, shape (H, W): 1 … N, 0 elsewhere.

    Raises MapError for what is no image.
    """
    grey, _ = read_grey(path)
    return label_free_rooms(grey)


def label_free_rooms(grey: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Rooms of a survey truth, shape (H, W): white pixels that touch by an edge, at least 400 of them.

    Smaller patches are slivers beside anti-aliased lines and become 0.
    """
    patches = label_patches(grey)
    is_room = np.bincount(patches.ravel(), minlength=1) >= MIN_ROOM_PX
    is_room[0] = False
    ids = np.where(is_room, np.cumsum(is_room), 0).astype(np.int32)
    return np.asarray(ids[patches])


def label_patches(grey: NDArray[np.uint8]) -> NDArray[np.int32]:
    """White patches of a survey truth of whatever size, shape (H, W): pixels above grey 250 that touch by an edge."""
    from scipy.ndimage import label

    patches, _ = label(grey > ROOM_ABOVE_GREY)
    return np.asarray(patches, np.int32)
