"""ROS maps: map.yaml and its image, read cell for cell as Nav2's map server does, and written.

Semantics from nav2_map_server/src/map_io.cpp. ROS 1 differs: its wiki compares with the thresholds strictly, its
scale mode yields 1 … 99 between them, and its raw mode passes 101 … 255 through.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath
from typing import Annotated, Any, Literal, get_args

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, FiniteFloat, ValidationError

from pianta._types import Mask
from pianta.errors import MapError, MapWarning
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.io._files import MAX_CELLS, atomic_file, check_input_file, one_line_reason, short_repr
from pianta.io._yaml import PlainLoader
from pianta.io.images import read_grey

Mode = Literal["trinary", "scale", "raw"]
ImageFormat = Literal["png", "pgm", "bmp"]

YAML_SUFFIXES = (".yaml", ".yml")
MAX_YAML_BYTES = 50_000  # a map.yaml has some 200; a wide one of 1 MB takes PyYAML 15 s

# Of Nav2's map_saver in trinary mode. Grey 205 is an occupancy of 50/255, just above the free threshold of 0.196.
FREE_GREY = 254
UNKNOWN_GREY = 205
OCCUPIED_GREY = 0
SAVED_FREE_THRESH = 0.196
SAVED_OCCUPIED_THRESH = 0.65

# Grey 205 means unknown, and not free, if it fills a hundredth of the map and there is other floor: more white cells
# than a tenth of the walls. Chosen on the real maps in the data: 81 have it on 18 … 99 % of their cells and 5 … 38
# times as many white cells as walls; the others have less than 0.1 % of it.
WHITE_GREY = 250  # and above
UNKNOWN_SHARE = 0.01  # of all cells
WHITE_PER_OCCUPIED = 0.1  # white cells to walls
# The same holds for another middle grey that fills more than half of the map's edge, such as 206 or 208 of drawing
# programs, where free_thresh is 0.196; or 128, if a threshold makes it free or occupied. Chosen by hand; no map in the
# data has such an edge by mistake.
EDGE_SHARE = 0.5
MIDDLE_GREYS = range(64, 231)
# A middle grey is no wall if other cells, of more than this share of the map, are occupied; chosen by hand.
WALL_SHARE = 0.001


class _MapYaml(BaseModel):
    """The keys of map.yaml; descriptions are the remedies in messages."""

    model_config = ConfigDict(frozen=True)

    image: str = Field(min_length=1, description="the name of an image file")
    resolution: FiniteFloat = Field(gt=0, description="positive metres per cell")
    origin: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = Field(description="three finite numbers [x, y, yaw]")
    occupied_thresh: float = Field(ge=0, le=1, description="a number from 0 to 1")
    free_thresh: float = Field(ge=0, le=1, description="a number from 0 to 1")
    negate: bool = Field(description="0, 1, true or false")
    mode: Annotated[Mode, BeforeValidator(lambda mode: str(mode).lower())] = Field(
        default="trinary", description="trinary, scale or raw"
    )


class _MapLoader(PlainLoader):
    """YAML as yaml-cpp gives it to Nav2: scalars stay text until parsed; the first of two equal keys counts."""

    def compose_mapping_node(self, anchor: dict[Any, yaml.Node]) -> yaml.MappingNode:
        """Put the first of equal keys last, where it wins."""
        node = super().compose_mapping_node(anchor)
        node.value.reverse()
        return node


def read_ros_map(path: str | Path, *, trust_thresholds: bool = False, max_cells: int = MAX_CELLS) -> GridMap:
    """Map from map.yaml and its image, each cell as Nav2's map server would publish it.

    The image's name is relative to the folder of the YAML; an absolute one that does not exist is looked for there
    too, with a MapWarning.
    trust_thresholds: keep greys of unknown free or occupied where the thresholds make them so. Map savers write 205 for
    unknown, and many YAMLs have free_thresh 0.25, which turns all unknown cells into floor; by default they stay
    unknown, with a MapWarning, and so does another middle grey that fills the edge of the map.

    Raises MapError, with every fault of the YAML in one message, if the YAML or its image cannot be used.
    """
    file = check_input_file(path, "map", MapError)
    description = _read_map_yaml(file)
    image = _find_image(file, description)
    grey, transparent = read_grey(image, max_cells=max_cells)
    cells = _cells_of_greys(description)[grey]
    if transparent is not None and description.mode != "raw":
        cells[transparent] = UNKNOWN
    if not trust_thresholds and description.mode != "raw":
        false = _find_false_cells(grey, cells, negate=description.negate)
        if false is not None:
            cells[false.mask] = UNKNOWN
            warnings.warn(false.describe(file, description), MapWarning, stacklevel=2)
    return GridMap(cells, description.resolution, description.origin, file.name)


def find_map_image(path: str | Path) -> Path | None:
    """The image of a map.yaml, which need not exist; None for other files, and for a YAML that cannot be read."""
    file = Path(path)
    if file.suffix.lower() not in YAML_SUFFIXES:
        return None
    try:
        description = _read_map_yaml(check_input_file(path, "map", MapError))
    except MapError:
        return None
    return _find_image_beside(file, description) or file.parent / description.image


def _find_image(file: Path, description: _MapYaml) -> Path:
    """The image of a map.yaml; with a MapWarning the one beside it, if the path is of another machine.

    Raises MapError if it does not exist.
    """
    beside = _find_image_beside(file, description)
    if beside is not None:
        warnings.warn(
            f"map {short_repr(file)}: its image {short_repr(description.image)} does not exist, "
            f"{short_repr(beside.name)} beside the map is read instead; write that name into the map.yaml",
            MapWarning,
            stacklevel=3,
        )
    return check_input_file(
        description.image if beside is None else beside.name,
        f"map {short_repr(file)}: its image",
        MapError,
        folder=file.parent.absolute(),
    )


def _find_image_beside(file: Path, description: _MapYaml) -> Path | None:
    """The image beside a map.yaml, if that names one of another machine: by an absolute path that does not exist."""
    # Both separators and a drive, as the YAML may come from Windows
    windows, path = PureWindowsPath(description.image), Path(description.image)
    beside = file.parent / windows.name
    is_elsewhere = (windows.is_absolute() or path.is_absolute()) and not path.exists()
    return beside if is_elsewhere and windows.name and beside.is_file() else None


def _read_map_yaml(file: Path) -> _MapYaml:
    """The valid content of map.yaml; MapError, with every fault in one message, if it is invalid or too large."""
    name = f"map {short_repr(file)}"
    if file.stat().st_size > MAX_YAML_BYTES:
        raise MapError(f"{name} has more than {MAX_YAML_BYTES} bytes, give the map.yaml that names the image")
    try:
        # A tab is a separator in yaml-cpp, but not in PyYAML.
        keys = _MapLoader(file.read_bytes().replace(b"\t", b" ")).get_data()
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError, OSError) as exception:
        raise MapError(f"{name} is no YAML: {one_line_reason(exception)}") from None
    if not isinstance(keys, dict):
        raise MapError(f"{name} is no map.yaml, it has no keys; give one with image, resolution, origin …")
    try:
        return _MapYaml.model_validate(keys)
    except ValidationError as exception:
        faulty = dict.fromkeys(str(fault["loc"][0]) for fault in exception.errors())
        raise MapError(f"{name}: " + "; ".join(_describe_fault(key, keys) for key in faulty)) from None


def _describe_fault(key: str, keys: dict[str, Any]) -> str:
    state = f"is {short_repr(keys[key])}" if key in keys else "is missing"
    return f"{key} {state}, give {_MapYaml.model_fields[key].description}"


def _cells_of_greys(description: _MapYaml) -> NDArray[np.int8]:
    """Cell value of each grey level, shape (256,), in Nav2's float32 arithmetic."""
    greys = np.arange(256)
    if description.mode == "raw":
        return np.where(greys <= OCCUPIED, greys, UNKNOWN).astype(np.int8)
    brightness = greys.astype(np.float32) / np.float32(255)
    occupancy = brightness if description.negate else np.float32(1) - brightness
    free, occupied = np.float32(description.free_thresh), np.float32(description.occupied_thresh)
    cells = np.full(256, UNKNOWN, np.int8)
    if description.mode == "scale":
        between = (occupancy > free) & (occupancy < occupied)
        span = np.float32(description.occupied_thresh - description.free_thresh)
        percent = (occupancy[between] - free) / span * np.float32(100)
        cells[between] = np.floor(percent.astype(float) + 0.5)
    cells[occupancy >= occupied] = OCCUPIED
    cells[occupancy <= free] = FREE
    return cells


