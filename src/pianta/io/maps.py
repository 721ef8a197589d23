"""Maps of all formats, by the suffix of the file; and NumPy archives of maps."""

from __future__ import annotations

import zipfile
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from pianta.errors import MapError
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.io._files import MAX_CELLS, atomic_file, check_cell_count, check_input_file, one_line_reason, short_repr
from pianta.io.bags import BAG_SUFFIXES, Message, check_message, is_bag, read_bag
from pianta.io.geotiffs import has_geotags, read_geotiff
from pianta.io.images import IMAGE_SUFFIXES, DecodedImage, Source, open_image, path_of, read_image_map
from pianta.io.point_clouds import CLOUD_SUFFIXES
from pianta.io.ros_maps import YAML_SUFFIXES, read_ros_map, save_ros_map
from pianta.io.valetudo import is_wrapped, read_valetudo_map

NPZ_SUFFIX = ".npz"
JSON_SUFFIX, PNG_SUFFIX = ".json", ".png"
TIFF_SUFFIXES = (".tif", ".tiff")
MAP_SUFFIXES = (*YAML_SUFFIXES, NPZ_SUFFIX, *IMAGE_SUFFIXES, *BAG_SUFFIXES, JSON_SUFFIX, *CLOUD_SUFFIXES)
# Count of numbers in each member of an archive; None for any.
_COUNTS = {"cells": None, "resolution": 1, "origin": 3}


class MissingResolutionError(MapError):
    """An image is read as a map without a resolution; it may be something else, such as a plan."""


def read_map(
    path: Source,
    *,
    resolution: float | None = None,
    origin: tuple[float, float, float] | None = None,
    trust_thresholds: bool = False,
    topic: str | None = None,
    message: Message = "last",
    max_cells: int = MAX_CELLS,
) -> GridMap:
    """Read a robot's map.

    Parameters
    ----------
    path
        A ROS map.yaml, a NumPy archive (.npz), an image or GeoTIFF; a rosbag: a .bag, .mcap or .db3, or the folder of a
        ROS 2 bag; the map JSON of Valetudo; the points of a floor as PCD or PLY.
    resolution
        Metres per cell of a plain image, which needs it, and of points, 0.05 unless given; the other formats have their
        own.
    origin
        The x, y (m) and yaw (rad, counter-clockwise) of the lower-left corner of a plain image; None for zero.
    trust_thresholds
        Keep greys of unknown free or occupied where the thresholds of a map.yaml make them so: 205, which map savers
        write, or another middle grey that fills the edge of the map.
    topic
        The topic of a bag; None for the only one with maps.
    message
        The number of the map in a bag, from 1, or "last".
    max_cells
        The largest map that is read, in cells.

    Returns
    -------
    GridMap
        The map; its `source` is the name of the file.

    Raises
    ------
    MapError
        The file or an option cannot be used; in one line.
    OptionError
        A bag has several topics with maps, or a package for it is not installed.

    Warns
    -----
    MapWarning
        A grey of unknown would have been free or occupied and was made unknown; the image of a map.yaml was not where
        it says, but beside it; or updates in a bag do not fit its map.

    Examples
    --------
    >>> import pianta
    >>> pianta.make_world("corridor")[1].save("map.yaml")
    >>> grid = pianta.read_map("map.yaml")
    >>> grid.shape, grid.resolution
    ((334, 646), 0.05)
    """
    check_message(message)
    if is_bag(path_of(path)):
        _refuse_frame(path_of(path), resolution, origin)
        return read_bag(path_of(path), topic=topic, message=message, max_cells=max_cells)
    file = check_input_file(path_of(path), "map", MapError)
    suffix = file.suffix.lower()
    if suffix not in MAP_SUFFIXES:
        raise MapError(f"map {short_repr(file)} is of no known kind, give one of {', '.join(MAP_SUFFIXES)}")
    if topic is not None or message != "last":
        raise MapError(f"map {short_repr(file)} is no bag, leave out topic= and message=")
    if suffix in CLOUD_SUFFIXES:
        from pianta.io.cloud_maps import DEFAULT_RESOLUTION, read_cloud_map

        _refuse_frame(file, None, origin)
        return read_cloud_map(file, resolution=resolution or DEFAULT_RESOLUTION, max_cells=max_cells)
    if suffix in IMAGE_SUFFIXES:
        return _read_image(path, file, resolution, origin, max_cells)
    _refuse_frame(file, resolution, origin)
    if suffix == NPZ_SUFFIX:
        return read_npz_map(file, max_cells=max_cells)
    if suffix == JSON_SUFFIX:
        return read_valetudo_map(file, max_cells=max_cells)
    return read_ros_map(file, trust_thresholds=trust_thresholds, max_cells=max_cells)


def _refuse_frame(path: str | Path, resolution: float | None, origin: object) -> None:
    """Raise MapError if a map that has its own resolution or origin is given another."""
    names = [name for name, value in (("resolution=", resolution), ("origin=", origin)) if value is not None]
    if names:
        raise MapError(f"map {short_repr(path)} has its own resolution and origin, leave out resolution= and origin=")


