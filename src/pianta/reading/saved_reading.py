"""SavedReading: the folder of a floor that was read, with its corrections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import prod
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pianta.corrections.correct import Outcome, correct_all
from pianta.corrections.corrections_file import FILE_NAME, read_corrections, save_corrections
from pianta.corrections.kinds import Correction
from pianta.errors import CorrectionError, FloorError, MapError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder
from pianta.io.floors import read_floor, save_floor
from pianta.io.maps import read_npz_map
from pianta.labels import ALL_SCHEMAS, LabelSchema
from pianta.reading.reading import OUTPUTS, PAPER, write_floor

# The floor as it was read, without corrections.
UNCORRECTED = "uncorrected.geojson"
FLOOR, GRID = OUTPUTS[0], OUTPUTS[-1]


@dataclass(frozen=True, eq=False)
class SavedReading:
    """A folder that `pianta read` has written, and what people have corrected in it.

    uncorrected: the floor as it was read. corrections: in their order. grid: the map, as it was read; None in a folder
    of an older pianta. paper: the sheet of a plan, RGB of shape (H, W, 3) on the cells of the grid; None for a map.
    """

    folder: Path
    uncorrected: Floor
    corrections: tuple[Correction, ...] = ()
    grid: GridMap | None = None
    paper: NDArray[np.uint8] | None = None

    @classmethod
    def open(cls, folder: str | Path) -> SavedReading:
        """Read the folder of a floor.

        Raises PiantaError, in one line, if a file is missing or damaged.
        """
        path = Path(folder)
        if not (path / FLOOR).is_file():
            raise FloorError(f"folder {short_repr(folder)} has no {FLOOR}, give a folder of `pianta read`")
        file = path / FILE_NAME
        corrections = tuple(read_corrections(file)) if file.exists() else ()
        uncorrected = read_floor(path / (UNCORRECTED if corrections else FLOOR))
        grid = read_npz_map(path / GRID) if (path / GRID).exists() else None
        return cls(path, uncorrected, corrections, grid, _read_paper(path / PAPER))

    def apply(self) -> tuple[Floor, list[Outcome]]:
        """The floor with its corrections, and what became of each."""
        return correct_all(self.uncorrected, self.corrections)

    def scaled_grid(self) -> GridMap | None:
        """The map in the metres of the corrected floor."""
        factor = prod(outcome.factor for outcome in self.apply()[1])
        if self.grid is None or factor == 1:
            return self.grid
        x, y, yaw = self.grid.origin
        return GridMap(self.grid.cells, self.grid.resolution * factor, (x * factor, y * factor, yaw), self.grid.source)

    def with_corrections(self, corrections: Sequence[Correction]) -> SavedReading:
        """The same reading with other corrections."""
        return replace(self, corrections=tuple(corrections))

    def save(self, *, schemas: Mapping[str, LabelSchema] = ALL_SCHEMAS) -> Floor:
        """Write the corrected floor with its picture, and the corrections; all files or none.

        Returns the corrected floor. Raises PiantaError, in one line, if a file cannot be written, and MapError if the
        folder has no map, without which rooms.png cannot be drawn.
        """
        grid = self.scaled_grid()
        if grid is None:
            raise MapError(f"folder {short_repr(self.folder)} has no {GRID}, read the map again with this pianta")
        floor, _ = self.apply()
        with atomic_folder(self.folder) as temporary:
            write_floor(floor, grid, temporary, schemas, paper=self.paper)
            save_floor(self.uncorrected, temporary / UNCORRECTED)
            save_corrections(self.corrections, temporary / FILE_NAME)
        return floor


def _read_paper(file: Path) -> NDArray[np.uint8] | None:
    """The sheet of a plan; None if there is none."""
    with suppress(FileNotFoundError):
        try:
            with Image.open(file) as image:
                return np.asarray(image.convert("RGB"))
        except (OSError, ValueError, Image.DecompressionBombError) as error:
            if isinstance(error, FileNotFoundError):
                raise
            raise CorrectionError(f"sheet {short_repr(file)} is damaged, read the plan again") from None
    return None