@dataclass(frozen=True, eq=False)
class _FalseCells:
    """Cells of unknown space that the thresholds make free or occupied: their grey, and their mask, shape (H, W)."""

    grey: int
    mask: Mask
    occupied: bool

    def describe(self, file: Path, description: _MapYaml) -> str:
        """The warning that they are read as unknown."""
        key = "occupied_thresh" if self.occupied else "free_thresh"
        state = "occupied" if self.occupied else "free"
        saved = self.grey == (255 - UNKNOWN_GREY if description.negate else UNKNOWN_GREY)
        evidence = "which map savers write for unknown" if saved else "which fills the edge of the map as unknown does"
        return (
            f"map {short_repr(file)}: {key} {getattr(description, key)} makes grey {self.grey} {state}, {evidence}; "
            f"its {np.count_nonzero(self.mask)} cells ({self.mask.mean():.0%}) are read as unknown, "
            f"keep them {state} with trust_thresholds=True"
        )


def _find_false_cells(grey: NDArray[np.uint8], cells: NDArray[np.int8], *, negate: bool) -> _FalseCells | None:
    """Cells with a grey of unknown that the thresholds make free or occupied; None without any."""
    brightness = 255 - grey if negate else grey
    counts = np.bincount(brightness.ravel(), minlength=256)
    is_free = np.bincount(brightness[cells == FREE], minlength=256) > 0
    is_occupied = np.bincount(brightness[cells == OCCUPIED], minlength=256) > 0
    for unknown in dict.fromkeys([UNKNOWN_GREY, *_find_edge_grey(brightness)]):
        is_wall = is_occupied & (np.arange(256) != unknown)
        floor, walls = counts[WHITE_GREY:][is_free[WHITE_GREY:]].sum(), counts[is_wall].sum()
        if counts[unknown] < UNKNOWN_SHARE * grey.size or floor <= WHITE_PER_OCCUPIED * walls:
            continue
        # Where nothing else is occupied, the grey is the walls
        if is_free[unknown] or (is_occupied[unknown] and walls > WALL_SHARE * grey.size):
            mask = (brightness == unknown) & (cells != UNKNOWN)
            return _FalseCells(255 - unknown if negate else unknown, mask, bool(is_occupied[unknown]))
    return None


