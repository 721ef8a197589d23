"""SavedReading: the folder of a floor that was read, with its corrections."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from PIL import Image
from shapely import Polygon

from pianta._types import Floats
from pianta.corrections.confirmed import list_confirmed
from pianta.corrections.correct import Outcome, correct, correct_all
from pianta.corrections.corrections_file import FILE_NAME, read_corrections, save_corrections
from pianta.corrections.kinds import Correction, SetType, move_correction
from pianta.errors import CorrectionError, FloorError, MapError
from pianta.floor import Floor, scale_floor
from pianta.floor.area_trust import AreaTrust
from pianta.gridmap import GridMap
from pianta.io._files import is_filled_file, short_repr
from pianta.io._folders import atomic_folder
from pianta.io.floors import read_floor, read_scale_member, save_floor
from pianta.io.maps import read_npz_map
from pianta.labels import ALL_SCHEMAS, LabelSchema
from pianta.layout.frames import Motion
from pianta.layout.room_ids import find_frame_motion, keep_room_ids
from pianta.reading._map_change import MapChange
from pianta.reading._restored_rooms import Restored, restore_rooms
from pianta.reading.reading import OUTPUTS, PAPER, UNCORRECTED, find_area_trust, write_floor

if TYPE_CHECKING:
    from pianta.plan.sheets.sheet import PlanScale

FLOOR, GRID = OUTPUTS[0], OUTPUTS[-1]
# The floor, and that which was read with the corrections, share this of their area, or are of different buildings;
# they are equal but for changes of the file by hand (chosen by hand).
MIN_SHARED = 0.5


class CarriedOver(NamedTuple):
    """A newer floor, uncorrected, and the corrections of the previous one in its frame.

    read: as the map was read, but for rooms that corrections confirm; restored: how many of these have their previous
    outline. floor: the same with the ids, names and labels of the previous floor.
    """

    read: Floor
    floor: Floor
    corrections: list[Correction]
    restored: int


@dataclass(frozen=True, eq=False)
class SavedReading:
    """A folder that `pianta read` has written, and what people have corrected in it.

    uncorrected: the floor as it was read. floor: with the corrections. corrections: in their order. outcomes: what
    became of each on this floor. grid: the map, in the metres of the floor; None in a folder of an older pianta. paper:
    the sheet of a plan, RGB of shape (H, W, 3) on the cells of the grid; None for a map. scale: of a plan as it was
    read; None for a map.
    """

    folder: Path
    uncorrected: Floor
    floor: Floor
    corrections: tuple[Correction, ...] = ()
    outcomes: tuple[Outcome, ...] = ()
    grid: GridMap | None = None
    paper: NDArray[np.uint8] | None = None
    scale: PlanScale | None = None

    @classmethod
    def open(cls, folder: str | Path) -> SavedReading:
        """Read the folder of a floor.

        Raises PiantaError, in one line, if a file is missing or damaged.
        """
        from pianta.plan.sheets.sheet import PlanScale

        path = Path(folder)
        if not (path / FLOOR).is_file():
            raise FloorError(f"folder {short_repr(folder)} has no {FLOOR}, give a folder of `pianta read`")
        floor = read_floor(path / FLOOR)
        # A link that leads nowhere is refused: without corrections, what was read would be replaced
        corrections = tuple(read_corrections(path / FILE_NAME)) if os.path.lexists(path / FILE_NAME) else ()
        uncorrected = read_floor(path / UNCORRECTED) if corrections else floor
        corrected, outcomes = correct_all(uncorrected, corrections) if corrections else (floor, [])
        grid = None if _is_missing(path / GRID) else read_npz_map(path / GRID)
        _check_same_building(path, floor, corrected, grid)
        scale = PlanScale.from_json(read_scale_member(path / (UNCORRECTED if corrections else FLOOR)))
        return cls(path, uncorrected, floor, corrections, tuple(outcomes), grid, _read_paper(path / PAPER), scale)

    def add(self, correction: Correction) -> SavedReading:
        """The reading with one more correction; the same object if the floor is as it says already.

        Raises CorrectionError, in one line, if the correction does not fit the floor.
        """
        if correct(self.floor, correction) is self.floor:
            return self
        corrected, (outcome,) = correct_all(self.floor, [correction])
        corrected = label_by_given_type(corrected, [correction])
        corrections, outcomes = (*self.corrections, correction), (*self.outcomes, outcome)
        grid = self._scale_grid(outcome.factor)
        return replace(self, floor=corrected, corrections=corrections, outcomes=outcomes, grid=grid)

    def keep(self, corrections: Sequence[Correction]) -> SavedReading:
        """The reading with these corrections alone; rooms that were there before have their ids."""
        corrected, outcomes = correct_all(self.uncorrected, corrections)
        factor = measure_factor(outcomes)
        change = factor / measure_factor(self.outcomes)
        # Rooms are compared by their places, so that all floors have to be in the same metres
        previous, earlier = scale_floor(self.floor, change, change), scale_floor(self.uncorrected, factor, factor)
        floor = keep_words(keep_room_ids(corrected, previous, earlier=[earlier]), corrected)
        floor = label_by_given_type(floor, corrections)
        grid = self._scale_grid(change)
        return replace(self, floor=floor, corrections=tuple(corrections), outcomes=tuple(outcomes), grid=grid)

    def carry_over(self, floor: Floor, grid: GridMap) -> CarriedOver:
        """The floor of a newer map of the building, and the corrections for it.

        Raises FloorError if it is of another building.
        """
        motion = find_frame_motion(floor, self.uncorrected)
        restored = self._restore(floor, grid, motion)
        corrections = self.move_corrections(motion)
        floor = keep_room_ids(restored.floor, self.uncorrected)
        return CarriedOver(restored.floor, floor, corrections, restored.count)

    def move_corrections(self, motion: Motion) -> list[Correction]:
        """The corrections in another frame. motion: from the frame of the uncorrected floor."""
        moved = []
        for correction, factor in self._list_factors():
            x, y = motion.shift
            # After a correction of the scale all places are in other metres
            moved.append(move_correction(correction, Motion(motion.angle, (x * factor, y * factor)).apply))
        return moved

    def _restore(self, floor: Floor, grid: GridMap, motion: Motion) -> Restored:
        """The floor with the rooms that the corrections confirm, where the map is as it was."""
        if self.grid is None:
            return Restored(floor)
        fitting = (outcome.problem is None for outcome in self.outcomes)
        unscaled = [
            move_correction(correction, partial(_scale_down, factor=factor))
            for (correction, factor), fits in zip(self._list_factors(), fitting, strict=True)
            if fits
        ]
        old_grid = self.grid.scaled(1 / measure_factor(self.outcomes))
        confirmed = list_confirmed(self.uncorrected, unscaled)
        return restore_rooms(floor, self.uncorrected, confirmed, MapChange(grid, old_grid, motion))

    def _list_factors(self) -> Iterator[tuple[Correction, float]]:
        """The corrections, and by how much the corrections before each multiply all lengths."""
        factor = 1.0
        for correction, outcome in zip(self.corrections, self.outcomes, strict=True):
            yield correction, factor
            factor *= outcome.factor

    def save(self, *, schemas: Mapping[str, LabelSchema] = ALL_SCHEMAS) -> None:
        """Write the corrected floor with its picture, and the corrections; all files or none.

        Raises PiantaError, in one line, if a file cannot be written, and MapError if the folder has no map, without
        which rooms.png cannot be drawn.
        """
        if self.grid is None:
            raise MapError(f"folder {short_repr(self.folder)} has no {GRID}, read the map again with this pianta")
        with atomic_folder(self.folder) as temporary:
            write_floor(self.floor, self.grid, temporary, schemas, paper=self.paper, scale=self.corrected_scale)
            self.grid.save(temporary / GRID)
            save_floor(
                self.uncorrected, temporary / UNCORRECTED, scale=None if self.scale is None else self.scale.as_json()
            )
            save_corrections(self.corrections, temporary / FILE_NAME)

    @property
    def corrected_scale(self) -> PlanScale | None:
        """The scale with the corrections; None for a map."""
        return None if self.scale is None else self.scale.corrected(measure_factor(self.outcomes))

    @property
    def area_trust(self) -> AreaTrust:
        """Whether the scale, with the corrections, is certain enough for areas; exact for a map."""
        return find_area_trust(self.corrected_scale)

    def _scale_grid(self, factor: float) -> GridMap | None:
        return self.grid if self.grid is None or factor == 1 else self.grid.scaled(factor)


def keep_words(floor: Floor, source: Floor) -> Floor:
    """The floor with the numbers, names and labels of another one that has the same rooms in the same order."""
    rooms = tuple(
        replace(
            room,
            number=own.number,
            name=own.name,
            label=own.label,
            labels=own.labels,
            label_probabilities=own.label_probabilities,
        )
        for room, own in zip(floor.rooms, source.rooms, strict=True)
    )
    return replace(floor, rooms=rooms)


def _scale_down(xy: Floats, *, factor: float) -> Floats:
    return xy / factor


def label_by_given_type(floor: Floor, corrections: Iterable[Correction]) -> Floor:
    """The floor with labels of the type of its building, if one of the corrections has given the type."""
    from pianta.reading._labelling import Labelling

    if not any(isinstance(correction, SetType) for correction in corrections):
        return floor
    return Labelling.make(None, None, None, None).relabel(floor)


def measure_factor(outcomes: Iterable[Outcome]) -> float:
    """By how much corrections multiply all lengths."""
    return prod(outcome.factor for outcome in outcomes)


def _check_same_building(folder: Path, floor: Floor, corrected: Floor, grid: GridMap | None) -> None:
    """Raise CorrectionError for a folder with files of another building."""
    shape = shapely.union_all([room.polygon for room in floor])
    expected = shape if corrected is floor else shapely.union_all([room.polygon for room in corrected])
    if shapely.intersection(shape, expected).area < MIN_SHARED * shapely.union(shape, expected).area:
        raise CorrectionError(
            f"folder {short_repr(folder)}: {FLOOR} is not {UNCORRECTED} with the corrections of {FILE_NAME}, "
            "put back the files of this building, or read the map into another folder"
        )
    if grid is not None and not shape.is_empty:
        height, width = grid.shape
        x, y = grid.pixel_to_map([0, 0, height, height], [0, width, width, 0])
        if not shape.intersects(Polygon(np.column_stack([x, y]))):
            raise CorrectionError(
                f"folder {short_repr(folder)}: no room of {FLOOR} is on the map {GRID}, put back the map of this "
                "building, or read it again"
            )


def _is_missing(file: Path) -> bool:
    """Whether a file is not there, or is empty, as after a loss of power."""
    return not file.exists() or (file.is_file() and not is_filled_file(file))


def _read_paper(file: Path) -> NDArray[np.uint8] | None:
    """The sheet of a plan; None without one."""
    if file.exists() and not file.is_file():
        raise CorrectionError(f"sheet {short_repr(file)} is no regular file, read the plan again")
    with suppress(FileNotFoundError):
        try:
            with Image.open(file) as image:
                return np.asarray(image.convert("RGB"))
        except (OSError, ValueError, Image.DecompressionBombError) as error:
            if isinstance(error, FileNotFoundError):
                raise
            raise CorrectionError(f"sheet {short_repr(file)} is damaged, read the plan again") from None
    return None
