"""Maps of every kind that pianta reads, told apart by the suffix of the file."""

from __future__ import annotations

from pathlib import Path

from pianta.errors import MapError
from pianta.gridmap import GridMap
from pianta.io._files import MAX_CELLS, checked_input, shown
from pianta.io.images import IMAGE_SUFFIXES, read_image_map
from pianta.io.npz_maps import NPZ_SUFFIX, read_npz_map
from pianta.io.ros_maps import YAML_SUFFIXES, read_ros_map

MAP_SUFFIXES = (*YAML_SUFFIXES, NPZ_SUFFIX, *IMAGE_SUFFIXES)


def read_map(
    path: str | Path,
    *,
    resolution: float | None = None,
    origin: tuple[float, float, float] | None = None,
    trust_thresholds: bool = False,
    max_cells: int = MAX_CELLS,
) -> GridMap:
    """Map from a ROS map.yaml, a NumPy archive (.npz), or a plain image.

    resolution: metres per cell of a plain image, which needs it; the other kinds bring their own.
    origin: x, y (m) and yaw (rad) of the lower-left corner of a plain image; zero when None.
    trust_thresholds, max_cells: see read_ros_map and read_grey.

    Raises MapError, in one line, when the file or an option cannot be used.
    """
    path = checked_input(path, "map", MapError)
    suffix = path.suffix.lower()
    if suffix not in MAP_SUFFIXES:
        raise MapError(f"map {shown(path)} is of no known kind, give one of {', '.join(MAP_SUFFIXES)}")
    if suffix in IMAGE_SUFFIXES:
        if resolution is None:
            raise MapError(_describe_missing_resolution(path))
        return read_image_map(path, resolution=resolution, origin=origin or (0.0, 0.0, 0.0), max_cells=max_cells)
    if resolution is not None or origin is not None:
        raise MapError(f"map {shown(path)} has its own resolution and origin, leave out those options")
    if suffix == NPZ_SUFFIX:
        return read_npz_map(path, max_cells=max_cells)
    return read_ros_map(path, trust_thresholds=trust_thresholds, max_cells=max_cells)


def _describe_missing_resolution(image: Path) -> str:
    beside = (image.with_suffix(suffix) for suffix in YAML_SUFFIXES)
    remedy = next((f"{shown(file)}, which lies beside it" for file in beside if file.is_file()), "its map.yaml")
    return (
        f"map {shown(image)} is an image without a resolution, give {remedy}, "
        f"or --resolution METRES_PER_CELL (resolution= in Python)"
    )
