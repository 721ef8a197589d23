"""Grey levels of image files of all formats, plain images as maps, and pictures on white."""

from math import nan
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from pianta.errors import MapError
from pianta.io.images import PICTURE_SUFFIXES, read_grey, read_image_map, read_picture
from pianta.io.maps import read_map
from tests.mutation import mutated, refused_in_one_line

GREYS = np.array([[0, 149, 150], [250, 251, 255]], np.uint8)


def grey_of(path: Path) -> object:
    grey, transparent = read_grey(path)
    assert grey.dtype == np.uint8
    assert transparent is None
    return grey.tolist()


def grey_and_transparency_of(path: Path) -> tuple[object, object]:
    grey, transparent = read_grey(path)
    assert transparent is not None
    return grey.tolist(), transparent.tolist()


@pytest.mark.parametrize("suffix", ["png", "pgm", "bmp", "tif"])
def test_lossless_formats_keep_every_grey(tmp_path, suffix):
    Image.fromarray(GREYS).save(tmp_path / f"a.{suffix}")
    assert grey_of(tmp_path / f"a.{suffix}") == GREYS.tolist()


def test_jpeg_is_read(tmp_path):
    Image.new("L", (8, 8), 200).save(tmp_path / "a.jpg")
    assert grey_of(tmp_path / "a.jpg") == [[200] * 8] * 8


@pytest.mark.parametrize(
    ("content", "greys"),
    [
        (b"P5\n# a comment\n3 1\n# another\n255\n\x00\xcd\xfe", [[0, 205, 254]]),
        (b"P2\r\n# a comment\r\n3 1\r\n255\r\n0 205 # here too\r\n254\r\n", [[0, 205, 254]]),
        (b"P5 3 1 100\n\x00\x14\x64", [[0, 51, 255]]),
        (b"P2 3 1 5 0 1 5\n", [[0, 51, 255]]),
        (b"P5 2 1 65535\n\x00\x00\xcd\xcd", [[0, 205]]),
        (b"P2 2 1 1000 0 1000\n", [[0, 255]]),
        (b"P1 3 1 0 1 0\n", [[255, 0, 255]]),
        (b"P4 3 1\n\x40", [[255, 0, 255]]),
        (b"P6 1 1 255\n\xcd\xcd\xcd", [[205]]),
    ],
)
def test_netpbm_of_every_kind(tmp_path, content, greys):
    (tmp_path / "a.pgm").write_bytes(content)
    assert grey_of(tmp_path / "a.pgm") == greys


def test_sixteen_bits_become_eight(tmp_path):
    Image.fromarray(np.array([[0, 205 * 257, 205 * 257 + 128, 205 * 257 + 129, 65535]], np.uint16)).save(
        tmp_path / "a.png"
    )
    assert grey_of(tmp_path / "a.png") == [[0, 205, 205, 206, 255]]


def test_one_bit_and_palette(tmp_path):
    Image.fromarray(np.array([[False, True]])).save(tmp_path / "bit.png")
    assert grey_of(tmp_path / "bit.png") == [[0, 255]]
    palette = Image.new("P", (3, 1))
    palette.putpalette([10, 10, 10, 205, 205, 205, 254, 254, 254])
    palette.putdata([2, 1, 0])
    palette.save(tmp_path / "palette.png")
    assert grey_of(tmp_path / "palette.png") == [[254, 205, 10]]
    palette.save(tmp_path / "seen.png", transparency=b"\xff\xfe\xff")
    assert grey_and_transparency_of(tmp_path / "seen.png") == ([[254, 205, 10]], [[False, True, False]])


def test_colours_become_luma(tmp_path):
    Image.fromarray(np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255]]], np.uint8)).save(tmp_path / "a.png")
    assert grey_of(tmp_path / "a.png") == [[76, 150, 29]]


@pytest.mark.parametrize("bands", [2, 4])
def test_alpha_below_full_is_transparent(tmp_path, bands):
    pixels = np.full((1, 3, bands), 77, np.uint8)
    pixels[0, :, -1] = [0, 254, 255]
    Image.fromarray(pixels).save(tmp_path / "a.png")
    assert grey_and_transparency_of(tmp_path / "a.png") == ([[77, 77, 77]], [[True, True, False]])


@pytest.mark.parametrize(("dtype", "step"), [(np.uint8, 1), (np.uint16, 257)])
def test_transparent_grey_level_is_transparent(tmp_path, dtype, step):
    Image.fromarray(np.array([[7 * step, 8 * step]], dtype)).save(tmp_path / "a.png", transparency=8 * step)
    assert grey_and_transparency_of(tmp_path / "a.png") == ([[7, 8]], [[False, True]])


