"""True rooms in colours."""

import numpy as np
import pytest
from PIL import Image

from pianta.errors import MapError
from pianta_bench.data.color_truth import label_colors, read_color_truth


def draw_colors() -> np.ndarray:
    """Two rooms, one of them in two pieces, on black, and 99 px of a blend of their colours."""
    colors = np.zeros((40, 40, 3), np.uint8)
    colors[:10, :10] = 200, 0, 10
    colors[:10, 20:] = colors[20:, :10] = 10, 0, 200
    colors[20:29, 20:31] = 105, 0, 105
    return colors


def test_a_room_is_a_colour_of_100_px():
    labels = label_colors(draw_colors())
    blue, red = labels[0, 20], labels[0, 0]
    assert {int(blue), int(red)} == {1, 2}
    assert (labels == red).sum() == 100
    assert (labels == blue).sum() == 400
    assert (labels == 0).sum() == 1600 - 500


def test_colours_of_one_grey_are_two_rooms(tmp_path):
    """Both have a luma of 76, so that a grey image would join them."""
    colors = np.zeros((20, 20, 3), np.uint8)
    colors[:, :10], colors[:, 10:] = (255, 0, 0), (0, 130, 0)
    Image.fromarray(colors).save(tmp_path / "a.png")
    labels = read_color_truth(tmp_path / "a.png")
    assert labels.max() == 2
    assert labels[0, 0] != labels[0, 19]


def test_what_is_no_image_is_refused(tmp_path):
    (tmp_path / "a.png").write_bytes(b"no image")
    with pytest.raises(MapError, match=r"\bimage\b"):
        read_color_truth(tmp_path / "a.png")
