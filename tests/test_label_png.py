"""Label images survive their PNG exactly, and other arrays are refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import array_shapes, arrays
from PIL import Image

from pianta.errors import FloorError
from pianta.io.floors import save_label_image

LABELS = np.array([[0, 1, 255], [256, 65534, 65535]], np.uint16)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("labels") / "rooms.png"


@pytest.mark.slow
@given(labels=arrays(np.uint16, array_shapes(min_dims=2, max_dims=2, max_side=9)))
def test_round_trip_is_exact(path, labels):
    save_label_image(labels, path)
    with Image.open(path) as image:
        content = np.array(image)
    assert content.dtype == np.uint16
    assert content.tolist() == labels.tolist()


def test_png_is_16_bit_grey(path):
    save_label_image(LABELS[:, ::-1], path)
    with Image.open(path) as image:
        assert (image.format, image.mode, image.size) == ("PNG", "I;16", (3, 2))


@pytest.mark.parametrize("labels", [LABELS.astype(np.int32), LABELS[0], LABELS[:0]])
def test_labels_that_are_no_image_are_refused(path, labels):
    with pytest.raises(FloorError, match="uint16"):
        save_label_image(labels, path)
