"""Robots' maps and plans are told apart, by suffix and by what images show."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from pianta.errors import MapError
from pianta.plan.map_or_plan import tell_kind
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


def with_alpha(greys: NDArray[np.uint8], seen: NDArray[np.bool_]) -> NDArray[np.uint8]:
    return np.dstack([greys, greys, greys, np.where(seen, 255, 0)]).astype(np.uint8)


def kind_of(pixels: NDArray[np.generic], tmp_path: Path, *, suffix: str = ".png") -> str:
    Image.fromarray(pixels).save(tmp_path / f"a{suffix}")
    return tell_kind(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("name", ["a.dxf", "a.svg", "a.pdf", "a.ifc", "a.gif", "a.webp", "A.DXF"])
def test_drawings_and_pictures_that_maps_never_are_need_no_look(name):
    assert tell_kind(name) == "plan"


@pytest.mark.parametrize("name", ["a.yaml", "a.yml", "a.npz", "a.pgm", "A.PGM", "a.txt", "a", "plan.png/a.yaml"])
def test_other_files_are_maps_whether_they_exist_or_not(name):
    assert tell_kind(name) == "map"


@pytest.mark.parametrize("suffix", [".png", ".bmp", ".tif", ".ppm", ".PNG"])
def test_images_are_told_by_what_they_show(tmp_path, suffix):
    assert kind_of(gmapping_map(), tmp_path, suffix=suffix) == "map"
    assert kind_of(line_plan(), tmp_path, suffix=suffix) == "plan"


def test_jpegs_have_more_greys_and_are_told_all_the_same(tmp_path):
    assert kind_of(gmapping_map(), tmp_path, suffix=".jpg") == "map"
    assert kind_of(line_plan(), tmp_path, suffix=".jpg") == "plan"


def test_sixteen_bits_are_told_as_eight(tmp_path):
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


@pytest.mark.parametrize(("paper", "kind"), [(244, "map"), (245, "plan")])
def test_paper_along_most_of_the_border_makes_a_plan(tmp_path, paper, kind):
    """Above and below, 80 pixels each, are most of 280; the sides, 60 each, are not."""
    greys = gmapping_map()
    greys[:, [0, -1]] = paper
    assert kind_of(greys, tmp_path) == "map"
    greys = gmapping_map()
    greys[[0, -1]] = paper
    assert kind_of(greys, tmp_path) == kind


def test_many_greys_are_a_photo_or_scan(tmp_path):
    """A map keeps three greys on more than half of its pixels, however noisy the rest."""
    noise = np.random.default_rng(0).integers(0, 240, (60, 80)).astype(np.uint8)
    assert kind_of(noise, tmp_path) == "plan"
    for noisy_rows, kind in ((24, "map"), (36, "plan")):
        greys = gmapping_map()
        greys[:noisy_rows] = noise[:noisy_rows]
        assert kind_of(greys, tmp_path) == kind


def test_a_transparent_map_has_free_space_and_a_transparent_drawing_only_lines(tmp_path):
    """Colours that are not seen do not count, nor does free space; a fully opaque image is judged by its border."""
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
    ("content", "fault"), [(None, "does not exist"), (b"", "is empty"), (b"x", "is no image"), (b"P5 9 9 255\n", "is")]
)
def test_images_that_cannot_be_read_are_refused_in_one_line(tmp_path, content, fault):
    if content is not None:
        (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(MapError, match=rf"^image '.*a\.png' {fault}[^\n]*$"):
        tell_kind(tmp_path / "a.png")


def test_images_beyond_the_limit_are_refused(tmp_path):
    Image.fromarray(gmapping_map()).save(tmp_path / "a.png")
    assert tell_kind(tmp_path / "a.png", max_cells=4800) == "map"
    with pytest.raises(MapError, match=r"80 × 60 = 4800 cells, the limit is 4799; .*--max-cells"):
        tell_kind(tmp_path / "a.png", max_cells=4799)


@given(turns=st.integers(0, 3), flipped=st.booleans(), scale=st.integers(1, 4))
def test_neither_turning_nor_enlarging_makes_another_kind(tmp_path_factory, turns, flipped, scale):
    path = tmp_path_factory.getbasetemp() / "turned.png"
    for greys, kind in ((gmapping_map(), "map"), (line_plan(), "plan")):
        turned = np.rot90(greys[::-1] if flipped else greys, turns).repeat(scale, axis=0).repeat(scale, axis=1)
        Image.fromarray(np.ascontiguousarray(turned)).save(path)
        assert tell_kind(path) == kind


@given(data=st.data())
def test_only_our_errors_escape_from_mutated_images(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "kind.png"
    Image.fromarray(gmapping_map()).save(path)
    path.write_bytes(data.draw(mutated(path.read_bytes())))
    with refused_in_one_line():
        assert tell_kind(path, max_cells=10_000) in ("map", "plan")


def smallest(files: list[Path], *, count: int) -> list[Path]:
    return sorted(files, key=lambda file: (file.stat().st_size, file.name))[:count]


def test_real_plans_are_plans(data):
    """Ten small ones, every sixth, and those with ways of escape, in JPEG and PNG."""
    folder = data / "floorplans"
    files = sorted(file for file in folder.glob("*.*") if file.suffix in (".png", ".jpg"))
    files = [file for file in files if file.stat().st_size < 300_000]
    chosen = {*smallest(files, count=10), *files[::6], *(folder / "evacuation").glob("*.png")}
    assert len(chosen) >= 12
    assert {file.name: tell_kind(file) for file in chosen} == {file.name: "plan" for file in chosen}


@pytest.mark.parametrize("folder", ["survey", "slam", "partial", "clutter", "priors"])
def test_real_maps_are_maps(data, folder):
    files = [
        file
        for file in sorted((data / folder).glob("**/*.png"))
        if not file.stem.endswith(("_gt", "_plan")) and "_world_" not in file.stem
    ]
    chosen = {*smallest(files, count=3), *files[:: len(files) // 2]}
    assert len(chosen) >= 3
    assert {file.name: tell_kind(file) for file in chosen} == {file.name: "map" for file in chosen}