def _find_edge_grey(brightness: NDArray[np.uint8]) -> list[int]:
    """The middle grey that fills most of the edge of a map, if there is one; brightness: shape (H, W)."""
    edge = np.concatenate([brightness[0], brightness[-1], brightness[1:-1, 0], brightness[1:-1, -1]])
    counts = np.bincount(edge)
    grey = int(counts.argmax())
    return [grey] if counts[grey] > EDGE_SHARE * len(edge) and grey in MIDDLE_GREYS else []


def save_ros_map(grid: GridMap, path: str | Path, *, mode: Mode = "trinary", image_format: ImageFormat = "png") -> None:
    """Write map.yaml at `path` and the image beside it, with the same stem; origin and resolution in full precision.

    mode: "trinary" keeps free, unknown and occupied, and values between become unknown; "scale" (PNG only, unknown
    is transparent) and "raw" keep every value. In scale mode the thresholds are 0 and 1, not Nav2's 0.196 and 0.65,
    which lose the values outside them.

    Raises MapError for a wrong option and PiantaError if a file cannot be written; then no file is written.
    """
    path = Path(path)
    _check_save_options(path, mode, image_format)
    free_thresh, occupied_thresh = (0.0, 1.0) if mode == "scale" else (SAVED_FREE_THRESH, SAVED_OCCUPIED_THRESH)
    image_path = path.with_suffix(f".{image_format}")
    keys = {
        "image": image_path.name,
        "mode": mode,
        "resolution": grid.resolution,
        "origin": list(grid.origin),
        "negate": 0,
        "occupied_thresh": occupied_thresh,
        "free_thresh": free_thresh,
    }
    # The inner file is renamed first, so that a YAML never names a missing image.
    with atomic_file(path) as new_yaml, atomic_file(image_path) as new_image:
        Image.fromarray(_pixels_of_cells(grid, mode)).save(new_image)
        new_yaml.write_text(yaml.safe_dump(keys, sort_keys=False, default_flow_style=None), encoding="utf-8")


def _check_save_options(path: Path, mode: str, image_format: str) -> None:
    """Raise MapError that lists all faults: of the suffix of the path, the mode and the image format."""
    faults = []
    if path.suffix.lower() not in YAML_SUFFIXES:
        faults.append(f"the path is {short_repr(path)}, give one that ends in .yaml")
    if mode not in get_args(Mode):
        faults.append(f"mode is {short_repr(mode)}, give {', '.join(get_args(Mode))}")
    if image_format not in get_args(ImageFormat):
        faults.append(f"image format is {short_repr(image_format)}, give {', '.join(get_args(ImageFormat))}")
    elif mode == "scale" and image_format != "png":
        faults.append(f"{image_format} has no transparency for the unknown cells of mode scale, give png")
    if faults:
        raise MapError("the map cannot be saved: " + "; ".join(faults))


def _pixels_of_cells(grid: GridMap, mode: Mode) -> NDArray[np.uint8]:
    """Grey levels, shape (H, W), in scale mode grey and alpha, shape (H, W, 2)."""
    if mode == "raw":
        return grid.cells.view(np.uint8)  # -1 is 255
    if mode == "scale":
        opaque = grid.cells != UNKNOWN
        grey = np.round((OCCUPIED - grid.cells.clip(0).astype(float)) * 2.55)
        return np.dstack([grey, opaque * 255]).astype(np.uint8)
    pixels = np.full(grid.shape, UNKNOWN_GREY, np.uint8)
    pixels[grid.free] = FREE_GREY
    pixels[grid.occupied] = OCCUPIED_GREY
    return pixels