def test_only_the_first_frame_counts(tmp_path):
    frames = [Image.new("L", (1, 1), grey) for grey in (7, 8)]
    frames[0].save(tmp_path / "a.tif", save_all=True, append_images=frames[1:])
    assert grey_of(tmp_path / "a.tif") == [[7]]


def test_giant_is_refused_before_it_is_decoded(tmp_path):
    (tmp_path / "a.pgm").write_bytes(b"P5 30000 30000 255\n")
    limit = Image.MAX_IMAGE_PIXELS
    with pytest.raises(MapError, match=r"900000000.*300000000.*max_cells="):
        read_grey(tmp_path / "a.pgm")
    with pytest.raises(MapError, match=r"\b6\b.*\b5\b"):
        read_grey(save(tmp_path / "b.png", np.zeros((3, 2), np.uint8)), max_cells=5)
    assert limit == Image.MAX_IMAGE_PIXELS


def test_the_limit_of_pianta_replaces_that_of_pillow(tmp_path, monkeypatch):
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 2)
    assert grey_of(save(tmp_path / "a.png", GREYS)) == GREYS.tolist()


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (b"hello", "PNG"),
        (b"\x89PNG\r\n\x1a\n", "is"),
        (b"P5 4 4 255\n123", "damaged"),
        (b"P2 2 1 255\n1 x", "damaged"),
        (b"Pf 1 1 -1.0\n\x00\x00\x80\x3f", "fractions"),
        (b"GIF89a\x01\x00\x01\x00\x00\x00\x00;", "PNG"),
    ],
)
def test_files_that_are_no_images_are_refused_in_one_line(tmp_path, content, fault):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(MapError, match=rf"^image '[^\n]*' [^\n]*{fault}[^\n]*$"):
        read_grey(tmp_path / "a.png")


def test_negative_and_wide_pixels_are_refused(tmp_path):
    path = save(tmp_path / "a.tif", np.array([[-1, 70000]], np.int32))
    with pytest.raises(MapError, match=r"-1.*70000"):
        read_grey(path)


def test_truncated_png_is_damaged(tmp_path):
    path = save(tmp_path / "a.png", np.random.default_rng(0).integers(0, 255, (99, 99)).astype(np.uint8))
    path.write_bytes(path.read_bytes()[:-2000])
    with pytest.raises(MapError, match=r"\bdamaged\b"):
        read_grey(path)


def test_white_is_free_dark_is_occupied_and_the_rest_unknown(tmp_path):
    grid = read_image_map(save(tmp_path / "a.png", GREYS), resolution=0.05, origin=(1, 2, 0.5))
    assert grid.cells.tolist() == [[100, 100, -1], [-1, 0, 0]]
    assert (grid.resolution, grid.origin) == (0.05, (1.0, 2.0, 0.5))


def test_greys_of_free_and_occupied_can_be_given(tmp_path):
    grid = read_image_map(save(tmp_path / "a.png", GREYS), resolution=1, free_above=149, occupied_below=149)
    assert grid.cells.tolist() == [[100, -1, 0], [0, 0, 0]]


def test_transparent_is_unknown(tmp_path):
    path = save(tmp_path / "a.png", np.array([[[255, 255], [255, 9], [0, 9]]], np.uint8))
    assert read_image_map(path, resolution=1).cells.tolist() == [[0, -1, -1]]


def test_all_faults_of_the_options_are_listed_at_once(tmp_path):
    path = save(tmp_path / "a.png", GREYS)
    with pytest.raises(MapError, match=r"resolution.*origin.*occupied_below.*free_above"):
        read_image_map(path, resolution=-1, origin=(0, nan, 0), free_above=9, occupied_below=200)
    for resolution in (0.0, nan, float("inf")):
        with pytest.raises(MapError, match="resolution"):
            read_image_map(path, resolution=resolution)


def test_read_map_requires_the_resolution_of_an_image(tmp_path):
    path = save(tmp_path / "a.PNG", GREYS)
    assert read_map(path, resolution=0.1, origin=(3, 4, 0)).origin == (3.0, 4.0, 0.0)
    with pytest.raises(MapError, match="resolution="):
        read_map(path)
    (tmp_path / "a.yaml").touch()
    with pytest.raises(MapError, match=r"a\.yaml.*resolution="):
        read_map(path)