def _read_image(
    path: Source,
    file: Path,
    resolution: float | None,
    origin: tuple[float, float, float] | None,
    max_cells: int,
) -> GridMap:
    """Map of an image: by the options, else by the tags of a GeoTIFF, or by the JSON in a PNG of Valetudo."""
    if resolution is not None:
        return read_image_map(path, resolution=resolution, origin=origin or (0.0, 0.0, 0.0), max_cells=max_cells)
    suffix = file.suffix.lower()
    if suffix == PNG_SUFFIX and is_wrapped(file):
        return read_valetudo_map(file, max_cells=max_cells)
    if suffix in TIFF_SUFFIXES:
        image = path if isinstance(path, DecodedImage) else open_image(path, max_cells=max_cells)
        if has_geotags(image.pixels):
            return read_geotiff(image, read_image_map, max_cells=max_cells)
    raise MissingResolutionError(_describe_missing_resolution(file))


def _describe_missing_resolution(image: Path) -> str:
    """The message about an image without a resolution; it recommends the YAML of the same name if there is one."""
    beside = (image.with_suffix(suffix) for suffix in YAML_SUFFIXES)
    remedy = next((f"{short_repr(file)}, which lies beside it" for file in beside if file.is_file()), "its map.yaml")
    return (
        f"map {short_repr(image)} is an image without a resolution, give {remedy}, "
        "or the metres per cell by resolution="
    )


def read_npz_map(path: str | Path, *, max_cells: int = MAX_CELLS) -> GridMap:
    """Map from a NumPy archive with the arrays cells (H, W), resolution (m per cell) and origin (x, y, yaw).

    Nothing is unpickled, and no array of more than max_cells numbers is unpacked.

    Raises MapError, with every fault in one message.
    """
    file = check_input_file(path, "map", MapError)
    try:
        arrays, faults = _read_arrays(file, max_cells)
    # zipfile, zlib and numpy raise various exceptions for hostile files.
    except Exception as exception:
        reason = one_line_reason(exception)
        raise MapError(f"map {short_repr(file)} is no NumPy archive or damaged: {reason}") from exception
    # Valid substitutes for unreadable members, so that GridMap finds the faults of the others.
    cells = arrays.get("cells", np.zeros((1, 1), np.int8))
    resolution = arrays.get("resolution", np.ones(1)).item()
    origin = arrays.get("origin", np.zeros(3)).ravel().tolist()
    try:
        grid = GridMap(cells, resolution, tuple(origin), file.name)
    except MapError as error:
        faults.append(str(error).removeprefix("not a map: "))
    if faults:
        raise MapError(f"map {short_repr(file)}: " + "; ".join(faults))
    return grid


def _read_arrays(file: Path, max_cells: int) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """The valid members, and the faults of the others."""
    arrays, faults = {}, []
    with zipfile.ZipFile(file) as archive:
        for key, count in _COUNTS.items():
            try:
                _check_member(archive, key, count, max_cells)
                with archive.open(f"{key}.npy") as stream:
                    arrays[key] = npy.read_array(stream, allow_pickle=False)
            except MapError as error:
                faults.append(str(error))
    return arrays, faults


def _check_member(archive: zipfile.ZipFile, key: str, count: int | None, max_cells: int) -> None:
    """Raise MapError for a member whose header has another type, count of numbers, or too many cells."""
    if f"{key}.npy" not in archive.namelist():
        raise MapError(f"{key} is missing, save it with numpy.savez")
    with archive.open(f"{key}.npy") as stream:
        version = npy.read_magic(stream)
        read_header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, dtype = read_header(stream)
    check_cell_count(shape, f"array {key}", max_cells=max_cells)
    if dtype.kind not in "iuf":
        raise MapError(f"{key} is of type {short_repr(str(dtype))}, give numbers")
    if count is not None and prod(shape) != count:
        raise MapError(f"{key} holds {prod(shape)} numbers, give {count}")


def save_map(grid: GridMap, path: str | Path) -> None:
    """Write a map as a ROS map.yaml with a PNG beside it (.yaml, .yml), or as a NumPy archive (.npz).

    Raises MapError for another suffix, PiantaError if a file cannot be written.
    """
    if len(list_saved_files(path)) == 1:
        save_npz_map(grid, path)
    else:
        save_ros_map(grid, path, mode="trinary" if is_trinary(grid) else "scale")


def list_saved_files(path: str | Path) -> list[Path]:
    """The files that save_map writes for a path.

    Raises MapError for another suffix than .yaml, .yml and .npz.
    """
    file = Path(path)
    if file.suffix.lower() == NPZ_SUFFIX:
        return [file]
    if file.suffix.lower() in YAML_SUFFIXES:
        return [file, file.with_suffix(".png")]
    raise MapError(f"the map cannot be saved as {short_repr(path)}, give .yaml or .npz")


def is_trinary(grid: GridMap) -> bool:
    """Whether all cells are free (0), occupied (100) or unknown (-1)."""
    return bool(np.isin(grid.cells, (FREE, OCCUPIED, UNKNOWN)).all())


def save_npz_map(grid: GridMap, path: str | Path) -> None:
    """Write a map as a compressed NumPy archive, from which read_npz_map returns an equal map.

    Raises MapError if the path does not end in .npz and PiantaError if it cannot be written.
    """
    if Path(path).suffix.lower() != NPZ_SUFFIX:
        raise MapError(f"the map cannot be saved: the path is {short_repr(path)}, give one that ends in .npz")
    with atomic_file(path) as temporary, temporary.open("wb") as stream:
        np.savez_compressed(stream, cells=grid.cells, resolution=grid.resolution, origin=grid.origin)
