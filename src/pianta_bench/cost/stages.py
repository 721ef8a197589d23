"""What the stages of reading a map cost, by a profile of the whole reading."""

from __future__ import annotations

import inspect
import tempfile
from collections.abc import Callable, Mapping
from cProfile import Profile
from importlib import import_module
from pathlib import Path
from pstats import Stats
from typing import Any

from pianta.gridmap import GridMap
from pianta.reading.read import read
from pianta_bench.harness.records import Figures

OTHER, TOTAL = "all other", "together"
# The functions of each stage, in the order of the reading; none of them calls another one
STAGES: Mapping[str, tuple[str, ...]] = {
    "file of the map": ("pianta.io.maps.read_map",),
    "noise and boxes": (
        "pianta.layout.structure.reconstruct.remove_noise",
        "pianta.layout.structure.unlikely_rooms.find_boxes",
    ),
    "network": ("pianta.layout.structure.evidence.evaluate_map",),
    "floor": ("pianta.layout.structure.space.find_floor_space",),
    "pieces": ("pianta.layout.structure.pieces.cut_into_pieces",),
    "multicut": (
        "pianta.layout.structure.pieces.compute_pair_weights",
        "pianta.layout.multicut.solve_multicut",
    ),
    "borders": ("pianta.layout.structure.borders.straighten_borders",),
    "rooms and doors": ("pianta.layout.structure.reconstruct.list_regions",),
    "confidence": ("pianta.layout.structure.confidence.rate_regions",),
    "walls": (
        "pianta.layout.structure.wall_lines.find_wall_lines",
        "pianta.layout.structure.wall_lines.span_walls",
    ),
    "possible doors": ("pianta.layout.structure.reconstruct.list_possible_doors",),
    "furniture": ("pianta.layout.furniture.find_furniture",),
    "partial rooms": ("pianta.layout.partial.predict.predict_partial_rooms",),
    "labels and type": ("pianta.reading._labelling.Labelling.label",),
    "files and picture": ("pianta.reading.reading.Reading.save",),
}


def profile_reading(grid: GridMap) -> Figures:
    """Seconds of each stage of reading a map from a file and saving its building, of all others, and together."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "map.npz"
        grid.save(file)

        def read_and_save() -> None:
            read(file).save(Path(folder) / "building")

        read_and_save()  # loads libraries and networks
        profile = Profile()
        profile.runcall(read_and_save)
    return split_into_stages(profile)


def split_into_stages(profile: Profile) -> Figures:
    """Seconds of each of STAGES in a profile, of all others, and together."""
    statistics: Any = Stats(profile)  # its attributes have no types
    seconds = {
        stage: sum(statistics.stats.get(find_key(name), (0, 0, 0, 0.0))[3] for name in names)
        for stage, names in STAGES.items()
    }
    return {**seconds, OTHER: statistics.total_tt - sum(seconds.values()), TOTAL: statistics.total_tt}


def find_key(name: str) -> tuple[str, int, str]:
    """The key of a function in a profile. name: of its module, perhaps its class, and itself."""
    code = inspect.unwrap(_find_function(name)).__code__
    return code.co_filename, code.co_firstlineno, code.co_name


def _find_function(name: str) -> Callable[..., Any]:
    parts = name.split(".")
    length = next(index for index, part in enumerate(parts) if part[0].isupper() or index == len(parts) - 1)
    value: Any = import_module(".".join(parts[:length]))
    for part in parts[length:]:
        value = getattr(value, part)
    return value  # type: ignore[no-any-return]