def test_the_message_of_read_map_lists_the_formats(tmp_path):
    (tmp_path / "a.txt").write_text("x")
    with pytest.raises(MapError, match=r"\.yaml.*\.npz"):
        read_map(tmp_path / "a.txt")
    with pytest.raises(MapError, match="address"):
        read_map("https://example.org/a.txt")
    with pytest.raises(MapError, match="folder"):
        read_map(tmp_path)


@given(
    st.sampled_from([b"", b"P5 ", b"P2 3 3 9 ", b"BM", b"\x89PNG\r\n\x1a\n", b"II*\x00", b"\xff\xd8\xff"]), st.binary()
)
def test_random_bytes_raise_only_errors_of_pianta(tmp_path_factory, start, rest):
    path = tmp_path_factory.getbasetemp() / "random.png"
    path.write_bytes(start + rest)
    read_or_refuse(path)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["png", "pgm", "bmp", "tif", "jpg"])
@settings(max_examples=60)
@given(data=st.data())
def test_mutated_images_raise_only_errors_of_pianta(tmp_path_factory, suffix, data):
    path = tmp_path_factory.getbasetemp() / f"mutated.{suffix}"
    Image.fromarray(np.tile(GREYS, (4, 4))).save(path)
    path.write_bytes(data.draw(mutated(path.read_bytes())))
    read_or_refuse(path)


# A picture of 3 × 2 pixels with a black corner: Exif orientation, upright shape, row and column of the corner.
ORIENTATIONS = [
    *[(1, (2, 3), [0, 0]), (2, (2, 3), [0, 2]), (3, (2, 3), [1, 2]), (4, (2, 3), [1, 0])],
    *[(5, (3, 2), [0, 0]), (6, (3, 2), [0, 1]), (7, (3, 2), [2, 1]), (8, (3, 2), [2, 0])],
]


def corner_of(path: Path) -> list[object]:
    """The shape of a picture, and row and column of its darkest pixel, because JPEG is not exact."""
    darkest = read_picture(path).min(axis=2)
    return [darkest.shape, [int(index) for index in np.unravel_index(darkest.argmin(), darkest.shape)]]


@pytest.mark.slow
@pytest.mark.parametrize("orientation", ORIENTATIONS)
@pytest.mark.parametrize(
    ("suffix", "mode"),
    [
        *[("jpg", "L"), ("jpg", "RGB"), ("webp", "RGB"), ("webp", "RGBA")],
        *[(suffix, mode) for suffix in ("png", "tif") for mode in ("L", "RGB", "RGBA", "I;16")],
    ],
)
def test_pictures_are_turned_upright(tmp_path, suffix, mode, orientation):
    exif_orientation, *answer = orientation
    corner_black = np.array([[0, 255, 255], [255, 255, 255]], np.uint8)
    deep = Image.fromarray(corner_black.astype(np.uint16) * 257)
    exif = Image.Exif()
    exif[0x0112] = exif_orientation
    image = deep if mode == "I;16" else Image.fromarray(corner_black).convert(mode)
    image.save(tmp_path / f"a.{suffix}", exif=exif, lossless=True)
    assert corner_of(tmp_path / f"a.{suffix}") == answer


def test_maps_keep_their_rows_when_a_tiff_is_turned(tmp_path):
    """Without compression, because Pillow maps such files into memory and would mix up the rows."""
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(GREYS).save(tmp_path / "a.tif", exif=exif)
    assert grey_of(tmp_path / "a.tif") == np.rot90(GREYS, -1).tolist()


def test_transparent_pixels_are_white(tmp_path):
    """Opaque, half transparent and fully transparent black: in colour, grey, a palette, and as a transparent colour."""
    alphas = np.array([[255, 127, 0]], np.uint8)
    blacks = np.zeros_like(alphas)
    answers = [[[0] * 3, [128] * 3, [255] * 3]]
    for stack in ([blacks] * 3, [blacks]):
        Image.fromarray(np.dstack([*stack, alphas])).save(tmp_path / "a.png")
        assert read_picture(tmp_path / "a.png").tolist() == answers
    palette = Image.fromarray(np.array([[0, 1, 2]], np.uint8)).convert("P")
    palette.putpalette([0, 0, 0] * 3)
    palette.save(tmp_path / "a.png", transparency=bytes([255, 127, 0]))
    assert read_picture(tmp_path / "a.png").tolist() == answers
    Image.fromarray(np.array([[[9, 8, 7], [1, 2, 3]]], np.uint8)).save(tmp_path / "a.png", transparency=(1, 2, 3))
    assert read_picture(tmp_path / "a.png").tolist() == [[[9, 8, 7], [255, 255, 255]]]


