"""GeoTIFFs: resolution and position from their tags."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image, TiffImagePlugin

import pianta
from pianta.errors import MapError
from pianta.plan.sheets.map_or_plan import detect_input_kind

# Two rows of three pixels: free, wall, unknown above free, free, wall.
GREYS = np.array([[255, 0, 200], [255, 255, 0]], np.uint8)
CELLS = [[0, 100, -1], [0, 0, 100]]


def write(path: Path, *, scale=None, tiepoint=None, matrix=None, keys=None) -> Path:
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    for tag, values in ((33550, scale), (33922, tiepoint), (34264, matrix)):
        if values is not None:
            tags.tagtype[tag] = 12
            tags[tag] = tuple(map(float, values))
    if keys is not None:
        listed = [1, 1, 0, len(keys), *(number for key, value in keys.items() for number in (key, 0, 1, value))]
        tags.tagtype[34735] = 3
        tags[34735] = tuple(listed)
    Image.fromarray(GREYS).save(path, tiffinfo=tags)
    return path


def test_scale_and_tiepoint(tmp_path):
    # The upper left corner is at 100, 50: the lower one is two pixels of 0.5 m below
    path = write(tmp_path / "a.tif", scale=(0.5, 0.5, 0), tiepoint=(0, 0, 0, 100, 50, 0))
    grid = pianta.read_map(path)
    assert grid.cells.tolist() == CELLS
    assert (grid.resolution, grid.origin, grid.source) == (0.5, (100, 49, 0), "a.tif")
    assert detect_input_kind(path) == "map"


def test_a_tiepoint_inside_the_image(tmp_path):
    grid = pianta.read_map(write(tmp_path / "a.tif", scale=(0.5, 0.5, 0), tiepoint=(2, 1, 0, 100, 50, 0)))
    assert grid.origin == (99, 49.5, 0)


def test_values_of_points_lie_in_the_middle_of_pixels(tmp_path):
    path = write(tmp_path / "a.tif", scale=(0.5, 0.5, 0), tiepoint=(0, 0, 0, 100, 50, 0), keys={1025: 2})
    assert pianta.read_map(path).origin == (99.75, 49.25, 0)


def test_a_turned_image(tmp_path):
    # A quarter turn counter-clockwise: to the right in the image is up in the map
    matrix = [0, 0.5, 0, 10, 0.5, 0, 0, 20, 0, 0, 0, 0, 0, 0, 0, 1]
    grid = pianta.read_map(write(tmp_path / "a.tif", matrix=matrix))
    assert grid.origin == pytest.approx((11, 20, np.pi / 2))
    x, y = grid.pixel_to_map(0, 0)
    assert (float(x), float(y)) == pytest.approx((10, 20))


def test_signed_bytes_are_cells(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    cells = np.array([[-1, 0, 100], [50, -128, 0]], np.int8)
    extra = [(33550, "d", 3, (0.1, 0.1, 0), True), (33922, "d", 6, (0, 0, 0, 0, 0, 0), True)]
    tifffile.imwrite(tmp_path / "a.tif", cells, extratags=extra)
    grid = pianta.read_map(tmp_path / "a.tif")
    assert grid.cells.tolist() == [[-1, 0, 100], [50, -1, 0]]
    assert grid.resolution == 0.1


@pytest.mark.parametrize(
    ("values", "fault"),
    [
        ({"scale": (1e-5, 1e-5, 0), "keys": {1024: 2}}, "is in degrees or feet"),
        ({"scale": (1, 1, 0), "keys": {1024: 1, 3076: 9002}}, "is in degrees or feet"),
        ({"scale": (1, 2, 0)}, "pixels that are no squares"),
        ({"scale": (0, 0, 0)}, "pixels that are no squares"),
        ({"scale": (float("nan"), 1, 0)}, "pixels that are no squares"),
        ({"scale": (1,)}, "damaged tags of its position"),
        ({"matrix": [1, 0, 0]}, "damaged tags of its position"),
        # Mirrored: down in the image is up in the map
        ({"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]}, "no squares or mirrored"),
    ],
)
def test_faults_are_one_line(tmp_path, values, fault):
    with pytest.raises(MapError, match=fault) as error:
        pianta.read_map(write(tmp_path / "a.tif", **{"tiepoint": (0, 0, 0, 0, 0, 0), **values}))
    assert "\n" not in str(error.value)


def test_an_image_without_tags_still_needs_a_resolution(tmp_path):
    with pytest.raises(MapError, match="is an image without a resolution"):
        pianta.read_map(write(tmp_path / "a.tif"))


def test_a_given_resolution_wins(tmp_path):
    path = write(tmp_path / "a.tif", scale=(0.5, 0.5, 0), tiepoint=(0, 0, 0, 100, 50, 0))
    assert pianta.read_map(path, resolution=0.1).origin == (0, 0, 0)
