"""Templates: our own, and those of a user's folder with every fault that it may have."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from pianta.errors import PlanError
from pianta.plan.symbols.templates import builtin_templates, read_symbol_folder

Image = NDArray[Any]


def write(folder: Path, name: str, image: Image) -> None:
    assert cv2.imwrite(str(folder / name), np.asarray(image, np.uint8))


def line_image(height: int = 20, width: int = 16) -> Image:
    """A dark line on white paper."""
    image = np.full((height, width), 255, np.uint8)
    image[:, 3] = 0
    return image


def bar(rows: slice, cols: slice, shape: tuple[int, int] = (20, 16)) -> Image:
    image = np.full(shape, 255, np.uint8)
    image[rows, cols] = 0
    return image


def test_jambs_of_builtin_templates_are_a_door_apart():
    builtin = {template.name: template for template in builtin_templates()}
    assert {"door", "double door", "window", "stairs", "lift", "extinguisher", "exit", "red sign"} <= builtin.keys()
    assert builtin["door"].kind == "door"
    widths = [float(np.hypot(*np.diff(np.array(builtin[name].jambs), axis=0)[0])) for name in ("door", "double door")]
    assert widths == pytest.approx([48, 96])
    assert builtin["door"].door_px == 48
    assert [name for name, template in builtin.items() if (template.jambs is None) != (template.kind == "object")] == []
    # A bare line is all over every plan
    assert "leaf" not in builtin


def test_names_give_kinds_and_walls_give_jambs(tmp_path):
    for name in ("door", "Porta2", "TÜR3", "puerta", "fenster", "finestra1", "kit"):
        write(tmp_path, f"{name}.png", line_image())
    write(tmp_path, "wall.png", bar(slice(12, 16), slice(None)))
    write(tmp_path, "wall2.png", bar(slice(2, 18), slice(4, 8)))
    write(tmp_path, "notes.txt.png", line_image())
    (tmp_path / "readme.txt").write_text("no picture")
    templates = {template.name: template for template in read_symbol_folder(tmp_path)}
    assert {name: template.kind for name, template in templates.items()} == {
        **dict.fromkeys(("door.png", "porta2.png", "tür3.png", "puerta.png"), "door"),
        **dict.fromkeys(("fenster.png", "finestra1.png"), "window"),
        **dict.fromkeys(("kit.png", "notes.txt.png"), "object"),
    }
    assert np.array(templates["door.png"].jambs).tolist() == [[14, 0], [14, 16]]
    assert np.array(templates["porta2.png"].jambs).tolist() == [[2, 6], [18, 6]]
    assert templates["tür3.png"].jambs is None
    assert templates["door.png"].image.tolist() == line_image().tolist()
    assert templates["door.png"].door_px is None


def test_colours_are_kept(tmp_path):
    write(tmp_path, "sign.png", np.full((12, 12, 3), (36, 28, 214)) * (np.arange(12) > 4)[:, None, None])
    (sign,) = read_symbol_folder(tmp_path)
    assert sign.image.shape == (12, 12, 3)
    assert sign.image[-1, 0].tolist() == [214, 28, 36]


def test_all_faults_are_reported_in_one_line(tmp_path):
    write(tmp_path, "good.png", line_image())
    write(tmp_path, "blank.png", np.full((20, 20), 200))
    write(tmp_path, "tiny.png", line_image(4, 9))
    write(tmp_path, "huge.png", line_image(300, 20))
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n no more")
    (tmp_path / "empty.png").write_bytes(b"")
    with pytest.raises(PlanError) as error:
        read_symbol_folder(tmp_path)
    message = str(error.value)
    assert "\n" not in message
    assert [name for name in ("blank", "tiny", "huge", "broken", "empty") if f"{name}.png" not in message] == []
    assert "good.png" not in message


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({}, "PNGs"),
        ({"wall.png": line_image()}, r"wall\.png"),
        ({"door.png": line_image(), "wall.png": line_image(30, 16)}, "large"),
        ({"door.png": line_image(), "wall.png": line_image(), "wall7.png": line_image()}, r"wall7\.png"),
    ],
)
def test_folders_that_cannot_be_used(tmp_path, files, message):
    for name, image in files.items():
        write(tmp_path, name, image)
    with pytest.raises(PlanError, match=message):
        read_symbol_folder(tmp_path)


def test_a_missing_folder_is_refused(tmp_path):
    with pytest.raises(PlanError, match=r"\bfolder\b"):
        read_symbol_folder(tmp_path / "missing")


def test_the_symbols_of_the_collection_are_read(data):
    templates = read_symbol_folder(data / "floorplans" / "symbols")
    kinds = [template.kind for template in templates]
    assert (kinds.count("door"), kinds.count("object")) == (27, 13)
    assert sum(template.jambs is not None for template in templates) == 12
    door = next(template for template in templates if template.name == "door.png")
    assert np.array(door.jambs)[:, 1].tolist() == [0, door.image.shape[1]]
