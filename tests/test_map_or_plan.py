"""Robots' maps and plans are distinguished by suffix and by the pixels of images."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from pianta._types import Colors
from pianta.errors import MapError
from pianta.plan.sheets.map_or_plan import detect_input_kind, looks_like_drawing
from tests.mutation import mutated, refused_in_one_line

FREE, UNKNOWN = 254, 205


def gmapping_map() -> NDArray[np.uint8]:
    """A room of free space in the unknown, with its walls."""
    cells = np.full((60, 80), UNKNOWN, np.uint8)
    cells[10:50, 10:70] = 0
    cells[12:48, 12:68] = FREE
    return cells


def line_plan() -> NDArray[np.uint8]:
    """A room of black lines on white paper."""
    plan = np.full((60, 80), 255, np.uint8)
    plan[10:50, 10:70] = 0
    plan[12:48, 12:68] = 255
    return plan


def with_alpha(greys: NDArray[np.uint8], opaque: NDArray[np.bool_]) -> NDArray[np.uint8]:
    return np.dstack([greys, greys, greys, np.where(opaque, 255, 0)]).astype(np.uint8)


def kind_of(pixels: NDArray[np.generic], tmp_path: Path, *, suffix: str = ".png") -> str:
    Image.fromarray(pixels).save(tmp_path / f"a{suffix}")
    return detect_input_kind(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("name", ["a.dxf", "a.svg", "a.pdf", "a.ifc", "a.gif", "a.webp", "A.DXF"])
def test_formats_that_maps_never_have_are_plans_by_their_suffix(name):
    assert detect_input_kind(name) == "plan"


@pytest.mark.parametrize("name", ["a.yaml", "a.yml", "a.npz", "a.pgm", "A.PGM", "a.txt", "a", "plan.png/a.yaml"])
def test_other_suffixes_are_maps_without_opening_the_file(name):
    assert detect_input_kind(name) == "map"


@pytest.mark.parametrize("suffix", [".png", ".bmp", ".tif", ".ppm", ".PNG"])
def test_images_are_distinguished_by_their_pixels(tmp_path, suffix):
    assert kind_of(gmapping_map(), tmp_path, suffix=suffix) == "map"
    assert kind_of(line_plan(), tmp_path, suffix=suffix) == "plan"


def test_jpegs_are_distinguished_although_they_have_more_greys(tmp_path):
    assert kind_of(gmapping_map(), tmp_path, suffix=".jpg") == "map"
    assert kind_of(line_plan(), tmp_path, suffix=".jpg") == "plan"


def test_sixteen_bits_are_distinguished_as_eight(tmp_path):
    assert kind_of(gmapping_map().astype(np.uint16) * 257, tmp_path) == "map"
    assert kind_of(line_plan().astype(np.uint16) * 257, tmp_path) == "plan"


def test_colours_make_a_plan_and_a_few_coloured_pixels_do_not(tmp_path):
    """15 of 4800 pixels are more than 0.3 %, 14 are not; and no colour is as pale as a chroma of 40."""
    colors = gmapping_map()[:, :, None].repeat(3, axis=2)
    colors[30, 20:34] = (255, 214, 255)
    assert kind_of(colors, tmp_path) == "map"
    colors[30, 34] = (255, 214, 255)
    assert kind_of(colors, tmp_path) == "plan"
    colors[30, 20:60] = (255, 215, 255)
    assert kind_of(colors, tmp_path) == "map"


@pytest.mark.parametrize(("paper", "expected"), [(244, "map"), (245, "plan")])
def test_paper_along_most_of_the_border_makes_a_plan(tmp_path, paper, expected):
    """Above and below, 80 pixels each, are most of 280; the sides, 60 each, are not."""
    greys = gmapping_map()
    greys[:, [0, -1]] = paper
    assert kind_of(greys, tmp_path) == "map"
    greys = gmapping_map()
    greys[[0, -1]] = paper
    assert kind_of(greys, tmp_path) == expected


def test_many_greys_are_a_photo_or_scan(tmp_path):
    """A map keeps three greys on more than half of its pixels, however noisy the rest."""
    noise = np.random.default_rng(0).integers(0, 240, (60, 80)).astype(np.uint8)
    assert kind_of(noise, tmp_path) == "plan"
    for noisy_rows, expected in ((24, "map"), (36, "plan")):
        greys = gmapping_map()
        greys[:noisy_rows] = noise[:noisy_rows]
        assert kind_of(greys, tmp_path) == expected


def test_a_transparent_map_has_free_space_and_a_transparent_drawing_only_lines(tmp_path):
    """Transparent pixels do not count; a fully opaque image is classified by its border."""
    greys = gmapping_map()
    assert kind_of(with_alpha(greys, greys != UNKNOWN), tmp_path) == "map"
    assert kind_of(with_alpha(line_plan(), line_plan() == 0), tmp_path) == "plan"
    assert kind_of(with_alpha(line_plan(), np.ones((60, 80), bool)), tmp_path) == "plan"
    hidden = with_alpha(greys, greys != UNKNOWN)
    hidden[greys == UNKNOWN, :3] = (255, 0, 0)
    assert kind_of(hidden, tmp_path) == "map"
    hidden[greys == FREE, 3] = 0
    assert kind_of(hidden, tmp_path) == "plan"


@pytest.mark.parametrize(
    ("content", "fault"), [(None, "exist"), (b"", "empty"), (b"x", "PNG"), (b"P5 9 9 255\n", "is")]
)
def test_images_that_cannot_be_read_are_refused_in_one_line(tmp_path, content, fault):
    if content is not None:
        (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(MapError, match=rf"^image '[^\n]*a\.png' [^\n]*{fault}[^\n]*$"):
        detect_input_kind(tmp_path / "a.png")


def test_images_beyond_the_limit_are_refused(tmp_path):
    Image.fromarray(gmapping_map()).save(tmp_path / "a.png")
    assert detect_input_kind(tmp_path / "a.png", max_cells=4800) == "map"
    with pytest.raises(MapError, match=r"4800.*4799.*max_cells="):
        detect_input_kind(tmp_path / "a.png", max_cells=4799)


@pytest.mark.slow
@given(turns=st.integers(0, 3), flipped=st.booleans(), scale=st.integers(1, 4))
def test_turning_and_enlarging_change_nothing(tmp_path_factory, turns, flipped, scale):
    path = tmp_path_factory.getbasetemp() / "turned.png"
    for greys, expected in ((gmapping_map(), "map"), (line_plan(), "plan")):
        turned = np.rot90(greys[::-1] if flipped else greys, turns).repeat(scale, axis=0).repeat(scale, axis=1)
        Image.fromarray(np.ascontiguousarray(turned)).save(path)
        assert detect_input_kind(path) == expected


@pytest.mark.slow
@given(data=st.data())
def test_mutated_images_raise_only_errors_of_pianta(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "kind.png"
    Image.fromarray(gmapping_map()).save(path)
    path.write_bytes(data.draw(mutated(path.read_bytes())))
    with refused_in_one_line():
        assert detect_input_kind(path, max_cells=10_000) in ("map", "plan")


def smallest(files: list[Path], *, count: int) -> list[Path]:
    return sorted(files, key=lambda file: (file.stat().st_size, file.name))[:count]


@pytest.mark.slow
def test_real_plans_are_plans(data):
    """Ten small ones, every sixth, and evacuation maps, in JPEG and PNG."""
    folder = data / "floorplans"
    files = sorted(file for file in folder.glob("*.*") if file.suffix in (".png", ".jpg"))
    files = [file for file in files if file.stat().st_size < 300_000]
    chosen = {*smallest(files, count=10), *files[::6], *(folder / "evacuation").glob("*.png")}
    assert len(chosen) >= 12
    assert {file.name: detect_input_kind(file) for file in chosen} == {file.name: "plan" for file in chosen}


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["survey", "slam", "partial", "clutter", "priors"])
def test_real_maps_are_maps(data, folder):
    files = [
        file
        for file in sorted((data / folder).glob("**/*.png"))
        if not file.stem.endswith(("_gt", "_plan")) and "_world_" not in file.stem
    ]
    chosen = {*smallest(files, count=3), *files[:: len(files) // 2]}
    assert len(chosen) >= 3
    assert {file.name: detect_input_kind(file) for file in chosen} == {file.name: "map" for file in chosen}


def rooms_on_paper(width: int = 600, *, line: int = 1) -> Colors:
    """Three rooms beside each other, with desks in them."""
    paper = np.full((width * 2 // 3, width, 3), 255, np.uint8)
    for left in (0.1, 0.4, 0.6):
        corner = round(left * width), width // 6
        cv2.rectangle(paper, corner, (corner[0] + width // 5, width // 2), (0, 0, 0), line)
        cv2.rectangle(
            paper, (corner[0] + width // 20, width // 4), (corner[0] + width // 8, width // 3), (90,) * 3, line
        )
    return paper


def in_uneven_light(colors: Colors) -> Colors:
    """As in a photo: darker and more yellow to the right, with grain."""
    light = np.linspace(1, 0.55, colors.shape[1])[None, :, None] * (1, 0.97, 0.9)
    grain = np.random.default_rng(0).normal(0, 6, colors.shape)
    return np.asarray((colors * light + grain).clip(0, 255), np.uint8)


def with_floors(colors: Colors, *, every: int, tiles: bool) -> Colors:
    """The drawing without its margin, floors hatched at 45° or tiled, with lines one pixel wide."""
    rows, cols = np.indices(colors.shape[:2])
    lines = (rows % every == 0) | (cols % every == 0) if tiles else (rows + cols) % every == 0
    hatched = np.where(lines[..., None], np.uint8(0), colors)
    return hatched[colors.shape[0] // 4 : colors.shape[0] // 2, colors.shape[1] // 10 : -colors.shape[1] // 10]


@pytest.mark.slow
@pytest.mark.parametrize("every", [5, 6, 9])
@pytest.mark.parametrize("tiles", [False, True])
@pytest.mark.parametrize("width", [600, 1500])
def test_drawings_with_hatched_floors_may_be_plans(width, tiles, every):
    assert looks_like_drawing(with_floors(rooms_on_paper(width, line=width // 150), every=every, tiles=tiles))


@pytest.mark.slow
@pytest.mark.parametrize(
    "colors",
    [
        rooms_on_paper(),
        rooms_on_paper(100),
        rooms_on_paper(4500),
        rooms_on_paper(line=12),
        255 - rooms_on_paper(),
        np.where(rooms_on_paper() == 255, np.array([200, 220, 255], np.uint8), np.uint8(60)),
        in_uneven_light(rooms_on_paper(line=3)),
    ],
    ids=["thin", "small", "large", "thick", "blueprint", "coloured", "photographed"],
)
def test_drawings_may_be_plans(colors):
    assert looks_like_drawing(colors)


def blobs() -> Colors:
    """A picture like a photo: soft light, and objects of all colours with soft edges."""
    random = np.random.default_rng(1)
    rows, cols = np.mgrid[:300, :400]
    scene = np.stack([120 + 80 * np.sin(cols / 90), 130 + 60 * np.cos(cols / 70), 90 + rows / 3], axis=-1)
    for _ in range(40):
        row, col, size = random.integers((0, 0, 5), (300, 400, 60))
        near = np.exp(-(((rows - row) / size) ** 2) - ((cols - col) / size) ** 2)[..., None]
        scene += near * (random.integers(0, 256, 3) - scene)
    return np.asarray(scene.clip(0, 255), np.uint8)


def page_of_text() -> Colors:
    paper = np.full((700, 500, 3), 255, np.uint8)
    for row in range(40, 680, 22):
        cv2.putText(paper, "it was a plan of many rooms and doors", (40, row), 0, 0.6, (0, 0, 0), 1, cv2.LINE_AA)
    return paper


RANDOM = np.random.default_rng(0)
NO_DRAWINGS = {
    "white": np.full((300, 400, 3), 255, np.uint8),
    "black": np.zeros((300, 400, 3), np.uint8),
    "a pixel": np.zeros((1, 1, 3), np.uint8),
    "a row": RANDOM.integers(0, 256, (1, 900, 3), np.uint8),
    "a column": np.full((900, 1, 3), 255, np.uint8),
    "a strip": np.tile(np.array([[[0], [255]]], np.uint8), (15, 200, 3)),
    "grey noise": np.repeat(RANDOM.integers(0, 256, (300, 400, 1), np.uint8), 3, axis=2),
    "coloured noise": RANDOM.integers(0, 256, (300, 400, 3), np.uint8),
    "black and white noise": np.repeat(RANDOM.integers(0, 2, (300, 400, 1), np.uint8) * np.uint8(255), 3, axis=2),
    "large noise": np.repeat(RANDOM.integers(0, 256, (2100, 2500, 1), np.uint8), 3, axis=2),
    "specks": np.repeat(np.where(RANDOM.random((300, 400, 1)) < 0.02, 0, 255).astype(np.uint8), 3, axis=2),
    "clouds": cv2.GaussianBlur(RANDOM.integers(0, 256, (300, 400, 3), np.uint8), (0, 0), 4),
    "photo": blobs(),
    "text": page_of_text(),
}


@pytest.mark.parametrize("name", NO_DRAWINGS)
def test_blank_sheets_noise_photos_and_text_are_no_drawings(name):
    assert not looks_like_drawing(NO_DRAWINGS[name])
