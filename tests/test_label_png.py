"""Label images survive their PNG exactly, and nothing else passes for one."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from PIL import Image

from pianta.errors import FloorError
from pianta.io.floors import read_label_image, save_label_image
from tests.mutation import mutated

LABELS = np.array([[0, 1, 255], [256, 65534, 65535]], np.uint16)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("labels") / "rooms.png"


@pytest.mark.slow
@given(labels=arrays(np.uint16, array_shapes(min_dims=2, max_dims=2, max_side=9)))
def test_round_trip_is_exact(path, labels):
    save_label_image(labels, path)
    read = read_label_image(path)
    assert read.dtype == np.uint16
    assert read.tolist() == labels.tolist()


def test_png_is_16_bit_grey(path):
    save_label_image(LABELS[:, ::-1], path)
    with Image.open(path) as image:
        assert (image.format, image.mode, image.size) == ("PNG", "I;16", (3, 2))


@pytest.mark.parametrize("labels", [LABELS.astype(np.int32), LABELS[0], LABELS[:0]])
def test_labels_that_are_no_image_are_refused(path, labels):
    with pytest.raises(FloorError, match="uint16"):
        save_label_image(labels, path)


@pytest.mark.parametrize("mode", ["L", "RGB", "P", "1", "LA"])
def test_other_pixels_are_refused(path, mode):
    Image.new(mode, (2, 2)).save(path)
    with pytest.raises(FloorError, match="16-bit"):
        read_label_image(path)


def test_other_formats_are_refused(path):
    Image.fromarray(LABELS).save(path, format="TIFF")
    with pytest.raises(FloorError, match="image"):
        read_label_image(path)


def test_size_is_limited(path):
    save_label_image(LABELS, path)
    with pytest.raises(FloorError, match="pixels"):
        read_label_image(path, max_cells=5)


@pytest.fixture(scope="module")
def valid(path):
    save_label_image(LABELS, path)
    return path.read_bytes()


@given(fuzz=st.data())
def test_damaged_file_is_read_or_refused(path, valid, fuzz):
    path.write_bytes(fuzz.draw(st.binary() | mutated(valid)))
    with suppress(FloorError):
        assert read_label_image(path).dtype == np.uint16