def test_sixteen_bits_of_a_picture_become_eight(tmp_path):
    deep = Image.fromarray(np.array([[0, 205 * 257, 65535, 7]], np.uint16))
    for suffix in ("png", "tif"):
        deep.save(tmp_path / f"a.{suffix}")
        assert read_picture(tmp_path / f"a.{suffix}").tolist() == [[[0] * 3, [205] * 3, [255] * 3, [0] * 3]]
    deep.save(tmp_path / "a.png", transparency=7)
    assert read_picture(tmp_path / "a.png").tolist() == [[[0] * 3, [205] * 3, [255] * 3, [255] * 3]]


def test_colours_of_a_picture_are_kept(tmp_path):
    colors = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [10, 20, 30]]], np.uint8)
    for suffix in ("png", "bmp", "tif", "ppm", "gif", "webp"):
        Image.fromarray(colors).save(tmp_path / f"a.{suffix}", lossless=True)
        picture = read_picture(tmp_path / f"a.{suffix}")
        assert picture.dtype == np.uint8
        assert picture.tolist() == colors.tolist()


@pytest.mark.parametrize("suffix", ["gif", "webp"])
def test_of_animations_the_first_frame_is_read_on_white(tmp_path, suffix):
    first = Image.new("RGBA", (2, 2), (200, 0, 0, 255))
    first.putpixel((0, 0), (0, 0, 0, 0))
    later = Image.new("RGBA", (2, 2), (0, 0, 200, 255))
    first.save(tmp_path / f"a.{suffix}", save_all=True, append_images=[later], lossless=True)
    red = [200, 0, 0]
    assert read_picture(tmp_path / f"a.{suffix}").tolist() == [[[255] * 3, red], [red, red]]


def test_a_map_is_no_gif(tmp_path):
    save(tmp_path / "a.gif", GREYS)
    with pytest.raises(MapError, match="PNG"):
        read_grey(tmp_path / "a.gif")
    assert read_picture(tmp_path / "a.gif")[..., 0].tolist() == GREYS.tolist()


@pytest.mark.parametrize(
    "content",
    [
        b"P5 30000 30000 255\n",
        b"GIF89a" + bytes([0x30, 0x75, 0x30, 0x75, 0, 0, 0]) + b"," + bytes([0] * 4 + [0x30, 0x75] * 2) + b"\0\2\0;",
    ],
)
def test_image_bombs_are_refused_before_they_are_decoded(tmp_path, content):
    (tmp_path / "a.png").write_bytes(content)
    limit = Image.MAX_IMAGE_PIXELS
    with pytest.raises(MapError, match=r"900000000.*300000000.*max_cells="):
        read_picture(tmp_path / "a.png")
    assert limit == Image.MAX_IMAGE_PIXELS
    with pytest.raises(MapError, match=r"\b6\b.*\b5\b"):
        read_picture(save(tmp_path / "b.png", np.zeros((3, 2), np.uint8)), max_cells=5)


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (b"hello", "PNG"),
        (b"P5 4 4 255\n123", "damaged"),
        (b"Pf 1 1 -1.0\n\x00\x00\x80\x3f", "damaged.*fractions"),
        (b"GIF89a\x01\x00\x01\x00\x00\x00\x00;", "is"),
        (b"RIFF\x10\x00\x00\x00WEBPVP8 \x00\x00\x00\x00", "is"),
        (b"<svg/>", "PNG"),
    ],
)
def test_files_that_are_no_pictures_are_refused_in_one_line(tmp_path, content, fault):
    (tmp_path / "a.gif").write_bytes(content)
    with pytest.raises(MapError, match=rf"^image '[^\n]*' [^\n]*{fault}[^\n]*$"):
        read_picture(tmp_path / "a.gif")


@pytest.mark.slow
@pytest.mark.parametrize("suffix", PICTURE_SUFFIXES)
@settings(max_examples=25)
@given(data=st.data())
def test_mutated_pictures_raise_only_errors_of_pianta(tmp_path_factory, suffix, data):
    path = tmp_path_factory.getbasetemp() / f"picture{suffix}"
    Image.fromarray(np.tile(GREYS, (4, 4))).save(path)
    path.write_bytes(data.draw(mutated(path.read_bytes())))
    with refused_in_one_line():
        assert read_picture(path, max_cells=10_000).shape[2] == 3


def read_or_refuse(path: Path) -> None:
    with refused_in_one_line():
        grid = read_image_map(path, resolution=0.05, max_cells=10_000)
        assert set(np.unique(grid.cells)) <= {-1, 0, 100}


def save(path: Path, pixels: np.ndarray) -> Path:
    Image.fromarray(pixels).save(path)
    return path
