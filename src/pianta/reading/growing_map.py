"""A map that grows: each is read with the floor of the one before, by a mapper where the options allow it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.labels import SCHEMAS
from pianta.layout.reconstruct import DEFAULT_METHOD
from pianta.reading._reader import (
    Reader,
    describe_ids,
    explain_map_fault,
    warn_of_implausible_map,
    warn_of_other_building,
)
from pianta.reading.reading import Reading, StoreyReading

if TYPE_CHECKING:
    from pianta.mapping.mapper import Mapper

# Floors before the previous one whose ids rooms can get back; chosen by hand.
MAX_EARLIER = 3


@dataclass
class GrowingMap:
    """The readings of a map that grows.

    reader: the options, with the floor of an earlier run. With options of a mapper, only changes are read, and labels
    and types are beliefs over all maps; else each map is read as a whole, with the floor before as the previous one.
    """

    reader: Reader
    mapper: Mapper | None = field(init=False)

    def __post_init__(self) -> None:
        self.mapper = _make_mapper(self.reader)

    def read(self, grid: GridMap, path: str | Path) -> Reading:
        """The building of the next map; path: where it comes from, for messages.

        Raises PiantaError, in one line, for a map that cannot be read; the next one may be.
        """
        before = self.reader.previous
        reading = self.reader.read_grid(grid, path) if self.mapper is None else self._update(self.mapper, grid, path)
        earlier = tuple(floor for floor in (before, *self.reader.earlier) if floor is not None)[:MAX_EARLIER]
        # What people have corrected is in the floor that was read, and needs no further correction
        self.reader = replace(self.reader, previous=reading.floor, earlier=earlier, corrected=None)
        return reading

    def _update(self, mapper: Mapper, grid: GridMap, path: str | Path) -> Reading:
        # Imported late, because its imports are slow
        from pianta.mapping.events import EventKind, describe_events

        previous = self.reader.previous
        try:
            update = mapper.update(grid)
        except PiantaError as error:
            raise explain_map_fault(error, grid, path) from error
        warn_of_implausible_map(update.floor, grid, path)
        messages = []
        if previous is not None:
            warn_of_other_building(update.floor, previous, self.reader.earlier, path)
            messages.append(describe_ids(update.floor, previous, self.reader.earlier))
        # The line about ids has the rooms that are new and gone
        events = [event for event in update.events if event.kind not in {EventKind.NEW_ROOM, EventKind.LOST_ROOM}]
        messages += [describe_events(events)] if messages and events else []
        labelling = self.reader.labelling
        storey = StoreyReading(
            update.floor,
            grid,
            candidate_types=labelling.predicted_types if labelling and update.floor.rooms else (),
            messages=tuple(messages),
        )
        return Reading(Path(path), (storey,), labelling.schemas if labelling else SCHEMAS)


def _make_mapper(reader: Reader) -> Mapper | None:
    """A mapper with the options of a reader; None if it has not all of them."""
    options, labelling = reader.options, reader.labelling
    is_usual = options.get("method", DEFAULT_METHOD) == DEFAULT_METHOD and not options.get("as_printed")
    has_own_labels = labelling and (labelling.words or labelling.has_own_types or labelling.label_unknown)
    is_corrected = reader.corrected or (reader.previous and _has_words(reader.previous))
    if not is_usual or options.get("parameters") or has_own_labels or is_corrected or reader.earlier:
        return None
    # Imported late, because its imports are slow
    from pianta.mapping.mapper import Mapper

    return Mapper(
        building_type=labelling.building_type if labelling else None,
        room_model=labelling.rooms if labelling else None,
        predict_partial=options.get("predict_partial", True),
        labels=labelling is not None,
        previous=reader.previous,
        # This may be the last map
        max_read_area=None,
    )


def _has_words(floor: Floor) -> bool:
    """Whether a floor has names, labels or a type that people have given."""
    from pianta.rooms.model import has_manual_label

    return bool(floor.given_type) or any(room.name or has_manual_label(room) for room in floor)
