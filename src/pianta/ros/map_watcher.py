"""MapWatcher: reads a map again when it has changed, keeps the ids of its rooms, and writes its folder."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Unpack

from pianta.gridmap import GridMap
from pianta.io.bags import is_same_map
from pianta.io.graphs import FLOOR_FILE
from pianta.reading._reader import Reader, ReadOptions, open_corrected, read_previous
from pianta.reading.growing_map import GrowingMap
from pianta.reading.reading import Reading


@dataclass
class MapWatcher:
    """What is done with each map that arrives.

    reader: the options of reading. out: the folder for the results; a floor in it is the previous one, also one of an
    earlier run. source: where the maps come from, for messages.
    """

    reader: Reader
    out: Path
    source: str
    last: GridMap | None = field(default=None, init=False)
    growing: GrowingMap | None = field(default=None, init=False)

    @classmethod
    def make(cls, out: str | Path, source: str, **options: Unpack[ReadOptions]) -> MapWatcher:
        """A watcher with checked options, as of `read`; raises PiantaError."""
        return cls(Reader.make(**options), Path(out), source)

    def update(self, grid: GridMap) -> Reading | None:
        """The building of a map, once its folder is written; None for a map like the last one.

        Raises PiantaError for a map that cannot be read, such as one without rooms; the next one may be.
        """
        if self.last is not None and is_same_map(grid, self.last):
            return None
        self.last = grid
        reading = self._choose_readings().read(grid, self.source)
        reading.save(self.out)
        return replace(reading, folder=self.out)

    def _choose_readings(self) -> GrowingMap:
        """Those so far; new ones at the start, and if people have corrected the folder."""
        has_floor = (self.out / FLOOR_FILE).is_file()
        corrected = open_corrected(self.out) if has_floor else None
        if self.growing is None or corrected is not None:
            # What people have corrected meanwhile stays
            previous = read_previous(self.out) if has_floor else self.reader.previous
            self.growing = GrowingMap(replace(self.reader, previous=previous, corrected=corrected))
        return self.growing
